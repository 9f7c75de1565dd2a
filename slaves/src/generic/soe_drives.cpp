#include "driveline/slaves/generic/soe_drives.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves::generic {
namespace {

using wire::SoeAttribute;
using wire::SoeDisplay;

constexpr wire::Idn kAtList{16};
constexpr wire::Idn kMdtList{24};
constexpr wire::Idn kVelocityCommand{36};
constexpr wire::Idn kVelocityFeedback{40};
constexpr wire::Idn kPositionCommand{47};
constexpr wire::Idn kPositionFeedback{51};
constexpr wire::Idn kResetClass1{99};
constexpr wire::Idn kControlWord{134};
constexpr wire::Idn kStatusWord{135};

/// Values that the drives use.
struct Values : SlotNumbers {
  constexpr Values() noexcept : SlotNumbers(0) {}
  Slot<std::uint16_t> class1_diagnostic{next()};
  Slot<std::uint16_t> interface_status{next()};
  Slot<IdnList> at_list{next()};
  Slot<IdnList> mdt_list{next()};
  Slot<std::int32_t> velocity_command{next()};
  Slot<std::int32_t> velocity_feedback{next()};
  Slot<std::int32_t> position_command{next()};
  Slot<std::int32_t> position_feedback{next()};
  Slot<IdnList> diagnostic_message{next()};
  Slot<IdnCommand> reset_class1{next()};
  Slot<std::uint16_t> control_word{next()};
  Slot<std::uint16_t> status_word{next()};
  Slot<IdnList> invalid_for_phase2{next()};
  Slot<IdnList> invalid_for_phase3{next()};
  Slot<IdnList> invalid_for_phase4{next()};
};
constexpr Values kValue{};

/// Bit 12 of S-0-0011 and bit 4 of S-0-0014 (IEC 61800-7-204): communication fault, no master data received.
constexpr std::uint16_t kCommunicationFault = 1U << 12;
constexpr std::uint16_t kNoMasterData = 1U << 4;
constexpr std::string_view kReady = "ready";
constexpr std::string_view kFault = "communication fault";
constexpr std::string_view kCheckFailed = "parameters invalid";
static_assert(kCheckFailed.size() <= kFault.size(), "S-0-0095 has room for kFault");
/// CiA 402: communication.
constexpr std::uint16_t kEmergencyCode = 0x7500;
constexpr std::uint8_t kCommunicationError = 0x10;

/// Maximum length of S-0-0142, in bytes.
constexpr std::uint16_t kLongestApplication = 512;
constexpr std::uint8_t kOneByte = 0;
constexpr std::uint8_t kTwoBytes = 1;
constexpr std::uint8_t kFourBytes = 2;
/// Bytes of the longest number.
constexpr std::size_t kLongestNumber = 4;

constexpr SoeAttribute read_only(SoeAttribute attribute) {
  attribute.pre_op_protected = attribute.safe_op_protected = attribute.op_protected = true;
  return attribute;
}

constexpr SoeAttribute of_pre_op(SoeAttribute attribute) {
  attribute.safe_op_protected = attribute.op_protected = true;
  return attribute;
}

constexpr SoeAttribute kWord{.length_code = kTwoBytes};
constexpr SoeAttribute kFlags{.length_code = kTwoBytes, .display = SoeDisplay::kBinary};
constexpr SoeAttribute kMotion{.length_code = kFourBytes, .display = SoeDisplay::kSigned, .decimals = 4};
constexpr SoeAttribute kIdns{.length_code = kTwoBytes, .list = true, .display = SoeDisplay::kIdn};
constexpr SoeAttribute kText{.length_code = kOneByte, .list = true, .display = SoeDisplay::kText};
constexpr SoeAttribute kCommand{.length_code = kTwoBytes, .command = true, .display = SoeDisplay::kBinary};

constexpr IdnRow datum(wire::Idn idn, std::string_view name, SoeAttribute attribute, std::string_view unit = {},
                       std::uint8_t uses = idn_use::kNone) {
  return {.idn = idn, .name = name, .attribute = attribute, .unit = unit, .uses = uses};
}

constexpr IdnRow number(wire::Idn idn, std::string_view name, SoeAttribute attribute, std::string_view unit,
                        double initial, double minimum, double maximum) {
  auto row = datum(idn, name, attribute, unit);
  row.initial = initial;
  row.minimum = minimum;
  row.maximum = maximum;
  row.has_default = true;
  return row;
}

constexpr IdnRow list(wire::Idn idn, std::string_view name, SoeAttribute attribute, std::size_t capacity) {
  auto row = datum(idn, name, attribute);
  row.capacity = static_cast<std::uint16_t>(capacity);
  return row;
}

constexpr IdnRow selection(wire::Idn idn, std::string_view name, IdnSelection selection) {
  auto row = datum(idn, name, read_only(kIdns));
  row.selection = selection;
  return row;
}

constexpr std::array kRowsAtRest = {
    number({1}, "NC cycle time (TNcyc)", of_pre_op(kWord), "us", 1000, 125, 64000),
    in_slot(kValue.class1_diagnostic, datum({11}, "Class 1 diagnostic", read_only(kFlags))),
    in_slot(kValue.interface_status, datum({14}, "Interface status", read_only(kFlags))),
    selection({17}, "IDN list of all operation data", IdnSelection::kAll),
    in_slot(kValue.velocity_feedback,
            datum(kVelocityFeedback, "Velocity feedback value", read_only(kMotion), "1/min", idn_use::kAt)),
    in_slot(kValue.position_feedback,
            datum(kPositionFeedback, "Position feedback value 1", read_only(kMotion), "deg", idn_use::kAt)),
    in_slot(kValue.diagnostic_message, list({95}, "Diagnostic message", read_only(kText), kFault.size())),
    in_slot(kValue.reset_class1, datum(kResetClass1, "Reset class 1 diagnostic", kCommand)),
    number({100}, "Velocity loop proportional gain", kWord, {}, 100, 1, 10000),
    list({142}, "Application type", kText, kLongestApplication),
};

constexpr std::array<std::uint16_t, 1> kFirstAt = {kPositionFeedback.raw};
constexpr std::array<std::uint16_t, 1> kFirstMdt = {kPositionCommand.raw};
/// Bytes of the longest list of cyclic data: velocity and position.
constexpr std::size_t kLongestTelegram = 2 * sizeof(wire::Idn::raw);

constexpr IdnRow telegram(wire::Idn idn, std::string_view name, std::span<const std::uint16_t> elements) {
  auto row = list(idn, name, of_pre_op(kIdns), kLongestTelegram);
  row.elements = elements;
  return row;
}

/// Additional rows of drives whose process data are chosen by lists.
constexpr std::array kCyclicRows = {
    in_slot(kValue.at_list, telegram(kAtList, "Configuration list of AT", kFirstAt)),
    in_slot(kValue.mdt_list, telegram(kMdtList, "Configuration list of MDT", kFirstMdt)),
    in_slot(kValue.velocity_command,
            datum(kVelocityCommand, "Velocity command value", read_only(kMotion), "1/min", idn_use::kMdt)),
    in_slot(kValue.position_command,
            datum(kPositionCommand, "Position command value", read_only(kMotion), "deg", idn_use::kMdt)),
    in_slot(kValue.control_word, datum(kControlWord, "Master control word", read_only(kFlags))),
    in_slot(kValue.status_word, datum(kStatusWord, "Drive status word", read_only(kFlags))),
    selection({187}, "IDN list of configurable data in the AT", IdnSelection::kAt),
    selection({188}, "IDN list of configurable data in the MDT", IdnSelection::kMdt),
};

/// Bytes of a list of invalid data.
constexpr std::size_t kInvalidBytes = 16 * sizeof(wire::Idn::raw);

/// Additional rows of drives with rules.
constexpr std::array kCheckRows = {
    in_slot(kValue.invalid_for_phase2,
            list({21}, "IDN list of invalid operation data for CP2", read_only(kIdns), kInvalidBytes)),
    in_slot(kValue.invalid_for_phase3,
            list({22}, "IDN list of invalid operation data for CP3", read_only(kIdns), kInvalidBytes)),
    in_slot(kValue.invalid_for_phase4,
            list({23}, "IDN list of invalid operation data for CP4", read_only(kIdns), kInvalidBytes)),
};

const IdnTable& table_of(SoeDrives::ProcessData process_data, bool checks) {
  static const IdnTable kAtRest({kRowsAtRest}, kValue.end());
  static const IdnTable kCyclic({kRowsAtRest, kCyclicRows}, kValue.end());
  static const IdnTable kCheckedAtRest({kRowsAtRest, kCheckRows}, kValue.end());
  static const IdnTable kCheckedCyclic({kRowsAtRest, kCyclicRows, kCheckRows}, kValue.end());
  const bool cyclic = process_data == SoeDrives::ProcessData::kByLists;
  if (checks) return cyclic ? kCheckedCyclic : kCheckedAtRest;
  return cyclic ? kCyclic : kAtRest;
}

/// Whether the operation datum is a number within the limits of the rule.
bool fulfils(const IdnValues& values, const SoeRule& rule) noexcept {
  const auto* row = values.table().find(rule.idn);
  if (row == nullptr || !is_number(*row)) return false;
  const auto number = number_from_raw(row->attribute, values.raw(*row));
  return number >= rule.minimum && number <= rule.maximum;
}

/// Returns the IDN at the start of a list, and removes it.
wire::Idn take_idn(std::span<const std::byte>& list) noexcept {
  const wire::Idn idn{bytes::load_le<std::uint16_t>(list)};
  list = list.subspan(sizeof(idn.raw));
  return idn;
}

bool is_cyclic(const IdnRow* row, std::uint8_t use) noexcept {
  return row != nullptr && (row->uses & use) != 0;
}

std::size_t size_of(const std::vector<std::vector<const IdnRow*>>& telegrams) noexcept {
  std::size_t size = 0;
  for (const auto& telegram : telegrams) {
    for (const auto* row : telegram) size += row->attribute.element_size();
  }
  return size;
}

}  // namespace

