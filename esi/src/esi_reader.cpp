#include <algorithm>
#include <array>
#include <map>

#include "data_type_name.hpp"
#include "driveline/bytes/endian.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/hex.hpp"
#include "esi_dictionary.hpp"
#include "utf8.hpp"
#include "xml_context.hpp"

namespace driveline::esi {
namespace {

constexpr std::size_t kConfigBytes = 14;      ///< ESC configuration area
constexpr std::size_t kBootStrapBytes = 8;    ///< four words
constexpr std::size_t kBootStrapOffset = 40;  ///< byte offset of SII word 0x14
constexpr std::uint32_t kMaxEntryBits = 255;
constexpr std::uint32_t kMaxPdoBits = 8 * 1486;  ///< longest process data in a frame

template <typename T>
struct Named {
  std::string_view name;
  T value;
};

/// The case of names in ESI files varies between vendors.
bool same_name(std::string_view a, std::string_view b) {
  return lower_case(a) == lower_case(b);
}

constexpr std::array kFmmuNames = {
    Named<FmmuUse>{"Outputs", FmmuUse::kOutputs}, Named<FmmuUse>{"Inputs", FmmuUse::kInputs},
    Named<FmmuUse>{"MBoxState", FmmuUse::kMailboxState}, Named<FmmuUse>{"", FmmuUse::kUnused}};
using SmUse = SyncManager::Use;
constexpr std::array kSyncManagerNames = {
    Named<SmUse>{"MBoxOut", SmUse::kMailboxOut}, Named<SmUse>{"MBoxIn", SmUse::kMailboxIn},
    Named<SmUse>{"Outputs", SmUse::kOutputs}, Named<SmUse>{"Inputs", SmUse::kInputs}, Named<SmUse>{"", SmUse::kUnused}};

class EsiReader {
 public:
  EsiReader(XmlContext& context, pugi::xml_document& document) : context_(context), document_(document) {}

  EsiFile read() {
    auto root = document_.document_element();
    if (std::string_view(root.name()) == "EtherCATInfoList") root = root.child("EtherCATInfo");
    if (std::string_view(root.name()) != "EtherCATInfo") {
      context_.fail(document_.document_element(),
                    fmt::format("the root element is '{}'", document_.document_element().name()), "EtherCATInfo");
      return {};
    }
    if (const auto next = root.next_sibling("EtherCATInfo")) context_.note(next, "only the first of a list is read");
    const auto vendor = root.child("Vendor");
    if (!vendor.child("Id")) context_.fail(vendor ? vendor : root, "no vendor id", "Vendor/Id, e.g. #x00000002");
    file_.vendor_id = context_.child_number<std::uint32_t>(vendor, "Id");
    file_.vendor_name = context_.localized_text(vendor, "Name");
    const auto descriptions = root.child("Descriptions");
    for (const auto group : descriptions.child("Groups").children("Group")) {
      groups_.emplace(XmlContext::child_text(group, "Type"), context_.localized_text(group, "Name"));
    }
    for (const auto device : descriptions.child("Devices").children("Device")) {
      file_.devices.push_back(read_device(device));
    }
    if (const auto modules = descriptions.child("Modules")) context_.note(modules, "modules are not read");
    return std::move(file_);
  }

