#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/slaves/line/simulated_line.hpp"

namespace driveline::runtime {

/// Makes the simulated slaves that `config` describes, in their order.
[[nodiscard]] std::vector<std::unique_ptr<slaves::Slave>> make_simulated_slaves(const LineConfig& config);

/// Builds the simulated line that `config` describes and switches it on. Without `second_interface`, the return cable
/// of a ring is unplugged at the master.
[[nodiscard]] std::unique_ptr<slaves::SimulatedLine> make_simulated_line(const LineConfig& config, rt::Clock& clock,
                                                                         bool second_interface = false);

/// Returns the axes whose drives are in this [[slave]].
[[nodiscard]] std::vector<const motion::AxisConfig*> axes_of_slave(const LineConfig& config, std::size_t slave);

/// Returns the start-up SDOs of an axis. `has_mode`: 6060h is in the process data of every drive.
[[nodiscard]] std::vector<motion::StartupSdo> axis_startup_sdos(const LineConfig& config,
                                                                const motion::AxisConfig& axis, bool has_mode);

/// Makes the plans for the master: identities, start-up SDOs and PDOs of the configured slaves.
[[nodiscard]] std::vector<ecat_master::SlavePlan> make_slave_plans(const LineConfig& config);

/// Returns the cycles between a position setpoint of `axis` and the corresponding actual position, calculated from its
/// drive, group and clock. Call after Master::configure().
[[nodiscard]] double setpoint_delay(const LineConfig& config, const motion::AxisConfig& axis,
                                    const ecat_master::Master& master);

/// Returns the age of the inputs of a slave when a frame fetches them: the time since the SYNC0 that latched them; 0
/// without SYNC0. `slave`: number of its [[slave]]. Call after Master::configure().
[[nodiscard]] std::chrono::nanoseconds input_age(std::size_t slave, const ecat_master::Master& master);

/// Makes the axes of the motion, in the order of the description, each at the position of its slave on the line. The
/// loss of a hot-connect axis does not stop the others. Call after Master::configure() with make_slave_plans().
[[nodiscard]] std::vector<motion::Axis> make_axes(const LineConfig& config, const ecat_master::Master& master);

/// Returns the settings of the motion: along the [path], else from the present positions.
[[nodiscard]] motion::Motion::Settings motion_settings(const LineConfig& config);
/// Returns the settings of axes that are commanded individually.
[[nodiscard]] motion::SingleAxes::Settings single_axis_settings(const LineConfig& config);

/// Returns how process data are exchanged: period, time for the answers, room for acyclic frames. Without copies, tasks
/// and flight recorder. Call after Master::configure().
[[nodiscard]] ecat_master::CyclicCore::Settings cycle_settings(const LineConfig& config,
                                                               const ecat_master::Master& master);

/// Returns the configuration of a line without a description: the slaves of `found`, named slave0, slave1 and so on,
/// each with the process data that it has assigned itself.
[[nodiscard]] std::vector<SlaveConfig> describe_found(std::span<const ecat_master::ConfiguredSlave> found);

/// Returns the number of the [[slave]] table for each slave of the line. Uses the order of the file if the line differs
/// from its description, which is refused later.
[[nodiscard]] std::vector<std::optional<std::size_t>> tables_of(const LineConfig& config,
                                                                std::span<const ecat_master::ConfiguredSlave> slaves);

}  // namespace driveline::runtime
