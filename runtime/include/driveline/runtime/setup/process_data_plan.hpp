#pragma once

#include <chrono>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include "driveline/runtime/error.hpp"

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Returns layout and groups of the process image, and the descriptions from [bus] esi.
[[nodiscard]] ecat_master::Master::Settings master_settings(const LineConfig& config);

/// Call after Master::scan(): checks the planned PDOs (those of an axis, those in [[slave.pdo]], else those that the
/// file assigns) against the ESI files of the slaves (their own, or from [bus] esi). Error: the first rule that is
/// violated.
[[nodiscard]] Result<void> check_planned_pdos(const LineConfig& config,
                                              std::span<const ecat_master::ConfiguredSlave> slaves);

/// Call after Master::configure(): checks that the process data of every axis contain the objects that its mode needs,
/// even if the slave assigned the PDOs itself. Error: the missing objects.
[[nodiscard]] Result<void> check_axis_objects(const LineConfig& config, const ecat_master::Master& master);

/// Process data of a configured line with the names of the file, and the copies of every cycle.
struct NamedProcessData {
  ecat_master::ProcessVariables variables;
  std::vector<motion::ProcessDataCopy> copies;
};

/// Call after Master::configure(). Errors, with file and line: an unknown name, a copy between entries of different
/// size, or a copy to an entry that an axis or another copy writes.
[[nodiscard]] Result<NamedProcessData> name_process_data(const LineConfig& config, const ecat_master::Master& master);
/// Same for process data that another bus has placed in its image.
[[nodiscard]] Result<NamedProcessData> name_process_data(const LineConfig& config,
                                                         ecat_master::ProcessVariables variables);

/// Finds an output by name that neither an axis nor a copy writes. Error: with this `place` of the file.
[[nodiscard]] Result<ecat_master::ProcessVariable> find_free_output(const LineConfig& config, std::string_view name,
                                                                    const std::string& place,
                                                                    const ecat_master::ProcessVariables& variables,
                                                                    std::span<const motion::ProcessDataCopy> copies);

}  // namespace driveline::runtime
