#include "sample_device.hpp"

#include <array>
#include <string>

namespace driveline::esi::test {
namespace {

constexpr std::array kTypes = {
    DataType::kBoolean,   DataType::kInteger8,      DataType::kInteger16,   DataType::kInteger32,  DataType::kInteger64,
    DataType::kUnsigned8, DataType::kUnsigned16,    DataType::kUnsigned32,  DataType::kUnsigned64, DataType::kReal32,
    DataType::kReal64,    DataType::kVisibleString, DataType::kOctetString, DataType::kBit1,       DataType::kBit7};

std::uint32_t number(std::mt19937& random, std::uint32_t first, std::uint32_t last) {
  return std::uniform_int_distribution<std::uint32_t>(first, last)(random);
}

template <typename T>
T any(std::mt19937& random) {
  return static_cast<T>(random());
}

bool coin(std::mt19937& random) {
  return number(random, 0, 1) == 1;
}

std::string name(std::mt19937& random) {
  // With the characters that XML must escape, and letters of more than one byte.
  constexpr std::array<std::string_view, 12> kPieces = {"a",  "Z", "7", "<", ">",        "&",
                                                        "\"", "'", " ", "]", "\xC3\xBC", "\xE2\x82\xAC"};
  std::string text = "n";
  for (std::uint32_t i = number(random, 0, 12); i > 0; --i) text += kPieces[number(random, 0, kPieces.size() - 1)];
  return text + "x";
}

std::string hex(std::mt19937& random, std::size_t bytes) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text;
  for (std::size_t i = 0; i < 2 * bytes; ++i) text += kDigits[number(random, 0, 15)];
  return text;
}

ObjectEntry random_entry(std::mt19937& random, std::uint8_t subindex) {
  ObjectEntry entry;
  entry.subindex = subindex;
  entry.name = name(random);
  entry.type = kTypes[number(random, 0, kTypes.size() - 1)];
  entry.bit_length = static_cast<std::uint16_t>(number(random, 1, 64));
  entry.readable = coin(random);
  entry.writable = !entry.readable || coin(random);
  entry.rx_mappable = coin(random);
  entry.tx_mappable = coin(random);
  const std::size_t bytes = (entry.bit_length + 7U) / 8U;
  if (coin(random)) entry.default_hex = hex(random, bytes);
  if (coin(random)) entry.minimum_hex = hex(random, bytes);
  if (coin(random)) entry.maximum_hex = hex(random, bytes);
  return entry;
}

Object random_object(std::mt19937& random, std::uint16_t index) {
  Object object{index, name(random), ObjectCode::kVariable, {random_entry(random, 0)}};
  switch (number(random, 0, 2)) {
    case 0:
      object.entries[0].name = object.name;
      return object;
    case 1:
      object.code = ObjectCode::kArray;
      for (std::uint32_t i = number(random, 1, 6); i > 0; --i) {
        ObjectEntry entry = random_entry(random, static_cast<std::uint8_t>(object.entries.size()));
        if (object.entries.size() > 1) {
          const ObjectEntry& first = object.entries[1];
          entry.type = first.type;
          entry.bit_length = first.bit_length;
          entry.readable = first.readable;
          entry.writable = first.writable;
          entry.rx_mappable = first.rx_mappable;
          entry.tx_mappable = first.tx_mappable;
        }
        object.entries.push_back(entry);
      }
      return object;
    default:
      object.code = ObjectCode::kRecord;
      for (std::uint32_t i = number(random, 1, 6), sub = 0; i > 0; --i) {
        sub += number(random, 1, 20);
        object.entries.push_back(random_entry(random, static_cast<std::uint8_t>(sub)));
      }
      return object;
  }
}

Pdo random_pdo(std::mt19937& random) {
  Pdo pdo{any<std::uint16_t>(random), name(random), coin(random), coin(random), std::nullopt, {}};
  if (coin(random)) pdo.sync_manager = static_cast<std::uint8_t>(number(random, 0, 15));
  for (std::uint32_t i = number(random, 0, 5); i > 0; --i) {
    PdoEntry entry;
    entry.bit_length = static_cast<std::uint8_t>(number(random, 1, 255));
    if (number(random, 0, 4) > 0) {
      entry.index = static_cast<std::uint16_t>(number(random, 1, 0xFFFF));
      entry.subindex = any<std::uint8_t>(random);
      entry.name = name(random);
      entry.type = kTypes[number(random, 0, kTypes.size() - 1)];
    }
    pdo.entries.push_back(entry);
  }
  return pdo;
}

DcOpMode random_dc_mode(std::mt19937& random) {
  return {name(random),
          coin(random) ? name(random) : "",
          any<std::uint16_t>(random),
          any<std::int32_t>(random),
          any<std::int16_t>(random),
          any<std::int32_t>(random),
          any<std::int32_t>(random),
          any<std::int16_t>(random),
          any<std::int32_t>(random)};
}

SyncManager random_sync_manager(std::mt19937& random) {
  return {static_cast<SyncManager::Use>(number(random, 0, 4)),
          any<std::uint16_t>(random),
          any<std::uint16_t>(random),
          any<std::uint16_t>(random),
          any<std::uint16_t>(random),
          any<std::uint8_t>(random),
          coin(random)};
}

}  // namespace

