#include "driveline/runtime/devices/drive_rules.hpp"

namespace driveline::runtime {

std::vector<motion::StartupSdo> DriveRules::startup_sdos(const motion::AxisConfig& /*axis*/,
                                                         std::chrono::nanoseconds period) const {
  return motion::cia402_startup_sdos(period);
}

}  // namespace driveline::runtime
