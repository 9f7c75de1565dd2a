#include "driveline/runtime/config/fault_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "driveline/runtime/config/finite_number.hpp"

namespace driveline::runtime {

using slaves::Fault;
using slaves::FaultParameter;

namespace {

tl::unexpected<Error> problem(std::string reason) {
  return fail(ErrorKind::kSetting, std::move(reason));
}

constexpr double kMaxDurationMs = 86'400'000.0;

template <typename T>
Result<void> set_integer(T& target, std::string_view text, std::uint64_t minimum, std::uint64_t maximum) {
  const auto value = whole_number(text);
  if (!value || *value < minimum || *value > maximum) {
    return problem(fmt::format("is \"{}\", {} to {} is expected", text, minimum, maximum));
  }
  target = static_cast<T>(*value);
  return {};
}

Result<void> set_time(std::chrono::nanoseconds& target, std::string_view text, double unit_ns, double minimum,
                      double maximum) {
  const auto value = finite_number(text);
  if (!value || *value < minimum || *value > maximum) {
    return problem(fmt::format("is \"{}\", {} to {} is expected", text, minimum, maximum));
  }
  target = std::chrono::nanoseconds{std::llround(*value * unit_ns)};
  return {};
}

Result<void> set_slave(std::uint16_t& target, std::string_view text, const FaultPlaces& places) {
  return parse_slave(text, places.slaves).map([&target](std::uint16_t slave) { target = slave; });
}

Result<void> set_state(wire::AlState& target, std::string_view text) {
  for (const auto state : {wire::AlState::kInit, wire::AlState::kPreOp, wire::AlState::kBootstrap,
                           wire::AlState::kSafeOp, wire::AlState::kOp}) {
    if (wire::to_text(state) != text) continue;
    target = state;
    return {};
  }
  return problem(fmt::format("is \"{}\", INIT, PREOP, BOOT, SAFEOP or OP is expected", text));
}

bool takes(const slaves::FaultKindRow& row, FaultParameter parameter) {
  return slaves::contains(row.needs, parameter) || slaves::contains(row.takes, parameter);
}

std::string slave_name(std::size_t position, const FaultPlaces& places) {
  return position < places.slaves.size() ? places.slaves[position] : std::to_string(position);
}

}  // namespace

Result<std::uint16_t> parse_slave(std::string_view text, std::span<const std::string> names) {
  const auto named = std::find(names.begin(), names.end(), text);
  if (named != names.end()) return static_cast<std::uint16_t>(named - names.begin());
  const auto position = whole_number(text);
  if (!position || *position >= names.size()) {
    return problem(fmt::format("there is no slave \"{}\" among the {}", text, names.size()));
  }
  return static_cast<std::uint16_t>(*position);
}

Result<void> FaultDraft::set(const slaves::FaultParameterRow& parameter, std::string_view value,
                             const FaultPlaces& places) {
  if (!takes(row_, parameter.parameter)) {
    return problem(fmt::format("is not a key of \"{}\"; its keys are {}", row_.name, parameters_of(row_)));
  }
  given_ = given_ | parameter.parameter;
  switch (parameter.parameter) {
    case FaultParameter::kSlave:
      return set_slave(fault_.slave, value, places);
    case FaultParameter::kPort:
      return set_integer(fault_.port, value, 0, slaves::kPortCount - 1);
    case FaultParameter::kTo:
      return set_slave(to_, value, places);
    case FaultParameter::kDirection:
      if (value != "out" && value != "back") return problem(fmt::format("is \"{}\", out or back is expected", value));
      fault_.direction = value == "out" ? slaves::FaultDirection::kOut : slaves::FaultDirection::kBack;
      return {};
    case FaultParameter::kCount:
      return set_integer(fault_.count, value, 1, 0xFFFFFFFF);
    case FaultParameter::kChance: {
      const auto chance = finite_number(value);
      if (!chance || *chance < 0.0 || *chance > 1.0)
        return problem(fmt::format("is \"{}\", 0 to 1 is expected", value));
      fault_.chance = *chance;
      return {};
    }
    case FaultParameter::kSeed:
      return set_integer(fault_.seed, value, 0, 0xFFFFFFFF);
    case FaultParameter::kBits:
      return set_integer(fault_.bits, value, 1, 1000);
    case FaultParameter::kTime:
      return set_time(fault_.time, value, 1e3, 1.0, 6e7);
    case FaultParameter::kState:
      return set_state(fault_.state, value);
    case FaultParameter::kCode:
      return set_integer(fault_.code, value, 0, 0xFFFF);
  }
  return {};
}

Result<Fault> FaultDraft::finish(const FaultPlaces& places, bool complete) const {
  for (const auto& parameter : slaves::kFaultParameters) {
    if (!slaves::contains(row_.needs, parameter.parameter) || slaves::contains(given_, parameter.parameter)) continue;
    const bool place = parameter.parameter == FaultParameter::kSlave || parameter.parameter == FaultParameter::kPort;
    if (!complete && !place) continue;
    return problem(fmt::format("\"{}\" needs {}: {}", row_.name, parameter.key, parameter.value));
  }
  return takes(row_, FaultParameter::kPort) ? with_cable(fault_, places) : fault_;
}

Result<Fault> FaultDraft::with_cable(Fault fault, const FaultPlaces& places) const {
  using Kind = slaves::Wiring::End::Kind;
  const bool port = slaves::contains(given_, FaultParameter::kPort);
  if (takes(row_, FaultParameter::kTo)) {
    const bool to = slaves::contains(given_, FaultParameter::kTo);
    if (port == to) return problem(fmt::format("\"{}\" needs either port or to", row_.name));
    for (std::uint8_t n = 0; to && n < slaves::kPortCount; ++n) {
      const auto& end = places.wiring.at({fault.slave, n});
      if (end.kind != Kind::kSlave || end.slave.slave != to_) continue;
      fault.port = n;
      return fault;
    }
    if (to) {
      return problem(fmt::format("there is no cable between \"{}\" and \"{}\"", slave_name(fault.slave, places),
                                 slave_name(to_, places)));
    }
  }
  if (places.wiring.at({fault.slave, fault.port}).kind == Kind::kNothing) {
    return problem(
        fmt::format("no cable is connected to port {} of \"{}\"", fault.port, slave_name(fault.slave, places)));
  }
  return fault;
}

Result<const slaves::FaultKindRow*> find_fault_kind(std::string_view name) {
  std::vector<std::string_view> names;
  for (const auto& row : slaves::kFaultKinds) {
    if (row.name == name) return &row;
    names.push_back(row.name);
  }
  return problem(fmt::format("\"{}\" is not a kind of fault; the kinds are {}", name, fmt::join(names, ", ")));
}

std::string parameters_of(const slaves::FaultKindRow& row) {
  std::vector<std::string> keys;
  for (const auto& parameter : slaves::kFaultParameters) {
    if (slaves::contains(row.needs, parameter.parameter)) keys.emplace_back(parameter.key);
  }
  for (const auto& parameter : slaves::kFaultParameters) {
    if (slaves::contains(row.takes, parameter.parameter)) keys.push_back(fmt::format("[{}]", parameter.key));
  }
  return keys.empty() ? "nothing" : fmt::format("{}", fmt::join(keys, ", "));
}

Result<Fault> parse_fault(std::string_view text, const FaultPlaces& places, bool complete) {
  std::vector<std::string_view> words;
  while (!text.empty()) {
    const auto begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) break;
    text.remove_prefix(begin);
    const auto end = std::min(text.find_first_of(" \t"), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  const auto row = find_fault_kind(words.empty() ? std::string_view{} : words.front());
  if (!row) return problem(row.error().reason);
  FaultDraft draft(**row);
  for (const auto word : std::span(words).subspan(1)) {
    const auto equals = word.find('=');
    const auto key = word.substr(0, equals);
    if (equals == std::string_view::npos) return problem(fmt::format("\"{}\": KEY=VALUE is expected", word));
    const auto value = word.substr(equals + 1);
    if (key == "for_ms") {
      std::chrono::nanoseconds duration{};
      if (const auto done = set_time(duration, value, 1e6, 0.001, kMaxDurationMs); !done) {
        return problem(fmt::format("for_ms {}", done.error().reason));
      }
      draft.set_duration(duration);
      continue;
    }
    const auto parameter = std::find_if(slaves::kFaultParameters.begin(), slaves::kFaultParameters.end(),
                                        [key](const auto& p) { return p.key == key; });
    if (parameter == slaves::kFaultParameters.end()) {
      return problem(fmt::format("\"{}\" is unknown; the keys of \"{}\" are {}, [for_ms]", key, (*row)->name,
                                 parameters_of(**row)));
    }
    if (const auto done = draft.set(*parameter, value, places); !done) {
      return problem(fmt::format("{} {}", key, done.error().reason));
    }
  }
  return draft.finish(places, complete);
}

std::string fault_text(const Fault& fault, const FaultPlaces& places) {
  const auto& row = slaves::fault_kind_row(fault.kind);
  const Fault defaults;
  std::string text(row.name);
  const auto add = [&](FaultParameter parameter, bool wanted, const std::string& value) {
    if (!takes(row, parameter) || !wanted) return;
    const auto entry = std::find_if(slaves::kFaultParameters.begin(), slaves::kFaultParameters.end(),
                                    [parameter](const auto& p) { return p.parameter == parameter; });
    text += fmt::format(" {}={}", entry->key, value);
  };
  add(FaultParameter::kSlave, true, slave_name(fault.slave, places));
  add(FaultParameter::kPort, true, std::to_string(fault.port));
  add(FaultParameter::kDirection, fault.direction != defaults.direction, "back");
  add(FaultParameter::kCount, fault.count != 0, std::to_string(fault.count));
  add(FaultParameter::kChance, fault.chance != defaults.chance, fmt::format("{}", fault.chance));
  add(FaultParameter::kSeed, fault.seed != defaults.seed, std::to_string(fault.seed));
  add(FaultParameter::kBits, fault.bits != defaults.bits, std::to_string(fault.bits));
  add(FaultParameter::kTime, true, fmt::format("{}", static_cast<double>(fault.time.count()) / 1e3));
  add(FaultParameter::kState, true, std::string(wire::to_text(fault.state)));
  add(FaultParameter::kCode, true, fmt::format("0x{:04X}", static_cast<unsigned>(fault.code)));
  if (fault.duration.count() > 0) text += fmt::format(" for_ms={}", static_cast<double>(fault.duration.count()) / 1e6);
  return text;
}

std::string fault_help() {
  std::string text = "Faults: KIND KEY=VALUE ... [for_ms=TIME]; keys in brackets are optional.\n";
  for (const auto& row : slaves::kFaultKinds) {
    text += fmt::format("  {:18} {}\n  {:18}   {}\n", row.name, parameters_of(row), "", row.text);
  }
  text += "Keys:\n";
  for (const auto& parameter : slaves::kFaultParameters) {
    text += fmt::format("  {:18} {}: {}\n", parameter.key, parameter.value, parameter.text);
  }
  text += fmt::format("  {:18} {}: {}\n", "for_ms", "0.001 to 86400000", "ends after this time; default: no end");
  return text;
}

}  // namespace driveline::runtime
