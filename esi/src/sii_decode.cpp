#include <algorithm>
#include <optional>

#include "byte_reader.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::esi {
namespace {

constexpr std::size_t kHeaderBytes = 128;
constexpr std::size_t kWordBytes = 2;

void read_window(ByteReader& in, SiiMailboxWindow& window) {
  in.read(window.receive_offset);
  in.read(window.receive_size);
  in.read(window.send_offset);
  in.read(window.send_size);
}

void read_header(ByteReader& in, SiiImage& image) {
  in.read(image.config.pdi_control);
  in.read(image.config.pdi_configuration);
  in.read(image.config.sync_impulse_10ns);
  in.read(image.config.pdi_configuration2);
  in.read(image.config.station_alias);
  in.read(image.config.reserved);
  in.read(image.checksum);
  in.read(image.vendor_id);
  in.read(image.product_code);
  in.read(image.revision);
  in.read(image.serial_number);
  in.read(image.delays);
  read_window(in, image.bootstrap_mailbox);
  read_window(in, image.standard_mailbox);
  in.read(image.mailbox_protocols);
  in.read(image.reserved);
  in.read(image.size_word);
  in.read(image.version);
}

/// Decodes the content of a category; offsets in errors are relative to the image.
class CategoryDecoder {
 public:
  CategoryDecoder(SiiCategoryType type, std::span<const std::byte> bytes, std::size_t image_offset)
      : type_(type), in_(bytes), image_offset_(image_offset) {}

  tl::expected<SiiContent, SiiError> decode() {
    switch (type_) {
      case SiiCategoryType::kStrings:
        return strings();
      case SiiCategoryType::kGeneral:
        return general();
      case SiiCategoryType::kFmmu:
        return fmmus();
      case SiiCategoryType::kSyncManager:
        return sync_managers();
      case SiiCategoryType::kTxPdo:
      case SiiCategoryType::kRxPdo:
        return pdos();
      case SiiCategoryType::kDistributedClock:
        return dc_modes();
      default:
        return SiiContent(SiiRaw{in_.take_rest()});
    }
  }

 private:
  [[nodiscard]] tl::unexpected<SiiError> error(SiiErrorCode code, std::size_t needed) const {
    return tl::unexpected(SiiError{code, type_, (image_offset_ + in_.position()) / kWordBytes, needed, in_.left()});
  }

  tl::expected<SiiContent, SiiError> strings() {
    SiiStrings strings;
    if (in_.left() < 1) return error(SiiErrorCode::kBadSize, 1);
    const auto count = in_.number<std::uint8_t>();
    for (unsigned i = 0; i < count; ++i) {
      if (in_.left() < 1) return error(SiiErrorCode::kLongText, 1);
      const auto length = in_.number<std::uint8_t>();
      if (in_.left() < length) return error(SiiErrorCode::kLongText, length);
      std::string text;
      for (const std::byte b : in_.raw(length)) text.push_back(static_cast<char>(b));
      strings.texts.push_back(std::move(text));
    }
    strings.padding = in_.take_rest();
    return SiiContent(std::move(strings));
  }

  tl::expected<SiiContent, SiiError> general() {
    if (in_.left() < SiiGeneral::kMinSize) return error(SiiErrorCode::kBadSize, SiiGeneral::kMinSize);
    SiiGeneral general;
    in_.read(general.group_text);
    in_.read(general.image_text);
    in_.read(general.order_text);
    in_.read(general.name_text);
    in_.read(general.reserved1);
    in_.read(general.coe_details);
    in_.read(general.foe_details);
    in_.read(general.eoe_details);
    in_.read(general.soe_channels);
    in_.read(general.ds402_channels);
    in_.read(general.sysman_class);
    in_.read(general.flags);
    in_.read(general.ebus_current_ma);
    in_.read(general.group_name_text);
    in_.read(general.reserved2);
    in_.read(general.physical_ports);
    general.further = in_.take_rest();
    return SiiContent(std::move(general));
  }

  tl::expected<SiiContent, SiiError> fmmus() {
    SiiFmmus fmmus;
    while (in_.left() > 0) fmmus.uses.push_back(in_.number<std::uint8_t>());
    return SiiContent(std::move(fmmus));
  }

  tl::expected<SiiContent, SiiError> sync_managers() {
    std::vector<SiiSyncManager> list;
    while (in_.left() > 0) {
      if (in_.left() < SiiSyncManager::kSize) return error(SiiErrorCode::kBadSize, SiiSyncManager::kSize);
      SiiSyncManager& sm = list.emplace_back();
      in_.read(sm.start_address);
      in_.read(sm.length);
      in_.read(sm.control);
      in_.read(sm.status);
      in_.read(sm.enable);
      in_.read(sm.use);
    }
    return SiiContent(std::move(list));
  }

