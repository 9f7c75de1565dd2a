#pragma once

#include <cstdint>

namespace driveline::ecat_master::dc {

/// Why a loop is not locked.
enum class LockCause : std::uint8_t {
  kNone,            ///< it is
  kAcquiring,       ///< has not been locked yet
  kNoReference,     ///< no measurement for too long
  kPhaseError,      ///< the reference clock has moved faster than the loop follows
  kFrequencyLimit,  ///< the reference clock is too far off to be followed
};

/// Greatest frequency difference between two clocks that is followed, either way; LockCause::kFrequencyLimit is beyond.
inline constexpr double kMaxFrequencyPpm = 500.0;

}  // namespace driveline::ecat_master::dc
