#include "driveline/ecat_master/configuration/process_variables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "configuration/process_data_setup.hpp"
#include "driveline/motion/cia402/object_name.hpp"

namespace driveline::ecat_master {
namespace {

struct Names {
  std::string entry;
  std::string pdo;
};

const esi::PdoEntry* find_entry(const esi::Pdo& pdo, const motion::MappedObject& object) {
  const auto entry = std::find_if(pdo.entries.begin(), pdo.entries.end(), [&](const esi::PdoEntry& e) {
    return e.index == object.index && e.subindex == object.subindex;
  });
  return entry != pdo.entries.end() && !entry->name.empty() ? &*entry : nullptr;
}

/// Name of an object in a PDO: taken from that PDO, else from another PDO, the dictionary, or the drive profile.
Names names_of(const esi::DeviceDescription& description, std::uint16_t pdo_index, const motion::MappedObject& object) {
  Names names;
  for (const auto* pdos : {&description.rx_pdos, &description.tx_pdos}) {
    for (const auto& pdo : *pdos) {
      const auto* entry = find_entry(pdo, object);
      if (entry != nullptr && (names.entry.empty() || pdo.index == pdo_index)) names.entry = entry->name;
      if (pdo.index == pdo_index) names.pdo = pdo.name;
    }
  }
  if (!names.entry.empty()) return names;
  for (const auto& known : description.objects) {
    if (known.index != object.index) continue;
    for (const auto& entry : known.entries) {
      if (entry.subindex == object.subindex) names.entry = entry.name;
    }
  }
  if (names.entry.empty()) names.entry = motion::cia402::object_name(object.index, object.subindex);
  return names;
}

/// Normalizes a name for comparison: lower case, one underscore for any characters other than letters and digits.
std::string plain(std::string_view name) {
  std::string text;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (letter || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80) {
      text += letter && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    } else if (!text.empty() && text.back() != '_') {
      text += '_';
    }
  }
  if (text.ends_with('_')) text.pop_back();
  return text;
}

bool is_called(const ProcessVariable& variable, std::string_view object) {
  const auto wanted = plain(object);
  if (wanted.empty() || variable.name.empty()) return false;
  return wanted == plain(variable.name) || wanted == plain(variable.pdo_name + "/" + variable.name);
}

std::optional<unsigned> number(std::string_view text, int base) {
  unsigned value = 0;
  const auto end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value, base);
  if (text.empty() || error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

struct ObjectAddress {
  unsigned index = 0;
  unsigned subindex = 0;
};

/// Parses "0x6041", "6041h", "6041:02".
std::optional<ObjectAddress> address(std::string_view text) {
  const auto colon = text.find(':');
  auto index = text.substr(0, colon);
  if (index.starts_with("0x") || index.starts_with("0X")) index.remove_prefix(2);
  if (index.ends_with('h')) index.remove_suffix(1);
  const auto high = index.size() == 4 ? number(index, 16) : std::nullopt;
  if (!high) return std::nullopt;
  if (colon == std::string_view::npos) return ObjectAddress{*high, 0};
  const auto low = number(text.substr(colon + 1), 16);
  if (!low || *low > 0xFF) return std::nullopt;
  return ObjectAddress{*high, *low};
}

/// The name, preceded by that of its PDO when others in the list have the same name.
std::string full_text(const ProcessVariable& variable, const std::vector<const ProcessVariable*>& list) {
  const auto namesakes = std::count_if(list.begin(), list.end(), [&](const ProcessVariable* other) {
    return other->slave == variable.slave && other->name == variable.name;
  });
  if (namesakes < 2 || variable.name.empty() || variable.pdo_name.empty()) return variable.text();
  auto full = variable;
  full.name = variable.pdo_name + "/" + variable.name;
  return full.text();
}

std::vector<std::string> texts(const std::vector<const ProcessVariable*>& variables) {
  std::vector<std::string> all;
  for (const auto* variable : variables) all.push_back(full_text(*variable, variables));
  return all;
}

std::string listing(const std::vector<std::string>& names) {
  constexpr std::size_t kMaxListedNames = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxListedNames); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMaxListedNames) text += fmt::format(" and {} more", names.size() - kMaxListedNames);
  return text;
}

