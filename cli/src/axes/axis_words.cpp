#include "axes/axis_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "axes/quantity.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/runtime/config/finite_number.hpp"
#include "driveline/runtime/toml/suggestion.hpp"

namespace driveline::cli {
namespace {

using motion::AxisCommand;
using motion::AxisConfig;
using motion::AxisRequest;
using motion::BufferMode;
using motion::MoveDirection;
using motion::ProbeTrigger;

/// A verb: the word after the name of an axis.
struct Verb {
  std::string_view name;
  AxisCommand command;
  bool on = true;                 ///< kPower: enable or disable
  std::string_view operand = "";  ///< description of the operand that must follow; empty: none
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
    Verb{"halt-superimposed", AxisCommand::kHaltSuperimposed},
    Verb{"position", AxisCommand::kSetPosition, true, "a position"},
    Verb{"override", AxisCommand::kSetOverride, true, "a factor such as 50%"},
    Verb{"mode", AxisCommand::kSetMode, true, "csp, csv, cst or ip"},
    Verb{"probe", AxisCommand::kTouchProbe},
    Verb{"abort-probe", AxisCommand::kAbortTrigger},
    Verb{"home-probe", AxisCommand::kHomeByProbe, true, "a distance, with the sign of its direction"},
    Verb{"drive-move", AxisCommand::kDriveMoveAbsolute, true, "a position, or by=DISTANCE"},
    Verb{"drive-jog", AxisCommand::kDriveMoveVelocity, true, "a velocity"},
    Verb{"drive-run", AxisCommand::kDriveRun, true, "a velocity"},
};

/// All words that may precede an equals sign, for hints.
constexpr std::array<std::string_view, 12> kOptions{"velocity", "acceleration", "deceleration", "jerk", "buffer", "by",
                                                    "add",      "superimpose",  "direction",    "from", "to",     "at"};

constexpr std::array kBufferModes = {BufferMode::kAborting,     BufferMode::kBuffered,
                                     BufferMode::kBlendingLow,  BufferMode::kBlendingPrevious,
                                     BufferMode::kBlendingNext, BufferMode::kBlendingHigh};
constexpr std::array kDirections = {MoveDirection::kShortest, MoveDirection::kPositive, MoveDirection::kNegative};
/// Buffer modes of moves by the drive, which stops at each of its targets.
constexpr std::array kDriveBufferModes = {BufferMode::kAborting, BufferMode::kBuffered};

std::string hint(std::string_view word, std::span<const std::string_view> known) {
  const auto meant = runtime::closest(word, known);
  return meant.empty() ? std::string{} : fmt::format("; did you mean {}?", meant);
}

/// Whether the master generates the setpoints of this motion.
bool moves(AxisCommand command) {
  return command == AxisCommand::kMoveAbsolute || command == AxisCommand::kMoveVelocity ||
         command == AxisCommand::kTorque || command == AxisCommand::kHomeByProbe;
}

/// Whether the drive follows its own ramps, which are set in velocity mode.
bool ramps_by_drive(AxisCommand command) {
  return command == AxisCommand::kDriveMoveAbsolute || command == AxisCommand::kDriveMoveVelocity;
}

bool probes(AxisCommand command) {
  return command == AxisCommand::kTouchProbe || command == AxisCommand::kHomeByProbe;
}

/// Parses the event of a touch probe: "1 rising", in any order and with either word left out, or "zero".
class TriggerReader {
 public:
  /// False: the word does not describe an event, or is the second one of its kind.
  [[nodiscard]] bool read(std::string_view word) {
    if (word == "1" || word == "2" || word == "zero") return take(input_, word);
    return (word == "rising" || word == "falling") && take(edge_, word);
  }
  /// None: an edge was given for the zero pulse, which has none.
  [[nodiscard]] std::optional<ProbeTrigger> trigger() const {
    const bool falling = edge_ == "falling";
    if (input_ == "zero") return edge_.empty() ? std::optional(ProbeTrigger::kZeroPulse) : std::nullopt;
    if (input_ == "2") return falling ? ProbeTrigger::kSecondFalling : ProbeTrigger::kSecondRising;
    return falling ? ProbeTrigger::kFirstFalling : ProbeTrigger::kFirstRising;
  }

