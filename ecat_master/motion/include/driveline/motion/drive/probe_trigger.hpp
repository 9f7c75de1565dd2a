#pragma once

#include <cstdint>

namespace driveline::motion {

/// Event at which a touch probe of a drive latches the position (CiA 402-2 "Touch probe functionality"; MSD manual
/// 14.1.1).
enum class ProbeTrigger : std::uint8_t {
  kFirstRising,    ///< touch probe 1, rising edge: 60BAh
  kFirstFalling,   ///< touch probe 1, falling edge: 60BBh
  kSecondRising,   ///< touch probe 2, rising edge: 60BCh
  kSecondFalling,  ///< touch probe 2, falling edge: 60BDh
  kZeroPulse,      ///< zero pulse of the encoder, by touch probe 1: 60BAh
};

}  // namespace driveline::motion
