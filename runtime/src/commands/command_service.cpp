#include "commands/command_service.hpp"

#include <utility>

namespace driveline::runtime {
namespace {

/// Commands of one pass, and the pause before the next one: no more than 64,000 in a second are even looked at.
constexpr std::size_t kCommandsPerPass = 64;
constexpr std::chrono::milliseconds kPassPause{1};

}  // namespace

Result<std::unique_ptr<CommandService>> CommandService::start(AxisDoor& door, std::chrono::nanoseconds lease_timeout) {
  auto commands = rt::SharedRegion::create("driveline-commands", snapshot::command_layout(snapshot::kCommandRoom));
  if (!commands) return fail(ErrorKind::kMachine, rt::describe(commands.error()), "[commands]");
  auto answers =
      rt::SharedRegion::create("driveline-command-answers", snapshot::command_answer_layout(snapshot::kAnswerRoom));
  if (!answers) return fail(ErrorKind::kMachine, rt::describe(answers.error()), "[commands]");
  return std::unique_ptr<CommandService>(
      new CommandService(door, lease_timeout, *std::move(commands), *std::move(answers)));
}

CommandService::CommandService(AxisDoor& door, std::chrono::nanoseconds lease_timeout, rt::SharedRegion commands,
                               rt::SharedRegion answers)
    : commands_(std::move(commands)),
      answers_(std::move(answers)),
      reader_(commands_),
      writer_(answers_),
      desk_(door, clock_, lease_timeout),
      room_(kCommandsPerPass),
      thread_([this] { serve(); }) {}

CommandService::~CommandService() {
  stop_ = true;
  thread_.join();
}

void CommandService::serve() {
  while (!stop_.load(std::memory_order_relaxed)) {
    pass();
    std::this_thread::sleep_for(kPassPause);
  }
}

void CommandService::pass() {
  if (lost_.exchange(false, std::memory_order_acq_rel)) forget_bridge();
  const auto count = reader_.pop(room_);
  if (std::exchange(breaches_, reader_.breaches()) != reader_.breaches()) desk_.unbelieved();
  for (std::size_t i = 0; i < count; ++i) desk_.take(room_[i]);
  desk_.look();
  for (const auto& answer : desk_.take_answers()) {
    writer_.begin();
    writer_.write(0, answer);
    writer_.commit();
  }
}

/// What it has left behind is not done any more.
void CommandService::forget_bridge() {
  for (std::uint64_t i = 0; i < snapshot::kCommandRoom; i += kCommandsPerPass) static_cast<void>(reader_.pop(room_));
  desk_.bridge_lost();
}

}  // namespace driveline::runtime
