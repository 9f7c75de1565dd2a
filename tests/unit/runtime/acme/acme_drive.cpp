#include "acme_drive.hpp"

#include <stdexcept>
#include <vector>

namespace driveline::acme {
namespace {

using esi::DataType;

/// Indices of the signals: the order of the entries in the PDOs.
enum Output : std::size_t { kControlWord = 0, kMode = 1, kTargetPosition = 2 };
enum Input : std::size_t { kStatusWord = 0, kModeDisplay = 1, kActualPosition = 2 };

esi::PdoEntry entry(std::uint16_t index, DataType type, std::uint8_t bits, const char* name) {
  return {.index = index, .subindex = 0, .bit_length = bits, .name = name, .type = type};
}

esi::Pdo pdo(std::uint16_t index, std::uint8_t sync_manager, std::vector<esi::PdoEntry> entries) {
  esi::Pdo pdo;
  pdo.index = index;
  pdo.name = index < 0x1A00 ? "Outputs" : "Inputs";
  pdo.sync_manager = sync_manager;
  pdo.entries = std::move(entries);
  return pdo;
}

esi::Object number_object(std::uint16_t index, const char* name, const std::vector<DataType>& types) {
  esi::Object object;
  object.index = index;
  object.name = name;
  object.code = types.size() == 1 ? esi::ObjectCode::kVariable : esi::ObjectCode::kRecord;
  std::uint8_t subindex = types.size() == 1 ? 0 : 1;
  for (const auto type : types) {
    esi::ObjectEntry one;
    one.subindex = subindex++;
    one.name = name;
    one.type = type;
    one.bit_length = type == DataType::kUnsigned32 ? 32 : 8;
    one.writable = true;
    object.entries.push_back(one);
  }
  return object;
}

esi::DeviceDescription description() {
  esi::DeviceDescription device;
  device.vendor_id = kVendorId;
  device.product_code = kProductCode;
  device.revision = 1;
  device.type = "ACME 1";
  device.name = "Acme servo drive";
  device.device_profile = 402;
  device.mailbox.coe = device.mailbox.coe_pdo_assign = device.mailbox.coe_pdo_config = true;
  device.rx_pdos = {
      pdo(0x1600, 2,
          {entry(0x6040, DataType::kUnsigned16, 16, "Control word"), entry(0x6060, DataType::kInteger8, 8, "Mode"),
           entry(0x607A, DataType::kInteger32, 32, "Target position")}),
      pdo(0x1601, 2,
          {entry(0x60FF, DataType::kInteger32, 32, "Target velocity"),
           entry(0x60B1, DataType::kInteger32, 32, "Velocity offset")}),
      pdo(0x1602, 2,
          {entry(0x6071, DataType::kInteger16, 16, "Target torque"),
           entry(0x60B2, DataType::kInteger16, 16, "Torque offset")})};
  device.tx_pdos = {pdo(0x1A00, 3,
                        {entry(0x6041, DataType::kUnsigned16, 16, "Status word"),
                         entry(0x6061, DataType::kInteger8, 8, "Mode display"),
                         entry(0x6064, DataType::kInteger32, 32, "Actual position")}),
                    pdo(0x1A01, 3,
                        {entry(0x606C, DataType::kInteger32, 32, "Actual velocity"),
                         entry(0x60F4, DataType::kInteger32, 32, "Following error")}),
                    pdo(0x1A02, 3,
                        {entry(0x6077, DataType::kInteger16, 16, "Actual torque"),
                         entry(0x603F, DataType::kUnsigned16, 16, "Error code")})};
  device.objects = {number_object(kSetpointTime, "Setpoint time", {DataType::kUnsigned32}),
                    number_object(0x60C2, "Interpolation time", {DataType::kUnsigned8, DataType::kInteger8})};
  return device;
}

}  // namespace

std::shared_ptr<const slaves::generic::DeviceModel> drive_model() {
  auto model = slaves::generic::DeviceModel::create(description());
  if (!model) throw std::logic_error(describe(model.error()));
  return *model;
}

AcmeDrive::AcmeDrive(std::int32_t start_increments, std::uint32_t serial_number)
    : bus_(drive_model(), {.serial_number = serial_number, .loop_back = false}),
      position_(start_increments),
      target_(start_increments) {}

std::uint64_t AcmeDrive::object(std::uint16_t index, std::uint8_t subindex) const {
  return bus_.dictionary().raw(*bus_.model().table().find(index, subindex));
}

void AcmeDrive::write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept {
  target_ = static_cast<std::int32_t>(output(kTargetPosition));
  bus_.write_outputs(sync_manager, data);
}

void AcmeDrive::advance(std::chrono::nanoseconds now) noexcept {
  slaves::PowerStateMachine::Conditions conditions;
  conditions.control_word = static_cast<std::uint16_t>(output(kControlWord));
  conditions.power_ready = object(kSetpointTime, 0) > 0;
  conditions.standstill = true;
  power_.step(conditions, now - last_);
  last_ = now;
  const bool follows = power_.motion() == slaves::MotionCommand::kFollow;
  if (follows) position_ = target_;
  namespace bits = slaves::status_word;
  bus_.set_signal(kStatusWord, status_bits(power_.state()) | bits::kVoltageEnabled | bits::kRemote |
                                   (follows ? bits::kTargetUsed : 0U));
  bus_.set_signal(kModeDisplay, output(kMode));
  bus_.set_signal(kActualPosition, position_);
}

}  // namespace driveline::acme
