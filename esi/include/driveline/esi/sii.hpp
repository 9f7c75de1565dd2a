#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "driveline/esi/device_description.hpp"

/// The slave information interface (SII): the content of the EEPROM that every slave controller has (ETG.1000.6 5.4,
/// ETG.2010). Words are 16 bits, little endian; the first 64 words are fixed, categories follow.
///
/// Decoding preserves every byte: for each image that decode_sii() accepts, encode_sii() returns the same bytes.
namespace driveline::esi {

/// Category types of the standard (ETG.1000.6 Table 17). Categories of other types are stored as raw bytes.
enum class SiiCategoryType : std::uint16_t {
  kStrings = 10,
  kDataTypes = 20,
  kGeneral = 30,
  kFmmu = 40,
  kSyncManager = 41,
  kFmmuExtended = 42,
  kSyncUnit = 43,
  kTxPdo = 50,
  kRxPdo = 51,
  kDistributedClock = 60,
  kEnd = 0xFFFF,
};

/// Words 0x00-0x06, which the slave controller loads at power-on; the checksum covers them.
struct SiiConfigArea {
  std::uint16_t pdi_control = 0;            ///< registers 0x0140/0x0141
  std::uint16_t pdi_configuration = 0;      ///< registers 0x0150/0x0151
  std::uint16_t sync_impulse_10ns = 0;      ///< register 0x0982
  std::uint16_t pdi_configuration2 = 0;     ///< registers 0x0152/0x0153
  std::uint16_t station_alias = 0;          ///< register 0x0012
  std::array<std::uint16_t, 2> reserved{};  ///< as read

  static constexpr std::size_t kSize = 14;  ///< bytes that the checksum covers
  /// Returns the area as it is stored in the EEPROM, for the checksum.
  [[nodiscard]] std::array<std::byte, kSize> bytes() const noexcept;
  bool operator==(const SiiConfigArea&) const = default;
};

/// Location of the mailbox sync managers in one state (words 0x14-0x17 bootstrap, 0x18-0x1B standard).
struct SiiMailboxWindow {
  std::uint16_t receive_offset = 0;  ///< master to slave
  std::uint16_t receive_size = 0;    ///< bytes; 0: no mailbox
  std::uint16_t send_offset = 0;     ///< slave to master
  std::uint16_t send_size = 0;       ///< bytes; 0: no mailbox
  bool operator==(const SiiMailboxWindow&) const = default;
};

/// Bits of the supported mailbox protocols, word 0x1C (ETG.1000.6 Table 18).
namespace sii_mailbox {
inline constexpr std::uint16_t kAoe = 0x0001;  ///< ADS over EtherCAT
inline constexpr std::uint16_t kEoe = 0x0002;  ///< Ethernet over EtherCAT
inline constexpr std::uint16_t kCoe = 0x0004;  ///< CANopen over EtherCAT
inline constexpr std::uint16_t kFoe = 0x0008;  ///< File access over EtherCAT
inline constexpr std::uint16_t kSoe = 0x0010;  ///< Servo drive profile over EtherCAT
inline constexpr std::uint16_t kVoe = 0x0020;  ///< vendor-specific protocol over EtherCAT
}  // namespace sii_mailbox

/// Category 10. Other categories refer to its texts by number, starting at 1.
struct SiiStrings {
  std::vector<std::string> texts;  ///< at most 255 texts of at most 255 bytes each
  std::vector<std::byte> padding;  ///< bytes from the last text to the end of the category
  bool operator==(const SiiStrings&) const = default;
};

/// Category 30 (ETG.1000.6 Table 21). Members that end in `_text` are string numbers, 0 for none.
struct SiiGeneral {
  std::uint8_t group_text = 0;       ///< name of the group
  std::uint8_t image_text = 0;       ///< name of the picture
  std::uint8_t order_text = 0;       ///< order number
  std::uint8_t name_text = 0;        ///< name of the device
  std::uint8_t reserved1 = 0;        ///< as read
  std::uint8_t coe_details = 0;      ///< kCoe... bits
  std::uint8_t foe_details = 0;      ///< bit 0: FoE supported
  std::uint8_t eoe_details = 0;      ///< bit 0: EoE supported
  std::uint8_t soe_channels = 0;     ///< 0 in current images
  std::uint8_t ds402_channels = 0;   ///< 0 in current images
  std::uint8_t sysman_class = 0;     ///< 0 in current images
  std::uint8_t flags = 0;            ///< bit 0: "enable SAFEOP", kEnableNotLrw, kIdentification
  std::int16_t ebus_current_ma = 0;  ///< current drawn from the E-bus; negative: feeds the E-bus
  std::uint8_t group_name_text = 0;  ///< group's name on real devices; by the standard, a copy of group_text
  std::uint8_t reserved2 = 0;        ///< high byte of the word that holds group_name_text
  std::uint16_t physical_ports = 0;  ///< four bits per port: 0 none, 1 MII, 3 E-bus, 4 fast hot connect
  std::vector<std::byte> further;    ///< the rest of the category, 14 bytes in current images

