#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/snapshot/feed/feed_writer.hpp"
#include "helper/helper_process.hpp"
#include "helper/restart_pause.hpp"
#include "telemetry/bridge_counts.hpp"

namespace driveline::runtime {

/// Keeps `driveline-bridge` running for a feed, or checks the counts of a bridge that a service starts. Belongs to one
/// thread at a time; only start() and end() wait.
class BridgeSupervisor {
 public:
  using Clock = std::chrono::steady_clock;

  /// How the bridge is run.
  struct Settings {
    std::filesystem::path program{};  ///< program of the bridge; empty: a service starts and restarts it
    std::vector<int> commands{};      ///< descriptors of CommandService; empty: no commands
    std::vector<int> security{};      ///< descriptors of open_security_files(); empty: no DDS Security
    std::string user{};               ///< "1000:1000", user of a bridge that root starts; empty: the user `nobody`
    int qos_profiles = -1;            ///< descriptor of the Fast DDS profiles; -1: none
    std::string qos_file{};           ///< name of the file of the profiles in messages
    std::chrono::milliseconds first_pause{100};  ///< pause before the first restart, doubled each time
    std::chrono::milliseconds longest_pause{10'000};
    std::chrono::milliseconds proven{30'000};      ///< a bridge that has run for this long has the first pause again
    std::chrono::milliseconds still_limit{3000};   ///< a bridge without a sign of life for this long is reported
    std::chrono::milliseconds hang_limit{10'000};  ///< a bridge without a sign of life for this long is killed
    std::chrono::milliseconds start_limit{5000};   ///< time-out of start()
  };

  /// `feed` must outlive it. Error (kMachine): no shared memory for the counts.
  [[nodiscard]] static Result<std::unique_ptr<BridgeSupervisor>> create(const snapshot::FeedWriter& feed,
                                                                        Settings settings);
  BridgeSupervisor(const BridgeSupervisor&) = delete;
  BridgeSupervisor& operator=(const BridgeSupervisor&) = delete;
  ~BridgeSupervisor() = default;

  /// Starts the bridge and waits until it publishes, has reported why it cannot (error, kMachine; for the QoS profiles,
  /// kFile), or has ended, which is treated as in operation. Does not wait if a service starts the bridge.
  [[nodiscard]] Result<void> start();
  /// Checks the bridge and its counts, and restarts it when its pause is over.
  void serve(Clock::time_point now);
  /// Lets the bridge publish the remaining records and end; kills it after a time-out.
  void end();

  /// Returns the events since the last call.
  [[nodiscard]] std::vector<EventFacts> take_events() { return std::exchange(events_, {}); }
  /// Returns the counts of the bridges.
  [[nodiscard]] const BridgeCounts& counts() const noexcept { return counts_; }
  /// Returns the number of restarts of the bridge.
  [[nodiscard]] std::uint64_t restarts() const noexcept { return restarts_; }
  /// Returns the number of checks that found impossible counts.
  [[nodiscard]] std::uint64_t invalid_counts() const noexcept { return invalid_counts_; }
  /// Returns the process of the bridge; 0: there is none.
  [[nodiscard]] pid_t process() const noexcept { return process_.id(); }
  /// Whether a bridge publishes.
  [[nodiscard]] bool running() const noexcept { return running_; }

 private:
  BridgeSupervisor(const snapshot::FeedWriter& feed, Settings settings, rt::SharedRegion region)
      : feed_(feed),
        settings_(std::move(settings)),
        region_(std::move(region)),
        counts_(region_, feed.axes()),
        pause_(settings_.first_pause, settings_.longest_pause) {}

  [[nodiscard]] bool by_service() const noexcept { return settings_.program.empty(); }
  [[nodiscard]] Result<void> spawn(Clock::time_point now);
  [[nodiscard]] tl::unexpected<Error> refused() const;
  void take_messages(Clock::time_point now);
  void update_counts(Clock::time_point now);
  void report_stillness(Clock::time_point now);
  void poll_guest(Clock::time_point now);
  void await_guest();
  void ended(const std::string& how, Clock::time_point now);

  const snapshot::FeedWriter& feed_;
  Settings settings_;
  rt::SharedRegion region_;
  BridgeCounts counts_;
  HelperProcess process_;
  RestartPause pause_;
  std::vector<EventFacts> events_;
  std::string reason_;                    ///< reason of a failure in the words of the bridge
  bool running_ = false;                  ///< the bridge has reported that it publishes
  bool still_ = false;                    ///< the bridge was reported to stand still
  bool invalid_counts_reported_ = false;  ///< impossible counts of the present bridge were reported
  std::uint64_t restarts_ = 0;
  std::uint64_t invalid_counts_ = 0;
  std::uint64_t beats_ = 0;  ///< passes of the bridge at `alive_at_`
  Clock::time_point alive_at_{};
  Clock::time_point started_at_{};
  Clock::time_point again_at_{};
};

}  // namespace driveline::runtime
