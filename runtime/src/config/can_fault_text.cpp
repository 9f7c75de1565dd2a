#include "driveline/runtime/config/can_fault_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "driveline/runtime/config/fault_text.hpp"
#include "driveline/runtime/config/finite_number.hpp"

namespace driveline::runtime {
namespace {

using slaves::can::BusEnd;
using slaves::can::BusFault;
using slaves::can::BusFaultKindRow;
using slaves::can::BusFaultParameter;
using slaves::can::BusFaultParameterRow;
using slaves::can::BusFaultParameters;

constexpr std::uint32_t kHighestIdentifier = 0x1FFF'FFFF;
constexpr double kLongestFaultMs = 86'400'000.0;
constexpr std::array<std::string_view, 3> kEnds{"both", "first", "last"};  ///< in the order of BusEnd

tl::unexpected<Error> wrong(std::string reason) {
  return fail(ErrorKind::kSetting, std::move(reason));
}

bool has_key(const BusFaultKindRow& row, BusFaultParameter parameter) {
  return contains(row.needs, parameter) || contains(row.takes, parameter);
}

std::string keys_of(const BusFaultKindRow& row) {
  std::vector<std::string> keys;
  for (const auto& parameter : slaves::can::kBusFaultParameters) {
    if (contains(row.needs, parameter.parameter)) keys.emplace_back(parameter.key);
  }
  for (const auto& parameter : slaves::can::kBusFaultParameters) {
    if (contains(row.takes, parameter.parameter)) keys.push_back(fmt::format("[{}]", parameter.key));
  }
  return keys.empty() ? "nothing" : fmt::format("{}", fmt::join(keys, ", "));
}

Result<const BusFaultKindRow*> find_kind(std::string_view name) {
  std::vector<std::string_view> names;
  for (const auto& row : slaves::can::kBusFaultKinds) {
    if (row.name == name) return &row;
    names.push_back(row.name);
  }
  return wrong(
      fmt::format("\"{}\" is not a kind of fault of a CAN line; the kinds are {}", name, fmt::join(names, ", ")));
}

template <typename T>
Result<void> take_number(T& target, std::string_view text, std::uint64_t minimum, std::uint64_t maximum) {
  const auto value = whole_number(text);
  if (!value || *value < minimum || *value > maximum) {
    return wrong(fmt::format("is \"{}\", {} to {} is expected", text, minimum, maximum));
  }
  target = static_cast<T>(*value);
  return {};
}

Result<void> take_chance(double& target, std::string_view text) {
  const auto value = finite_number(text);
  if (!value || *value < 0.0 || *value > 1.0) return wrong(fmt::format("is \"{}\", 0 to 1 is expected", text));
  target = *value;
  return {};
}

Result<void> take_end(BusEnd& target, std::string_view text) {
  const auto* found = std::find(kEnds.begin(), kEnds.end(), text);
  if (found == kEnds.end()) return wrong(fmt::format("is \"{}\", both, first or last is expected", text));
  target = static_cast<BusEnd>(found - kEnds.begin());
  return {};
}

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const int letter = (c | 0x20) - 'a';
  return letter >= 0 && letter < 6 ? letter + 10 : -1;
}

Result<void> take_data(BusFault& fault, std::string_view text) {
  auto& frame = fault.frame;
  const bool digits = std::all_of(text.begin(), text.end(), [](char c) { return digit_of(c) >= 0; });
  if (!digits || text.size() % 2 != 0 || text.size() > 2 * frame.data.size()) {
    return wrong(fmt::format("is \"{}\", up to 16 hexadecimal digits, two for each byte, are expected", text));
  }
  frame.length = static_cast<std::uint8_t>(text.size() / 2);
  for (std::size_t i = 0; i < frame.length; ++i) {
    frame.data[i] = static_cast<std::byte>(16 * digit_of(text[2 * i]) + digit_of(text[2 * i + 1]));
  }
  return {};
}

Result<void> take_rate(std::uint32_t& target, std::string_view text) {
  if (auto done = take_number(target, text, 10'000, 1'000'000); !done) return done;
  if (1'000'000'000 % target == 0) return {};
  return wrong(fmt::format("is {}, a rate whose bits are whole nanoseconds is expected", target));
}

/// A fault under construction, parameter by parameter.
class Draft {
 public:
  explicit Draft(const BusFaultKindRow& row) : row_(&row) { fault_.kind = row.kind; }

  /// Sets a parameter from its text. Error: the reason, without the name of the parameter.
  Result<void> set(const BusFaultParameterRow& parameter, std::string_view text, std::span<const std::string> names) {
    if (!has_key(*row_, parameter.parameter)) {
      return wrong(fmt::format("is not a key of \"{}\"; its keys are {}", row_->name, keys_of(*row_)));
    }
    given_ = slaves::can::bus_fault_parameters(BusFaultParameter{given_}, parameter.parameter);
    return take(parameter.parameter, text, names);
  }
  Result<void> set_duration(double ms) {
    if (!row_->lasts) return wrong(fmt::format("is not a key of \"{}\", which does not last", row_->name));
    fault_.duration = std::chrono::nanoseconds{std::llround(ms * 1e6)};
    return {};
  }
  Result<BusFault> finish(bool complete) const {
    for (const auto& parameter : slaves::can::kBusFaultParameters) {
      if (!contains(row_->needs, parameter.parameter) || contains(given_, parameter.parameter)) continue;
      if (!complete && parameter.parameter != BusFaultParameter::kSlave) continue;
      return wrong(fmt::format("\"{}\" needs {}: {}", row_->name, parameter.key, parameter.value));
    }
    if (contains(given_, BusFaultParameter::kMask) && !contains(given_, BusFaultParameter::kIdentifier)) {
      return wrong(fmt::format("\"{}\" has a mask and no id", row_->name));
    }
    BusFault fault = fault_;
    const bool all_bits =
        contains(given_, BusFaultParameter::kIdentifier) && !contains(given_, BusFaultParameter::kMask);
    if (all_bits) fault.mask = kHighestIdentifier;
    return fault;
  }

 private:
  Result<void> take(BusFaultParameter parameter, std::string_view text, std::span<const std::string> names) {
    switch (parameter) {
      case BusFaultParameter::kSlave:
        return parse_slave(text, names).map([this](std::uint16_t slave) { fault_.slave = slave; });
      case BusFaultParameter::kIdentifier:
        return take_number(fault_.identifier, text, 0, kHighestIdentifier);
      case BusFaultParameter::kMask:
        return take_number(fault_.mask, text, 0, kHighestIdentifier);
      case BusFaultParameter::kBit:
        return take_number(fault_.bit, text, 1, 110);
      case BusFaultParameter::kCount:
        return take_number(fault_.count, text, 1, 0xFFFF'FFFE);
      case BusFaultParameter::kChance:
        return take_chance(fault_.chance, text);
      case BusFaultParameter::kSeed:
        return take_number(fault_.seed, text, 0, 0xFFFF'FFFF);
      case BusFaultParameter::kEnd:
        return take_end(fault_.end, text);
      case BusFaultParameter::kData:
        return take_data(fault_, text);
      case BusFaultParameter::kRate:
        return take_rate(fault_.bit_rate, text);
    }
    return {};
  }

  const BusFaultKindRow* row_;
  BusFault fault_;
  BusFaultParameters given_ = 0;
};

Result<void> set_word(Draft& draft, std::string_view word, std::span<const std::string> names) {
  const auto equals = word.find('=');
  if (equals == std::string_view::npos) return wrong(fmt::format("\"{}\": KEY=VALUE is expected", word));
  const auto key = word.substr(0, equals);
  const auto value = word.substr(equals + 1);
  const auto named = [key](Result<void> done) -> Result<void> {
    if (done) return done;
    return wrong(fmt::format("{} {}", key, done.error().reason));
  };
  if (key == "for_ms") {
    const auto ms = finite_number(value);
    if (!ms || *ms < 0.001 || *ms > kLongestFaultMs) {
      return named(wrong(fmt::format("is \"{}\", 0.001 to {} is expected", value, kLongestFaultMs)));
    }
    return named(draft.set_duration(*ms));
  }
  const auto& rows = slaves::can::kBusFaultParameters;
  const auto* row = std::find_if(rows.begin(), rows.end(), [key](const auto& one) { return one.key == key; });
  if (row == rows.end()) return wrong(fmt::format("\"{}\" is no key of a fault; help lists the keys", key));
  return named(draft.set(*row, value, names));
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (;;) {
    const auto begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return words;
    text.remove_prefix(begin);
    const auto end = std::min(text.find_first_of(" \t"), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

/// The value of a parameter as text; empty: it is the default.
std::string value_text(const BusFault& fault, BusFaultParameter parameter, std::span<const std::string> names) {
  switch (parameter) {
    case BusFaultParameter::kSlave:
      if (fault.slave == BusFault::kEverySlave) return {};
      return fault.slave < names.size() ? names[fault.slave] : std::to_string(fault.slave);
    case BusFaultParameter::kIdentifier:
      return fault.mask == 0 && fault.identifier == 0 ? "" : fmt::format("0x{:X}", fault.identifier);
    case BusFaultParameter::kMask:
      return fault.mask == 0 || fault.mask == kHighestIdentifier ? "" : fmt::format("0x{:X}", fault.mask);
    case BusFaultParameter::kBit:
      return fault.bit == BusFault{}.bit ? "" : std::to_string(fault.bit);
    case BusFaultParameter::kCount:
      return fault.count == 0 ? "" : std::to_string(fault.count);
    case BusFaultParameter::kChance:
      return fault.chance >= 1.0 ? "" : fmt::format("{}", fault.chance);
    case BusFaultParameter::kSeed:
      return fault.seed == BusFault{}.seed ? "" : std::to_string(fault.seed);
    case BusFaultParameter::kEnd:
      return fault.end == BusEnd::kBoth ? "" : std::string(kEnds[static_cast<std::size_t>(fault.end)]);
    case BusFaultParameter::kData: {
      std::string digits;
      for (const auto byte : fault.frame.payload()) digits += fmt::format("{:02X}", std::to_integer<unsigned>(byte));
      return digits;
    }
    case BusFaultParameter::kRate:
      return std::to_string(fault.bit_rate);
  }
  return {};
}

}  // namespace

Result<BusFault> parse_can_fault(std::string_view text, std::span<const std::string> names, bool complete) {
  const auto words = words_of(text);
  const auto row = find_kind(words.empty() ? std::string_view{} : words.front());
  if (!row) return tl::unexpected(row.error());
  Draft draft(**row);
  for (const auto word : std::span(words).subspan(1)) {
    if (const auto done = set_word(draft, word, names); !done) return tl::unexpected(done.error());
  }
  return draft.finish(complete);
}

std::string can_fault_text(const BusFault& fault, std::span<const std::string> names) {
  const auto& row = bus_fault_kind_row(fault.kind);
  std::string text(row.name);
  for (const auto& parameter : slaves::can::kBusFaultParameters) {
    if (!has_key(row, parameter.parameter)) continue;
    const auto value = value_text(fault, parameter.parameter, names);
    if (!value.empty()) text += fmt::format(" {}={}", parameter.key, value);
  }
  if (fault.duration.count() > 0) text += fmt::format(" for_ms={}", static_cast<double>(fault.duration.count()) / 1e6);
  return text;
}

std::string can_fault_help() {
  std::string text = "Faults of a CAN line: KIND KEY=VALUE ... [for_ms=TIME]; keys in brackets are optional.\n";
  for (const auto& row : slaves::can::kBusFaultKinds) {
    text += fmt::format("  {:18} {}\n  {:18}   {}\n", row.name, keys_of(row), "", row.text);
  }
  text += "Keys:\n";
  for (const auto& parameter : slaves::can::kBusFaultParameters) {
    text += fmt::format("  {:18} {}: {}\n", parameter.key, parameter.value, parameter.text);
  }
  text += fmt::format("  {:18} {}: {}\n", "for_ms", "0.001 to 86400000",
                      "ends after this time; default: no end; not for bus-off and reset");
  return text;
}

CanFaultPlan read_can_fault(TomlReader reader, std::span<const std::string> names) {
  CanFaultPlan plan;
  plan.at = std::chrono::nanoseconds{std::llround(reader.number_or("at_ms", 0.0, 0.0, kLongestFaultMs) * 1e6)};
  const auto row = find_kind(reader.text("kind"));
  if (!row) reader.fail("kind", row.error().reason);
  Draft draft(**row);
  for (const auto& parameter : slaves::can::kBusFaultParameters) {
    if (!reader.has(parameter.key)) continue;
    const auto done = draft.set(parameter, reader.scalar_text(parameter.key), names);
    if (!done) reader.fail(parameter.key, done.error().reason);
  }
  if (reader.has("for_ms")) {
    const auto done = draft.set_duration(reader.number("for_ms", 0.001, kLongestFaultMs));
    if (!done) reader.fail("for_ms", done.error().reason);
  }
  reader.finish();
  const auto fault = draft.finish(true);
  if (!fault) reader.fail("", fault.error().reason);
  plan.fault = *fault;
  return plan;
}

}  // namespace driveline::runtime