  static constexpr std::uint8_t kCoeSdo = 0x01;  ///< SDO transfers
  static constexpr std::uint8_t kCoeSdoInfo = 0x02;
  static constexpr std::uint8_t kCoePdoAssign = 0x04;        ///< PDO assignment can be changed
  static constexpr std::uint8_t kCoePdoConfig = 0x08;        ///< PDO mapping can be changed
  static constexpr std::uint8_t kCoeUploadAtStartup = 0x10;  ///< the master reads the PDOs at start-up
  static constexpr std::uint8_t kCoeCompleteAccess = 0x20;
  static constexpr std::uint8_t kEnableNotLrw = 0x02;    ///< in `flags`: the device needs LWR and LRD instead of LRW
  static constexpr std::uint8_t kIdentification = 0x08;  ///< in `flags`: ID in register 0x0134 (ETG.1000.6 Table 22)
  static constexpr std::size_t kMinSize = 18;            ///< bytes that every image has
  static constexpr std::size_t kFurtherSize = 14;        ///< bytes after kMinSize in current images
  bool operator==(const SiiGeneral&) const = default;
};

/// Category 40: one byte per FMMU; 0xFF (also used as padding to a whole word) or 0: unused; see FmmuUse.
struct SiiFmmus {
  std::vector<std::uint8_t> uses;  ///< by FMMU number
  bool operator==(const SiiFmmus&) const = default;
};

/// An element of category 41 (ETG.1000.6 Table 23): the register contents of a sync manager and its use.
struct SiiSyncManager {
  std::uint16_t start_address = 0;  ///< address in the slave's memory
  std::uint16_t length = 0;         ///< bytes; 0: as large as the PDOs need
  std::uint8_t control = 0;         ///< wire::SyncManagerControl::raw()
  std::uint8_t status = 0;          ///< meaningless in the EEPROM
  std::uint8_t enable = 0;          ///< bit 0 enable, bit 1 fixed content, bit 2 virtual, bit 3 only in OP
  std::uint8_t use = 0;             ///< SyncManager::Use

  static constexpr std::size_t kSize = 8;  ///< bytes in the image
  bool operator==(const SiiSyncManager&) const = default;
};

/// An entry of a PDO in the EEPROM (ETG.1000.6 Table 25).
struct SiiPdoEntry {
  std::uint16_t index = 0;      ///< 0: a gap
  std::uint8_t subindex = 0;    ///< sub-index of the mapped entry
  std::uint8_t name_text = 0;   ///< number of a string
  std::uint8_t data_type = 0;   ///< index of the data type in the object dictionary
  std::uint8_t bit_length = 0;  ///< length in the process data
  std::uint16_t flags = 0;      ///< 0 in current images

