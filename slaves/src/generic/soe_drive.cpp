#include "driveline/slaves/generic/soe_drive.hpp"

#include <string_view>
#include <utility>

#include "driveline/wire/endian.hpp"

namespace driveline::slaves::generic {
namespace {

using wire::SoeAttribute;
using wire::SoeDisplay;
using Bytes = std::vector<std::byte>;

constexpr std::uint8_t kDrive = 0;
constexpr wire::Idn kClass1Diagnostic{11};
constexpr wire::Idn kInterfaceStatus{14};
constexpr wire::Idn kDiagnosticMessage{95};
constexpr wire::Idn kResetClass1{99};

/// Bit 12 of S-0-0011 and bit 4 of S-0-0014 (IEC 61800-7-204): communication fault, master data have not come.
constexpr std::uint16_t kCommunicationFault = 1U << 12;
constexpr std::uint16_t kNoMasterData = 1U << 4;
constexpr std::string_view kReady = "ready";
constexpr std::string_view kFault = "communication fault";
/// CiA 402: communication.
constexpr std::uint16_t kEmergencyCode = 0x7500;
constexpr std::uint8_t kCommunicationError = 0x10;

constexpr std::uint8_t kTwoBytes = 1;
constexpr std::uint8_t kFourBytes = 2;

template <typename T>
Bytes bytes_of(T value) {
  const auto bytes = wire::to_le_bytes(value);
  return {bytes.begin(), bytes.end()};
}

SoeAttribute read_only(SoeAttribute attribute) {
  attribute.pre_op_protected = attribute.safe_op_protected = attribute.op_protected = true;
  return attribute;
}

std::vector<SoeRow> rows() {
  const SoeAttribute flags{.length_code = kTwoBytes, .display = SoeDisplay::kBinary};
  const SoeAttribute feedback{.length_code = kFourBytes, .display = SoeDisplay::kSigned, .decimals = 4};
  return {
      {.idn = {1},
       .name = "NC cycle time (TNcyc)",
       .attribute = {.length_code = kTwoBytes, .safe_op_protected = true, .op_protected = true},
       .unit = "us",
       .value = bytes_of<std::uint16_t>(1000),
       .min = bytes_of<std::uint16_t>(125),
       .max = bytes_of<std::uint16_t>(64000),
       .preset = bytes_of<std::uint16_t>(1000)},
      {.idn = kClass1Diagnostic,
       .name = "Class 1 diagnostic",
       .attribute = read_only(flags),
       .value = bytes_of<std::uint16_t>(0)},
      {.idn = kInterfaceStatus,
       .name = "Interface status",
       .attribute = read_only(flags),
       .value = bytes_of<std::uint16_t>(0)},
      {.idn = {17},
       .name = "IDN list of all operation data",
       .attribute = read_only({.length_code = kTwoBytes, .list = true, .display = SoeDisplay::kIdn})},
      {.idn = {40},
       .name = "Velocity feedback value",
       .attribute = read_only(feedback),
       .unit = "1/min",
       .value = bytes_of<std::int32_t>(0)},
      {.idn = {51},
       .name = "Position feedback value 1",
       .attribute = read_only(feedback),
       .unit = "deg",
       .value = bytes_of<std::int32_t>(0)},
      {.idn = kDiagnosticMessage,
       .name = "Diagnostic message",
       .attribute = read_only({.length_code = 0, .list = true, .display = SoeDisplay::kText}),
       .capacity = static_cast<std::uint16_t>(kFault.size())},
      {.idn = kResetClass1,
       .name = "Reset class 1 diagnostic",
       .attribute = {.length_code = kTwoBytes, .command = true, .display = SoeDisplay::kBinary},
       .value = bytes_of(wire::kSoeCommandCancel)},
      {.idn = {100},
       .name = "Velocity loop proportional gain",
       .attribute = {.length_code = kTwoBytes},
       .value = bytes_of<std::uint16_t>(100),
       .min = bytes_of<std::uint16_t>(1),
       .max = bytes_of<std::uint16_t>(10000),
       .preset = bytes_of<std::uint16_t>(100)},
  };
}

}  // namespace

SoeDrive::SoeDrive() : SoeTable({rows()}) {
  set_diagnosis(kReady);
}

void SoeDrive::set(wire::Idn idn, std::uint16_t value) noexcept {
  wire::store_le(find(kDrive, idn)->value, value);
}

void SoeDrive::set_diagnosis(std::string_view text) noexcept {
  const auto bytes = std::as_bytes(std::span(text));
  find(kDrive, kDiagnosticMessage)->value.assign(bytes.begin(), bytes.end());
}

void SoeDrive::communication_failed() noexcept {
  set(kClass1Diagnostic, kCommunicationFault);
  set(kInterfaceStatus, kNoMasterData);
  set_diagnosis(kFault);
  say({kDrive, wire::Emergency{kEmergencyCode, kCommunicationError, {}}});
}

/// There is but one command.
SoeAnswer<void> SoeDrive::start_command(std::uint8_t /*drive*/, wire::Idn /*idn*/) {
  reset_over_ = now_ + kResetTime;
  return {};
}

void SoeDrive::advance(std::chrono::nanoseconds now) noexcept {
  now_ = now;
  if (!reset_over_ || now < *reset_over_) return;
  reset_over_.reset();
  if (find(kDrive, kResetClass1)->state != wire::SoeCommandState::kInProgress) return;
  set(kClass1Diagnostic, 0);
  set(kInterfaceStatus, 0);
  set_diagnosis(kReady);
  end_command(kDrive, kResetClass1, wire::SoeCommandState::kExecuted);
}

}  // namespace driveline::slaves::generic
