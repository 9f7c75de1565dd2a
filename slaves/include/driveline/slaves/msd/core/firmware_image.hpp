#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/msd/core/variant.hpp"

namespace driveline::slaves::msd {

/// Why a file is no firmware for a drive.
enum class FirmwareError : std::uint8_t {
  kNoHeader,  ///< it does not begin as a firmware does, or ends in its header
  kProduct,   ///< it is for another drive
  kLength,    ///< more or less follows than the header says
  kChecksum,  ///< what follows is damaged
  kTooOld,    ///< older than any version of this drive
};

/// A firmware as a file. The form is ours; what the real drive takes is not described. Little endian: "DLFW", product
/// code, version (three bytes, the fourth 0), length and checksum (FNV-1a) of what follows, which is of no meaning.
[[nodiscard]] std::vector<std::byte> make_firmware(Variant variant, FirmwareVersion version,
                                                   std::span<const std::byte> program);

/// The version of a firmware for this drive.
[[nodiscard]] tl::expected<FirmwareVersion, FirmwareError> check_firmware(std::span<const std::byte> file,
                                                                          Variant variant) noexcept;

}  // namespace driveline::slaves::msd