  static constexpr std::size_t kSize = 8;  ///< bytes in the image
  bool operator==(const SiiPdoEntry&) const = default;
};

/// An element of categories 50 (TxPDO) and 51 (RxPDO), ETG.1000.6 Table 24.
struct SiiPdo {
  std::uint16_t index = 0;           ///< index of the PDO
  std::uint8_t sync_manager = 0xFF;  ///< default assignment; 0xFF: none
  std::uint8_t dc_sync = 0;          ///< clock mode that the PDO belongs to; 0 in current images
  std::uint8_t name_text = 0;        ///< number of a string
  std::uint16_t flags = 0;           ///< kMandatory, kFixedContent
  std::vector<SiiPdoEntry> entries;  ///< at most 255

  static constexpr std::size_t kHeaderSize = 8;           ///< bytes in the image
  static constexpr std::uint8_t kNoSyncManager = 0xFF;    ///< `sync_manager`: not assigned by default
  static constexpr std::uint16_t kMandatory = 0x0001;     ///< `flags`: always assigned
  static constexpr std::uint16_t kFixedContent = 0x0010;  ///< `flags`: the mapping cannot be changed
  bool operator==(const SiiPdo&) const = default;
};

/// An element of category 60 (ETG.2010 Table "DC").
struct SiiDcMode {
  std::uint32_t cycle_time_sync0_ns = 0;     ///< 0: bus cycle time times the factor
  std::uint32_t shift_time_sync0_ns = 0;     ///< from the start of the bus cycle to SYNC0
  std::uint32_t shift_time_sync1_ns = 0;     ///< from SYNC0 to SYNC1
  std::int16_t cycle_time_sync1_factor = 0;  ///< SYNC0 cycles per SYNC1 cycle
  std::uint16_t assign_activate = 0;         ///< registers 0x0980/0x0981
  std::int16_t cycle_time_sync0_factor = 0;  ///< bus cycles per SYNC0 cycle
  std::uint8_t name_text = 0;                ///< number of a string
  std::uint8_t description_text = 0;         ///< number of a string
  std::array<std::byte, 4> reserved{};       ///< as read

  static constexpr std::size_t kSize = 24;  ///< bytes in the image
  bool operator==(const SiiDcMode&) const = default;
};

/// A category that is not interpreted: 20, 42, 43, and those of vendors and of later editions of the standard.
struct SiiRaw {
  std::vector<std::byte> bytes;  ///< an even number of bytes
  bool operator==(const SiiRaw&) const = default;
};

/// Content of a category; the type of the category selects the alternative.
using SiiContent = std::variant<SiiRaw, SiiStrings, SiiGeneral, SiiFmmus, std::vector<SiiSyncManager>,
                                std::vector<SiiPdo>, std::vector<SiiDcMode>>;

/// A category: its type, and its content, decoded if the type is known.
struct SiiCategory {
  SiiCategoryType type = SiiCategoryType::kEnd;  ///< type number of the category
  SiiContent content;                            ///< decoded content, or the raw bytes
  bool operator==(const SiiCategory&) const = default;
};

/// A complete EEPROM image, decoded.
struct SiiImage {
  SiiConfigArea config;                      ///< words 0x00-0x06
  std::uint16_t checksum = 0;                ///< low byte: CRC of the configuration area, as read; see checksum_valid()
  std::uint32_t vendor_id = 0;               ///< words 0x08-0x09
  std::uint32_t product_code = 0;            ///< words 0x0A-0x0B
  std::uint32_t revision = 0;                ///< words 0x0C-0x0D
  std::uint32_t serial_number = 0;           ///< words 0x0E-0x0F, 0: none
  std::array<std::uint16_t, 4> delays{};     ///< words 0x10-0x13: execution and port delays, reserved in newer editions
  SiiMailboxWindow bootstrap_mailbox;        ///< words 0x14-0x17
  SiiMailboxWindow standard_mailbox;         ///< words 0x18-0x1B
  std::uint16_t mailbox_protocols = 0;       ///< sii_mailbox bits
  std::array<std::uint16_t, 33> reserved{};  ///< words 0x1D-0x3D
  std::uint16_t size_word = 0;               ///< EEPROM size in KiBit minus 1
  std::uint16_t version = 1;                 ///< word 0x3F: version of the format
  std::vector<SiiCategory> categories;       ///< in the order of the image, without the end category
  std::vector<std::byte> tail;               ///< bytes from the end category to the last byte that is not 0xFF
  std::size_t image_bytes = 0;  ///< length of the image; shorter than eeprom_bytes() for a partial read-out

