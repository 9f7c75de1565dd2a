#include "text/sii_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <array>

namespace driveline::cli {
namespace {

using esi::SiiCategoryType;
using esi::SiiGeneral;

std::string_view yes_no(bool value) {
  return value ? "yes" : "no";
}

struct Detail {
  std::string_view text;
  std::string_view key;
  std::uint8_t bit;
};

constexpr std::array kCoeDetails = {
    Detail{"Enable SDO", "sdo", SiiGeneral::kCoeSdo},
    Detail{"Enable SDO Info", "sdo_info", SiiGeneral::kCoeSdoInfo},
    Detail{"Enable PDO Assign", "pdo_assign", SiiGeneral::kCoePdoAssign},
    Detail{"Enable PDO Configuration", "pdo_configuration", SiiGeneral::kCoePdoConfig},
    Detail{"Enable Upload at startup", "upload_at_startup", SiiGeneral::kCoeUploadAtStartup},
    Detail{"Enable SDO complete access", "complete_access", SiiGeneral::kCoeCompleteAccess},
};

std::string window_text(const esi::SiiMailboxWindow& window) {
  return fmt::format("RX: 0x{:04x}/{}, TX: 0x{:04x}/{}", window.receive_offset, window.receive_size, window.send_offset,
                     window.send_size);
}

nlohmann::json window_json(const esi::SiiMailboxWindow& window) {
  return {{"receive_offset", window.receive_offset},
          {"receive_size", window.receive_size},
          {"send_offset", window.send_offset},
          {"send_size", window.send_size}};
}

std::string general_text(const esi::SiiImage& sii, const SiiGeneral& general) {
  std::string text = "General:\n";
  text += fmt::format("  Group: {}\n", sii.text(general.group_text));
  text += fmt::format("  Image name: {}\n", sii.text(general.image_text));
  text += fmt::format("  Order number: {}\n", sii.text(general.order_text));
  text += fmt::format("  Device name: {}\n", sii.text(general.name_text));
  if ((sii.mailbox_protocols & esi::sii_mailbox::kCoe) != 0) {
    text += "  CoE details:\n";
    for (const auto& detail : kCoeDetails) {
      text += fmt::format("    {}: {}\n", detail.text, yes_no((general.coe_details & detail.bit) != 0));
    }
  }
  text += fmt::format("  Flags:\n    Enable SafeOp: {}\n    Enable notLRW: {}\n", yes_no((general.flags & 1U) != 0),
                      yes_no((general.flags & 2U) != 0));
  return text + fmt::format("  Current consumption: {} mA\n", general.ebus_current_ma);
}

std::string_view fmmu_use(std::uint8_t use) {
  switch (use) {
    case 1:
      return "outputs";
    case 2:
      return "inputs";
    case 3:
      return "mailbox state";
    default:
      return "unused";
  }
}

nlohmann::json pdos_json(const esi::SiiImage& sii, const std::vector<esi::SiiPdo>* pdos) {
  auto list = nlohmann::json::array();
  if (pdos == nullptr) return list;
  for (const auto& pdo : *pdos) {
    auto entries = nlohmann::json::array();
    for (const auto& entry : pdo.entries) {
      entries.push_back({{"index", entry.index},
                         {"subindex", entry.subindex},
                         {"bits", entry.bit_length},
                         {"name", std::string(sii.text(entry.name_text))}});
    }
    nlohmann::json row = {{"index", pdo.index}, {"name", std::string(sii.text(pdo.name_text))}, {"entries", entries}};
    if (pdo.sync_manager != esi::SiiPdo::kNoSyncManager) row["sync_manager"] = pdo.sync_manager;
    list.push_back(std::move(row));
  }
  return list;
}

}  // namespace

std::vector<std::string> protocol_names(std::uint16_t protocols) {
  constexpr std::array kNames = {"AoE", "EoE", "CoE", "FoE", "SoE", "VoE"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (((protocols >> i) & 1U) != 0) names.emplace_back(kNames[i]);
  }
  return names;
}

std::string identity_text(const esi::SiiImage& sii) {
  return fmt::format(
      "Identity:\n  Vendor Id:       0x{:08x}\n  Product code:    0x{:08x}\n  Revision number: 0x{:08x}\n"
      "  Serial number:   0x{:08x}\n",
      sii.vendor_id, sii.product_code, sii.revision, sii.serial_number);
}

std::string mailbox_and_general_text(const esi::SiiImage& sii) {
  std::string text;
  if (sii.mailbox_protocols != 0) {
    text += "Mailboxes:\n";
    text += fmt::format("  Bootstrap {}\n", window_text(sii.bootstrap_mailbox));
    text += fmt::format("  Standard  {}\n", window_text(sii.standard_mailbox));
    text += fmt::format("  Supported protocols: {}\n", fmt::join(protocol_names(sii.mailbox_protocols), ", "));
  }
  if (const auto* general = sii.find<SiiGeneral>(SiiCategoryType::kGeneral)) text += general_text(sii, *general);
  return text;
}

std::string fmmu_and_clock_text(const esi::SiiImage& sii) {
  std::string text;
  if (const auto* fmmus = sii.find<esi::SiiFmmus>(SiiCategoryType::kFmmu)) {
    for (std::size_t i = 0; i < fmmus->uses.size(); ++i) {
      if (fmmus->uses[i] == 0xFF) continue;  // padding, or unused
      text += fmt::format("FMMU{}: {}\n", i, fmmu_use(fmmus->uses[i]));
    }
  }
  const auto* modes = sii.find<std::vector<esi::SiiDcMode>>(SiiCategoryType::kDistributedClock);
  if (modes == nullptr) return text;
  for (const auto& mode : *modes) {
    text += fmt::format(
        "DC mode \"{}\": AssignActivate 0x{:04x}, SYNC0 {} ns (factor {}), shift {} ns, SYNC1 shift {} ns\n",
        sii.text(mode.name_text), mode.assign_activate, mode.cycle_time_sync0_ns, mode.cycle_time_sync0_factor,
        mode.shift_time_sync0_ns, mode.shift_time_sync1_ns);
  }
  return text;
}

std::string sync_manager_text(std::size_t number, const esi::SiiSyncManager& sync_manager) {
  return fmt::format("SM{}: PhysAddr 0x{:04x}, DefaultSize {:4}, ControlRegister 0x{:02x}, Enable {}\n", number,
                     sync_manager.start_address, sync_manager.length, sync_manager.control, sync_manager.enable & 1U);
}

nlohmann::json to_json(const esi::SiiImage& sii) {
  nlohmann::json document = {{"alias", sii.config.station_alias},
                             {"checksum_valid", sii.checksum_valid()},
                             {"vendor_id", sii.vendor_id},
                             {"product_code", sii.product_code},
                             {"revision", sii.revision},
                             {"serial_number", sii.serial_number},
                             {"eeprom_bytes", sii.eeprom_bytes()},
                             {"mailbox",
                              {{"protocols", protocol_names(sii.mailbox_protocols)},
                               {"standard", window_json(sii.standard_mailbox)},
                               {"bootstrap", window_json(sii.bootstrap_mailbox)}}}};
  if (const auto* general = sii.find<SiiGeneral>(SiiCategoryType::kGeneral)) {
    document["group"] = std::string(sii.text(general->group_text));
    document["order_number"] = std::string(sii.text(general->order_text));
    document["name"] = std::string(sii.text(general->name_text));
    document["current_ma"] = general->ebus_current_ma;
    for (const auto& detail : kCoeDetails) {
      document["coe"][std::string(detail.key)] = (general->coe_details & detail.bit) != 0;
    }
  }
  document["sync_managers"] = nlohmann::json::array();
  if (const auto* channels = sii.find<std::vector<esi::SiiSyncManager>>(SiiCategoryType::kSyncManager)) {
    for (const auto& channel : *channels) {
      document["sync_managers"].push_back({{"start_address", channel.start_address},
                                           {"length", channel.length},
                                           {"control", channel.control},
                                           {"enable", (channel.enable & 1U) != 0},
                                           {"use", channel.use}});
    }
  }
  document["rx_pdos"] = pdos_json(sii, sii.find<std::vector<esi::SiiPdo>>(SiiCategoryType::kRxPdo));
  document["tx_pdos"] = pdos_json(sii, sii.find<std::vector<esi::SiiPdo>>(SiiCategoryType::kTxPdo));
  return document;
}

}  // namespace driveline::cli
