#include "line/line_console.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <thread>

#include "console.hpp"
#include "text/signal_text.hpp"

namespace driveline::cli {

using std::chrono::milliseconds;

namespace {

constexpr int kAnswerTries = 1000;

std::string state_text(const runtime::StateChange& change) {
  if (change.status.state == wire::AlState::kNone) return "OFF";
  if (!change.status.error) return std::string(wire::to_text(change.status.state));
  return fmt::format("{} + ERROR 0x{:04X}", wire::to_text(change.status.state), static_cast<unsigned>(change.code));
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

constexpr std::string_view kNoAnswer = "error: the line does not answer";
constexpr std::string_view kCommands =
    "Commands: FAULT starts a fault; heal FAULT ends it, its location is sufficient; heal all; list: active faults; "
    "input SLAVE: its inputs and outputs; input SLAVE INPUT=VALUE ... sets inputs; states; help; quit.\n";

}  // namespace

LineConsole::LineConsole(runtime::LineOrders& orders, slaves::SimulatedLine& line, std::vector<std::string> names,
                         Events events)
    : orders_(orders), line_(line), names_(std::move(names)), latest_(names_.size()), events_(events) {
  for (std::size_t i = 0; i < latest_.size(); ++i) latest_[i].slave = static_cast<std::uint16_t>(i);
}

std::string LineConsole::execute(std::string_view command) {
  constexpr std::string_view kFault = "fault ";
  command = trimmed(command);
  if (command.starts_with(kFault)) command = trimmed(command.substr(kFault.size()));
  if (command.empty()) return {};
  if (command == "help") return std::string(kCommands) + runtime::fault_help();
  if (command == "list") return list();
  if (command == "states") return current_states();
  if (command == "quit") {
    ended_ = true;
    return "ending";
  }
  if (command == "input" || command.starts_with("input ")) return input(trimmed(command.substr(5)));
  runtime::LineOrder wanted;
  if (command == "heal all") {
    wanted.verb = runtime::LineOrder::Verb::kHealAll;
    return order(wanted);
  }
  if (command.starts_with("heal ")) {
    wanted.verb = runtime::LineOrder::Verb::kHeal;
    command = trimmed(command.substr(5));
  }
  const auto fault = runtime::parse_fault(command, places(), wanted.verb == runtime::LineOrder::Verb::kBegin);
  if (!fault) return fmt::format("error: {}; help lists all", fault.error().reason);
  wanted.fault = *fault;
  return order(wanted);
}

std::optional<runtime::LineOrder> LineConsole::carry_out(const runtime::LineOrder& wanted) {
  auto sent = wanted;
  sent.number = ++number_;
  if (!orders_.order(sent)) return std::nullopt;
  runtime::LineOrder answer;
  for (int i = 0; i < kAnswerTries;) {
    if (!orders_.next_answer(answer)) {
      std::this_thread::sleep_for(milliseconds{1});
      ++i;
    } else if (answer.number == sent.number) {  // others answer commands that had timed out
      return answer;
    }
  }
  return std::nullopt;
}

std::string LineConsole::current_states() {
  if (!carry_out({.verb = runtime::LineOrder::Verb::kReportStates})) return std::string(kNoAnswer);
  tell_events();
  return states();
}

/// `words`: "SLAVE" or "SLAVE INPUT=VALUE ...".
std::string LineConsole::input(std::string_view words) {
  const auto end = std::min(words.find(' '), words.size());
  const auto slave = runtime::parse_slave(words.substr(0, end), names_);
  if (!slave) return fmt::format("error: {}", slave.error().reason);
  const auto* signals = line_.slave(*slave).device().signals();
  if (signals == nullptr) return fmt::format("error: {} has no inputs", names_[*slave]);
  const auto settings = parse_signal_settings(words.substr(end), *signals);
  if (!settings) return fmt::format("error: {}", settings.error());
  if (settings->empty()) return signal_levels(*slave);
  for (const auto& setting : *settings) {
    const runtime::LineOrder order{.verb = runtime::LineOrder::Verb::kSetSignal,
                                   .slave = *slave,
                                   .signal = {slaves::SignalId::Direction::kInput, setting.input},
                                   .value = setting.value};
    if (!carry_out(order)) return std::string(kNoAnswer);
  }
  return "done";
}

std::string LineConsole::signal_levels(std::uint16_t slave) {
  using Direction = slaves::SignalId::Direction;
  const auto& signals = *line_.slave(slave).device().signals();
  std::string text;
  for (const Direction direction : {Direction::kInput, Direction::kOutput}) {
    for (std::size_t i = 0; i < signals.signal_count(direction); ++i) {
      const auto answer =
          carry_out({.verb = runtime::LineOrder::Verb::kReadSignal, .slave = slave, .signal = {direction, i}});
      if (!answer) return std::string(kNoAnswer);
      text +=
          fmt::format("{}{} {} = {}", text.empty() ? "" : "\n", direction == Direction::kInput ? "input " : "output",
                      signals.signal_name({direction, i}), answer->value);
    }
  }
  return text.empty() ? "no inputs and no outputs" : text;
}

std::string LineConsole::order(runtime::LineOrder wanted) {
  const auto answer = carry_out(wanted);
  if (!answer) return std::string(kNoAnswer);
  tell_events();
  if (answer->done) return "done";
  return wanted.verb == runtime::LineOrder::Verb::kHeal
             ? "error: this fault is not active"
             : fmt::format("error: not possible; at most {} faults can be active", slaves::LineFaults::kMaxActive);
}

std::string LineConsole::list() const {
  if (active_.empty()) return "no faults";
  std::string text;
  for (const auto& fault : active_) text.append(text.empty() ? "" : "\n").append(runtime::fault_text(fault, places()));
  return text;
}

void LineConsole::note(const slaves::FaultEvent& event) {
  std::erase_if(active_, [&](const auto& fault) { return fault.same_place(event.fault); });
  if (event.begins) active_.push_back(event.fault);
}

void LineConsole::tell_events() {
  slaves::FaultEvent event;
  while (line_.faults().next_event(event)) {
    note(event);
    if (events_ == Events::kPrinted)
      progress("fault {}: {}", event.begins ? "begins" : "ends", runtime::fault_text(event.fault, places()));
  }
  runtime::StateChange change;
  while (orders_.next_change(change)) {
    latest_[change.slave] = change;
    if (events_ == Events::kPrinted) print(change);
  }
}

void LineConsole::print(const runtime::StateChange& change) const {
  const auto& name = names_[change.slave];
  if (change.status.state == wire::AlState::kNone) {
    progress("slave {} ({}): OFF", change.slave, name);
  } else if (change.status.error) {
    progress("slave {} ({}): {} + ERROR, AL status code 0x{:04X} ({})", change.slave, name,
             wire::to_text(change.status.state), static_cast<unsigned>(change.code), wire::to_text(change.code));
  } else {
    progress("slave {} ({}): {}", change.slave, name, wire::to_text(change.status.state));
  }
}

std::string LineConsole::states() const {
  std::map<std::string, std::string> names_by_state;
  for (const auto& change : latest_) names_by_state[state_text(change)].append(" ").append(names_[change.slave]);
  std::string text;
  for (const auto& [state, names] : names_by_state) {
    text += fmt::format("{}{}:{}", text.empty() ? "" : "; ", state, names);
  }
  return text;
}

}  // namespace driveline::cli