SoeDrives::SoeDrives(std::size_t count, ProcessData process_data, std::vector<SoeRule> rules)
    : IdnDictionary(std::vector<const IdnTable*>(count, &table_of(process_data, !rules.empty()))),
      rules_(std::move(rules)),
      resets_over_(count),
      mdts_(count),
      ats_(count) {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    set_diagnosis(drive, 0, 0, kReady);
    if (process_data == ProcessData::kByLists) plan_telegrams(drive);
  }
}

void SoeDrives::plan_telegrams(std::uint8_t drive) {
  const auto& known = values(drive);
  const auto plan = [&known](wire::Idn word, std::span<const std::byte> list) {
    Telegram telegram{known.table().find(word)};
    while (!list.empty()) telegram.push_back(known.table().find(take_idn(list)));
    return telegram;
  };
  mdts_[drive] = plan(kControlWord, known.get(kValue.mdt_list));
  ats_[drive] = plan(kStatusWord, known.get(kValue.at_list));
}

void SoeDrives::set_diagnosis(std::uint8_t drive, std::uint16_t class1, std::uint16_t interface_status,
                              std::string_view text) noexcept {
  auto& known = values(drive);
  known.set(kValue.class1_diagnostic, class1);
  known.set(kValue.interface_status, interface_status);
  known.set(kValue.diagnostic_message, std::as_bytes(std::span(text)));
}

