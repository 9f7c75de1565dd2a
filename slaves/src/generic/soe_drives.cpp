#include "driveline/slaves/generic/soe_drives.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves::generic {
namespace {

using wire::SoeAttribute;
using wire::SoeDisplay;
using Bytes = std::vector<std::byte>;

constexpr wire::Idn kClass1Diagnostic{11};
constexpr wire::Idn kInterfaceStatus{14};
constexpr wire::Idn kAtList{16};
constexpr wire::Idn kMdtList{24};
constexpr wire::Idn kVelocityCommand{36};
constexpr wire::Idn kVelocityFeedback{40};
constexpr wire::Idn kPositionCommand{47};
constexpr wire::Idn kPositionFeedback{51};
constexpr wire::Idn kDiagnosticMessage{95};
constexpr wire::Idn kControlWord{134};
constexpr wire::Idn kStatusWord{135};
constexpr wire::Idn kAtChoice{187};
constexpr wire::Idn kMdtChoice{188};
/// Data of the MDT, and the data of the AT that follow them at once.
constexpr std::array kFollowers = {std::pair{kControlWord, kStatusWord}, std::pair{kVelocityCommand, kVelocityFeedback},
                                   std::pair{kPositionCommand, kPositionFeedback}};
constexpr wire::Idn kResetClass1{99};

/// Bit 12 of S-0-0011 and bit 4 of S-0-0014 (IEC 61800-7-204): communication fault, no master data received.
constexpr std::uint16_t kCommunicationFault = 1U << 12;
constexpr std::uint16_t kNoMasterData = 1U << 4;
constexpr std::string_view kReady = "ready";
constexpr std::string_view kFault = "communication fault";
/// CiA 402: communication.
constexpr std::uint16_t kEmergencyCode = 0x7500;
constexpr std::uint8_t kCommunicationError = 0x10;

/// Maximum length of S-0-0142, in bytes.
constexpr std::uint16_t kLongestApplication = 512;
constexpr std::uint8_t kOneByte = 0;
constexpr std::uint8_t kTwoBytes = 1;
constexpr std::uint8_t kFourBytes = 2;

template <typename T>
Bytes bytes_of(T value) {
  const auto bytes = bytes::to_le_bytes(value);
  return {bytes.begin(), bytes.end()};
}

SoeAttribute read_only(SoeAttribute attribute) {
  attribute.pre_op_protected = attribute.safe_op_protected = attribute.op_protected = true;
  return attribute;
}

constexpr SoeAttribute kFlags{.length_code = kTwoBytes, .display = SoeDisplay::kBinary};
constexpr SoeAttribute kMotion{.length_code = kFourBytes, .display = SoeDisplay::kSigned, .decimals = 4};
constexpr SoeAttribute kIdns{.length_code = kTwoBytes, .list = true, .display = SoeDisplay::kIdn};

std::vector<SoeRow> rows_at_rest() {
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
       .attribute = read_only(kFlags),
       .value = bytes_of<std::uint16_t>(0)},
      {.idn = kInterfaceStatus,
       .name = "Interface status",
       .attribute = read_only(kFlags),
       .value = bytes_of<std::uint16_t>(0)},
      {.idn = {17}, .name = "IDN list of all operation data", .attribute = read_only(kIdns)},
      {.idn = kVelocityFeedback,
       .name = "Velocity feedback value",
       .attribute = read_only(kMotion),
       .unit = "1/min",
       .value = bytes_of<std::int32_t>(0)},
      {.idn = kPositionFeedback,
       .name = "Position feedback value 1",
       .attribute = read_only(kMotion),
       .unit = "deg",
       .value = bytes_of<std::int32_t>(0)},
      {.idn = kDiagnosticMessage,
       .name = "Diagnostic message",
       .attribute = read_only({.length_code = kOneByte, .list = true, .display = SoeDisplay::kText}),
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
      {.idn = {142},
       .name = "Application type",
       .attribute = {.length_code = kOneByte, .list = true, .display = SoeDisplay::kText},
       .capacity = kLongestApplication},
  };
}

