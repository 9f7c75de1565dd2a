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
#include "driveline/runtime/event/event.hpp"
#include "driveline/runtime/telemetry/telemetry_report.hpp"
#include "driveline/snapshot/feed/feed_writer.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "telemetry/bridge_supervisor.hpp"
#include "telemetry/cycle_assembler.hpp"

namespace driveline::runtime {

/// Publishes a line over DDS: writes its feed, and keeps the process running that reads it. A consumer of samples on
/// the drain thread; no part of it runs in the cycle, and no part of DDS in this process.
class TelemetryService final : public snapshot::SampleConsumer {
 public:
  /// Starts the bridge as [telemetry] says. `virtual_time`: the run waits for the bridge, because on virtual time
  /// nothing else keeps it slow enough for subscribers. Errors: impossible settings (kSetting), no memory, the bridge
  /// cannot start (kMachine).
  [[nodiscard]] static Result<std::unique_ptr<TelemetryService>> start(const LineConfig& config, bool virtual_time,
                                                                       BridgeSupervisor::Settings settings);
  /// Finds `driveline-bridge`: from the environment variable DRIVELINE_BRIDGE, else in the folder of this program, or
  /// in ../libexec/driveline from there. Error (kMachine): it does not exist.
  [[nodiscard]] static Result<std::filesystem::path> find_program();

  /// Returns the events since the last call. Any thread.
  [[nodiscard]] std::vector<EventFacts> poll();
  /// Publishes an event of the line with its severity and sentence. Any thread except the real-time thread.
  void tell(Severity severity, std::string_view sentence);
  /// Replaces the published data of the slaves and of the owners of the axes. Any thread except the real-time thread.
  void set_condition(const snapshot::FeedCondition& condition);
  /// Returns the figures so far. Any thread.
  [[nodiscard]] TelemetryReport report() const;

  // Called on the drain thread.
  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void set_line_status(const snapshot::LineStatus& status) override;
  void pass_done(const snapshot::DrainCounters& counters) override;
  /// Lets the bridge publish the remaining records and end.
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
  bool waits_;                      ///< waits for the bridge
  std::uint64_t stuck_at_ = ~0ULL;  ///< record at which the bridge stopped while it was waited for
  std::uint64_t dropped_by_rings_ = 0;
  std::uint64_t cycles_per_wake_;    ///< cycles per millisecond, at least one
  std::uint64_t batch_ = 0;          ///< millisecond of the cycle after the last pushed one
  std::uint64_t batch_of_wake_ = 0;  ///< value of `batch_` when the bridge was woken
  Clock::time_point next_look_{};
  mutable std::mutex mutex_;  ///< protects the members below
  std::vector<EventFacts> events_;
  std::vector<snapshot::FeedEvent> waiting_events_;   ///< events to be written into the feed
  std::optional<snapshot::FeedCondition> condition_;  ///< data to be written into the feed
  TelemetryReport report_;
};

}  // namespace driveline::runtime