bool SoeDrives::check_transition(wire::AlState to) noexcept {
  bool valid = true;
  if (rules_.empty()) return valid;
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) valid = check_drive(drive, to) && valid;
  return valid;
}

bool SoeDrives::check_drive(std::uint8_t drive, wire::AlState to) noexcept {
  auto& known = values(drive);
  std::array<std::byte, kInvalidBytes> invalid{};
  std::size_t size = 0;
  for (const auto& rule : rules_) {
    if (rule.to != to || fulfils(known, rule) || size == invalid.size()) continue;
    bytes::store_le(std::span(invalid).subspan(size).first<2>(), rule.idn.raw);
    size += sizeof(rule.idn.raw);
  }
  const auto list = to == wire::AlState::kSafeOp ? kValue.invalid_for_phase2 : kValue.invalid_for_phase3;
  known.set(list, std::span(invalid).first(size));
  const auto text = size == 0 ? kReady : kCheckFailed;
  known.set(kValue.diagnostic_message, std::as_bytes(std::span(text)));
  return size == 0;
}

void SoeDrives::communication_failed() noexcept {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    set_diagnosis(drive, kCommunicationFault, kNoMasterData, kFault);
    say({drive, wire::Emergency{kEmergencyCode, kCommunicationError, {}}});
  }
}

