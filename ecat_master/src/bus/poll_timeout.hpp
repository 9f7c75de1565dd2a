#pragma once

#include <chrono>

namespace driveline::ecat_master {

/// Time-out for polling a slave. While the master is suspended, time passes without polls; so the time-out expires only
/// when the time has passed *and* the slave has been polled a number of times.
class PollTimeout {
 public:
  /// Polls that remain after the master was suspended.
  static constexpr int kMinPolls = 5;

  PollTimeout(std::chrono::nanoseconds now, std::chrono::nanoseconds timeout) : timeout_(timeout) { begin(now); }

  /// Restarts the time after progress of the slave.
  void begin(std::chrono::nanoseconds now) {
    deadline_ = now + timeout_;
    polls_ = 0;
  }
  /// Call it after each poll that found the slave still waiting; `now`: time after the poll.
  [[nodiscard]] bool over(std::chrono::nanoseconds now) { return ++polls_ >= kMinPolls && now >= deadline_; }

 private:
  std::chrono::nanoseconds timeout_;
  std::chrono::nanoseconds deadline_{0};
  int polls_ = 0;
};

}  // namespace driveline::ecat_master
