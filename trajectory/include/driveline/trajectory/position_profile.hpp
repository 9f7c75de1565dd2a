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

/// The fastest motion of one axis from any state to a position, velocity and acceleration. Where the start is outside
/// the limits, the axis is first brought back inside as fast as possible, and then takes the fastest way that stays
/// inside. With an infinite jerk limit the accelerations of both ends do not count. The target must be inside the
/// limits, and so must what comes before and after it: with a target acceleration a < 0, velocity + a^2 / (2 jerk) <=
/// max_velocity. Bounded cost, no allocation. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                   const ProfileLimits& limits) noexcept;

/// The same in exactly the given time, with as little of the limits as the mixture of the farthest and the shortest
/// motion of this duration needs. An error names the next longer duration that is possible. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                   const ProfileLimits& limits,
                                                                   double duration_s) noexcept;

/// What to do about a motion that would leave a range of positions.
enum class OutOfRange : std::uint8_t {
  kRefuse,  ///< there is no profile
  /// The axis is brought to a standstill instead, as fast as possible, and Profile::end() is not the target. One that
  /// is too fast for the range leaves it all the same.
  kBrake,
};

/// The fastest motion, if it stays within a range of positions on its whole way. \rtsafe
[[nodiscard]] tl::expected<Profile, ProfileError> plan_to_position(const AxisSetpoint& from, const AxisSetpoint& to,
                                                                   const ProfileLimits& limits,
                                                                   const PositionRange& range,
                                                                   OutOfRange otherwise) noexcept;

/// In which time a motion can be done: in the shortest one and any longer one that is not between the ends of a gap.
class PossibleDurations {
 public:
  /// Two for the acceleration at the ends, up to three on the way.
  static constexpr std::size_t kMaxGaps = 8;

  /// Durations between the two are impossible; the ends themselves are possible.
  struct Gap {
    double begin_s = 0.0;  ///< the longest duration before it
    double end_s = 0.0;    ///< the shortest duration behind it
  };

  /// \rtsafe
  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }
  /// In the order of time. \rtsafe
  [[nodiscard]] std::span<const Gap> gaps() const noexcept { return {gaps_.data(), count_}; }

 private:
  friend tl::expected<PossibleDurations, ProfileError> possible_durations(const AxisSetpoint& from,
                                                                          const AxisSetpoint& to,
                                                                          const ProfileLimits& limits) noexcept;

  double shortest_s_ = 0.0;
  std::array<Gap, kMaxGaps> gaps_;
  std::size_t count_ = 0;
};

/// All durations in which plan_to_position can do a motion. \rtsafe
[[nodiscard]] tl::expected<PossibleDurations, ProfileError> possible_durations(const AxisSetpoint& from,
                                                                               const AxisSetpoint& to,
                                                                               const ProfileLimits& limits) noexcept;

}  // namespace driveline::trajectory
