// Telemetry and commands of a run over DDS.
#include "operation/line_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "telemetry/sealed_copy.hpp"
#include "telemetry/security_files.hpp"

namespace driveline::runtime {
namespace {

/// Interval at which the rings are read: the longest delay of a sample before the consumers get it.
constexpr auto kDrainPeriod = std::chrono::microseconds{500};

}  // namespace

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
  if (auto set = set_bridge_user(settings); !set) return set;
  if (auto copied = copy_bridge_files(settings); !copied) return copied;
  if (auto ready = start_commands(); !ready) return ready;
  if (commands_) settings.commands = commands_->descriptors();
  auto started = TelemetryService::start(config_, bus_.virtual_time(), std::move(settings));
  if (!started) return tl::unexpected(started.error());
  telemetry_ = std::move(*started);
  return {};
}

/// Sets the user of the bridge. Only root can start a process of another user.
Result<void> LineRun::set_bridge_user(BridgeSupervisor::Settings& settings) const {
  const auto& user = config_.telemetry.user;
  if (!user) return {};
  if (const auto own = ::geteuid(); own != 0 && own != user->user) {
    return fail(
        ErrorKind::kSetting,
        fmt::format("is \"{0}\", but this run belongs to user {1}, who cannot start the bridge as another user: "
                    "start the run as root, or remove this key to start the bridge as user {1}",
                    user->name, own),
        "[telemetry] user");
  }
  settings.user = fmt::format("{}:{}", user->user, user->group);
  return {};
}

/// Opens or copies the files for the bridge, which must not open files itself.
Result<void> LineRun::copy_bridge_files(BridgeSupervisor::Settings& settings) {
  const auto& telemetry = config_.telemetry;
  if (telemetry.security) {
    auto files = open_security_files(*telemetry.security);
    if (!files) return tl::unexpected(files.error());
    security_ = std::move(*files);
    for (const auto& file : security_) settings.security.push_back(file.get());
  }
  if (!telemetry.qos_profiles) return {};
  const auto content = read_input_file(*telemetry.qos_profiles);
  if (!content) return tl::unexpected(content.error());
  auto copy = sealed_copy(*content, *telemetry.qos_profiles);
  if (!copy) return tl::unexpected(copy.error());
  qos_profiles_ = std::move(*copy);
  settings.qos_profiles = qos_profiles_.get();
  settings.qos_file = telemetry.qos_profiles->string();
  return {};
}

Result<void> LineRun::start_commands() {
  if (!config_.commands) return {};
  auto started = CommandService::start(*settings_.axis_requests, config_.commands->lease_timeout);
  if (!started) return tl::unexpected(started.error());
  commands_ = std::move(*started);
  note(events::CommandsOpen{config_.commands->insecure}, Severity::kNotice);
  return {};
}

Result<void> LineRun::start_telemetry() {
  if (auto started = start_bridge(); !started) return started;
  figures_ = std::make_unique<CycleFigures>(config_.period);
  auto listeners = settings_.consumers;
  if (telemetry_) listeners.push_back(telemetry_.get());
  feed_ = std::make_unique<StatusFeed>(listeners, config_.period);
  std::vector<snapshot::SampleConsumer*> consumers{recorder_.get(), figures_.get(), feed_.get()};
  consumers.insert(consumers.end(), listeners.begin(), listeners.end());
  velocities_ = std::make_unique<VelocityEstimate>(std::move(consumers));
  drain_ = std::make_unique<snapshot::DrainThread>(line_ring_, axis_ring_,
                                                   std::vector<snapshot::SampleConsumer*>{velocities_.get()},
                                                   snapshot::DrainConfig{.period = kDrainPeriod});
  if (auto started = drain_->start(); !started) return fail(ErrorKind::kMachine, describe(started.error()));
  return {};
}

/// Reports events of the bridge: they are no faults of the line, but subscribers need to know them.
void LineRun::note_telemetry() {
  if (!telemetry_) return;
  for (auto& facts : telemetry_->poll()) {
    const bool stopped = facts.is<events::BridgeStopped>();
    if (stopped && commands_) commands_->bridge_lost();
    note(std::move(facts), Severity::kNotice);
    if (stopped && feed_) feed_->add_fault(describe(events_.newest()));
  }
}

/// Publishes the slaves: if `now` is set, when something has changed, or when the interval has passed.
void LineRun::tell_slaves(bool now) {
  if (!telemetry_) return;
  std::vector<std::string> owners;
  for (std::size_t i = 0; i < config_.axes.size(); ++i)
    owners.push_back(settings_.axis_requests->authority().owner_of(i));
  if (const auto* condition = bus_.slaves(owners, now)) telemetry_->set_condition(*condition);
}

}  // namespace driveline::runtime
