#include <algorithm>
#include <array>
#include <set>
#include <sstream>

#include "data_type_name.hpp"
#include "driveline/bytes/endian.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/hex.hpp"
#include "esi_dictionary.hpp"
#include "xml_writer.hpp"

namespace driveline::esi {
namespace {

void set_attribute(pugi::xml_node node, const char* name, std::string_view value) {
  node.append_attribute(name) = xml_text(value).c_str();
}

void append_groups(pugi::xml_node descriptions, const std::vector<DeviceDescription>& devices) {
  auto groups = descriptions.append_child("Groups");
  std::set<std::string> written;
  for (const auto& device : devices) {
    if (device.group_type.empty() || !written.insert(device.group_type).second) continue;
    auto group = groups.append_child("Group");
    append_text(group, "Type", device.group_type);
    append_name(group, device.group_name);
  }
}

void append_profile(pugi::xml_node node, const DeviceDescription& device) {
  if (device.device_profile == 0 && device.objects.empty()) return;
  auto profile = node.append_child("Profile");
  append_text(profile, "ProfileNo", std::to_string(device.device_profile));
  if (!device.objects.empty()) write_dictionary(profile, device.objects);
}

const char* fmmu_name(FmmuUse use) {
  switch (use) {
    case FmmuUse::kOutputs:
      return "Outputs";
    case FmmuUse::kInputs:
      return "Inputs";
    case FmmuUse::kMailboxState:
      return "MBoxState";
    case FmmuUse::kUnused:
      break;
  }
  return "";
}

const char* sync_manager_name(SyncManager::Use use) {
  switch (use) {
    case SyncManager::Use::kMailboxOut:
      return "MBoxOut";
    case SyncManager::Use::kMailboxIn:
      return "MBoxIn";
    case SyncManager::Use::kOutputs:
      return "Outputs";
    case SyncManager::Use::kInputs:
      return "Inputs";
    case SyncManager::Use::kUnused:
      break;
  }
  return "";
}

void append_sync_manager(pugi::xml_node node, const SyncManager& sm) {
  auto out = append_text(node, "Sm", sync_manager_name(sm.use));
  if (sm.min_size != 0) set_attribute(out, "MinSize", std::to_string(sm.min_size));
  if (sm.max_size != 0) set_attribute(out, "MaxSize", std::to_string(sm.max_size));
  set_attribute(out, "DefaultSize", std::to_string(sm.default_size));
  set_attribute(out, "StartAddress", hex_number(sm.start_address, 4));
  set_attribute(out, "ControlByte", hex_number(sm.control, 2));
  set_attribute(out, "Enable", sm.enable ? "1" : "0");
}

void append_pdo(pugi::xml_node node, const char* element, const Pdo& pdo) {
  auto out = node.append_child(element);
  if (pdo.fixed) set_attribute(out, "Fixed", "1");
  if (pdo.mandatory) set_attribute(out, "Mandatory", "1");
  if (pdo.sync_manager) set_attribute(out, "Sm", std::to_string(*pdo.sync_manager));
  append_text(out, "Index", hex_number(pdo.index, 4));
  append_name(out, pdo.name);
  for (const auto other : pdo.excluded) append_text(out, "Exclude", hex_number(other, 4));
  for (const auto& entry : pdo.entries) {
    auto item = out.append_child("Entry");
    append_text(item, "Index", hex_number(entry.index, 4));
    if (entry.index != 0 || entry.subindex != 0) append_text(item, "SubIndex", std::to_string(entry.subindex));
    append_text(item, "BitLen", std::to_string(entry.bit_length));
    if (!entry.name.empty()) append_name(item, entry.name);
    if (entry.index != 0) append_text(item, "DataType", data_type_name(entry.type, entry.bit_length));
  }
}

void append_mailbox(pugi::xml_node node, const MailboxSupport& mailbox) {
  if (!mailbox.any()) return;
  auto out = node.append_child("Mailbox");
  if (mailbox.aoe) out.append_child("AoE");
  const auto flag = [](pugi::xml_node protocol, const char* name, bool set) {
    if (set) set_attribute(protocol, name, "1");
  };
  if (mailbox.eoe) {
    auto eoe = out.append_child("EoE");
    flag(eoe, "IP", mailbox.eoe_ip);
    flag(eoe, "MAC", mailbox.eoe_mac);
  }
  if (mailbox.coe) {
    auto coe = out.append_child("CoE");
    flag(coe, "SdoInfo", mailbox.coe_sdo_info);
    flag(coe, "PdoAssign", mailbox.coe_pdo_assign);
    flag(coe, "PdoConfig", mailbox.coe_pdo_config);
    flag(coe, "PdoUpload", mailbox.coe_upload_at_startup);
    flag(coe, "CompleteAccess", mailbox.coe_complete_access);
  }
  if (mailbox.foe) out.append_child("FoE");
  if (mailbox.soe) {
    auto soe = out.append_child("SoE");
    if (mailbox.soe_channels != 0) set_attribute(soe, "ChannelCount", std::to_string(mailbox.soe_channels));
  }
  if (mailbox.voe) out.append_child("VoE");
}

void append_cycle_time(pugi::xml_node node, const char* name, std::int32_t time_ns, std::int16_t factor) {
  auto out = append_text(node, name, std::to_string(time_ns));
  if (factor != 0) set_attribute(out, "Factor", std::to_string(factor));
}

void append_dc(pugi::xml_node node, const std::vector<DcOpMode>& modes) {
  if (modes.empty()) return;
  auto dc = node.append_child("Dc");
  for (const auto& mode : modes) {
    auto out = dc.append_child("OpMode");
    append_text(out, "Name", mode.name);
    if (!mode.description.empty()) append_text(out, "Desc", mode.description);
    append_text(out, "AssignActivate", hex_number(mode.assign_activate, 4));
    append_cycle_time(out, "CycleTimeSync0", mode.cycle_time_sync0_ns, mode.cycle_time_sync0_factor);
    append_text(out, "ShiftTimeSync0", std::to_string(mode.shift_time_sync0_ns));
    append_cycle_time(out, "CycleTimeSync1", mode.cycle_time_sync1_ns, mode.cycle_time_sync1_factor);
    append_text(out, "ShiftTimeSync1", std::to_string(mode.shift_time_sync1_ns));
    for (const auto& assignment : mode.assignments) {
      auto sm = out.append_child("Sm");
      set_attribute(sm, "No", std::to_string(assignment.sync_manager));
      for (const auto pdo : assignment.pdos) append_text(sm, "Pdo", hex_number(pdo, 4));
    }
  }
}

void append_number(pugi::xml_node node, const char* name, const std::optional<std::uint32_t>& value) {
  if (value) append_text(node, name, std::to_string(*value));
}

void append_info(pugi::xml_node node, const DeviceDescription& device) {
  const auto& timeouts = device.timeouts;
  const bool states =
      timeouts.to_pre_op || timeouts.to_safe_op_and_op || timeouts.back_to_init || timeouts.back_to_safe_op;
  const bool mailbox = timeouts.mailbox_request || timeouts.mailbox_response;
  if (!states && !mailbox && !device.identification) return;
  auto info = node.append_child("Info");
  if (states) {
    auto out = info.append_child("StateMachine").append_child("Timeout");
    append_number(out, "PreopTimeout", timeouts.to_pre_op);
    append_number(out, "SafeopOpTimeout", timeouts.to_safe_op_and_op);
    append_number(out, "BackToInitTimeout", timeouts.back_to_init);
    append_number(out, "BackToSafeopTimeout", timeouts.back_to_safe_op);
  }
  if (mailbox) {
    auto out = info.append_child("Mailbox").append_child("Timeout");
    append_number(out, "RequestTimeout", timeouts.mailbox_request);
    append_number(out, "ResponseTimeout", timeouts.mailbox_response);
  }
  if (device.identification) append_text(info, "IdentificationReg134", "true");
}

void append_watchdogs(pugi::xml_node node, const DeviceWatchdogs& watchdogs) {
  if (watchdogs == DeviceWatchdogs{}) return;
  auto out = node.append_child("ESC");
  append_number(out, "Reg0400", watchdogs.divider);
  append_number(out, "Reg0410", watchdogs.pdi);
  append_number(out, "Reg0420", watchdogs.process_data);
}

void append_init_command(pugi::xml_node coe, const InitCommand& command) {
  auto out = coe.append_child("InitCmd");
  if (command.complete_access) set_attribute(out, "CompleteAccess", "1");
  for (const auto& transition : command.transitions) append_text(out, "Transition", transition);
  append_text(out, "Index", hex_number(command.index, 4));
  append_text(out, "SubIndex", std::to_string(command.subindex));
  append_text(out, "Data", command.data_hex);
}

void append_eeprom(pugi::xml_node node, const DeviceDescription& device) {
  auto eeprom = node.append_child("Eeprom");
  if (device.eeprom_to_application) set_attribute(eeprom, "AssignToPdi", "1");
  append_text(eeprom, "ByteSize", std::to_string(device.eeprom_bytes));
  if (!device.eeprom_config_data_hex.empty()) append_text(eeprom, "ConfigData", device.eeprom_config_data_hex);
  const std::array words{device.bootstrap_rx_offset, device.bootstrap_rx_size, device.bootstrap_tx_offset,
                         device.bootstrap_tx_size};
  if (std::all_of(words.begin(), words.end(), [](std::uint16_t word) { return word == 0; })) return;
  std::string boot;
  for (const std::uint16_t word : words) boot += to_hex(bytes::to_le_bytes(word));
  append_text(eeprom, "BootStrap", boot);
}

void append_device(pugi::xml_node devices, const DeviceDescription& device) {
  auto node = devices.append_child("Device");
  set_attribute(node, "Physics", device.physics);
  auto type = append_text(node, "Type", device.type);
  set_attribute(type, "ProductCode", hex_number(device.product_code, 8));
  set_attribute(type, "RevisionNo", hex_number(device.revision, 8));
  if (device.serial_number != 0) set_attribute(type, "SerialNo", hex_number(device.serial_number, 8));
  if (device.not_lrw) set_attribute(type, "UseLrdLwr", "1");
  append_name(node, device.name);
  append_info(node, device);
  if (!device.group_type.empty()) append_text(node, "GroupType", device.group_type);
  append_profile(node, device);
  for (const FmmuUse use : device.fmmus) append_text(node, "Fmmu", fmmu_name(use));
  for (const auto& sm : device.sync_managers) append_sync_manager(node, sm);
  for (const auto& pdo : device.rx_pdos) append_pdo(node, "RxPdo", pdo);
  for (const auto& pdo : device.tx_pdos) append_pdo(node, "TxPdo", pdo);
  append_mailbox(node, device.mailbox);
  if (auto coe = node.child("Mailbox").child("CoE")) {
    for (const auto& command : device.init_commands) append_init_command(coe, command);
  }
  append_dc(node, device.dc_modes);
  append_watchdogs(node, device.watchdogs);
  append_eeprom(node, device);
}

}  // namespace

std::string write_esi(const std::vector<DeviceDescription>& devices) {
  pugi::xml_document document;
  auto declaration = document.append_child(pugi::node_declaration);
  set_attribute(declaration, "version", "1.0");
  set_attribute(declaration, "encoding", "utf-8");
  auto root = document.append_child("EtherCATInfo");
  set_attribute(root, "xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance");
  set_attribute(root, "xsi:noNamespaceSchemaLocation", "EtherCATInfo.xsd");
  set_attribute(root, "Version", "1.6");
  auto vendor = root.append_child("Vendor");
  append_text(vendor, "Id", hex_number(devices.empty() ? 0 : devices.front().vendor_id, 8));
  append_name(vendor, devices.empty() ? "" : devices.front().vendor_name);
  auto descriptions = root.append_child("Descriptions");
  append_groups(descriptions, devices);
  auto list = descriptions.append_child("Devices");
  for (const auto& device : devices) append_device(list, device);
  std::ostringstream out;
  document.save(out, "  ", pugi::format_default, pugi::encoding_utf8);
  return out.str();
}

}  // namespace driveline::esi