  /// Returns the size of the EEPROM according to its size word, 128 bytes to 8 MiB.
  [[nodiscard]] std::size_t eeprom_bytes() const noexcept { return (std::size_t{size_word} + 1) * 128; }
  /// Whether the checksum matches the configuration area; the slave controller loads the area only then. 0x88A4
  /// disables the check (ESC data sheet, EEPROM layout, for debugging).
  [[nodiscard]] bool checksum_valid() const noexcept;
  /// Returns text `number` of the string category; empty for 0 and for numbers that do not exist.
  [[nodiscard]] std::string_view text(std::uint8_t number) const noexcept;
  /// Returns the content of the first category `type` with content T, or nullptr when there is none.
  template <typename T>
  [[nodiscard]] const T* find(SiiCategoryType type) const noexcept {
    for (const auto& category : categories) {
      if (category.type != type) continue;
      if (const auto* content = std::get_if<T>(&category.content)) return content;
    }
    return nullptr;
  }
  bool operator==(const SiiImage&) const = default;
};

/// Kind of error in an image.
enum class SiiErrorCode : std::uint8_t {
  kOddSize,        ///< not a whole number of words
  kNoHeader,       ///< shorter than the 64 fixed words
  kNoEnd,          ///< the image ends where a category should start
  kLongCategory,   ///< the length of a category exceeds the image
  kBadSize,        ///< the size of a category is not a multiple of its element size, or smaller than its fixed part
  kLongText,       ///< a string exceeds its category
  kLongEntryList,  ///< a PDO has more entries than fit into its category
};

/// Why and where an image was rejected.
struct SiiError {
  SiiErrorCode code = SiiErrorCode::kNoHeader;       ///< kind of error
  SiiCategoryType category = SiiCategoryType::kEnd;  ///< kEnd: outside the categories
  std::size_t word_offset = 0;                       ///< position of the invalid element
  std::size_t needed_bytes = 0;                      ///< 0: not applicable
  std::size_t available_bytes = 0;                   ///< 0: not applicable
  bool operator==(const SiiError&) const = default;
};

/// Formats the error as a sentence for display.
[[nodiscard]] std::string to_text(const SiiError& error);
/// The same.
[[nodiscard]] inline std::string describe(const SiiError& error) {
  return to_text(error);
}

/// Returns the CRC-8 of the configuration area: polynomial x^8 + x^2 + x + 1, initial value 0xFF (ETG.1000.6 5.4, word
/// 0x07).
[[nodiscard]] std::uint8_t sii_checksum(std::span<const std::byte, SiiConfigArea::kSize> config) noexcept;

/// Decodes an EEPROM image and checks every length. A wrong checksum is not an error, see SiiImage::checksum_valid().
[[nodiscard]] tl::expected<SiiImage, SiiError> decode_sii(std::span<const std::byte> image);

/// Returns the bytes of an image: header, categories, end category, tail, then 0xFF up to `image_bytes` (the result is
/// longer if the content is longer).
[[nodiscard]] std::vector<std::byte> encode_sii(const SiiImage& image);

/// Creates the SII image of a device, checksum included, with the length of its EEPROM. The EEPROM size is doubled
/// until the content fits. Content that exceeds the format is cut: texts after 255 bytes, texts and PDO entries after
/// number 255.
[[nodiscard]] SiiImage make_sii(const DeviceDescription& device);

/// Returns the device described by an SII image. The SII does not contain vendor name, objects, device profile, minimum
/// and maximum of sync manager sizes, and SYNC1 cycle time.
[[nodiscard]] DeviceDescription description_from_sii(const SiiImage& image);

}  // namespace driveline::esi
