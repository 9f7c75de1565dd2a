#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Error codes of drives (603Fh, emergencies) in words: IEC 61800-7-201 (CiA 402-2), error codes.
namespace driveline::ecat_master::cia402 {

/// "continuous overcurrent" for 0x2310; the name of its group where the standard has none for the code itself,
/// "manufacturer-specific" above 0xFF00; empty for 0 and unknown groups.
[[nodiscard]] std::string_view error_name(std::uint16_t code) noexcept;

/// "0x2310, continuous overcurrent"; the number alone where there is no name. Not for use in the cycle.
[[nodiscard]] std::string error_text(std::uint16_t code);

}  // namespace driveline::ecat_master::cia402
