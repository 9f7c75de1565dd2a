#pragma once

#include <cstdint>
#include <string_view>

namespace driveline::motion::cia402 {

/// Name in CiA 402-2 (IEC 61800-7-201) of a drive object that can be mapped into PDOs; empty for other objects. For
/// drives whose own description has no names.
[[nodiscard]] std::string_view object_name(std::uint16_t index, std::uint8_t subindex) noexcept;

}  // namespace driveline::motion::cia402
