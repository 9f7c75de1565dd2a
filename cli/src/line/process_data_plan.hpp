#pragma once

#include <chrono>
#include <vector>

#include "driveline/cli/line_config.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/process_data/process_variables.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// Layout and groups of the process image, and the descriptions out of [bus] esi.
[[nodiscard]] ecat_master::Master::Settings master_settings(const LineConfig& config);

/// The process data of a configured line by the names of the file, and what is copied in every cycle.
struct NamedProcessData {
  ecat_master::ProcessVariables variables;
  std::vector<ecat_master::ProcessDataCopy> copies;
};

/// After Master::configure(). Failure (status 2) with file and line: a name that nothing is called, a copy between
/// entries that do not fit, onto an entry that an axis or another copy writes.
[[nodiscard]] Outcome<NamedProcessData> name_process_data(const LineConfig& config, const ecat_master::Master& master);

/// What the cyclic frames of the busiest cycle cost on a 100 Mbit/s wire.
struct WireBudget {
  std::chrono::nanoseconds frames{};  ///< the wire is occupied
  std::chrono::nanoseconds line{};    ///< way of a frame through all slaves and back
  bool line_measured = false;         ///< by the receive times of the ports; else 1 us a slave is assumed
  std::chrono::nanoseconds period{};
  [[nodiscard]] std::chrono::nanoseconds total() const noexcept { return frames + line; }
  [[nodiscard]] double utilisation() const noexcept {
    return static_cast<double>(total().count()) / static_cast<double>(period.count());
  }
};

/// After Master::configure().
[[nodiscard]] WireBudget wire_budget(const ecat_master::Master& master, std::chrono::nanoseconds period);

}  // namespace driveline::cli