  tl::expected<SiiContent, SiiError> pdos() {
    std::vector<SiiPdo> list;
    while (in_.left() > 0) {
      if (in_.left() < SiiPdo::kHeaderSize) return error(SiiErrorCode::kBadSize, SiiPdo::kHeaderSize);
      SiiPdo& pdo = list.emplace_back();
      in_.read(pdo.index);
      const auto entries = in_.number<std::uint8_t>();
      in_.read(pdo.sync_manager);
      in_.read(pdo.dc_sync);
      in_.read(pdo.name_text);
      in_.read(pdo.flags);
      if (in_.left() < entries * SiiPdoEntry::kSize) {
        return error(SiiErrorCode::kLongEntryList, entries * SiiPdoEntry::kSize);
      }
      for (unsigned i = 0; i < entries; ++i) pdo.entries.push_back(pdo_entry());
    }
    return SiiContent(std::move(list));
  }

  SiiPdoEntry pdo_entry() {
    SiiPdoEntry entry;
    in_.read(entry.index);
    in_.read(entry.subindex);
    in_.read(entry.name_text);
    in_.read(entry.data_type);
    in_.read(entry.bit_length);
    in_.read(entry.flags);
    return entry;
  }

  tl::expected<SiiContent, SiiError> dc_modes() {
    std::vector<SiiDcMode> list;
    while (in_.left() > 0) {
      if (in_.left() < SiiDcMode::kSize) return error(SiiErrorCode::kBadSize, SiiDcMode::kSize);
      SiiDcMode& mode = list.emplace_back();
      in_.read(mode.cycle_time_sync0_ns);
      in_.read(mode.shift_time_sync0_ns);
      in_.read(mode.shift_time_sync1_ns);
      in_.read(mode.cycle_time_sync1_factor);
      in_.read(mode.assign_activate);
      in_.read(mode.cycle_time_sync0_factor);
      in_.read(mode.name_text);
      in_.read(mode.description_text);
      const auto reserved = in_.raw(mode.reserved.size());
      std::copy(reserved.begin(), reserved.end(), mode.reserved.begin());
    }
    return SiiContent(std::move(list));
  }

  SiiCategoryType type_;
  ByteReader in_;
  std::size_t image_offset_;
};

/// Reads categories up to and including the end category.
std::optional<SiiError> read_categories(ByteReader& in, SiiImage& image) {
  const auto word = [&in] { return in.position() / kWordBytes; };
  for (;;) {
    if (in.left() < kWordBytes) {
      return SiiError{SiiErrorCode::kNoEnd, SiiCategoryType::kEnd, word(), kWordBytes, in.left()};
    }
    const auto type = static_cast<SiiCategoryType>(in.number<std::uint16_t>());
    if (type == SiiCategoryType::kEnd) return std::nullopt;
    if (in.left() < kWordBytes) return SiiError{SiiErrorCode::kLongCategory, type, word(), kWordBytes, in.left()};
    const std::size_t bytes = in.number<std::uint16_t>() * kWordBytes;
    if (bytes > in.left()) return SiiError{SiiErrorCode::kLongCategory, type, word(), bytes, in.left()};
    const std::size_t offset = in.position();
    auto content = CategoryDecoder(type, in.raw(bytes), offset).decode();
    if (!content) return content.error();
    image.categories.push_back({type, std::move(*content)});
  }
}

}  // namespace

tl::expected<SiiImage, SiiError> decode_sii(std::span<const std::byte> bytes) {
  if (bytes.size() % kWordBytes != 0) {
    return tl::unexpected(
        SiiError{SiiErrorCode::kOddSize, SiiCategoryType::kEnd, bytes.size() / kWordBytes, kWordBytes, 1});
  }
  if (bytes.size() < kHeaderBytes) {
    return tl::unexpected(SiiError{SiiErrorCode::kNoHeader, SiiCategoryType::kEnd, 0, kHeaderBytes, bytes.size()});
  }
  SiiImage image;
  ByteReader in(bytes);
  read_header(in, image);
  if (const auto error = read_categories(in, image)) return tl::unexpected(*error);
  image.tail = in.take_rest();
  const auto used =
      std::find_if(image.tail.rbegin(), image.tail.rend(), [](std::byte b) { return b != std::byte{0xFF}; });
  image.tail.erase(used.base(), image.tail.end());
  image.image_bytes = bytes.size();
  return image;
}

}  // namespace driveline::esi
