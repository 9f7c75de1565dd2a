#pragma once

#include <cstdint>

namespace driveline::trajectory {

/// Why there is no profile.
struct ProfileError {
  /// What is wrong.
  enum class Reason : std::uint8_t {
    kLimits,         ///< a limit has the wrong sign, is zero, not a number, or an infinite acceleration
    kState,          ///< the start is not finite
    kTarget,         ///< the target is not finite, outside the limits, or cannot be reached or left inside them
    kTooLong,        ///< would take longer than kLongestProfile_s, or further than numbers go
    kTooShort,       ///< cannot be done in so short a time
    kBlocked,        ///< can be done faster and slower, but not in just this time
    kPositionRange,  ///< would leave the range of positions
    kAxes,           ///< the lists of axes differ in length, or there are too many
  };

  Reason reason = Reason::kLimits;   ///< what is wrong
  double possible_duration_s = 0.0;  ///< for kTooShort and kBlocked: the next longer duration that can be done

  /// \rtsafe
  friend bool operator==(const ProfileError&, const ProfileError&) noexcept = default;
};

/// No profile is longer, in s: at greater times the resolution of a double would be seen in its positions.
inline constexpr double kLongestProfile_s = 1e5;

}  // namespace driveline::trajectory
