#include "commands/line_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "console.hpp"

namespace driveline::cli {
namespace {

/// How often the socket is polled and answers of the line are forwarded.
constexpr std::chrono::milliseconds kControlInterval{10};
constexpr std::string_view kAxis = "axis ";
constexpr std::string_view kGroup = "group ";
constexpr std::string_view kFault = "fault ";
constexpr std::string_view kInput = "input ";
constexpr std::array<std::string_view, 4> kQuestions{"diag", "diag json", "eoe", "eoe json"};

}  // namespace

LineControl::LineControl(std::unique_ptr<CommandInput> input, runtime::AxisRequests& axes,
                         runtime::GroupRequests& groups, runtime::CouplingPlan couplings,
                         std::unique_ptr<SlaveConsole> console)
    : input_(std::move(input)),
      console_(std::move(console)),
      axes_(axes, std::move(couplings)),
      groups_(groups, axes),
      thread_([this] { serve(); }) {}

LineControl::~LineControl() {
  stop_ = true;
  thread_.join();
}

void LineControl::serve() {
  while (!stop_) {
    input_->run(kControlInterval, *this);
    axes_.watch();
    groups_.watch();
    if (console_ != nullptr) console_->tell_events();
    std::vector<Question> answered;
    {
      const std::lock_guard guard(lock_);
      answered.swap(answered_);
    }
    for (const auto& answer : answered) input_->supply(answer.connection, answer.text, *this);
  }
}

CommandReply LineControl::execute(const CommandSender& sender, std::string_view command) {
  if (command.starts_with(kAxis)) return {axes_.execute(sender, command.substr(kAxis.size())), true, false};
  if (command.starts_with(kGroup)) return {groups_.execute(sender, command.substr(kGroup.size())), true, false};
  if (command.starts_with(kFault) || command.starts_with(kInput)) return {order_line(sender, command)};
  const bool question = std::find(kQuestions.begin(), kQuestions.end(), command) != kQuestions.end();
  if (!question && !command.starts_with(kDriveQuestion)) {
    return {
        fmt::format("error: \"{}\" is not a command of a running line; expected: diag, eoe, diag json, eoe json, axis, "
                    "group, drive, fault or input",
                    command)};
  }
  const std::lock_guard guard(lock_);
  asked_.push_back({sender.connection, std::string(command)});
  return {{}, false, true};
}

std::string LineControl::order_line(const CommandSender& sender, std::string_view command) {
  if (console_ == nullptr)
    return "error: the slaves of this line are on an interface: only slaves simulated in this process have faults and "
           "inputs "
           "to set";
  if (command == "fault quit") return "error: quit ends `simulate`; Ctrl-C ends this run";
  auto answer = console_->execute(command);
  // What changes the line explains the faults that follow.
  if (answer == "done") progress("{}: {}", caller_name(sender), command);
  return answer;
}

void LineControl::answer_questions(const Answer& answer) {
  std::vector<Question> asked;
  {
    const std::lock_guard guard(lock_);
    asked.swap(asked_);
  }
  for (auto& question : asked) {
    question.text = answer(question.text);
    const std::lock_guard guard(lock_);
    answered_.push_back(std::move(question));
  }
}

}  // namespace driveline::cli