Bytes idn_list(std::initializer_list<wire::Idn> idns) {
  Bytes list;
  for (const auto idn : idns) {
    const auto bytes = bytes::to_le_bytes(idn.raw);
    list.insert(list.end(), bytes.begin(), bytes.end());
  }
  return list;
}

/// Returns the additional rows of drives whose process data are chosen by lists.
std::vector<SoeRow> cyclic_rows() {
  auto of_pre_op = kIdns;
  of_pre_op.safe_op_protected = of_pre_op.op_protected = true;
  const auto at = idn_list({kVelocityFeedback, kPositionFeedback});
  const auto mdt = idn_list({kVelocityCommand, kPositionCommand});
  const auto longest = static_cast<std::uint16_t>(at.size());
  return {
      {.idn = kAtList,
       .name = "Configuration list of AT",
       .attribute = of_pre_op,
       .value = idn_list({kPositionFeedback}),
       .capacity = longest},
      {.idn = kMdtList,
       .name = "Configuration list of MDT",
       .attribute = of_pre_op,
       .value = idn_list({kPositionCommand}),
       .capacity = longest},
      {.idn = kVelocityCommand,
       .name = "Velocity command value",
       .attribute = read_only(kMotion),
       .unit = "1/min",
       .value = bytes_of<std::int32_t>(0)},
      {.idn = kPositionCommand,
       .name = "Position command value",
       .attribute = read_only(kMotion),
       .unit = "deg",
       .value = bytes_of<std::int32_t>(0)},
      {.idn = kControlWord,
       .name = "Master control word",
       .attribute = read_only(kFlags),
       .value = bytes_of<std::uint16_t>(0)},
      {.idn = kStatusWord,
       .name = "Drive status word",
       .attribute = read_only(kFlags),
       .value = bytes_of<std::uint16_t>(0)},
      {.idn = kAtChoice,
       .name = "IDN list of configurable data in the AT",
       .attribute = read_only(kIdns),
       .value = at,
       .capacity = longest},
      {.idn = kMdtChoice,
       .name = "IDN list of configurable data in the MDT",
       .attribute = read_only(kIdns),
       .value = mdt,
       .capacity = longest},
  };
}

std::vector<SoeRow> rows(SoeDrives::ProcessData process_data) {
  auto rows = rows_at_rest();
  if (process_data == SoeDrives::ProcessData::kNone) return rows;
  for (auto& row : cyclic_rows()) rows.push_back(std::move(row));
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.idn.raw < b.idn.raw; });
  return rows;
}

}  // namespace

SoeDrives::SoeDrives(std::size_t count, ProcessData process_data)
    : SoeTable(std::vector<std::vector<SoeRow>>(count, rows(process_data))),
      cyclic_(process_data == ProcessData::kByLists),
      resets_over_(count) {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) set_diagnosis(drive, kReady);
}

void SoeDrives::set(std::uint8_t drive, wire::Idn idn, std::uint16_t value) noexcept {
  bytes::store_le(find(drive, idn)->value, value);
}

void SoeDrives::set_diagnosis(std::uint8_t drive, std::string_view text) noexcept {
  const auto bytes = std::as_bytes(std::span(text));
  find(drive, kDiagnosticMessage)->value.assign(bytes.begin(), bytes.end());
}

void SoeDrives::communication_failed() noexcept {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    set(drive, kClass1Diagnostic, kCommunicationFault);
    set(drive, kInterfaceStatus, kNoMasterData);
    set_diagnosis(drive, kFault);
    say({drive, wire::Emergency{kEmergencyCode, kCommunicationError, {}}});
  }
}

