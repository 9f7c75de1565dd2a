#include <algorithm>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/hex.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::esi {
namespace {

constexpr std::size_t kMaxCount = 255;  ///< largest count and length, both single bytes
constexpr std::uint32_t kSizeUnit = 128;
constexpr std::uint32_t kMaxSizeWord = 0xFFFF;
constexpr std::size_t kPorts = 4;

// --- description to SII -----------------------------------------------------------------------------------------

/// Collects texts and numbers them; equal texts share a number.
class TextTable {
 public:
  std::uint8_t number(std::string_view text) {
    if (text.empty()) return 0;
    text = text.substr(0, kMaxCount);
    const auto found = std::find(texts_.begin(), texts_.end(), text);
    if (found != texts_.end()) return static_cast<std::uint8_t>(found - texts_.begin() + 1);
    if (texts_.size() == kMaxCount) return 0;
    texts_.emplace_back(text);
    return static_cast<std::uint8_t>(texts_.size());
  }
  [[nodiscard]] SiiStrings take() { return {std::move(texts_), {}}; }

 private:
  std::vector<std::string> texts_;
};

SiiConfigArea make_config(const DeviceDescription& device) {
  std::vector<std::byte> bytes = parse_hex(device.eeprom_config_data_hex).value_or(std::vector<std::byte>{});
  bytes.resize(SiiConfigArea::kSize);
  const auto word = [&bytes](std::size_t n) {
    return bytes::load_le<std::uint16_t>(std::span(bytes).subspan(2 * n, 2));
  };
  return {word(0), word(1), word(2), word(3), word(4), {word(5), word(6)}};
}

std::uint16_t port_code(char physics) {
  switch (physics) {
    case 'Y':
      return 1;
    case 'K':
      return 3;
    case 'H':
      return 4;
    default:
      return 0;
  }
}

char port_letter(unsigned code) {
  switch (code) {
    case 1:
      return 'Y';
    case 3:
      return 'K';
    case 4:
      return 'H';
    default:
      return ' ';
  }
}

SiiGeneral make_general(const DeviceDescription& device, TextTable& texts) {
  SiiGeneral general;
  general.group_text = texts.number(device.group_type);
  general.order_text = texts.number(device.type);
  general.name_text = texts.number(device.name);
  general.group_name_text = texts.number(device.group_name);
  const MailboxSupport& mailbox = device.mailbox;
  const auto bit = [](bool set, std::uint8_t mask) { return set ? mask : std::uint8_t{0}; };
  general.coe_details = static_cast<std::uint8_t>(
      bit(mailbox.coe, SiiGeneral::kCoeSdo) | bit(mailbox.coe_sdo_info, SiiGeneral::kCoeSdoInfo) |
      bit(mailbox.coe_pdo_assign, SiiGeneral::kCoePdoAssign) | bit(mailbox.coe_pdo_config, SiiGeneral::kCoePdoConfig) |
      bit(mailbox.coe_upload_at_startup, SiiGeneral::kCoeUploadAtStartup) |
      bit(mailbox.coe_complete_access, SiiGeneral::kCoeCompleteAccess));
  general.flags = static_cast<std::uint8_t>(bit(device.not_lrw, SiiGeneral::kEnableNotLrw) |
                                            bit(device.identification, SiiGeneral::kIdentification));
  general.foe_details = bit(mailbox.foe, 1);
  general.eoe_details = bit(mailbox.eoe, 1);
  general.soe_channels = mailbox.soe_channels;
  for (std::size_t port = 0; port < std::min(device.physics.size(), kPorts); ++port) {
    general.physical_ports =
        static_cast<std::uint16_t>(general.physical_ports | port_code(device.physics[port]) << (4 * port));
  }
  general.further.resize(SiiGeneral::kFurtherSize);
  return general;
}

std::uint16_t make_protocols(const MailboxSupport& mailbox) {
  unsigned bits = 0;
  if (mailbox.aoe) bits |= sii_mailbox::kAoe;
  if (mailbox.eoe) bits |= sii_mailbox::kEoe;
  if (mailbox.coe) bits |= sii_mailbox::kCoe;
  if (mailbox.foe) bits |= sii_mailbox::kFoe;
  if (mailbox.soe) bits |= sii_mailbox::kSoe;
  if (mailbox.voe) bits |= sii_mailbox::kVoe;
  return static_cast<std::uint16_t>(bits);
}

SiiMailboxWindow make_standard_mailbox(const std::vector<SyncManager>& sync_managers) {
  SiiMailboxWindow window;
  for (const auto& sm : sync_managers) {
    if (sm.use == SyncManager::Use::kMailboxOut) {
      window.receive_offset = sm.start_address;
      window.receive_size = sm.default_size;
    } else if (sm.use == SyncManager::Use::kMailboxIn) {
      window.send_offset = sm.start_address;
      window.send_size = sm.default_size;
    }
  }
  return window;
}

SiiFmmus make_fmmus(const std::vector<FmmuUse>& uses) {
  SiiFmmus fmmus;
  for (const FmmuUse use : uses) fmmus.uses.push_back(static_cast<std::uint8_t>(use));
  return fmmus;
}

std::vector<SiiSyncManager> make_sync_managers(const std::vector<SyncManager>& sync_managers) {
  std::vector<SiiSyncManager> list;
  for (const auto& sm : sync_managers) {
    list.push_back({sm.start_address, sm.default_size, sm.control, 0, static_cast<std::uint8_t>(sm.enable ? 1 : 0),
                    static_cast<std::uint8_t>(sm.use)});
  }
  return list;
}

std::vector<SiiPdo> make_pdos(const std::vector<Pdo>& pdos, TextTable& texts) {
  std::vector<SiiPdo> list;
  for (const auto& pdo : pdos) {
    SiiPdo& out = list.emplace_back();
    out.index = pdo.index;
    out.sync_manager = pdo.sync_manager.value_or(SiiPdo::kNoSyncManager);
    out.name_text = texts.number(pdo.name);
    out.flags = static_cast<std::uint16_t>((pdo.mandatory ? SiiPdo::kMandatory : 0U) |
                                           (pdo.fixed ? SiiPdo::kFixedContent : 0U));
    for (const auto& entry : pdo.entries) {
      if (out.entries.size() == kMaxCount) break;
      const bool gap = entry.index == 0;
      out.entries.push_back({entry.index, entry.subindex, texts.number(entry.name),
                             gap ? std::uint8_t{0} : static_cast<std::uint8_t>(entry.type), entry.bit_length, 0});
    }
  }
  return list;
}

std::vector<SiiDcMode> make_dc_modes(const std::vector<DcOpMode>& modes, TextTable& texts) {
  std::vector<SiiDcMode> list;
  for (const auto& mode : modes) {
    SiiDcMode& out = list.emplace_back();
    out.cycle_time_sync0_ns = static_cast<std::uint32_t>(mode.cycle_time_sync0_ns);
    out.shift_time_sync0_ns = static_cast<std::uint32_t>(mode.shift_time_sync0_ns);
    out.shift_time_sync1_ns = static_cast<std::uint32_t>(mode.shift_time_sync1_ns);
    out.cycle_time_sync1_factor = mode.cycle_time_sync1_factor;
    out.assign_activate = mode.assign_activate;
    out.cycle_time_sync0_factor = mode.cycle_time_sync0_factor;
    out.name_text = texts.number(mode.name);
    out.description_text = texts.number(mode.description);
  }
  return list;
}

/// Returns the size word of an EEPROM with at least `wanted` bytes, doubled until `content` bytes fit.
std::uint16_t make_size_word(std::uint32_t wanted, std::size_t content) {
  std::uint64_t units = std::max<std::uint64_t>((std::uint64_t{wanted} + kSizeUnit - 1) / kSizeUnit, 1);
  while (units * kSizeUnit < content) units *= 2;
  return static_cast<std::uint16_t>(std::min<std::uint64_t>(units - 1, kMaxSizeWord));
}

// --- SII to description -----------------------------------------------------------------------------------------

void read_general(const SiiImage& image, DeviceDescription& device) {
  const auto* general = image.find<SiiGeneral>(SiiCategoryType::kGeneral);
  if (general == nullptr) return;
  device.group_type = image.text(general->group_text);
  device.group_name = image.text(general->group_name_text);
  device.type = image.text(general->order_text);
  device.name = image.text(general->name_text);
  device.physics.clear();
  for (std::size_t port = 0; port < kPorts; ++port) {
    device.physics += port_letter((general->physical_ports >> (4 * port)) & 0x0FU);
  }
  device.physics.erase(device.physics.find_last_not_of(' ') + 1);
  device.not_lrw = (general->flags & SiiGeneral::kEnableNotLrw) != 0;
  device.identification = (general->flags & SiiGeneral::kIdentification) != 0;
  const auto coe = [general](std::uint8_t mask) { return (general->coe_details & mask) != 0; };
  device.mailbox.coe_sdo_info = coe(SiiGeneral::kCoeSdoInfo);
  device.mailbox.coe_pdo_assign = coe(SiiGeneral::kCoePdoAssign);
  device.mailbox.coe_pdo_config = coe(SiiGeneral::kCoePdoConfig);
  device.mailbox.coe_upload_at_startup = coe(SiiGeneral::kCoeUploadAtStartup);
  device.mailbox.coe_complete_access = coe(SiiGeneral::kCoeCompleteAccess);
  device.mailbox.soe_channels = general->soe_channels;
}

void read_protocols(std::uint16_t bits, MailboxSupport& mailbox) {
  mailbox.aoe = (bits & sii_mailbox::kAoe) != 0;
  mailbox.eoe = (bits & sii_mailbox::kEoe) != 0;
  mailbox.coe = (bits & sii_mailbox::kCoe) != 0;
  mailbox.foe = (bits & sii_mailbox::kFoe) != 0;
  mailbox.soe = (bits & sii_mailbox::kSoe) != 0;
  mailbox.voe = (bits & sii_mailbox::kVoe) != 0;
}

FmmuUse to_fmmu_use(std::uint8_t raw) {
  return raw <= static_cast<std::uint8_t>(FmmuUse::kMailboxState) ? static_cast<FmmuUse>(raw) : FmmuUse::kUnused;
}

SyncManager::Use to_sync_manager_use(std::uint8_t raw) {
  const bool known = raw <= static_cast<std::uint8_t>(SyncManager::Use::kInputs);
  return known ? static_cast<SyncManager::Use>(raw) : SyncManager::Use::kUnused;
}

void read_fmmus(const SiiImage& image, DeviceDescription& device) {
  const auto* fmmus = image.find<SiiFmmus>(SiiCategoryType::kFmmu);
  if (fmmus == nullptr) return;
  for (const std::uint8_t use : fmmus->uses) device.fmmus.push_back(to_fmmu_use(use));
  // The last byte may be padding to a whole word.
  if (!fmmus->uses.empty() && fmmus->uses.back() == 0xFF) device.fmmus.pop_back();
}

void read_sync_managers(const SiiImage& image, DeviceDescription& device) {
  const auto* list = image.find<std::vector<SiiSyncManager>>(SiiCategoryType::kSyncManager);
  if (list == nullptr) return;
  for (const auto& sm : *list) {
    SyncManager& out = device.sync_managers.emplace_back();
    out.use = to_sync_manager_use(sm.use);
    out.start_address = sm.start_address;
    out.default_size = sm.length;
    out.control = sm.control;
    out.enable = (sm.enable & 1U) != 0;
  }
}

/// Devices may distribute their PDOs over several categories of the same type.
std::vector<Pdo> read_pdos(const SiiImage& image, SiiCategoryType type) {
  std::vector<Pdo> pdos;
  for (const auto& category : image.categories) {
    const auto* list = std::get_if<std::vector<SiiPdo>>(&category.content);
    if (category.type != type || list == nullptr) continue;
    for (const auto& pdo : *list) {
      Pdo& out = pdos.emplace_back();
      out.index = pdo.index;
      out.name = image.text(pdo.name_text);
      out.fixed = (pdo.flags & SiiPdo::kFixedContent) != 0;
      out.mandatory = (pdo.flags & SiiPdo::kMandatory) != 0;
      if (pdo.sync_manager != SiiPdo::kNoSyncManager) out.sync_manager = pdo.sync_manager;
      for (const auto& entry : pdo.entries) {
        PdoEntry& out_entry = out.entries.emplace_back();
        out_entry.index = entry.index;
        out_entry.subindex = entry.subindex;
        out_entry.bit_length = entry.bit_length;
        out_entry.name = image.text(entry.name_text);
        if (entry.index != 0) out_entry.type = static_cast<DataType>(entry.data_type);
      }
    }
  }
  return pdos;
}

void read_dc_modes(const SiiImage& image, DeviceDescription& device) {
  const auto* list = image.find<std::vector<SiiDcMode>>(SiiCategoryType::kDistributedClock);
  if (list == nullptr) return;
  for (const auto& mode : *list) {
    DcOpMode& out = device.dc_modes.emplace_back();
    out.name = image.text(mode.name_text);
    out.description = image.text(mode.description_text);
    out.assign_activate = mode.assign_activate;
    out.cycle_time_sync0_ns = static_cast<std::int32_t>(mode.cycle_time_sync0_ns);
    out.cycle_time_sync0_factor = mode.cycle_time_sync0_factor;
    out.shift_time_sync0_ns = static_cast<std::int32_t>(mode.shift_time_sync0_ns);
    out.cycle_time_sync1_factor = mode.cycle_time_sync1_factor;
    out.shift_time_sync1_ns = static_cast<std::int32_t>(mode.shift_time_sync1_ns);
  }
}

}  // namespace