 private:
  [[nodiscard]] static bool take(std::string& place, std::string_view word) {
    const bool first = place.empty();
    if (first) place = word;
    return first;
  }

  std::string input_;
  std::string edge_;
};

/// Builds a request word by word.
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
    if (!verb_.operand.empty() && !operand_) {
      return misused(fmt::format("axis {}: {} needs {}", axis_.name, verb_.name, verb_.operand));
    }
    if (window_first_ != window_last_) {
      return misused(fmt::format("axis {}: {}: from= and to= must be given together", axis_.name, verb_.name));
    }
    const auto trigger = trigger_.trigger();
    if (!trigger) {
      return misused(
          fmt::format("axis {}: {}: the zero pulse of an encoder has no edge to choose", axis_.name, verb_.name));
    }
    request_.trigger = *trigger;
    return request_;
  }

 private:
  [[nodiscard]] Outcome<void> read(std::string_view word) {
    const auto equals = word.find('=');
    if (equals != std::string_view::npos) return read_option(word.substr(0, equals), word.substr(equals + 1));
    if (verb_.operand.empty() || operand_) {
      if (probes(verb_.command)) return read_trigger(word);
      return misused(
          fmt::format("axis {}: {}: \"{}\" was not expected{}", axis_.name, verb_.name, word, unit_hint(word)));
    }
    operand_ = true;
    operand_text_ = word;
    return read_operand(word);
  }

  /// A hint for a unit that is a word of its own: "90 deg".
  [[nodiscard]] std::string unit_hint(std::string_view word) const {
    if (!is_unit(axis_, word)) return {};
    const bool joined =
        !operand_text_.empty() && RequestReader(axis_, verb_).read_operand(operand_text_ + std::string(word));
    return joined ? fmt::format("; did you mean {}{}?", operand_text_, word)
                  : "; a unit follows its number without a space";
  }

  [[nodiscard]] Outcome<void> read_trigger(std::string_view word) {
    if (trigger_.read(word)) return {};
    return misused(fmt::format(
        "axis {}: {}: \"{}\" was not expected; expected are 1, 2 or zero (touch probe) and rising or falling (edge)",
        axis_.name, verb_.name, word));
  }

