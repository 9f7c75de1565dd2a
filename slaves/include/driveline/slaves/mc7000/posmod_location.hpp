#pragma once

#include <cstdint>
#include <string_view>

/// MASTERDRIVE MC7000: the sequence language PosMod of its positioning and sequence control.
namespace driveline::slaves::mc7000 {

/// Error code of the drive with which PosMod reports every location below (MC7000 manual, lines 1536, 1570).
inline constexpr std::uint8_t kPosModErrorCode = 26;

/// Error locations of PosMod (MC7000 manual, lines 1572-1600).
enum class PosModLocation : std::uint8_t {
  kNone = 0,
  kPositiveLimitSwitch = 210,
  kNegativeLimitSwitch = 211,
  kPositiveSoftwareLimit = 212,
  kNegativeSoftwareLimit = 213,
  kNoReference = 214,
  kNoHardware = 215,
  kNoProgram = 216,
  kNoRecord = 217,
  kNoSubroutine = 218,
  kOutsideRange = 219,
  kDivisionByZero = 220,
  kNesting = 221,
  kManualTimeout = 222,
  kNotReached = 223,
  kNoFeed = 224,
  kHeldByPcProgram = 225,
  kIndexOverflow = 226,
  kTooFast = 230,
  kNotEnabled = 232,
  kMoving = 235,
};

/// Returns the meaning of a location; empty for a number that has none. \rtsafe
[[nodiscard]] std::string_view text_of(PosModLocation location) noexcept;

}  // namespace driveline::slaves::mc7000