/// Visitor that makes the message.
struct VariableSentence {
  std::string operator()(const variable_faults::NotThere& facts) const {
    if (!facts.of_slave.empty()) {
      return fmt::format("there is no process variable '{}'; the slave has {}", facts.name, listing(facts.of_slave));
    }
    return fmt::format("there is no process variable '{}'; expected slave.object, for example {}", facts.name,
                       facts.example.value_or("x.6041h:00, but no process data are mapped"));
  }
  std::string operator()(const variable_faults::Ambiguous& facts) const {
    return fmt::format("'{}' is ambiguous: it may be {}", facts.name, listing(facts.candidates));
  }
  std::string operator()(const variable_faults::NameTaken& facts) const {
    return fmt::format("'{}' is already the name of {}", facts.alias, facts.owner);
  }
  std::string operator()(const variable_faults::Unfit& facts) const {
    return fmt::format("{} has {} bits from bit {} of a byte on; the handle is for {} bits{}", facts.variable.text(),
                       facts.variable.bits, facts.variable.bit_offset % 8, facts.wanted_bits,
                       facts.wanted_bits == 1 ? "" : " on a byte border");
  }
  std::string operator()(const variable_faults::NoSource& facts) const {
    return fmt::format("{} cannot be the source of a copy: it is an output", facts.variable.text());
  }
  std::string operator()(const variable_faults::NoTarget& facts) const {
    return fmt::format("{} cannot be the target of a copy: it is an input", facts.variable.text());
  }
  std::string operator()(const variable_faults::SizesDiffer& facts) const {
    return fmt::format("{} has {} bits and {} has {}: they cannot be copied", facts.from.text(), facts.from.bits,
                       facts.to.text(), facts.to.bits);
  }
};

}  // namespace

std::string describe(const VariableError& error) {
  return std::visit(VariableSentence{}, error.facts);
}

std::string ProcessVariable::text() const {
  const auto who = slave_name.empty() ? std::to_string(slave) : slave_name;
  const auto what = name.empty() ? std::string() : fmt::format(" ({})", name);
  return fmt::format("{}.{:04X}h:{:02X}{}", who, index, subindex, what);
}

ProcessVariables::ProcessVariables(std::span<const ConfiguredSlave> slaves, const ProcessImage& image) {
  for (const auto& slave : slaves) {
    add(slave, image, true);
    add(slave, image, false);
  }
}

void ProcessVariables::add(const ConfiguredSlave& slave, const ProcessImage& image, bool output) {
  const auto demand = make_demand(slave);
  if (!demand) return;
  const auto position = slave.info.ref.position;
  const auto& place = image.places()[position];
  const auto exchanged = exchanged_pdos(slave);
  const auto& pdos = output ? exchanged.outputs : exchanged.inputs;
  const auto first =
      find_sync_manager(slave.info, output ? esi::SyncManager::Use::kOutputs : esi::SyncManager::Use::kInputs);
  std::size_t channel_offset = output ? place.output_offset : place.input_offset;
  for (const auto& channel : demand->channels) {
    if (channel.output != output) continue;
    std::size_t bit = 8 * channel_offset;
    for (const auto& pdo : pdos) {
      if (pdo.sync_manager.value_or(first.value_or(0)) != channel.sync_manager) continue;
      for (const auto& object : pdo.objects) {
        if (object.index != 0) {
          auto names = names_of(slave.info.description, pdo.index, object);
          variables_.push_back({slave.plan.name,
                                position,
                                std::move(names.entry),
                                std::move(names.pdo),
                                {},
                                object.index,
                                object.subindex,
                                output,
                                bit,
                                object.bits});
        }
        bit += object.bits;
      }
    }
    channel_offset += channel.bytes;
  }
}

ProcessVariables::Found<ProcessVariable> ProcessVariables::find(std::string_view name) const {
  return find_number(name).map([this](std::size_t number) { return variables_[number]; });
}

