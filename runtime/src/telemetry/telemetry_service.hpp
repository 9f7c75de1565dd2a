#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/telemetry/telemetry_report.hpp"
#include "driveline/snapshot/feed/feed_writer.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "telemetry/bridge_supervisor.hpp"
#include "telemetry/cycle_assembler.hpp"

namespace driveline::runtime {

/// Publishes a line over DDS: writes its feed, and keeps the process running that reads it. A consumer of the samples
/// like others, on the drain thread; nothing of it is in the cycle, and nothing of DDS in this process.
class TelemetryService final : public snapshot::SampleConsumer {
 public:
  /// Starts the bridge as [telemetry] says. `virtual_time`: the run waits for the bridge, because nothing else makes it
  /// slow enough for anybody to follow. Errors: settings that cannot be (kSetting), no memory, the bridge cannot start
  /// (kMachine).
  [[nodiscard]] static Result<std::unique_ptr<TelemetryService>> start(const LineConfig& config, bool virtual_time,
                                                                       BridgeSupervisor::Settings settings);
  /// `driveline-bridge`: that of the environment variable DRIVELINE_BRIDGE; else beside this program, or in
  /// ../libexec/driveline from there. Error (kMachine): it is not there.
  [[nodiscard]] static Result<std::filesystem::path> find_program();

  /// What has happened since the last call. Any thread.
  [[nodiscard]] std::vector<EventFacts> poll();
  /// Something has happened to the line: `severity` of it, and its sentence. Any thread but the real-time one.
  void tell(Severity severity, std::string_view sentence);
  /// Replaces what is told of the slaves and of who commands the axes. Any thread but the real-time one.
  void set_condition(const snapshot::FeedCondition& condition);
  /// So far. Any thread.
  [[nodiscard]] TelemetryReport report() const;

  // The drain thread.
  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void set_line_status(const snapshot::LineStatus& status) override;
  void pass_done(const snapshot::DrainCounters& counters) override;
  /// The bridge publishes what is left, and ends.
  void finish(const snapshot::DrainCounters& counters) override;

 private:
  using Clock = BridgeSupervisor::Clock;

  TelemetryService(const LineConfig& config, snapshot::FeedWriter feed, bool virtual_time);
  void push(const snapshot::FeedLine& line, std::span<const snapshot::FeedAxisSample> axes);
  void wait_for_bridge();
  void wake_bridge();
  void tell_status();
  void tell_events();
  void tell_condition();
  void hand_over(const snapshot::DrainCounters& counters);

  snapshot::FeedWriter feed_;
  std::unique_ptr<BridgeSupervisor> supervisor_;
  CycleAssembler assembler_;
  snapshot::FeedStatus status_;
  bool waits_;                      ///< for the bridge
  std::uint64_t stuck_at_ = ~0ULL;  ///< record at which the bridge stood still while it was waited for
  std::uint64_t dropped_by_rings_ = 0;
  std::uint64_t cycles_per_wake_;    ///< of a millisecond, one at least
  std::uint64_t batch_ = 0;          ///< millisecond of the cycle that comes after the last one that was pushed
  std::uint64_t batch_of_wake_ = 0;  ///< the same, when the bridge was woken
  Clock::time_point next_look_{};
  mutable std::mutex mutex_;  ///< of what follows
  std::vector<EventFacts> events_;
  std::vector<snapshot::FeedEvent> told_;             ///< to be put into the feed
  std::optional<snapshot::FeedCondition> condition_;  ///< to be put into the feed
  TelemetryReport report_;
};

}  // namespace driveline::runtime