DeviceDescription sample_device() {
  DeviceDescription device;
  device.vendor_id = 0x0000ABCD;
  device.product_code = 0x00401234;
  device.revision = 0x00010002;
  device.serial_number = 4711;
  device.vendor_name = "Drives & Co. <GmbH>";
  device.group_type = "ServoDrives";
  device.group_name = "Servo drives";
  device.type = "SD-1";
  device.name = "Servo drive SD-1 (CoE)";
  device.physics = "YY";
  device.device_profile = 402;
  device.mailbox = {false, true, true, true, false, false, true, true, true, true, true};
  device.bootstrap_rx_offset = 0x1000;
  device.bootstrap_rx_size = 0x0100;
  device.bootstrap_tx_offset = 0x1200;
  device.bootstrap_tx_size = 0x0080;
  device.fmmus = {FmmuUse::kOutputs, FmmuUse::kInputs, FmmuUse::kMailboxState};
  device.sync_managers = {{SyncManager::Use::kMailboxOut, 0x1800, 512, 48, 1024, 0x26, true},
                          {SyncManager::Use::kMailboxIn, 0x1C00, 512, 48, 1024, 0x22, true},
                          {SyncManager::Use::kOutputs, 0x1100, 6, 0, 32, 0x64, true},
                          {SyncManager::Use::kInputs, 0x1140, 7, 0, 32, 0x20, false}};
  device.rx_pdos = {{0x1600,
                     "Outputs",
                     false,
                     true,
                     2,
                     {{0x6040, 0, 16, "Control word", DataType::kUnsigned16},
                      {0x607A, 0, 32, "Target position", DataType::kInteger32}}},
                    {0x1601, "Empty", false, false, std::nullopt, {}}};
  device.tx_pdos = {{0x1A00,
                     "Inputs",
                     true,
                     false,
                     3,
                     {{0x6041, 0, 16, "Status word", DataType::kUnsigned16},
                      {0, 0, 8, "", DataType::kUnsigned8},
                      {0x6064, 0, 32, "Position actual value", DataType::kInteger32}}}};
  device.dc_modes = {{"DC", "Synchronous with SYNC0", 0x0300, 0, 1, -5000, 0, 0, 0},
                     {"FreeRun", "", 0, 0, 0, 0, 125000, -2, 700}};
  ObjectEntry device_type{0, "Device type", DataType::kUnsigned32, 32, true, false, false, false, "92010200", "", ""};
  ObjectEntry count{0, "Number of entries", DataType::kUnsigned8, 8, true, false, false, false, "02", "", ""};
  ObjectEntry vendor{1, "Vendor ID", DataType::kUnsigned32, 32, true, false, false, false, "CDAB0000", "", ""};
  ObjectEntry product{2, "Product code", DataType::kUnsigned32, 32, true, false, false, false, "", "", ""};
  ObjectEntry limit{1,     "Minimum", DataType::kInteger32, 32,         true,      true,
                    false, false,     "00000080",           "00000080", "FFFFFF7F"};
  ObjectEntry limit2 = limit;
  limit2.subindex = 2;
  limit2.name = "Maximum";
  ObjectEntry key{0, "Start key", DataType::kOctetString, 128, false, true, false, false, "", "", ""};
  ObjectEntry target{0, "Target position", DataType::kInteger32, 32, true, true, true, true, "00000000", "", ""};
  device.objects = {{0x1000, "Device type", ObjectCode::kVariable, {device_type}},
                    {0x1018, "Identity", ObjectCode::kRecord, {count, vendor, product}},
                    {0x2FFF, "Start key", ObjectCode::kVariable, {key}},
                    {0x607A, "Target position", ObjectCode::kVariable, {target}},
                    {0x607D, "Position limits", ObjectCode::kArray, {count, limit, limit2}}};
  device.eeprom_bytes = 4096;
  device.eeprom_config_data_hex = "05060344640000000000000A0000";
  return device;
}