SiiImage make_sii(const DeviceDescription& device) {
  SiiImage image;
  image.config = make_config(device);
  image.checksum = sii_checksum(image.config.bytes());
  image.vendor_id = device.vendor_id;
  image.product_code = device.product_code;
  image.revision = device.revision;
  image.serial_number = device.serial_number;
  image.bootstrap_mailbox = {device.bootstrap_rx_offset, device.bootstrap_rx_size, device.bootstrap_tx_offset,
                             device.bootstrap_tx_size};
  image.standard_mailbox = make_standard_mailbox(device.sync_managers);
  image.mailbox_protocols = make_protocols(device.mailbox);

  TextTable texts;
  const auto add = [&image](SiiCategoryType type, SiiContent content) {
    image.categories.push_back({type, std::move(content)});
  };
  // The string category comes first in the image, but its content is complete only at the end.
  add(SiiCategoryType::kStrings, SiiStrings{});
  add(SiiCategoryType::kGeneral, make_general(device, texts));
  if (!device.fmmus.empty()) add(SiiCategoryType::kFmmu, make_fmmus(device.fmmus));
  if (!device.sync_managers.empty()) add(SiiCategoryType::kSyncManager, make_sync_managers(device.sync_managers));
  if (!device.tx_pdos.empty()) add(SiiCategoryType::kTxPdo, make_pdos(device.tx_pdos, texts));
  if (!device.rx_pdos.empty()) add(SiiCategoryType::kRxPdo, make_pdos(device.rx_pdos, texts));
  if (!device.dc_modes.empty()) add(SiiCategoryType::kDistributedClock, make_dc_modes(device.dc_modes, texts));
  image.categories.front().content = texts.take();

  image.size_word = make_size_word(device.eeprom_bytes, encode_sii(image).size());
  image.image_bytes = image.eeprom_bytes();
  return image;
}

DeviceDescription description_from_sii(const SiiImage& image) {
  DeviceDescription device;
  device.vendor_id = image.vendor_id;
  device.product_code = image.product_code;
  device.revision = image.revision;
  device.serial_number = image.serial_number;
  read_general(image, device);
  read_protocols(image.mailbox_protocols, device.mailbox);
  device.bootstrap_rx_offset = image.bootstrap_mailbox.receive_offset;
  device.bootstrap_rx_size = image.bootstrap_mailbox.receive_size;
  device.bootstrap_tx_offset = image.bootstrap_mailbox.send_offset;
  device.bootstrap_tx_size = image.bootstrap_mailbox.send_size;
  read_fmmus(image, device);
  read_sync_managers(image, device);
  device.rx_pdos = read_pdos(image, SiiCategoryType::kRxPdo);
  device.tx_pdos = read_pdos(image, SiiCategoryType::kTxPdo);
  read_dc_modes(image, device);
  device.eeprom_bytes = static_cast<std::uint32_t>(image.eeprom_bytes());
  device.eeprom_config_data_hex = to_hex(image.config.bytes());
  return device;
}

}  // namespace driveline::esi
