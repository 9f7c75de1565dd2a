#pragma once

#include <cstdint>

namespace driveline::ecat_master {

/// What a touch probe of a drive latches the position at (CiA 402-2 "Touch probe functionality"; MSD manual 14.1.1).
enum class ProbeTrigger : std::uint8_t {
  kFirstRising,    ///< touch probe 1, rising edge: 60BAh
  kFirstFalling,   ///< 60BBh
  kSecondRising,   ///< touch probe 2, rising edge: 60BCh
  kSecondFalling,  ///< 60BDh
  kZeroPulse,      ///< of the encoder, by touch probe 1: 60BAh
};

}  // namespace driveline::ecat_master
