#include "config/command_reader.hpp"

#include <chrono>

namespace driveline::runtime {
namespace {

constexpr double kDefaultLeaseMs = 500.0;
constexpr double kShortestLeaseMs = 50.0;
constexpr double kLongestLeaseMs = 60'000.0;

}  // namespace

std::optional<CommandConfig> read_commands(TomlReader reader, const TelemetryConfig& telemetry) {
  CommandConfig commands;
  const bool enabled = reader.boolean_or("enabled", false);
  commands.insecure = reader.boolean_or("insecure", false);
  commands.lease_timeout = std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double, std::milli>(
      reader.number_or("lease_timeout_ms", kDefaultLeaseMs, kShortestLeaseMs, kLongestLeaseMs)));
  reader.finish();
  if (!enabled) return std::nullopt;
  if (!telemetry.enabled)
    reader.fail("enabled", "needs the telemetry bridge to receive commands, but [telemetry] is off");
  if (telemetry.service) {
    reader.fail("enabled", "needs the bridge that run starts, but [telemetry] has bridge = \"service\"");
  }
  const bool secured = telemetry.security.has_value();
  if (!commands.insecure && !secured) {
    reader.fail("enabled",
                "needs [telemetry] security, or insecure = true, with which any participant in the network of its "
                "interfaces may move the axes");
  }
  commands.insecure = !secured;
  return commands;
}

}  // namespace driveline::runtime
