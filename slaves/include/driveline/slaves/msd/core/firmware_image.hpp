#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/msd/core/variant.hpp"

namespace driveline::slaves::msd {

/// Why a file is not a firmware of a drive.
enum class FirmwareError : std::uint8_t {
  kNoHeader,  ///< it does not start like a firmware, or ends within its header
  kProduct,   ///< the firmware is for another drive
  kLength,    ///< the content is longer or shorter than the header states
  kChecksum,  ///< the content is damaged
  kTooOld,    ///< older than any version of this drive
};

/// Creates a firmware file. The format is ours; the format of the real drive is not described. Little endian: "DLFW",
/// product code, version (three bytes, the fourth is 0), length and checksum (FNV-1a) of the content, which has no
/// meaning.
[[nodiscard]] std::vector<std::byte> make_firmware(Variant variant, FirmwareVersion version,
                                                   std::span<const std::byte> program);

/// Checks a firmware file for this drive and returns its version.
[[nodiscard]] tl::expected<FirmwareVersion, FirmwareError> check_firmware(std::span<const std::byte> file,
                                                                          Variant variant) noexcept;

}  // namespace driveline::slaves::msd