 private:
  DeviceDescription read_device(pugi::xml_node node) {
    DeviceDescription device;
    device.vendor_id = file_.vendor_id;
    device.vendor_name = file_.vendor_name;
    if (const auto physics = node.attribute("Physics")) device.physics = physics.value();
    read_type(node, device);
    device.name = context_.localized_text(node, "Name");
    device.group_type = XmlContext::child_text(node, "GroupType");
    if (const auto group = groups_.find(device.group_type); group != groups_.end()) device.group_name = group->second;
    read_timeouts(node.child("Info"), device.timeouts);
    const auto identification = XmlContext::child_text(node.child("Info"), "IdentificationReg134");
    device.identification = identification == "true" || identification == "1";
    read_profile(node, device);
    read_fmmus(node, device);
    read_sync_managers(node, device);
    for (const auto pdo : node.children("RxPdo")) device.rx_pdos.push_back(read_pdo(pdo));
    for (const auto pdo : node.children("TxPdo")) device.tx_pdos.push_back(read_pdo(pdo));
    read_mailbox(node.child("Mailbox"), device.mailbox);
    for (const auto command : node.child("Mailbox").child("CoE").children("InitCmd")) {
      if (command.child("Index")) {
        device.init_commands.push_back(read_init_command(command));
      } else {
        context_.note(command, "a start-up command without Index is ignored");
      }
    }
    for (const auto mode : node.child("Dc").children("OpMode")) device.dc_modes.push_back(read_dc_mode(mode));
    if (const auto slots = node.child("Slots")) context_.note(slots, "slots are not read");
    // Both spellings occur in ESI files.
    const auto controller = node.child("ESC") ? node.child("ESC") : node.child("Esc");
    device.watchdogs.divider = optional_number<std::uint16_t>(controller, "Reg0400");
    device.watchdogs.pdi = optional_number<std::uint16_t>(controller, "Reg0410");
    device.watchdogs.process_data = optional_number<std::uint16_t>(controller, "Reg0420");
    read_eeprom(node.child("Eeprom"), device);
    return device;
  }

  void read_type(pugi::xml_node node, DeviceDescription& device) {
    const auto type = node.child("Type");
    if (!type) {
      context_.fail(node, "a device without type", "Type with ProductCode and RevisionNo");
      return;
    }
    for (const char* attribute : {"ProductCode", "RevisionNo"}) {
      if (!type.attribute(attribute)) context_.note(type, fmt::format("no {}, taken as 0", attribute));
    }
    device.type = XmlContext::text_of(type);
    device.product_code = context_.attribute_number<std::uint32_t>(type, "ProductCode");
    device.revision = context_.attribute_number<std::uint32_t>(type, "RevisionNo");
    device.serial_number = context_.attribute_number<std::uint32_t>(type, "SerialNo");
    device.not_lrw = context_.attribute_flag(type, "UseLrdLwr");
  }

  template <typename T>
  std::optional<T> optional_number(pugi::xml_node parent, const char* child) {
    if (!parent.child(child)) return std::nullopt;
    return context_.child_number<T>(parent, child);
  }

  void read_timeouts(pugi::xml_node info, DeviceTimeouts& timeouts) {
    const auto states = info.child("StateMachine").child("Timeout");
    timeouts.to_pre_op = optional_number<std::uint32_t>(states, "PreopTimeout");
    timeouts.to_safe_op_and_op = optional_number<std::uint32_t>(states, "SafeopOpTimeout");
    timeouts.back_to_init = optional_number<std::uint32_t>(states, "BackToInitTimeout");
    timeouts.back_to_safe_op = optional_number<std::uint32_t>(states, "BackToSafeopTimeout");
    const auto mailbox = info.child("Mailbox").child("Timeout");
    timeouts.mailbox_request = optional_number<std::uint32_t>(mailbox, "RequestTimeout");
    timeouts.mailbox_response = optional_number<std::uint32_t>(mailbox, "ResponseTimeout");
  }