ProcessVariables::Found<std::size_t> ProcessVariables::find_number(std::string_view name) const {
  std::vector<const ProcessVariable*> of_slave;
  std::vector<const ProcessVariable*> matches;
  for (const auto& variable : variables_) {
    // Names may contain dots: the slave's name determines where it ends.
    for (const auto& who : {variable.slave_name, std::to_string(variable.slave)}) {
      if (who.empty() || name.size() <= who.size() || !name.starts_with(who) || name[who.size()] != '.') continue;
      of_slave.push_back(&variable);
      const auto object = name.substr(who.size() + 1);
      if (!variable.alias.empty() && plain(object) == plain(variable.alias)) {
        return static_cast<std::size_t>(&variable - variables_.data());
      }
      const auto at = address(object);
      const bool same_address = at && at->index == variable.index && at->subindex == variable.subindex;
      if (same_address || is_called(variable, object)) matches.push_back(&variable);
      break;
    }
  }
  if (matches.size() == 1) return static_cast<std::size_t>(matches.front() - variables_.data());
  if (matches.size() > 1) {
    return tl::unexpected(VariableError{variable_faults::Ambiguous{std::string(name), texts(matches)}});
  }
  variable_faults::NotThere fault{std::string(name), texts(of_slave)};
  if (!variables_.empty()) fault.example = variables_[0].text();
  return tl::unexpected(VariableError{std::move(fault)});
}

std::string ProcessVariables::full_name(const ProcessVariable& variable) const {
  const auto who = variable.slave_name.empty() ? std::to_string(variable.slave) : variable.slave_name;
  if (!variable.alias.empty()) return fmt::format("{}.{}", who, variable.alias);
  if (variable.name.empty()) return fmt::format("{}.{:04X}:{:02X}", who, variable.index, variable.subindex);
  const auto namesakes = std::count_if(variables_.begin(), variables_.end(), [&](const ProcessVariable& other) {
    return other.slave == variable.slave && plain(other.name) == plain(variable.name);
  });
  if (namesakes < 2 || variable.pdo_name.empty()) return fmt::format("{}.{}", who, variable.name);
  return fmt::format("{}.{}/{}", who, variable.pdo_name, variable.name);
}

ProcessVariables::Found<void> ProcessVariables::rename(std::string_view name, std::string_view alias) {
  const auto number = find_number(name);
  if (!number) return tl::unexpected(number.error());
  auto& variable = variables_[*number];
  for (const auto& other : variables_) {
    if (other.slave != variable.slave || plain(other.alias) != plain(alias)) continue;
    return tl::unexpected(VariableError{variable_faults::NameTaken{std::string(alias), other.text()}});
  }
  variable.alias = alias;
  return {};
}

tl::unexpected<VariableError> ProcessVariables::unfit(ProcessVariable variable, std::size_t wanted_bits) {
  return tl::unexpected(VariableError{variable_faults::Unfit{std::move(variable), wanted_bits}});
}

ProcessVariables::Found<motion::PdoBits> ProcessVariables::bits(std::string_view name) const {
  auto variable = find(name);
  if (!variable) return tl::unexpected(variable.error());
  if (variable->bits == 0 || variable->bits > motion::PdoBits::kMaxBits) {
    return unfit(std::move(*variable), motion::PdoBits::kMaxBits);
  }
  return motion::PdoBits(variable->bit_offset, variable->bits);
}

ProcessVariables::Found<motion::ProcessDataCopy> ProcessVariables::copy(std::string_view from,
                                                                        std::string_view to) const {
  auto source = find(from);
  if (!source) return tl::unexpected(source.error());
  auto target = find(to);
  if (!target) return tl::unexpected(target.error());
  if (source->output) return tl::unexpected(VariableError{variable_faults::NoSource{std::move(*source)}});
  if (!target->output) return tl::unexpected(VariableError{variable_faults::NoTarget{std::move(*target)}});
  if (source->bits != target->bits) {
    return tl::unexpected(VariableError{variable_faults::SizesDiffer{std::move(*source), std::move(*target)}});
  }
  return motion::ProcessDataCopy{source->slave, source->bit_offset, target->bit_offset, source->bits};
}

}  // namespace driveline::ecat_master
