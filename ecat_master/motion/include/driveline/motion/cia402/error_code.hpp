#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Texts of drive error codes (603Fh, emergencies) according to IEC 61800-7-201 (CiA 402-2).
namespace driveline::motion::cia402 {

/// Name of an error code, such as "continuous overcurrent" for 0x2310; the name of its group if the standard has none
/// for the code itself; "manufacturer-specific" above 0xFF00; empty for 0 and unknown groups.
[[nodiscard]] std::string_view error_name(std::uint16_t code) noexcept;

/// Code and name, such as "0x2310, continuous overcurrent"; only the number if there is no name. Not for use in the
/// cycle.
[[nodiscard]] std::string error_text(std::uint16_t code);

}  // namespace driveline::motion::cia402