/// The lists of cyclic data may contain only data that may be cyclic.
SoeAnswer<void> SoeDrives::check_value(std::uint8_t drive, wire::Idn idn, std::span<const std::byte> value) {
  if (idn != kAtList && idn != kMdtList) return {};
  const auto use = idn == kAtList ? idn_use::kAt : idn_use::kMdt;
  while (!value.empty()) {
    const auto* row = values(drive).table().find(take_idn(value));
    if (!is_cyclic(row, use)) return tl::unexpected(wire::SoeError::kValueInvalid);
  }
  return {};
}

void SoeDrives::written(std::uint8_t drive, wire::Idn idn) {
  if (idn == kAtList || idn == kMdtList) plan_telegrams(drive);
}

std::size_t SoeDrives::outputs_size() const noexcept {
  return size_of(mdts_);
}

std::size_t SoeDrives::inputs_size() const noexcept {
  return size_of(ats_);
}

void SoeDrives::write_outputs(std::span<const std::byte> data) noexcept {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    for (const auto* row : mdts_[drive]) {
      std::array<std::byte, kLongestNumber> bytes{};
      const auto value = std::span(bytes).first(row->attribute.element_size());
      raw_to_bytes(values(drive).raw(*row), value);
      const auto part = data.first(std::min(data.size(), value.size()));
      std::copy(part.begin(), part.end(), value.begin());
      values(drive).set_raw(*row, raw_from_bytes(row->attribute, value));
      data = data.subspan(part.size());
    }
  }
  follow_commands();
}

void SoeDrives::clear_outputs() noexcept {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    for (const auto* row : mdts_[drive]) values(drive).set_raw(*row, 0);
  }
  follow_commands();
}

void SoeDrives::follow_commands() noexcept {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    auto& known = values(drive);
    known.set(kValue.status_word, known.get(kValue.control_word));
    known.set(kValue.velocity_feedback, known.get(kValue.velocity_command));
    known.set(kValue.position_feedback, known.get(kValue.position_command));
  }
}

void SoeDrives::read_inputs(std::span<std::byte> data) const noexcept {
  for (std::uint8_t drive = 0; has_drive(drive); ++drive) {
    for (const auto* row : ats_[drive]) {
      const auto part = data.first(std::min(data.size(), row->attribute.element_size()));
      raw_to_bytes(values(drive).raw(*row), part);
      data = data.subspan(part.size());
    }
  }
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
  if (values(drive).get(kValue.reset_class1).state != wire::SoeCommandState::kInProgress) return;
  set_diagnosis(drive, 0, 0, kReady);
  end_command(drive, kResetClass1, wire::SoeCommandState::kExecuted);
}

}  // namespace driveline::slaves::generic
