#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/snapshot/feed/feed_writer.hpp"
#include "helper/helper_process.hpp"
#include "helper/restart_pause.hpp"
#include "telemetry/bridge_counts.hpp"

namespace driveline::runtime {

/// Keeps `driveline-bridge` running beside a feed, or looks at the counts of one that a service starts. Belongs to one
/// thread at a time; but for start() and end() no call waits for anything.
class BridgeSupervisor {
 public:
  using Clock = std::chrono::steady_clock;

  /// How the bridge is run.
  struct Settings {
    std::filesystem::path program{};             ///< the bridge; empty: somebody else starts it, and again
    std::vector<int> commands{};                 ///< descriptors of CommandService; empty: it takes no commands
    std::vector<int> security{};                 ///< descriptors of open_security_files(); empty: without
    std::string user{};                          ///< "1000:1000", whom the bridge becomes; empty: nobody, if it is root
    int qos_profiles = -1;                       ///< descriptor of profiles of Fast DDS; -1: without
    std::string qos_file{};                      ///< what their file is called in messages
    std::chrono::milliseconds first_pause{100};  ///< before a dead one is started again, doubled each time
    std::chrono::milliseconds longest_pause{10'000};
    std::chrono::milliseconds proven{30'000};      ///< a bridge that has run so long has the first pause again
    std::chrono::milliseconds hang_limit{10'000};  ///< without a sign of life after which it is ended
    std::chrono::milliseconds start_limit{5000};   ///< for which start() waits
  };

  /// `feed` must outlive it. Error (kMachine): no memory for what the bridge tells.
  [[nodiscard]] static Result<std::unique_ptr<BridgeSupervisor>> create(const snapshot::FeedWriter& feed,
                                                                        Settings settings);
  BridgeSupervisor(const BridgeSupervisor&) = delete;
  BridgeSupervisor& operator=(const BridgeSupervisor&) = delete;
  ~BridgeSupervisor() = default;

  /// Starts the bridge and waits until it publishes, has told why it cannot (error, kMachine; of the QoS profiles,
  /// kFile), or has ended, which is treated as in operation. Nothing is waited for where somebody else starts it.
  [[nodiscard]] Result<void> start();
  /// Looks at the bridge and its counts, and starts it again when its pause is over.
  void serve(Clock::time_point now);
  /// The bridge publishes what is left and ends, in time or with force.
  void end();

  /// What has happened since the last call.
  [[nodiscard]] std::vector<EventFacts> take_events() { return std::exchange(events_, {}); }
  /// What the bridges have counted.
  [[nodiscard]] const BridgeCounts& counts() const noexcept { return counts_; }
  /// Of the bridge.
  [[nodiscard]] std::uint64_t restarts() const noexcept { return restarts_; }
  /// Looks at counts that cannot be.
  [[nodiscard]] std::uint64_t unbelieved() const noexcept { return unbelieved_; }
  /// 0: there is none.
  [[nodiscard]] pid_t process() const noexcept { return process_.id(); }
  /// A bridge publishes.
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
  void take_messages();
  void look_at_counts(Clock::time_point now);
  void look_at_guest(Clock::time_point now);
  void await_guest();
  void ended(const std::string& how, Clock::time_point now);

  const snapshot::FeedWriter& feed_;
  Settings settings_;
  rt::SharedRegion region_;
  BridgeCounts counts_;
  HelperProcess process_;
  RestartPause pause_;
  std::vector<EventFacts> events_;
  std::string reason_;          ///< in the words of the bridge
  bool running_ = false;        ///< it has said that it publishes
  bool told_nonsense_ = false;  ///< the bridge that runs
  std::uint64_t restarts_ = 0;
  std::uint64_t unbelieved_ = 0;
  std::uint64_t beats_ = 0;  ///< at `alive_at_`
  Clock::time_point alive_at_{};
  Clock::time_point started_at_{};
  Clock::time_point again_at_{};
};

}  // namespace driveline::runtime
