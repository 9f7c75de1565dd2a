#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/dc/sync_objects.hpp"
#include "driveline/ecat_master/master.hpp"

namespace driveline::runtime {

/// Time from the arrival of the outputs at one slave to SYNC0.
struct SlaveMargin {
  std::size_t slave = 0;
  ecat_master::dc::SyncMarginReport report;
};

/// Reads the margins of all slaves with SYNC0 that are in OP (1C32h). Slaves that do not measure it or do not answer
/// are left out.
[[nodiscard]] std::vector<SlaveMargin> read_sync_margins(ecat_master::Master& master);

}  // namespace driveline::runtime
