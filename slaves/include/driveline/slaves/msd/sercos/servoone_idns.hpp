#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "driveline/slaves/idn/idn_table.hpp"

/// Operation data of the ServoOne with SERCOS ("ServoOne User Manual SERCOS II interface", 1100.29B.2-00).
namespace driveline::slaves::msd::sercos {

/// Values with several IDNs.
struct ServoOneValues : SlotNumbers {
  constexpr ServoOneValues() noexcept : SlotNumbers(0) {}
  Slot<std::uint32_t> tracking_limit{next()};  ///< P 742 and P 743: position difference that is a fault
  Slot<std::int32_t> tracking_error{next()};   ///< S-0-0189 and P 279
};
inline constexpr ServoOneValues kServoOneValue{};

/// Number of the parameter of the device that a parameter S-0-0000 has: S-0-n is parameter 10000 + n (SERCOS manual
/// 392).
inline constexpr std::uint16_t kFirstStandardParameter = 10000;

/// Returns the number of the parameter of the device that an IDN of parameter set 0 addresses: n for P n, 10000 + n for
/// S-0-n (SERCOS manual 392-400). \rtsafe
[[nodiscard]] constexpr std::uint16_t parameter_number(wire::Idn idn) noexcept {
  const auto number = static_cast<std::uint16_t>(idn.raw & 0x0FFFU);
  return (idn.raw & 0x8000U) != 0 ? number : static_cast<std::uint16_t>(kFirstStandardParameter + number);
}
/// Returns the IDN of a parameter of the device; nullopt for numbers that no IDN addresses. \rtsafe
[[nodiscard]] constexpr std::optional<wire::Idn> idn_of_parameter(std::uint16_t number) noexcept {
  if (number <= 0x0FFF) return wire::Idn{static_cast<std::uint16_t>(0x8000U | number)};
  const bool standard = number >= kFirstStandardParameter && number <= kFirstStandardParameter + 0x0FFF;
  if (!standard) return std::nullopt;
  return wire::Idn{static_cast<std::uint16_t>(number - kFirstStandardParameter)};
}

/// Returns the table of the ServoOne's 479 IDNs: the 475 of Table 10.1 of its manual and the four that its text needs
/// beside them (P 156, 279, 743, 2242). IdnRow::line is a line of the manual. The manual has no types, lengths, limits
/// and defaults, so IdnRow::source names for each row where these are from:
///
/// - `manual N`: line N of the manual, where the text gives a number outside the table
/// - `as the MSD`: the parameter of the same number in the object dictionary of the sibling drive, whose row names its
///   own source; numbers of one byte have two
/// - `AX2000`, `AX5000`: IDN pages of AX2000-B750 and AX5000 (infosys.beckhoff.com)
/// - `S300`: "sercos II for S300/S700", Kollmorgen, edition 04/2016
/// - `ours`: no source states it
///
/// Which data are saved and which telegram may carry them is ours.
[[nodiscard]] const IdnTable& servoone_idns();

/// Returns the reference page of these IDNs in Markdown.
[[nodiscard]] std::string idn_reference();

}  // namespace driveline::slaves::msd::sercos
