#include "fixed_drive.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>

#include "driveline/slaves/generic/generic_device.hpp"

namespace driveline::bus_test {
namespace {

using esi::DataType;

// A mailbox message with an SDO request (ETG.1000.6 5.6.2): mailbox header of 6 bytes, CoE header of 2, SDO.
constexpr std::size_t kTypeAt = 5;
constexpr std::size_t kServiceAt = 7;
constexpr std::size_t kCommandAt = 8;
constexpr std::size_t kIndexAt = 9;
constexpr std::size_t kSubindexAt = 11;
constexpr std::size_t kDataAt = 12;
constexpr std::size_t kSdoLength = 16;
constexpr unsigned kCoe = 3;
constexpr unsigned kSdoRequest = 2;
constexpr unsigned kDownload = 1;  // command specifier, bits 5 to 7
constexpr unsigned kUpload = 2;

unsigned at(std::span<const std::byte> mailbox, std::size_t offset) {
  return std::to_integer<unsigned>(mailbox[offset]);
}

esi::Pdo pdo(std::uint16_t index, std::optional<std::uint8_t> sync_manager, std::vector<esi::PdoEntry> entries) {
  return {index, "PDO", false, false, sync_manager, std::move(entries)};
}

esi::PdoEntry entry(std::uint16_t index, DataType type, std::uint8_t bits, const char* name) {
  return {index, 0, bits, name, type};
}

/// 60C2h with the default period of 1 ms.
esi::Object interpolation_time() {
  esi::Object object;
  object.index = 0x60C2;
  object.name = "Interpolation time";
  object.code = esi::ObjectCode::kRecord;
  const auto add = [&](std::uint8_t subindex, DataType type, const char* hex) {
    esi::ObjectEntry one;
    one.subindex = subindex;
    one.name = "Part";
    one.type = type;
    one.bit_length = 8;
    one.writable = true;
    one.default_hex = hex;
    object.entries.push_back(one);
  };
  add(1, DataType::kUnsigned8, "01");
  add(2, DataType::kInteger8, "FD");
  return object;
}

esi::DeviceDescription description() {
  esi::DeviceDescription device;
  device.vendor_id = 0xE000FEED;
  device.product_code = 0x402;
  device.type = "FIXED";
  device.name = "Drive with fixed objects";
  device.device_profile = 402;
  device.mailbox.coe = device.mailbox.coe_pdo_assign = device.mailbox.coe_pdo_config = true;
  device.rx_pdos = {pdo(0x1600, 2,
                        {entry(0x6040, DataType::kUnsigned16, 16, "Control word"),
                         entry(0x607A, DataType::kInteger32, 32, "Target position")}),
                    pdo(0x1601, 2, {entry(0x60FF, DataType::kInteger32, 32, "Target velocity")}),
                    pdo(0x1602, std::nullopt, {entry(0x6071, DataType::kInteger16, 16, "Target torque")})};
  device.tx_pdos = {pdo(0x1A00, 3,
                        {entry(0x6041, DataType::kUnsigned16, 16, "Status word"),
                         entry(0x6064, DataType::kInteger32, 32, "Actual position")}),
                    pdo(0x1A01, 3, {entry(0x606C, DataType::kInteger32, 32, "Actual velocity")})};
  device.objects = {interpolation_time()};
  return device;
}

std::vector<motion::PdoMapping> mappings(const std::vector<esi::Pdo>& known, const std::vector<std::uint16_t>& wanted) {
  std::vector<motion::PdoMapping> all;
  for (const auto index : wanted) {
    const auto found = std::find_if(known.begin(), known.end(), [=](const esi::Pdo& p) { return p.index == index; });
    auto& mapping = all.emplace_back(motion::PdoMapping{index, {}});
    for (const auto& e : found->entries) mapping.objects.push_back({e.index, e.subindex, e.bit_length});
  }
  return all;
}

}  // namespace

FixedDrive::FixedDrive(std::vector<FixedObject> fixed, const EditDescription& edit, const EditEeprom& edit_eeprom)
    : fixed_(std::move(fixed)) {
  auto device = description();
  if (edit) edit(device);
  auto model = slaves::generic::DeviceModel::create(device);
  if (!model) throw std::runtime_error(describe(model.error()));
  slaves::generic::GenericOptions options;
  options.serial_number = 17;
  auto drive = std::make_unique<slaves::generic::GenericDevice>(*model, options);
  auto profile = drive->profile();
  if (edit_eeprom) {
    auto image = esi::decode_sii(profile.sii_image).value();
    edit_eeprom(image);
    profile.sii_image = esi::encode_sii(image);
  }
  auto edited = std::make_unique<EditedDevice>(std::move(drive), std::move(profile));
  device_ = edited.get();
  device_->changes_request = [this](std::span<std::byte> mailbox) { take_request(mailbox); };
  device_->changes_answer = [this](std::span<std::byte> out, std::size_t length) { return answer(out, length); };
  std::vector<std::unique_ptr<slaves::Slave>> list;
  list.push_back(std::make_unique<slaves::Slave>(std::move(edited), slaves::SlaveOptions{}));
  line_ = std::make_unique<slaves::SimulatedLine>(clock, std::move(list));
  master_ = std::make_unique<ecat_master::Master>(*line_, clock);
}

/// A transfer that the rules refuse reaches the drive as a harmless upload of 1000h, whose answer is replaced.
void FixedDrive::take_request(std::span<std::byte> mailbox) {
  if (mailbox.size() < kSdoLength || (at(mailbox, kTypeAt) & 0x0FU) != kCoe ||
      at(mailbox, kServiceAt) >> 4 != kSdoRequest) {
    return;
  }
  const auto command = at(mailbox, kCommandAt) >> 5;
  const auto index = static_cast<std::uint16_t>(at(mailbox, kIndexAt) | at(mailbox, kIndexAt + 1) << 8);
  const auto subindex = static_cast<std::uint8_t>(at(mailbox, kSubindexAt));
  if (command == kDownload) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "%04X:%02X", index, subindex);
    written.emplace_back(text.data());
  }
  const auto rule = std::find_if(fixed_.begin(), fixed_.end(), [&](const FixedObject& object) {
    const bool way = object.way == FixedObject::Way::kBoth ||
                     (object.way == FixedObject::Way::kWrite ? command == kDownload : command == kUpload);
    return way && object.index == index && object.subindex.value_or(subindex) == subindex;
  });
  if (rule == fixed_.end() || (command != kDownload && command != kUpload)) return;
  const auto code = static_cast<std::uint32_t>(rule->code);
  abort_.emplace();
  for (const unsigned byte : {0x80U, index & 0xFFU, static_cast<unsigned>(index) >> 8, static_cast<unsigned>(subindex),
                              code & 0xFFU, code >> 8 & 0xFFU, code >> 16 & 0xFFU, code >> 24}) {
    abort_->push_back(static_cast<std::byte>(byte));
  }
  mailbox[kCommandAt] = std::byte{0x40};
  mailbox[kIndexAt] = std::byte{0x00};
  mailbox[kIndexAt + 1] = std::byte{0x10};
  mailbox[kSubindexAt] = std::byte{0x00};
  std::fill(mailbox.begin() + kDataAt, mailbox.begin() + kSdoLength, std::byte{0});
}

