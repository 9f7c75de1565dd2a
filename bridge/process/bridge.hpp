#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "command_relay.hpp"
#include "confinement.hpp"
#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/snapshot/feed/feed_condition.hpp"
#include "driveline/snapshot/feed/feed_reader.hpp"
#include "options.hpp"

namespace driveline::bridge {

/// Takes cycles out of a feed and publishes them over DDS.
class Bridge {
 public:
  /// `stop`: set by a signal.
  Bridge(const Options& options, const std::atomic<bool>& stop) : options_(options), stop_(stop) {}

  /// Drops privileges, then publishes until the feed, the supervisor or a signal ends it. Returns an error message;
  /// empty: success.
  [[nodiscard]] std::string run();

 private:
  [[nodiscard]] std::string set_up();
  [[nodiscard]] bool pass();
  void take_status();
  void take_events();
  void take_condition();
  void tell();
  [[nodiscard]] bool must_end() const;
  void say(char kind, std::string_view text) const;
  void end_without_line();

  Options options_;
  const std::atomic<bool>& stop_;
  std::optional<snapshot::FeedReader> feed_;
  std::optional<snapshot::FeedConditionReader> condition_;
  std::optional<snapshot::FeedReturnWriter> return_;
  std::unique_ptr<DdsPublisher> publisher_;
  std::unique_ptr<CommandRelay> commands_;  ///< null: the bridge takes no commands
  std::optional<FileLimits> files_;         ///< nullopt: the bridge cannot open files at all
  bool no_room_ = false;                    ///< /dev/shm has no room for the shared memory that was asked for
  snapshot::FeedStatus status_;
  snapshot::DrainCounters counters_;
  /// Counts of the previous bridge that have not been accounted for yet. A supervisor accounts for them and resets
  /// them.
  snapshot::FeedReturn earlier_return_;
  std::uint64_t beats_ = 0;
  std::chrono::steady_clock::time_point line_alive_at_{};  ///< time of the last sign of life of the line's process
};

}  // namespace driveline::bridge
