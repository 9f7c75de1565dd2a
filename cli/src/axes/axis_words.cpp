#include "axes/axis_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>

#include "axes/quantity.hpp"
#include "driveline/ecat_master/cia402/cyclic_mode.hpp"
#include "driveline/runtime/config/finite_number.hpp"
#include "driveline/runtime/toml/suggestion.hpp"

namespace driveline::cli {
namespace {

using ecat_master::AxisCommand;
using ecat_master::AxisConfig;
using ecat_master::AxisRequest;
using ecat_master::BufferMode;

/// A word behind the name of an axis.
struct Verb {
  std::string_view name;
  AxisCommand command;
  bool on = true;                 ///< kPower
  std::string_view operand = "";  ///< what is expected behind it
};

constexpr std::array kVerbs = {
    Verb{"enable", AxisCommand::kPower},
    Verb{"disable", AxisCommand::kPower, false},
    Verb{"reset", AxisCommand::kReset},
    Verb{"home", AxisCommand::kHome},
    Verb{"move", AxisCommand::kMoveAbsolute, true, "a position, or by=DISTANCE"},
    Verb{"jog", AxisCommand::kMoveVelocity, true, "a velocity"},
    Verb{"torque", AxisCommand::kTorque, true, "a torque"},
    Verb{"stop", AxisCommand::kStop},
    Verb{"release-stop", AxisCommand::kReleaseStop},
    Verb{"halt", AxisCommand::kHalt},
    Verb{"position", AxisCommand::kSetPosition, true, "a position"},
    Verb{"override", AxisCommand::kSetOverride, true, "a factor such as 50%"},
    Verb{"mode", AxisCommand::kSetMode, true, "csp, csv or cst"},
};

constexpr std::array kBufferModes = {BufferMode::kAborting,     BufferMode::kBuffered,
                                     BufferMode::kBlendingLow,  BufferMode::kBlendingPrevious,
                                     BufferMode::kBlendingNext, BufferMode::kBlendingHigh};

std::string hint(std::string_view word, std::span<const std::string_view> known) {
  const auto meant = runtime::closest(word, known);
  return meant.empty() ? std::string{} : fmt::format("; did you mean {}?", meant);
}

bool moves(AxisCommand command) {
  return command == AxisCommand::kMoveAbsolute || command == AxisCommand::kMoveVelocity ||
         command == AxisCommand::kTorque;
}

/// Puts a request together, word by word.
class RequestReader {
 public:
  RequestReader(const AxisConfig& axis, const Verb& verb) : axis_(axis), verb_(verb) {
    request_.command = verb.command;
    request_.on = verb.on;
  }

  [[nodiscard]] Outcome<AxisRequest> read(std::span<const std::string> words) {
    for (const auto& word : words) {
      if (auto read = this->read(word); !read) return tl::unexpected(read.error());
    }
    if (verb_.operand.empty() || operand_) return request_;
    return misused(fmt::format("axis {}: {} needs {}", axis_.name, verb_.name, verb_.operand));
  }

 private:
  [[nodiscard]] Outcome<void> read(std::string_view word) {
    const auto equals = word.find('=');
    if (equals != std::string_view::npos) return read_option(word.substr(0, equals), word.substr(equals + 1));
    if (verb_.operand.empty() || operand_) {
      return misused(fmt::format("axis {}: {}: \"{}\" was not expected", axis_.name, verb_.name, word));
    }
    operand_ = true;
    return read_operand(word);
  }

  [[nodiscard]] Outcome<void> read_operand(std::string_view word) {
    switch (verb_.command) {
      case AxisCommand::kMoveAbsolute:
      case AxisCommand::kSetPosition:
        return take(request_.target, Quantity::kPosition, word, "position");
      case AxisCommand::kMoveVelocity:
        return take(request_.target, Quantity::kVelocity, word, "velocity");
      case AxisCommand::kTorque:
        return take(request_.target, Quantity::kTorque, word, "torque");
      case AxisCommand::kSetOverride:
        return read_override(word);
      default:
        return read_mode(word);
    }
  }

  [[nodiscard]] Outcome<void> read_override(std::string_view word) {
    constexpr double kPercent = 100.0;
    const bool percent = word.ends_with('%');
    const auto value = runtime::finite_number(word.substr(0, word.size() - (percent ? 1 : 0)));
    if (!value) return misused(fmt::format("override \"{}\": a factor such as 50% or 0.5 is expected", word));
    request_.target = percent ? *value / kPercent : *value;
    return {};
  }

  [[nodiscard]] Outcome<void> read_mode(std::string_view word) {
    namespace cia402 = ecat_master::cia402;
    const auto mode = cia402::find_cyclic_mode(word);
    if (!mode) {
      return misused(
          fmt::format("mode \"{}\": csp, csv or cst is expected{}", word, hint(word, cia402::cyclic_mode_names())));
    }
    request_.mode = static_cast<std::int8_t>(*mode);
    return {};
  }

