// Telemetry and commands of a run over DDS.
#include "operation/line_run.hpp"

#include <fmt/format.h>
#include "driveline/runtime/event.hpp"

namespace driveline::runtime {
Result<void> LineRun::check_commands() const {
  if (!config_.commands) return {};
  if (bus_.virtual_time()) {
    return fail(ErrorKind::kSetting, "need real time: clients cannot follow leases in virtual time", "[commands]");
  }
  if (settings_.telemetry) return {};
  return fail(ErrorKind::kSetting, "arrive through the telemetry bridge, but this run has no telemetry", "[commands]");
}

/// Starts the bridge. A machine without the bridge program runs lines, too, unless telemetry is explicitly enabled.
Result<void> LineRun::start_bridge() {
  if (!settings_.telemetry || !config_.telemetry.enabled) return {};
  Result<std::filesystem::path> program;
  if (!config_.telemetry.service) program = TelemetryService::find_program();
  if (!program) {
    if (config_.telemetry.asked.value_or(false) || config_.commands) return tl::unexpected(program.error());
    note(events::TelemetryOff{describe(program.error())}, Severity::kNotice);
    return {};
  }
  BridgeSupervisor::Settings settings{.program = std::move(*program)};
  if (auto ready = start_commands(); !ready) return ready;
  if (commands_) settings.commands = commands_->descriptors();
  return telemetry_.start(config_, bus_.virtual_time(), std::move(settings));
}

Result<void> LineRun::start_commands() {
  if (!config_.commands) return {};
  auto started = CommandService::start(axis_requests(), config_.commands->lease_timeout);
  if (!started) return tl::unexpected(started.error());
  commands_ = std::move(*started);
  note(events::CommandsOpen{config_.commands->insecure}, Severity::kNotice);
  return {};
}

Result<void> LineRun::start_telemetry() {
  if (auto started = start_bridge(); !started) return started;
  auto listeners = settings_.consumers;
  if (auto* telemetry = telemetry_.service()) listeners.push_back(telemetry);
  return samples_.start(std::move(listeners));
}

/// Reports events of the bridge: they are no faults of the line, but subscribers need to know them.
void LineRun::note_telemetry() {
  auto* telemetry = telemetry_.service();
  if (!telemetry) return;
  for (auto& facts : telemetry->poll()) {
    const bool stopped = facts.is<events::BridgeStopped>();
    if (stopped && commands_) commands_->bridge_lost();
    note(std::move(facts), Severity::kNotice);
    if (stopped) samples_.feed()->add_fault(describe(events_.newest()));
  }
}

/// Publishes the slaves: if `now` is set, when something has changed, or when the interval has passed.
void LineRun::tell_slaves(bool now) {
  auto* telemetry = telemetry_.service();
  if (!telemetry) return;
  std::vector<std::string> owners;
  for (std::size_t i = 0; i < config_.axes.size(); ++i) owners.push_back(axis_requests().authority().owner_of(i));
  if (const auto* condition = bus_.slaves(owners, now)) telemetry->set_condition(*condition);
}

}  // namespace driveline::runtime
