#include "line/can_console.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "console.hpp"
#include "driveline/runtime/config/can_fault_text.hpp"
#include "driveline/runtime/config/fault_text.hpp"
#include "text/signal_text.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kCanCommands =
    "Commands: FAULT starts a fault; heal FAULT ends it, its location is sufficient; heal all; list: active faults; "
    "input SLAVE: its inputs and outputs; input SLAVE INPUT=VALUE ... sets inputs; states; help; quit.\n";

std::string_view without_blanks(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// All inputs and outputs with their values.
std::string levels_of(const slaves::DeviceSignals& signals) {
  using Direction = slaves::SignalId::Direction;
  std::string text;
  for (const Direction direction : {Direction::kInput, Direction::kOutput}) {
    for (std::size_t i = 0; i < signals.signal_count(direction); ++i) {
      text +=
          fmt::format("{}{} {} = {}", text.empty() ? "" : "\n", direction == Direction::kInput ? "input " : "output",
                      signals.signal_name({direction, i}), signals.signal({direction, i}));
    }
  }
  return text.empty() ? "no inputs and no outputs" : text;
}

}  // namespace

std::string CanConsole::execute(std::string_view command) {
  constexpr std::string_view kFault = "fault ";
  command = without_blanks(command);
  if (command.starts_with(kFault)) command = without_blanks(command.substr(kFault.size()));
  if (command.empty()) return {};
  if (command == "help") return std::string(kCanCommands) + runtime::can_fault_help();
  if (command == "list") return list();
  if (command == "states") return states();
  if (command == "quit") {
    ended_ = true;
    return "ending";
  }
  if (command == "input" || command.starts_with("input ")) return input(without_blanks(command.substr(5)));
  auto answer = order(command);
  tell_events();
  return answer;
}

std::string CanConsole::order(std::string_view command) {
  constexpr std::string_view kHeal = "heal ";
  auto& faults = line_.faults();
  const auto now = line_.bus().now();
  if (command == "heal all") {
    faults.heal_all(now);
    return "done";
  }
  const bool heals = command.starts_with(kHeal);
  if (heals) command = without_blanks(command.substr(kHeal.size()));
  const auto fault = runtime::parse_can_fault(command, line_.names(), !heals);
  if (!fault) return fmt::format("error: {}; help lists all", fault.error().reason);
  if (heals) return faults.heal(*fault, now) ? "done" : "error: this fault is not active";
  if (faults.begin(*fault, now)) return "done";
  return fmt::format("error: not possible; at most {} faults can be active", slaves::can::BusFaults::kMaxActive);
}

std::string CanConsole::list() {
  std::string text;
  for (const auto& fault : line_.faults().active()) {
    text.append(text.empty() ? "" : "\n").append(runtime::can_fault_text(fault, line_.names()));
  }
  return text.empty() ? "no faults" : text;
}

/// `words`: "SLAVE" or "SLAVE INPUT=VALUE ...".
std::string CanConsole::input(std::string_view words) {
  const auto end = std::min(words.find(' '), words.size());
  const auto slave = runtime::parse_slave(words.substr(0, end), line_.names());
  if (!slave) return fmt::format("error: {}", slave.error().reason);
  auto* signals = line_.device(*slave).signals();
  if (signals == nullptr) return fmt::format("error: {} has no inputs", line_.names()[*slave]);
  const auto settings = parse_signal_settings(words.substr(end), *signals);
  if (!settings) return fmt::format("error: {}", settings.error());
  if (settings->empty()) return levels_of(*signals);
  for (const auto& setting : *settings) signals->set_signal(setting.input, setting.value);
  return "done";
}

void CanConsole::tell_events() {
  while (const auto event = line_.faults().take_event()) {
    progress("fault {}: {}", event->begins ? "begins" : "ends", runtime::can_fault_text(event->fault, line_.names()));
  }
}

std::string_view CanConsole::state_of(std::size_t place) {
  const auto& controller = line_.bus().controller(place);
  if (!controller.powered()) return "OFF";
  // Such a node takes no part in the bus, whatever its NMT state.
  if (controller.errors().state() == slaves::can::ErrorState::kBusOff) return "BUS OFF";
  return line_.device(place).state();
}

std::string CanConsole::states() {
  std::map<std::string, std::string> names_by_state;
  for (std::size_t i = 0; i < line_.size(); ++i) {
    names_by_state[std::string(state_of(i))].append(" ").append(line_.names()[i]);
  }
  std::string text;
  for (const auto& [state, names] : names_by_state) {
    text += fmt::format("{}{}:{}", text.empty() ? "" : "; ", state, names);
  }
  for (const auto& fault : line_.faults().active()) {
    text += fmt::format("; fault: {}", runtime::can_fault_text(fault, line_.names()));
  }
  return text;
}

}  // namespace driveline::cli
