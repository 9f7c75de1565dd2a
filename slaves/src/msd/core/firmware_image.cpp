#include "driveline/slaves/msd/core/firmware_image.hpp"

#include <algorithm>
#include <array>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint32_t kSignature = 0x57464C44;  ///< "DLFW"
constexpr std::size_t kProductOffset = 4;
constexpr std::size_t kVersionOffset = 8;
constexpr std::size_t kLengthOffset = 12;
constexpr std::size_t kChecksumOffset = 16;
constexpr std::size_t kHeaderBytes = 20;

std::uint32_t checksum(std::span<const std::byte> bytes) noexcept {
  std::uint32_t hash = 0x811C9DC5;
  for (const auto byte : bytes) hash = (hash ^ std::to_integer<std::uint32_t>(byte)) * 0x01000193;
  return hash;
}

}  // namespace

std::vector<std::byte> make_firmware(Variant variant, FirmwareVersion version, std::span<const std::byte> program) {
  std::vector<std::byte> file(kHeaderBytes + program.size());
  const auto at = [&](std::size_t offset) { return std::span(file).subspan(offset); };
  bytes::store_le(at(0), kSignature);
  bytes::store_le(at(kProductOffset), facts(variant).product_code);
  const std::array numbers{version.major, version.minor, version.correction};
  for (std::size_t i = 0; i < numbers.size(); ++i) file[kVersionOffset + i] = static_cast<std::byte>(numbers[i]);
  bytes::store_le(at(kLengthOffset), static_cast<std::uint32_t>(program.size()));
  bytes::store_le(at(kChecksumOffset), checksum(program));
  std::copy(program.begin(), program.end(), file.begin() + kHeaderBytes);
  return file;
}

tl::expected<FirmwareVersion, FirmwareError> check_firmware(std::span<const std::byte> file, Variant variant) noexcept {
  const auto number = [&](std::size_t offset) { return bytes::load_le<std::uint32_t>(file.subspan(offset)); };
  if (file.size() < kHeaderBytes || number(0) != kSignature) return tl::unexpected(FirmwareError::kNoHeader);
  if (number(kProductOffset) != facts(variant).product_code) return tl::unexpected(FirmwareError::kProduct);
  const auto program = file.subspan(kHeaderBytes);
  if (number(kLengthOffset) != program.size()) return tl::unexpected(FirmwareError::kLength);
  if (number(kChecksumOffset) != checksum(program)) return tl::unexpected(FirmwareError::kChecksum);
  const auto part = [&](std::size_t i) { return std::to_integer<std::uint8_t>(file[kVersionOffset + i]); };
  const FirmwareVersion version{part(0), part(1), part(2)};
  constexpr std::uint8_t kTwoDigits = 99;
  if (version.minor > kTwoDigits || version.correction > kTwoDigits) return tl::unexpected(FirmwareError::kNoHeader);
  if (version < facts(variant).oldest) return tl::unexpected(FirmwareError::kTooOld);
  return version;
}

}  // namespace driveline::slaves::msd