  InitCommand read_init_command(pugi::xml_node node) {
    InitCommand command;
    for (const auto transition : node.children("Transition")) {
      auto name = XmlContext::text_of(transition);
      std::transform(name.begin(), name.end(), name.begin(),
                     [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
      command.transitions.push_back(std::move(name));
    }
    command.index = context_.child_number<std::uint16_t>(node, "Index");
    command.subindex = context_.child_number<std::uint8_t>(node, "SubIndex");
    command.data_hex = context_.child_hex(node, "Data");
    command.complete_access = context_.attribute_flag(node, "CompleteAccess");
    const bool upward = std::any_of(command.transitions.begin(), command.transitions.end(),
                                    [](const auto& name) { return name == "IP" || name == "PS" || name == "SO"; });
    if (!upward)
      context_.note(node, "an InitCmd for none of the transitions IP, PS and SO: this master never sends it");
    return command;
  }

  void read_profile(pugi::xml_node node, DeviceDescription& device) {
    for (const auto profile : node.children("Profile")) {
      // The profile number of the device, or else of its first channel.
      const auto holder = profile.child("ProfileNo") ? profile : profile.child("ChannelInfo");
      if (device.device_profile == 0) device.device_profile = context_.child_number<std::uint16_t>(holder, "ProfileNo");
      if (const auto file = profile.child("DictionaryFile")) context_.note(file, "the dictionary is in another file");
      const auto dictionary = profile.child("Dictionary");
      if (dictionary && device.objects.empty()) device.objects = read_dictionary(context_, dictionary);
    }
  }

  /// Returns the value for the name in the element's text; an unknown name gives the unused value and adds a note.
  template <typename T, std::size_t N>
  T read_name(pugi::xml_node node, const std::array<Named<T>, N>& names) {
    const std::string text = XmlContext::text_of(node);
    for (const auto& row : names) {
      if (same_name(row.name, text)) return row.value;
    }
    context_.note(node, fmt::format("the use '{}' is not known; taken as unused", text));
    return T{};
  }

  void read_fmmus(pugi::xml_node node, DeviceDescription& device) {
    for (const auto fmmu : node.children("Fmmu")) device.fmmus.push_back(read_name(fmmu, kFmmuNames));
  }

  void read_sync_managers(pugi::xml_node node, DeviceDescription& device) {
    for (const auto sm : node.children("Sm")) {
      SyncManager& out = device.sync_managers.emplace_back();
      out.use = read_name(sm, kSyncManagerNames);
      out.start_address = context_.attribute_number<std::uint16_t>(sm, "StartAddress");
      out.default_size = context_.attribute_number<std::uint16_t>(sm, "DefaultSize");
      out.min_size = context_.attribute_number<std::uint16_t>(sm, "MinSize");
      out.max_size = context_.attribute_number<std::uint16_t>(sm, "MaxSize");
      out.control = context_.attribute_number<std::uint8_t>(sm, "ControlByte");
      out.enable = context_.attribute_bit(sm, "Enable");
    }
  }

  Pdo read_pdo(pugi::xml_node node) {
    Pdo pdo;
    if (!node.child("Index")) context_.fail(node, "a PDO without Index", "Index, e.g. #x1600");
    pdo.index = context_.child_number<std::uint16_t>(node, "Index");
    pdo.name = context_.localized_text(node, "Name");
    pdo.fixed = context_.attribute_flag(node, "Fixed");
    pdo.mandatory = context_.attribute_flag(node, "Mandatory");
    if (node.attribute("Sm")) pdo.sync_manager = context_.attribute_number<std::uint8_t>(node, "Sm");
    for (const auto entry : node.children("Entry")) read_pdo_entry(entry, pdo.entries);
    for (const auto other : node.children("Exclude")) {
      pdo.excluded.push_back(context_.number<std::uint16_t>(other, other.text().get(), 0));
    }
    return pdo;
  }

  void read_pdo_entry(pugi::xml_node node, std::vector<PdoEntry>& entries) {
    PdoEntry entry;
    if (!node.child("BitLen")) context_.fail(node, "a PDO entry without BitLen", "BitLen, 1 to 255");
    entry.index = context_.child_number<std::uint16_t>(node, "Index");
    entry.subindex = context_.child_number<std::uint8_t>(node, "SubIndex");
    entry.name = context_.localized_text(node, "Name");
    auto bits = context_.child_number<std::uint32_t>(node, "BitLen");
    if (bits == 0 && entry.index != 0) context_.note(node, "an entry of 0 bits: it is in no process data");
    entry.bit_length = static_cast<std::uint8_t>(std::min(bits, kMaxEntryBits));
    if (entry.index != 0) entry.type = read_entry_type(node, entry.bit_length);
    entries.push_back(entry);
    if (bits <= kMaxEntryBits) return;
    // Mapping objects and SII store the bit length of an entry in one byte. Gaps preserve the positions of later
    // entries.
    if (bits > kMaxPdoBits) context_.fail(node, fmt::format("a PDO entry of {} bits", bits), "at most 11888 bits");
    context_.note(node, fmt::format("an entry of {} bits: the first {} of them, the rest a gap", bits, kMaxEntryBits));
    for (bits = std::min(bits, kMaxPdoBits) - kMaxEntryBits; bits > 0;) {
      PdoEntry gap;
      gap.bit_length = static_cast<std::uint8_t>(std::min(bits, kMaxEntryBits));
      bits -= gap.bit_length;
      entries.push_back(gap);
    }
  }

  /// Returns the base type of an entry. A type that the file does not declare becomes the unsigned number of the
  /// entry's length, or raw bytes when there is no such number.
  DataType read_entry_type(pugi::xml_node node, std::uint8_t bit_length) {
    const auto type = node.child("DataType");
    const auto base = type ? data_type_of(XmlContext::text_of(type)) : std::nullopt;
    if (base) return *base;
    const auto number = unsigned_type(bit_length);
    if (type) {
      const auto name = XmlContext::text_of(type);
      context_.note(type, number ? fmt::format("the type '{}' is taken as a number of {} bits", name, bit_length)
                                 : fmt::format("the type '{}' is taken as raw bytes", name));
    }
    return number.value_or(DataType::kOctetString);
  }

  void read_mailbox(pugi::xml_node node, MailboxSupport& mailbox) {
    mailbox.aoe = static_cast<bool>(node.child("AoE"));
    const auto eoe = node.child("EoE");
    mailbox.eoe = static_cast<bool>(eoe);
    mailbox.eoe_ip = context_.attribute_flag(eoe, "IP");
    mailbox.eoe_mac = context_.attribute_flag(eoe, "MAC");
    mailbox.foe = static_cast<bool>(node.child("FoE"));
    const auto soe = node.child("SoE");
    mailbox.soe = static_cast<bool>(soe);
    mailbox.soe_channels = context_.attribute_number<std::uint8_t>(soe, "ChannelCount");
    mailbox.voe = static_cast<bool>(node.child("VoE"));
    const auto coe = node.child("CoE");
    mailbox.coe = static_cast<bool>(coe);
    mailbox.coe_sdo_info = context_.attribute_flag(coe, "SdoInfo");
    mailbox.coe_pdo_assign = context_.attribute_flag(coe, "PdoAssign");
    mailbox.coe_pdo_config = context_.attribute_flag(coe, "PdoConfig");
    mailbox.coe_upload_at_startup = context_.attribute_flag(coe, "PdoUpload");
    mailbox.coe_complete_access = context_.attribute_flag(coe, "CompleteAccess");
  }

  DcOpMode read_dc_mode(pugi::xml_node node) {
    DcOpMode mode;
    mode.name = XmlContext::child_text(node, "Name");
    mode.description = context_.localized_text(node, "Desc");
    mode.assign_activate = context_.child_number<std::uint16_t>(node, "AssignActivate");
    mode.cycle_time_sync0_ns = context_.child_number<std::int32_t>(node, "CycleTimeSync0");
    mode.cycle_time_sync0_factor = context_.attribute_number<std::int16_t>(node.child("CycleTimeSync0"), "Factor");
    mode.shift_time_sync0_ns = context_.child_number<std::int32_t>(node, "ShiftTimeSync0");
    mode.cycle_time_sync1_ns = context_.child_number<std::int32_t>(node, "CycleTimeSync1");
    mode.cycle_time_sync1_factor = context_.attribute_number<std::int16_t>(node.child("CycleTimeSync1"), "Factor");
    mode.shift_time_sync1_ns = context_.child_number<std::int32_t>(node, "ShiftTimeSync1");
    for (const auto sm : node.children("Sm")) read_assignment(sm, mode);
    return mode;
  }

  /// Reads a sync manager of a mode: its PDOs, but not its times. Without PDOs the default assignment applies.
  void read_assignment(pugi::xml_node node, DcOpMode& mode) {
    SmAssignment assignment;
    assignment.sync_manager = context_.attribute_number<std::uint8_t>(node, "No");
    for (const auto pdo : node.children("Pdo")) {
      assignment.pdos.push_back(context_.number<std::uint16_t>(pdo, pdo.text().get(), 0));
    }
    if (!assignment.pdos.empty()) mode.assignments.push_back(std::move(assignment));
  }

  /// Reads the EEPROM, which is described by its parts or given as the complete image in Data.
  void read_eeprom(pugi::xml_node node, DeviceDescription& device) {
    const std::string image = context_.child_hex(node, "Data");
    const std::string config = image.empty() ? context_.child_hex(node, "ConfigData") : image;
    device.eeprom_config_data_hex = config.substr(0, 2 * kConfigBytes);
    device.eeprom_bytes = context_.child_number<std::uint32_t>(node, "ByteSize", device.eeprom_bytes);
    device.eeprom_to_application = context_.attribute_flag(node, "AssignToPdi");
    const bool in_image = image.size() >= 2 * (kBootStrapOffset + kBootStrapBytes);
    const std::string boot_hex =
        in_image ? image.substr(2 * kBootStrapOffset, 2 * kBootStrapBytes) : context_.child_hex(node, "BootStrap");
    auto boot = parse_hex(boot_hex).value_or(std::vector<std::byte>{});
    if (boot.size() < kBootStrapBytes) {
      if (!boot.empty()) context_.note(node.child("BootStrap"), "shorter than 8 bytes; the rest is taken as 0");
      boot.resize(kBootStrapBytes);
    }
    const auto word = [&boot](std::size_t n) {
      return bytes::load_le<std::uint16_t>(std::span(boot).subspan(2 * n, 2));
    };
    device.bootstrap_rx_offset = word(0);
    device.bootstrap_rx_size = word(1);
    device.bootstrap_tx_offset = word(2);
    device.bootstrap_tx_size = word(3);
  }

  XmlContext& context_;
  pugi::xml_document& document_;
  EsiFile file_;
  std::map<std::string, std::string> groups_;
};

}  // namespace

const DeviceDescription* EsiFile::find_device(std::uint32_t vendor, std::uint32_t product,
                                              std::uint32_t revision) const noexcept {
  const auto found = std::find_if(devices.begin(), devices.end(), [&](const DeviceDescription& device) {
    return device.vendor_id == vendor && device.product_code == product && device.revision == revision;
  });
  return found == devices.end() ? nullptr : &*found;
}

std::string to_text(const EsiError& error) {
  const std::string place = error.path.empty() ? "" : error.path + ": ";
  const std::string wish = error.expected.empty() ? "" : ", expected " + error.expected;
  return fmt::format("{}:{}: {}{}{}", error.file, error.line, place, error.problem, wish);
}

tl::expected<EsiFile, EsiError> read_esi(std::string_view xml, std::string_view file_name) {
  const std::string text = to_utf8(xml);
  XmlContext context(text, file_name);
  pugi::xml_document document;
  const auto parsed = document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    context.fail_at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(parsed.offset, 0)),
                    fmt::format("not well-formed XML: {}", parsed.description()));
    return tl::unexpected(*context.error());
  }
  EsiFile file = EsiReader(context, document).read();
  if (context.error()) return tl::unexpected(*context.error());
  file.notes = context.take_notes();
  return file;
}

}  // namespace driveline::esi