DeviceDescription random_device(std::mt19937& random) {
  DeviceDescription device;
  device.vendor_id = 1;
  device.vendor_name = "V";
  device.product_code = any<std::uint32_t>(random);
  device.revision = any<std::uint32_t>(random);
  device.serial_number = any<std::uint32_t>(random);
  device.type = name(random);
  device.name = name(random);
  device.group_type = "group" + std::to_string(device.product_code);
  device.group_name = name(random);
  device.physics = coin(random) ? "YKY" : "Y";
  device.device_profile = any<std::uint16_t>(random);
  const bool coe = coin(random);
  device.mailbox = {coin(random), coin(random), coe, coin(random), coin(random), coin(random)};
  if (coe) {
    device.mailbox.coe_sdo_info = coin(random);
    device.mailbox.coe_pdo_assign = coin(random);
    device.mailbox.coe_pdo_config = coin(random);
    device.mailbox.coe_complete_access = coin(random);
    device.mailbox.coe_upload_at_startup = coin(random);
  }
  if (device.mailbox.soe) device.mailbox.soe_channels = static_cast<std::uint8_t>(number(random, 0, 8));
  device.bootstrap_rx_offset = any<std::uint16_t>(random);
  device.bootstrap_rx_size = any<std::uint16_t>(random);
  device.bootstrap_tx_offset = any<std::uint16_t>(random);
  device.bootstrap_tx_size = any<std::uint16_t>(random);
  for (std::uint32_t i = number(random, 0, 5); i > 0; --i) {
    device.fmmus.push_back(static_cast<FmmuUse>(number(random, 0, 3)));
  }
  for (std::uint32_t i = number(random, 0, 5); i > 0; --i) device.sync_managers.push_back(random_sync_manager(random));
  for (std::uint32_t i = number(random, 0, 4); i > 0; --i) device.rx_pdos.push_back(random_pdo(random));
  for (std::uint32_t i = number(random, 0, 4); i > 0; --i) device.tx_pdos.push_back(random_pdo(random));
  for (std::uint32_t i = number(random, 0, 3); i > 0; --i) device.dc_modes.push_back(random_dc_mode(random));
  std::uint32_t index = number(random, 0, 0x1000);
  for (std::uint32_t i = number(random, 0, 8); i > 0; --i) {
    device.objects.push_back(random_object(random, static_cast<std::uint16_t>(index)));
    index += number(random, 1, 0x1000);
  }
  device.eeprom_bytes = 128U << number(random, 4, 9);
  device.eeprom_config_data_hex = hex(random, 14);
  return device;
}

DeviceDescription sii_part(DeviceDescription device) {
  device.vendor_name.clear();
  device.device_profile = 0;
  device.objects.clear();
  for (auto& sm : device.sync_managers) sm.min_size = sm.max_size = 0;
  for (auto& mode : device.dc_modes) mode.cycle_time_sync1_ns = 0;
  return device;
}

std::vector<std::byte> bytes_of(std::string_view hex) {
  std::vector<std::byte> bytes;
  unsigned value = 0;
  unsigned digits = 0;
  for (const char c : hex) {
    if (c == ' ' || c == '\n') continue;
    const unsigned digit = c <= '9' ? static_cast<unsigned>(c - '0') : static_cast<unsigned>((c | 0x20) - 'a' + 10);
    value = (value << 4) | digit;
    if (++digits % 2 == 0) {
      bytes.push_back(static_cast<std::byte>(value & 0xFFU));
      value = 0;
    }
  }
  return bytes;
}

}  // namespace driveline::esi::test
