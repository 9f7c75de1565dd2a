#pragma once

#include <memory>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "telemetry/telemetry_service.hpp"

namespace driveline::runtime {

/// The telemetry of a run, with the files that its bridge needs: the bridge must not open files itself.
class RunTelemetry {
 public:
  /// Starts the bridge as [telemetry] says. `settings`: its program, and descriptors for commands if there are any.
  /// Errors: user or files of [telemetry] cannot be used (kSetting), the bridge cannot start (kMachine).
  [[nodiscard]] Result<void> start(const LineConfig& config, bool virtual_time, BridgeSupervisor::Settings settings);
  /// Returns the service; null: nothing is published.
  [[nodiscard]] TelemetryService* service() const noexcept { return service_.get(); }

 private:
  [[nodiscard]] Result<void> copy_files(const TelemetryConfig& telemetry, BridgeSupervisor::Settings& settings);

  rt::FileDescriptor qos_profiles_;           ///< none: the writers use their own profiles
  std::vector<rt::FileDescriptor> security_;  ///< empty: telemetry without DDS Security
  std::unique_ptr<TelemetryService> service_;
};

}  // namespace driveline::runtime