  [[nodiscard]] Outcome<void> read_option(std::string_view name, std::string_view value) {
    const bool torque = verb_.command == AxisCommand::kTorque;
    if (moves(verb_.command)) {
      if (name == "velocity" && verb_.command != AxisCommand::kMoveVelocity)
        return take(request_.velocity, Quantity::kVelocity, value, name);
      if (name == "acceleration")
        return take(request_.acceleration, torque ? Quantity::kTorqueRate : Quantity::kAcceleration, value, name);
      if (name == "deceleration") return take(request_.deceleration, Quantity::kAcceleration, value, name);
      if (name == "jerk") return take(request_.jerk, Quantity::kJerk, value, name);
      if (name == "buffer") return read_buffer(value);
    }
    if (verb_.command == AxisCommand::kMoveAbsolute && !operand_) {
      if (name == "by") return relative(AxisCommand::kMoveRelative, value);
      if (name == "add") return relative(AxisCommand::kMoveAdditive, value);
      if (name == "superimpose") return relative(AxisCommand::kMoveSuperimposed, value);
    }
    constexpr std::array<std::string_view, 8> known{"velocity", "acceleration", "deceleration", "jerk",
                                                    "buffer",   "by",           "add",          "superimpose"};
    return misused(fmt::format("axis {}: {}: \"{}=\" does not belong there{}", axis_.name, verb_.name, name,
                               std::find(known.begin(), known.end(), name) == known.end() ? hint(name, known) : ""));
  }

  [[nodiscard]] Outcome<void> relative(AxisCommand command, std::string_view value) {
    operand_ = true;
    request_.command = command;
    return take(request_.target, Quantity::kPosition, value, "distance");
  }

  [[nodiscard]] Outcome<void> read_buffer(std::string_view value) {
    std::vector<std::string_view> names;
    for (const auto mode : kBufferModes) {
      names.push_back(ecat_master::to_text(mode));
      if (names.back() != value) continue;
      request_.buffer = mode;
      return {};
    }
    return misused(fmt::format("buffer \"{}\": {} are possible{}", value, fmt::join(names, ", "), hint(value, names)));
  }

  [[nodiscard]] Outcome<void> take(double& target, Quantity quantity, std::string_view text, std::string_view what) {
    const auto value = parse_quantity(axis_, quantity, text, what);
    if (!value) return tl::unexpected(value.error());
    target = *value;
    return {};
  }

  const AxisConfig& axis_;
  const Verb& verb_;
  AxisRequest request_;
  bool operand_ = false;
};

}  // namespace

std::vector<std::string> split_words(std::string_view line) {
  std::vector<std::string> words;
  bool quoted = false;
  bool within = false;
  for (const char c : line) {
    const bool space = c == ' ' || c == '\t' || c == '\r';
    if (c == '"') {
      quoted = !quoted;
      if (!within) words.emplace_back();
      within = true;
    } else if (space && !quoted) {
      within = false;
    } else {
      if (!within) words.emplace_back();
      within = true;
      words.back() += c;
    }
  }
  return words;
}

std::string quoted_word(std::string_view word) {
  const bool plain = !word.empty() && word.find_first_of(" \t") == std::string_view::npos;
  return plain ? std::string(word) : fmt::format("\"{}\"", word);
}

std::span<const std::string_view> axis_verbs() {
  static const auto kNames = [] {
    std::vector<std::string_view> names;
    for (const auto& verb : kVerbs) names.push_back(verb.name);
    return names;
  }();
  return kNames;
}

Outcome<AxisRequest> parse_axis_request(const AxisConfig& axis, std::span<const std::string> words) {
  if (words.empty()) {
    return misused(fmt::format("axis {}: what is it to do? {} are possible", axis.name, fmt::join(axis_verbs(), ", ")));
  }
  const auto* const verb =
      std::find_if(kVerbs.begin(), kVerbs.end(), [&](const Verb& one) { return one.name == words[0]; });
  if (verb != kVerbs.end()) return RequestReader(axis, *verb).read(words.subspan(1));
  const auto meant = hint(words[0], axis_verbs());
  return misused(fmt::format("axis {}: it cannot \"{}\"{}", axis.name, words[0],
                             meant.empty() ? fmt::format("; {} are possible", fmt::join(axis_verbs(), ", ")) : meant));
}

Outcome<std::chrono::nanoseconds> parse_time(std::string_view text, std::string_view what) {
  constexpr double kLongestSeconds = 1e7;
  const auto number = leading_number(text);
  std::optional<double> seconds;
  if (number && (number->rest.empty() || number->rest == "s")) seconds = number->value;
  if (number && number->rest == "ms") seconds = number->value / 1e3;
  if (!seconds || *seconds < 0.0 || *seconds > kLongestSeconds) {
    return misused(fmt::format("{} \"{}\": a time such as 2s or 500ms is expected", what, text));
  }
  return std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(*seconds));
}

Outcome<std::vector<std::size_t>> find_axes(std::span<const AxisConfig> axes, std::string_view name) {
  std::vector<std::size_t> found;
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    names.emplace_back(axes[i].name);
    if (axes[i].name == name) return std::vector{i};
    found.push_back(i);
  }
  if (axes.empty()) return misused("the line has no axes");
  if (name == "all") return found;
  return misused(
      fmt::format("there is no axis \"{}\"; the line has {}{}", name, fmt::join(names, ", "), hint(name, names)));
}

}  // namespace driveline::cli
