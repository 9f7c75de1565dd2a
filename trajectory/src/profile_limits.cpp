#include "driveline/trajectory/profile_limits.hpp"

#include <cmath>

namespace driveline::trajectory {

bool is_valid(const ProfileLimits& limits) noexcept {
  return limits.max_velocity > 0.0 && limits.min_velocity < 0.0 && limits.max_acceleration > 0.0 &&
         limits.min_acceleration < 0.0 && limits.max_jerk > 0.0 && std::isfinite(limits.max_acceleration) &&
         std::isfinite(limits.min_acceleration);
}

}  // namespace driveline::trajectory
