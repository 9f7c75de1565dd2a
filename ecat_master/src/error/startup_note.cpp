#include "driveline/ecat_master/error/startup_note.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace driveline::ecat_master {
namespace {

std::string noted_entry(const facts::ObjectAddress& object) {
  return fmt::format("object {:04X}h:{:02X}", object.index, object.subindex);
}

std::string noted_abort(wire::SdoAbort code) {
  return fmt::format("0x{:08X} ({})", static_cast<std::uint32_t>(code), wire::to_text(code));
}

/// Names of sync manager types as in the EEPROM (ETG.1000.6 Table 23).
std::string_view sync_manager_type(std::uint8_t type) {
  constexpr std::array<std::string_view, 5> kNames{"unused", "mailbox out", "mailbox in", "outputs", "inputs"};
  return type < kNames.size() ? kNames.at(type) : "unknown";
}

std::string counted_pdos(std::uint16_t pdos) {
  return pdos == 1 ? std::string("1 PDO") : fmt::format("{} PDOs", pdos);
}

std::string noted_idn(wire::Idn idn) {
  const auto text = idn.text();
  return {text.begin(), text.end()};
}

/// Value and limits as far as they are known: ": it is 500 us, limits 125 to 64000 us".
std::string noted_value(const notes::DatumRefusesState& facts) {
  const auto unit = facts.unit.empty() ? std::string{} : " " + facts.unit;
  std::string text;
  if (!facts.value.empty()) text += fmt::format(": it is {}{}", facts.value, unit);
  if (facts.minimum.empty() && facts.maximum.empty()) return text;
  text += text.empty() ? ": " : ", ";
  if (facts.minimum.empty()) return text + fmt::format("upper limit {}{}", facts.maximum, unit);
  if (facts.maximum.empty()) return text + fmt::format("lower limit {}{}", facts.minimum, unit);
  return text + fmt::format("limits {} to {}{}", facts.minimum, facts.maximum, unit);
}

/// Visitor that makes the sentence, without the slave.
struct NoteSentence {
  std::string operator()(const notes::WriteRefused& facts) const {
    return fmt::format("{} refused{} with {}{}", noted_entry(facts.object),
                       facts.wanted ? fmt::format(" {}", *facts.wanted) : std::string{}, noted_abort(facts.code),
                       facts.present ? fmt::format(" and keeps {}", *facts.present) : std::string{});
  }
  std::string operator()(const notes::WriteIgnored& facts) const {
    return fmt::format("{} is {} after {} was written", noted_entry(facts.object), facts.present, facts.wanted);
  }
  std::string operator()(const notes::PdosFromDescription& facts) const {
    return fmt::format("{} cannot be read, aborted with {}: sync manager {} exchanges the {} of the description",
                       noted_entry(facts.object), noted_abort(facts.code), facts.sync_manager,
                       counted_pdos(facts.pdos));
  }
  std::string operator()(const notes::MappingFromDescription& facts) const {
    return fmt::format("the mapping of PDO {:04X}h cannot be read, aborted with {}: that of the description is used",
                       facts.pdo, noted_abort(facts.code));
  }
  std::string operator()(const notes::ListEndsEarly& facts) const {
    return fmt::format("{} cannot be read, aborted with {}: the list should have {} elements, {} are used",
                       noted_entry(facts.object), noted_abort(facts.code), facts.elements, facts.object.subindex - 1);
  }
  std::string operator()(const notes::PlannedPdosReplaced& facts) const {
    return fmt::format("exchanges its own {} ({}, {} bytes), not the planned ones",
                       facts.outputs ? "outputs" : "inputs", counted_pdos(facts.pdos), facts.bytes);
  }
  std::string operator()(const notes::NothingAssigned& facts) const {
    return fmt::format(
        "exchanges no process data: of its {} none with objects is assigned to a sync manager; [[slave.pdo]] of a line "
        "description assigns PDOs",
        counted_pdos(facts.pdos));
  }
  std::string operator()(const notes::SyncManagerUse& facts) const {
    return fmt::format(
        "sync manager {} has type {} ({}) in the EEPROM, its control byte 0x{:02X} is that of {}: it is used for {}",
        facts.number, facts.type, sync_manager_type(facts.type), facts.control, sync_manager_type(facts.taken),
        sync_manager_type(facts.taken));
  }
  std::string operator()(const notes::StateReachedLater& facts) const {
    return fmt::format("reached {} only after {}, AL status code 0x{:04X} ({})", wire::to_text(facts.state),
                       facts.refusals == 1 ? std::string("a refusal") : fmt::format("{} refusals", facts.refusals),
                       static_cast<std::uint16_t>(facts.code), wire::to_text(facts.code));
  }
  std::string operator()(const notes::DatumRefusesState& facts) const {
    const auto& invalid = facts.invalid;
    return fmt::format("drive {} lists {}{} in {} as invalid{}{}", invalid.drive, noted_idn(invalid.idn),
                       facts.name.empty() ? std::string{} : fmt::format(" ({})", facts.name), noted_idn({invalid.list}),
                       noted_value(facts), facts.further == 0 ? "" : fmt::format("; and {} more", facts.further));
  }
  std::string operator()(const notes::DriveDiagnosis& facts) const {
    return fmt::format("drive {} says in S-0-0095: \"{}\"", facts.drive, facts.text);
  }
};

}  // namespace

void add_new(StartupNotes& notes, const StartupNotes& more) {
  for (const auto& note : more) {
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  }
}

std::string describe(const StartupNote& note) {
  return fmt::format("slave {}: {}", note.slave, std::visit(NoteSentence{}, note.facts));
}

}  // namespace driveline::ecat_master