/// The lists of cyclic data may contain only data that may be cyclic.
SoeAnswer<void> SoeDrives::check_value(std::uint8_t drive, wire::Idn idn, std::span<const std::byte> value) {
  if (idn != kAtList && idn != kMdtList) return {};
  const auto& known = find(drive, idn == kAtList ? kAtChoice : kMdtChoice)->value;
  for (; !value.empty(); value = value.subspan(sizeof(wire::Idn::raw))) {
    bool may_be = false;
    for (auto rest = std::span<const std::byte>(known); !rest.empty(); rest = rest.subspan(sizeof(wire::Idn::raw))) {
      may_be = may_be || bytes::load_le<std::uint16_t>(rest) == bytes::load_le<std::uint16_t>(value);
    }
    if (!may_be) return tl::unexpected(wire::SoeError::kValueInvalid);
  }
  return {};
}

template <typename Visit>
void SoeDrives::for_each_cyclic(wire::Idn word, wire::Idn list, Visit&& visit) noexcept {
  for (std::uint8_t drive = 0; cyclic_ && has_drive(drive); ++drive) {
    visit(find(drive, word)->value);
    const auto& idns = find(drive, list)->value;
    for (std::size_t at = 0; at < idns.size(); at += sizeof(wire::Idn::raw)) {
      visit(find(drive, {bytes::load_le<std::uint16_t>(std::span(idns).subspan(at))})->value);
    }
  }
}

std::size_t SoeDrives::outputs_size() noexcept {
  std::size_t size = 0;
  for_each_cyclic(kControlWord, kMdtList, [&size](const Bytes& value) { size += value.size(); });
  return size;
}

std::size_t SoeDrives::inputs_size() noexcept {
  std::size_t size = 0;
  for_each_cyclic(kStatusWord, kAtList, [&size](const Bytes& value) { size += value.size(); });
  return size;
}

void SoeDrives::write_outputs(std::span<const std::byte> data) noexcept {
  for_each_cyclic(kControlWord, kMdtList, [&data](Bytes& value) {
    const auto part = data.first(std::min(data.size(), value.size()));
    std::copy(part.begin(), part.end(), value.begin());
    data = data.subspan(part.size());
  });
  follow_commands();
}

void SoeDrives::clear_outputs() noexcept {
  for_each_cyclic(kControlWord, kMdtList, [](Bytes& value) { std::fill(value.begin(), value.end(), std::byte{0}); });
  follow_commands();
}

void SoeDrives::follow_commands() noexcept {
  for (std::uint8_t drive = 0; cyclic_ && has_drive(drive); ++drive) {
    for (const auto& [from, to] : kFollowers) {
      const auto& command = find(drive, from)->value;
      std::copy(command.begin(), command.end(), find(drive, to)->value.begin());
    }
  }
}

void SoeDrives::read_inputs(std::span<std::byte> data) noexcept {
  for_each_cyclic(kStatusWord, kAtList, [&data](const Bytes& value) {
    const auto size = std::min(data.size(), value.size());
    std::copy_n(value.begin(), size, data.begin());
    data = data.subspan(size);
  });
}

/// The only procedure command is the reset.
SoeAnswer<void> SoeDrives::start_command(std::uint8_t drive, wire::Idn /*idn*/) {
  resets_over_[drive] = now_ + kResetTime;
  return {};
}

void SoeDrives::advance(std::chrono::nanoseconds now) noexcept {
  now_ = now;
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) advance(drive);
}

void SoeDrives::advance(std::uint8_t drive) noexcept {
  auto& over = resets_over_[drive];
  if (!over || now_ < *over) return;
  over.reset();
  if (find(drive, kResetClass1)->state != wire::SoeCommandState::kInProgress) return;
  set(drive, kClass1Diagnostic, 0);
  set(drive, kInterfaceStatus, 0);
  set_diagnosis(drive, kReady);
  end_command(drive, kResetClass1, wire::SoeCommandState::kExecuted);
}

}  // namespace driveline::slaves::generic
