#pragma once

#include <chrono>

namespace driveline::ecat_master {

/// Waiting for a slave that is looked at again and again. A machine that suspends the master takes the time away
/// without a look at the slave; so it is over when the time has passed *and* the slave has been looked at some times.
class Patience {
 public:
  /// Looks that a suspended master still has.
  static constexpr int kLooks = 5;

  Patience(std::chrono::nanoseconds now, std::chrono::nanoseconds timeout) : timeout_(timeout) { begin(now); }

  /// The slave has got further: the time begins anew.
  void begin(std::chrono::nanoseconds now) {
    deadline_ = now + timeout_;
    looks_ = 0;
  }
  /// Behind each look that found the slave still waiting; `now`: behind the look.
  [[nodiscard]] bool over(std::chrono::nanoseconds now) { return ++looks_ >= kLooks && now >= deadline_; }

 private:
  std::chrono::nanoseconds timeout_;
  std::chrono::nanoseconds deadline_{0};
  int looks_ = 0;
};

}  // namespace driveline::ecat_master
