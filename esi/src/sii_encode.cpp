#include <algorithm>

#include "byte_writer.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::esi {
namespace {

constexpr std::byte kErased{0xFF};

/// Encodes the content of a category.
class CategoryEncoder {
 public:
  explicit CategoryEncoder(ByteWriter& out) : out_(out) {}

  void operator()(const SiiRaw& raw) { out_.raw(raw.bytes); }

  void operator()(const SiiStrings& strings) {
    out_.number(static_cast<std::uint8_t>(strings.texts.size()));
    for (const auto& text : strings.texts) {
      out_.number(static_cast<std::uint8_t>(text.size()));
      out_.text(text);
    }
    out_.raw(strings.padding);
  }

  void operator()(const SiiGeneral& general) {
    out_.number(general.group_text);
    out_.number(general.image_text);
    out_.number(general.order_text);
    out_.number(general.name_text);
    out_.number(general.reserved1);
    out_.number(general.coe_details);
    out_.number(general.foe_details);
    out_.number(general.eoe_details);
    out_.number(general.soe_channels);
    out_.number(general.ds402_channels);
    out_.number(general.sysman_class);
    out_.number(general.flags);
    out_.number(general.ebus_current_ma);
    out_.number(general.group_name_text);
    out_.number(general.reserved2);
    out_.number(general.physical_ports);
    out_.raw(general.further);
  }

  void operator()(const SiiFmmus& fmmus) {
    for (const std::uint8_t use : fmmus.uses) out_.number(use);
  }

  void operator()(const std::vector<SiiSyncManager>& list) {
    for (const auto& sm : list) {
      out_.number(sm.start_address);
      out_.number(sm.length);
      out_.number(sm.control);
      out_.number(sm.status);
      out_.number(sm.enable);
      out_.number(sm.use);
    }
  }

  void operator()(const std::vector<SiiPdo>& list) {
    for (const auto& pdo : list) {
      out_.number(pdo.index);
      out_.number(static_cast<std::uint8_t>(pdo.entries.size()));
      out_.number(pdo.sync_manager);
      out_.number(pdo.dc_sync);
      out_.number(pdo.name_text);
      out_.number(pdo.flags);
      for (const auto& entry : pdo.entries) {
        out_.number(entry.index);
        out_.number(entry.subindex);
        out_.number(entry.name_text);
        out_.number(entry.data_type);
        out_.number(entry.bit_length);
        out_.number(entry.flags);
      }
    }
  }

  void operator()(const std::vector<SiiDcMode>& list) {
    for (const auto& mode : list) {
      out_.number(mode.cycle_time_sync0_ns);
      out_.number(mode.shift_time_sync0_ns);
      out_.number(mode.shift_time_sync1_ns);
      out_.number(mode.cycle_time_sync1_factor);
      out_.number(mode.assign_activate);
      out_.number(mode.cycle_time_sync0_factor);
      out_.number(mode.name_text);
      out_.number(mode.description_text);
      out_.raw(mode.reserved);
    }
  }

 private:
  ByteWriter& out_;
};

void write_category(ByteWriter& out, const SiiCategory& category) {
  ByteWriter content;
  std::visit(CategoryEncoder(content), category.content);
  content.pad_to((content.size() + 1) / 2 * 2, kErased);
  out.number(static_cast<std::uint16_t>(category.type));
  out.number(static_cast<std::uint16_t>(content.size() / 2));
  out.raw(content.take());
}

void write_window(ByteWriter& out, const SiiMailboxWindow& window) {
  out.number(window.receive_offset);
  out.number(window.receive_size);
  out.number(window.send_offset);
  out.number(window.send_size);
}

}  // namespace

std::array<std::byte, SiiConfigArea::kSize> SiiConfigArea::bytes() const noexcept {
  std::array<std::byte, kSize> out{};
  const std::array words{pdi_control,   pdi_configuration, sync_impulse_10ns, pdi_configuration2,
                         station_alias, reserved[0],       reserved[1]};
  for (std::size_t i = 0; i < words.size(); ++i) bytes::store_le(std::span(out).subspan(2 * i, 2), words[i]);
  return out;
}

std::uint8_t sii_checksum(std::span<const std::byte, SiiConfigArea::kSize> config) noexcept {
  constexpr unsigned kPolynomial = 0x07;
  unsigned crc = 0xFF;
  for (const std::byte b : config) {
    crc ^= std::to_integer<unsigned>(b);
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x80U) != 0 ? (crc << 1) ^ kPolynomial : crc << 1) & 0xFFU;
  }
  return static_cast<std::uint8_t>(crc);
}

bool SiiImage::checksum_valid() const noexcept {
  constexpr std::uint16_t kCheckDisabled = 0x88A4;
  return checksum == kCheckDisabled || (checksum & 0xFFU) == sii_checksum(config.bytes());
}

std::string_view SiiImage::text(std::uint8_t number) const noexcept {
  const auto* strings = find<SiiStrings>(SiiCategoryType::kStrings);
  if (strings == nullptr || number == 0 || number > strings->texts.size()) return {};
  return strings->texts[number - 1U];
}

std::vector<std::byte> encode_sii(const SiiImage& image) {
  ByteWriter out;
  out.raw(image.config.bytes());
  out.number(image.checksum);
  out.number(image.vendor_id);
  out.number(image.product_code);
  out.number(image.revision);
  out.number(image.serial_number);
  out.numbers(image.delays);
  write_window(out, image.bootstrap_mailbox);
  write_window(out, image.standard_mailbox);
  out.number(image.mailbox_protocols);
  out.numbers(image.reserved);
  out.number(image.size_word);
  out.number(image.version);
  for (const auto& category : image.categories) write_category(out, category);
  out.number(static_cast<std::uint16_t>(SiiCategoryType::kEnd));
  out.raw(image.tail);
  out.pad_to(std::max(image.image_bytes, (out.size() + 1) / 2 * 2), kErased);
  return out.take();
}

}  // namespace driveline::esi
