#pragma once

#include <cstdint>

namespace driveline::ecat_master::dc {

/// Why a loop is not locked.
enum class LockCause : std::uint8_t {
  kNone,            ///< the loop is locked
  kAcquiring,       ///< not locked yet since the start
  kNoReference,     ///< no measurement for too long
  kPhaseError,      ///< the reference clock moved faster than the loop follows
  kFrequencyLimit,  ///< the frequency of the reference clock is too far off to follow
};

/// Largest magnitude of the frequency difference that is followed, in ppm; LockCause::kFrequencyLimit beyond it.
inline constexpr double kMaxFrequencyPpm = 500.0;

}  // namespace driveline::ecat_master::dc
