#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

#include "driveline/esi/device_description.hpp"

namespace driveline::esi::test {

/// A servo drive that uses every field of the description, in the normal form of write_esi().
[[nodiscard]] DeviceDescription sample_device();

/// A random device in the normal form of write_esi().
[[nodiscard]] DeviceDescription random_device(std::mt19937& random);

/// The part of a description that an SII image contains.
[[nodiscard]] DeviceDescription sii_part(DeviceDescription device);

/// Bytes from hexadecimal digits; white space is ignored.
[[nodiscard]] std::vector<std::byte> bytes_of(std::string_view hex);

}  // namespace driveline::esi::test