std::size_t FixedDrive::answer(std::span<std::byte> out, std::size_t length) {
  if (!abort_) return length;
  out[0] = static_cast<std::byte>(kSdoLength - 6);
  out[1] = std::byte{0};
  out[kServiceAt] = static_cast<std::byte>(kSdoRequest << 4);
  std::copy(abort_->begin(), abort_->end(), out.begin() + kCommandAt);
  abort_.reset();
  return kSdoLength;
}

std::string FixedDrive::to_safe_op(const ecat_master::SlavePlan& plan) {
  if (auto done = master_->scan(); !done) return describe(done.error());
  if (auto done = master_->configure({plan}); !done) return describe(done.error());
  return {};
}

std::vector<std::string> FixedDrive::notes() const {
  std::vector<std::string> sentences;
  for (const auto& note : master_->startup_notes()) sentences.push_back(describe(note));
  return sentences;
}

std::optional<std::uint32_t> FixedDrive::value(std::uint16_t index, std::uint8_t subindex) {
  const auto data = ecat_master::CoeClient(*master_->mailbox(0)).upload(index, subindex);
  if (!data) return std::nullopt;
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(data->size(), 4); ++i) {
    number |= std::to_integer<std::uint32_t>((*data)[i]) << (8 * i);
  }
  return number;
}

ecat_master::SlavePlan plan_with(const std::vector<std::uint16_t>& outputs, const std::vector<std::uint16_t>& inputs) {
  const auto known = description();
  ecat_master::SlavePlan plan;
  plan.name = "drive";
  plan.pdos = {mappings(known.rx_pdos, outputs), mappings(known.tx_pdos, inputs)};
  return plan;
}

}  // namespace driveline::bus_test
