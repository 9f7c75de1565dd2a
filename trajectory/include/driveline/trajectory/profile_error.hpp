#pragma once

#include <cstdint>

namespace driveline::trajectory {

/// Reason why there is no profile.
struct ProfileError {
  /// The kind of error.
  enum class Reason : std::uint8_t {
    kLimits,         ///< a limit has the wrong sign, is zero, not a number, or an infinite acceleration
    kState,          ///< the start is not finite
    kTarget,         ///< the target is not finite, outside the limits, or cannot be reached or left inside them
    kTooLong,        ///< takes longer than kLongestProfileSeconds, or exceeds the range of floating-point numbers
    kTooShort,       ///< impossible in so short a time
    kBlocked,        ///< possible faster and slower, but not in exactly this time
    kPositionRange,  ///< leaves the range of positions
    kAxes,           ///< the lists of axes differ in length, or have too many axes
  };

  Reason reason = Reason::kLimits;   ///< kind of error
  double possible_duration_s = 0.0;  ///< for kTooShort and kBlocked: next longer possible duration

  /// Compares all fields. \rtsafe
  friend bool operator==(const ProfileError&, const ProfileError&) noexcept = default;
};

/// Longest duration of a profile in s: at greater times the resolution of a double would be visible in its positions.
inline constexpr double kLongestProfileSeconds = 1e5;

}  // namespace driveline::trajectory
