#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace driveline::cli {

/// An EEPROM image section by section, as hexadecimal bytes with readable text: the fixed words, then every category
/// with its number, name and offset. Bytes that belong to no category, because one is longer than the image, are shown
/// as the remainder.
[[nodiscard]] std::string sii_dump(std::span<const std::byte> image);

}  // namespace driveline::cli
