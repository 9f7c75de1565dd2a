#include "driveline/runtime/devices/drive_rules.hpp"

namespace driveline::runtime {

std::vector<ecat_master::StartupSdo> DriveRules::startup_sdos(const ecat_master::AxisConfig& /*axis*/,
                                                              std::chrono::nanoseconds period) const {
  return ecat_master::cia402_startup_sdos(period);
}

}  // namespace driveline::runtime
