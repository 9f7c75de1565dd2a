#include "commands/command_service.hpp"

#include <utility>

namespace driveline::runtime {
namespace {

/// Most commands per pass; with the pause between passes, at most 64,000 commands per second are processed.
constexpr std::size_t kCommandsPerPass = 64;
/// Most setpoints per pass; a stream with a setpoint in each cycle of 125 us sends 8.
constexpr std::size_t kSetpointsPerPass = 64;
constexpr std::chrono::milliseconds kPassPause{1};

}  // namespace

Result<std::unique_ptr<CommandService>> CommandService::start(AxisRequests& axis_requests,
                                                              std::chrono::nanoseconds lease_timeout) {
  auto commands = rt::SharedRegion::create("driveline-commands", snapshot::command_layout(snapshot::kCommandRoom));
  if (!commands) return fail(ErrorKind::kMachine, rt::describe(commands.error()), "[commands]");
  auto answers =
      rt::SharedRegion::create("driveline-command-answers", snapshot::command_answer_layout(snapshot::kAnswerRoom));
  if (!answers) return fail(ErrorKind::kMachine, rt::describe(answers.error()), "[commands]");
  auto setpoints = rt::SharedRegion::create("driveline-setpoints", snapshot::setpoint_layout(snapshot::kSetpointRoom));
  if (!setpoints) return fail(ErrorKind::kMachine, rt::describe(setpoints.error()), "[commands]");
  auto reports =
      rt::SharedRegion::create("driveline-stream-reports", snapshot::stream_report_layout(snapshot::kStreamReportRoom));
  if (!reports) return fail(ErrorKind::kMachine, rt::describe(reports.error()), "[commands]");
  return std::unique_ptr<CommandService>(new CommandService(axis_requests, lease_timeout, *std::move(commands),
                                                            *std::move(answers), *std::move(setpoints),
                                                            *std::move(reports)));
}

CommandService::CommandService(AxisRequests& axis_requests, std::chrono::nanoseconds lease_timeout,
                               rt::SharedRegion commands, rt::SharedRegion answers, rt::SharedRegion setpoints,
                               rt::SharedRegion reports)
    : commands_(std::move(commands)),
      answers_(std::move(answers)),
      setpoints_(std::move(setpoints)),
      reports_(std::move(reports)),
      reader_(commands_),
      writer_(answers_),
      setpoint_reader_(setpoints_),
      report_writer_(reports_),
      axis_requests_(axis_requests),
      desk_(axis_requests, clock_, lease_timeout),
      room_(kCommandsPerPass),
      setpoint_room_(kSetpointsPerPass),
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
  if (std::exchange(breaches_, reader_.breaches()) != reader_.breaches()) desk_.report_invalid_data();
  for (std::size_t i = 0; i < count; ++i) desk_.take(room_[i]);
  pass_streams();
  desk_.poll();
  for (const auto& answer : desk_.take_answers()) {
    writer_.begin();
    writer_.write(0, answer);
    writer_.commit();
  }
}

void CommandService::pass_streams() {
  const std::lock_guard lock(streams_lock_);
  const auto count = setpoint_reader_.pop(setpoint_room_);
  if (std::exchange(setpoint_breaches_, setpoint_reader_.breaches()) != setpoint_reader_.breaches())
    desk_.report_invalid_data();
  if (streams_ == nullptr) return;
  const auto now = clock_.now();
  for (std::size_t i = 0; i < count; ++i) {
    const auto& setpoint = setpoint_room_[i];
    const auto client = setpoint.client.view();
    if (streams_->take(setpoint, commander_name(setpoint.participant, client), now)) {
      desk_.heard(setpoint.participant, client);
    }
  }
  streams_->poll(now);
  for (auto& facts : streams_->take_events()) axis_requests_.note(std::move(facts));
  for (const auto& report : streams_->take_reports()) {
    report_writer_.begin();
    report_writer_.write(0, report);
    report_writer_.commit();
  }
}

void CommandService::attach(RemoteStreams* streams) {
  const std::lock_guard lock(streams_lock_);
  streams_ = streams;
}

void CommandService::end_streams() {
  const std::lock_guard lock(streams_lock_);
  if (streams_ == nullptr) return;
  streams_->close();
  streams_->end_all(stream::EndReason::kLine);
}

/// Discards what the bridge has left in shared memory.
void CommandService::forget_bridge() {
  for (std::uint64_t i = 0; i < snapshot::kCommandRoom; i += kCommandsPerPass) static_cast<void>(reader_.pop(room_));
  {
    const std::lock_guard lock(streams_lock_);
    for (std::uint64_t i = 0; i < snapshot::kSetpointRoom; i += kSetpointsPerPass) {
      static_cast<void>(setpoint_reader_.pop(setpoint_room_));
    }
    if (streams_ != nullptr) streams_->end_all(stream::EndReason::kGone);
  }
  desk_.bridge_lost();
}

}  // namespace driveline::runtime
