#include "driveline/motion/control/following_error_watch.hpp"

#include <cmath>
#include <limits>

namespace driveline::motion {

FollowingErrorWatch::FollowingErrorWatch(const AxisConfig& axis, std::chrono::nanoseconds period) noexcept
    : window_(axis.following_error_window.value_or(std::numeric_limits<double>::infinity())),
      timeout_(axis.following_error_timeout),
      period_(period) {}

bool FollowingErrorWatch::judge(std::int64_t cycle, double following_error, bool driven) noexcept {
  const bool beyond = driven && std::abs(following_error) > window_;
  if (beyond && !beyond_) since_ = cycle;
  beyond_ = beyond;
  return beyond && (cycle - since_) * period_ >= timeout_;
}

}  // namespace driveline::motion
