#include "operation/run_telemetry.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <utility>

#include "driveline/runtime/files/input_file.hpp"
#include "telemetry/sealed_copy.hpp"
#include "telemetry/security_files.hpp"

namespace driveline::runtime {
namespace {

/// Sets the user of the bridge. Only root can start a process of another user.
Result<void> set_user(const TelemetryConfig& telemetry, BridgeSupervisor::Settings& settings) {
  const auto& user = telemetry.user;
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

}  // namespace

Result<void> RunTelemetry::start(const LineConfig& config, bool virtual_time, BridgeSupervisor::Settings settings) {
  if (auto set = set_user(config.telemetry, settings); !set) return set;
  if (auto copied = copy_files(config.telemetry, settings); !copied) return copied;
  auto started = TelemetryService::start(config, virtual_time, std::move(settings));
  if (!started) return tl::unexpected(started.error());
  service_ = std::move(*started);
  return {};
}

/// Opens or copies the files for the bridge.
Result<void> RunTelemetry::copy_files(const TelemetryConfig& telemetry, BridgeSupervisor::Settings& settings) {
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

}  // namespace driveline::runtime