  [[nodiscard]] Outcome<void> read_operand(std::string_view word) {
    switch (verb_.command) {
      case AxisCommand::kMoveAbsolute:
      case AxisCommand::kSetPosition:
      case AxisCommand::kDriveMoveAbsolute:
        return take(request_.target_si, Quantity::kPosition, word, "position");
      case AxisCommand::kHomeByProbe:
        return take(request_.distance_si, Quantity::kPosition, word, "distance");
      case AxisCommand::kMoveVelocity:
      case AxisCommand::kDriveMoveVelocity:
      case AxisCommand::kDriveRun:
        return take(request_.target_si, Quantity::kVelocity, word, "velocity");
      case AxisCommand::kTorque:
        return take(request_.target_si, Quantity::kTorque, word, "torque");
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
    request_.target_si = percent ? *value / kPercent : *value;
    return {};
  }

  [[nodiscard]] Outcome<void> read_mode(std::string_view word) {
    namespace cia402 = motion::cia402;
    auto names = cia402::cyclic_mode_names();
    names.push_back(to_text(cia402::Mode::kInterpolatedPosition));
    const auto mode = word == names.back() ? cia402::Mode::kInterpolatedPosition : cia402::find_cyclic_mode(word);
    if (!mode) {
      return misused(fmt::format("mode \"{}\": csp, csv, cst or ip is expected{}", word, hint(word, names)));
    }
    request_.mode = static_cast<std::int8_t>(*mode);
    return {};
  }

  [[nodiscard]] Outcome<void> read_option(std::string_view name, std::string_view value) {
    const bool torque = verb_.command == AxisCommand::kTorque;
    if (moves(verb_.command)) {
      if (name == "velocity" && verb_.command != AxisCommand::kMoveVelocity)
        return take(request_.velocity_si, Quantity::kVelocity, value, name);
      if (name == "acceleration")
        return take(request_.acceleration_si, torque ? Quantity::kTorqueRate : Quantity::kAcceleration, value, name);
      if (name == "deceleration") return take(request_.deceleration_si, Quantity::kAcceleration, value, name);
      if (name == "jerk") return take(request_.jerk_si, Quantity::kJerk, value, name);
      if (name == "buffer" && verb_.command != AxisCommand::kHomeByProbe) return read_buffer(kBufferModes, value);
    }
    if (ramps_by_drive(verb_.command)) {
      const bool position = verb_.command == AxisCommand::kDriveMoveAbsolute;
      if (name == "velocity" && position) return take(request_.velocity_si, Quantity::kVelocity, value, name);
      if (name == "buffer" && position) return read_buffer(kDriveBufferModes, value);
      if (name == "acceleration") return take(request_.acceleration_si, Quantity::kAcceleration, value, name);
      if (name == "deceleration") return take(request_.deceleration_si, Quantity::kAcceleration, value, name);
    }
    if (verb_.command == AxisCommand::kHomeByProbe && name == "at")
      return take(request_.target_si, Quantity::kPosition, value, name);
    if (verb_.command == AxisCommand::kTouchProbe && (name == "from" || name == "to")) return read_window(name, value);
    if (verb_.command == AxisCommand::kMoveAbsolute && name == "direction")
      return choose(std::span<const MoveDirection>(kDirections), name, value, request_.direction);
    if (verb_.command == AxisCommand::kMoveAbsolute && !operand_) {
      if (name == "by") return relative(AxisCommand::kMoveRelative, value);
      if (name == "add") return relative(AxisCommand::kMoveAdditive, value);
      if (name == "superimpose") return relative(AxisCommand::kMoveSuperimposed, value);
    }
    if (verb_.command == AxisCommand::kDriveMoveAbsolute && !operand_ && name == "by")
      return relative(AxisCommand::kDriveMoveRelative, value);
    const bool known = std::find(kOptions.begin(), kOptions.end(), name) != kOptions.end();
    return misused(fmt::format("axis {}: {}: \"{}=\" does not belong there{}", axis_.name, verb_.name, name,
                               known ? "" : hint(name, kOptions)));
  }

  [[nodiscard]] Outcome<void> read_window(std::string_view name, std::string_view value) {
    const bool first = name == "from";
    (first ? window_first_ : window_last_) = true;
    return take(first ? request_.window_first_si : request_.window_last_si, Quantity::kPosition, value, name);
  }

  [[nodiscard]] Outcome<void> relative(AxisCommand command, std::string_view value) {
    operand_ = true;
    request_.command = command;
    return take(request_.target_si, Quantity::kPosition, value, "distance");
  }

  /// Returns the choice that `value` names.
  template <typename Choice>
  [[nodiscard]] Outcome<void> choose(std::span<const Choice> choices, std::string_view what, std::string_view value,
                                     Choice& to) {
    std::vector<std::string_view> names;
    for (const auto choice : choices) {
      names.push_back(motion::to_text(choice));
      if (names.back() != value) continue;
      to = choice;
      return {};
    }
    return misused(
        fmt::format("{} \"{}\": {} are possible{}", what, value, fmt::join(names, ", "), hint(value, names)));
  }

  [[nodiscard]] Outcome<void> read_buffer(std::span<const BufferMode> modes, std::string_view value) {
    return choose(modes, "buffer", value, request_.buffer);
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
  TriggerReader trigger_;
  std::string operand_text_;
  bool operand_ = false;
  bool window_first_ = false;
  bool window_last_ = false;
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
    return misused(
        fmt::format("axis {}: a request is missing; {} are possible", axis.name, fmt::join(axis_verbs(), ", ")));
  }
  const auto* const verb =
      std::find_if(kVerbs.begin(), kVerbs.end(), [&](const Verb& one) { return one.name == words[0]; });
  if (verb != kVerbs.end()) return RequestReader(axis, *verb).read(words.subspan(1));
  const auto meant = hint(words[0], axis_verbs());
  return misused(fmt::format("axis {}: unknown request \"{}\"{}", axis.name, words[0],
                             meant.empty() ? fmt::format("; {} are possible", fmt::join(axis_verbs(), ", ")) : meant));
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
