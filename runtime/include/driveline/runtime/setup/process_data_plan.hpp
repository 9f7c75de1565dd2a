#pragma once

#include <chrono>
#include <vector>
#include "driveline/runtime/error.hpp"

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Layout and groups of the process image, and the descriptions out of [bus] esi.
[[nodiscard]] ecat_master::Master::Settings master_settings(const LineConfig& config);

/// After Master::scan(): whether the ESI files of the slaves (their own, or out of [bus] esi) allow the PDOs that are
/// planned: those of an axis, [[slave.pdo]], else those that the file assigns. Failure: the first rule that is broken.
[[nodiscard]] Result<void> check_planned_pdos(const LineConfig& config,
                                              std::span<const ecat_master::ConfiguredSlave> slaves);

/// After Master::configure(): whether the process data of every axis have what its mode needs, also of those whose PDOs
/// are the slave's own. Failure (status 2): what is missing.
[[nodiscard]] Result<void> check_axis_objects(const LineConfig& config, const ecat_master::Master& master);

/// The process data of a configured line by the names of the file, and what is copied in every cycle.
struct NamedProcessData {
  ecat_master::ProcessVariables variables;
  std::vector<ecat_master::ProcessDataCopy> copies;
};

/// After Master::configure(). Failure (status 2) with file and line: a name that nothing is called, a copy between
/// entries that do not fit, onto an entry that an axis or another copy writes.
[[nodiscard]] Result<NamedProcessData> name_process_data(const LineConfig& config, const ecat_master::Master& master);

}  // namespace driveline::runtime
