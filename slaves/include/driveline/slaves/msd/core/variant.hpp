#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace driveline::slaves::msd {

/// Drives of a family that share manual chapters, firmware and object dictionary; the differences are in kVariants and
/// in the table in variant.cpp, and are described in docs/servoone.md.
enum class Variant : std::uint8_t {
  kMsd,             ///< Moog MSD Servo Drive
  kServoOne,        ///< ServoOne, single and multi-axis system
  kServoOneJunior,  ///< ServoOne junior, with the RUN/ERROR indicator H1
};

/// Firmware version in the notation of the manuals: 4.15-02.
struct FirmwareVersion {
  std::uint8_t major = 0;       ///< before the point
  std::uint8_t minor = 0;       ///< after the point, two digits
  std::uint8_t correction = 0;  ///< after the hyphen, two digits

  // NOLINTNEXTLINE(modernize-use-nullptr): the finding is the 0 in the comparisons generated from <=>
  friend constexpr auto operator<=>(const FirmwareVersion&, const FirmwareVersion&) = default;
  /// Formats the version as "4.15-02". Not for use in the cycle.
  [[nodiscard]] std::string text() const;
  /// Parses "4.15-02", with or without a leading V: up to 255, then twice two digits. Returns nullopt for other
  /// formats.
  [[nodiscard]] static std::optional<FirmwareVersion> parse(std::string_view text);
};

/// Series that differ in their LEDs (MSD manual Tables 5.2-5.4, ServoOne manual Tables 5.2, 5.3).
enum class Series : std::uint8_t { kSingleMultiAxis, kCompact, kServoOne, kServoOneJunior };
/// Properties of a variant. Product codes and revisions are ours: no public source states the real ones. The vendor is
/// Moog for all variants (ours for the ServoOne, whose vendor ID no source states).
struct VariantFacts {
  Variant variant = Variant::kMsd;           ///< rows are in the order of the enumeration
  std::string_view key;                      ///< name in line descriptions
  std::string_view file_stem;                ///< base name of the generated device files
  std::string_view device_name;              ///< 1008h
  std::string_view type;                     ///< order code: ESI Type, SII order text
  std::string_view group_type;               ///< ESI GroupType
  std::string_view group_name;               ///< ESI name of the group
  std::uint32_t product_code = 0;            ///< 1018h:02, ours
  std::uint32_t revision = 0;                ///< 1018h:03, ours
  FirmwareVersion firmware;                  ///< default firmware
  FirmwareVersion oldest;                    ///< first version in the manual's scope
  Series series = Series::kSingleMultiAxis;  ///< determines the LEDs
  /// External feed-forward is effective only with P 370 = 2 (ServoOne manual 12.4).
  bool external_feed_forward_needs_spline = false;
  /// First firmware whose PDOs may have an odd number of bytes; earlier firmware fills them up with P 2055 (ServoOne
  /// manual 8.3.3, 9.1).
  FirmwareVersion odd_pdos_since;
};

/// One row per variant; see facts().
inline constexpr std::array kVariants = {
    VariantFacts{.variant = Variant::kMsd,
                 .key = "msd",
                 .file_stem = "moog_msd",
                 .device_name = "MSD Servo Drive",
                 .type = "G392",
                 .group_type = "MSD",
                 .group_name = "MSD servo drives",
                 .product_code = 0x4D534431,
                 .revision = 0x007C001E,
                 .firmware = {124, 30, 0},
                 .oldest = {124, 25, 0},
                 .odd_pdos_since = {124, 15, 2}},
    VariantFacts{.variant = Variant::kServoOne,
                 .key = "servoone",
                 .file_stem = "servoone",
                 .device_name = "ServoOne",
                 .type = "SO8",
                 .group_type = "ServoOne",
                 .group_name = "ServoOne servo drives",
                 .product_code = 0x00534F38,
                 .revision = 0x0004001E,
                 .firmware = {4, 30, 0},
                 .oldest = {3, 25, 0},
                 .series = Series::kServoOne,
                 .external_feed_forward_needs_spline = true,
                 .odd_pdos_since = {4, 15, 2}},
    VariantFacts{.variant = Variant::kServoOneJunior,
                 .key = "servoone_junior",
                 .file_stem = "servoone_junior",
                 .device_name = "ServoOne junior",
                 .type = "SO2",
                 .group_type = "ServoOne",
                 .group_name = "ServoOne servo drives",
                 .product_code = 0x00534F32,
                 .revision = 0x0004001E,
                 .firmware = {4, 30, 0},
                 .oldest = {1, 30, 0},
                 .series = Series::kServoOneJunior,
                 .external_feed_forward_needs_spline = true,
                 .odd_pdos_since = {4, 15, 2}},
};

/// \rtsafe
[[nodiscard]] constexpr const VariantFacts& facts(Variant variant) noexcept {
  return kVariants[static_cast<std::size_t>(variant)];
}
inline constexpr std::uint32_t kVendorId = 0x00000028;  ///< Moog
/// 1018h:02 of the MSD; other variants have different ones
inline constexpr std::uint32_t kProductCode = facts(Variant::kMsd).product_code;
inline constexpr std::uint32_t kRevision = facts(Variant::kMsd).revision;  ///< 1018h:03 of the MSD

/// Returns the variant with the name `key` in line descriptions; nullopt when there is none.
[[nodiscard]] std::optional<Variant> find_variant(std::string_view key) noexcept;

}  // namespace driveline::slaves::msd
