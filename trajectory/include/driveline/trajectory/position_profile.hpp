#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>

#include "driveline/trajectory/profile.hpp"
#include "driveline/trajectory/profile_error.hpp"
#include "driveline/trajectory/profile_limits.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Plans the fastest motion of an axis from any state to a position, velocity and acceleration. If the start is outside
/// the limits, the axis is first brought back inside as fast as possible, and then takes the fastest motion that stays
/// inside. With an infinite jerk limit the accelerations at both ends are ignored. The target must be inside the
/// limits, and so must the motion before and after it: with a target acceleration a < 0, velocity + a^2 / (2 jerk) <=
/// max_velocity. Bounded cost, no allocation. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                   const ProfileLimits& limits) noexcept;

/// Plans the same motion for exactly the given duration, as the mixture of the farthest and the shortest motion of this
/// duration. An error states the next longer possible duration. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                   const ProfileLimits& limits,
                                                                   double duration_s) noexcept;

/// Reaction to a motion that would leave a range of positions.
enum class OutOfRange : std::uint8_t {
  kRefuse,  ///< return an error
  /// The axis is stopped instead, as fast as possible, and Profile::end() is not the target. An axis that is too fast
  /// for the range leaves it nevertheless.
  kBrake,
};

/// Plans the fastest motion, if it stays within a range of positions throughout. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                   const ProfileLimits& limits,
                                                                   const PositionRange& range,
                                                                   OutOfRange otherwise) noexcept;

/// The possible durations of a motion: the shortest and every longer duration outside the gaps.
class PossibleDurations {
 public:
  /// Up to two gaps for the acceleration at the ends, up to three during the motion.
  static constexpr std::size_t kMaxGaps = 8;

  /// Durations between both ends are impossible; the ends themselves are possible.
  struct Gap {
    double begin_s = 0.0;  ///< longest possible duration before the gap
    double end_s = 0.0;    ///< shortest possible duration after the gap
  };

  /// Shortest possible duration. \rtsafe
  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }
  /// Gaps in ascending order. \rtsafe
  [[nodiscard]] std::span<const Gap> gaps() const noexcept { return {gaps_.data(), count_}; }

 private:
  friend tl::expected<PossibleDurations, ProfileError> possible_durations(const AxisSetpoint& from,
                                                                          const AxisSetpoint& to,
                                                                          const ProfileLimits& limits) noexcept;

  double shortest_s_ = 0.0;
  std::array<Gap, kMaxGaps> gaps_;
  std::size_t count_ = 0;
};

/// Determines all durations for which plan_to_position can plan a motion. \rtsafe
[[nodiscard]] tl::expected<PossibleDurations, ProfileError> possible_durations(const AxisSetpoint& from,
                                                                               const AxisSetpoint& to,
                                                                               const ProfileLimits& limits) noexcept;

}  // namespace driveline::trajectory
