#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/cyclic/motion.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/slaves/line/line.hpp"

namespace driveline::runtime {

/// The simulated slaves that `config` describes, in their order.
[[nodiscard]] std::vector<std::unique_ptr<slaves::Slave>> make_simulated_slaves(const LineConfig& config);

/// Builds the simulated line that `config` describes and switches it on. The cable back from the far end of a ring is
/// unplugged at the master's side without a `second_interface` there.
[[nodiscard]] std::unique_ptr<slaves::Line> make_simulated_line(const LineConfig& config, rt::Clock& clock,
                                                                bool second_interface = false);

/// Plans for the master: identities, start-up SDOs and PDOs of the configured slaves.
[[nodiscard]] std::vector<ecat_master::SlavePlan> make_slave_plans(const LineConfig& config);

/// Cycles between a position setpoint of `axis` and the actual position that belongs to it, calculated from its drive,
/// group and clock. After Master::configure().
[[nodiscard]] double setpoint_delay(const LineConfig& config, const ecat_master::AxisConfig& axis,
                                    const ecat_master::Master& master);

/// How old the inputs of a slave are when a frame fetches them: since the SYNC0 that has latched them; 0 without one.
/// `slave`: number of its [[slave]]. After Master::configure().
[[nodiscard]] std::chrono::nanoseconds input_age(std::size_t slave, const ecat_master::Master& master);

/// The axes of the motion, in the order of the description, each at the place that its slave has on the line. An axis
/// of a hot-connected slave does not stop the others when it is lost. After Master::configure() by make_slave_plans().
[[nodiscard]] std::vector<ecat_master::Axis> make_axes(const LineConfig& config, const ecat_master::Master& master);

/// How the axes are moved: along the [path], else from where they stand.
[[nodiscard]] ecat_master::Motion::Settings motion_settings(const LineConfig& config);
/// Settings of axes that are commanded one by one.
[[nodiscard]] ecat_master::SingleAxes::Settings single_axis_settings(const LineConfig& config);

/// How process data are exchanged: period, time for the answers, room for acyclic work. Without copies, tasks and
/// flight recorder. After Master::configure().
[[nodiscard]] ecat_master::CyclicCore::Settings cycle_settings(const LineConfig& config,
                                                               const ecat_master::Master& master);

/// Configuration of a line without a description: the slaves of `found`, named slave0, slave1 and so on, each with the
/// process data that it has assigned by itself.
[[nodiscard]] std::vector<SlaveConfig> describe_found(std::span<const ecat_master::ConfiguredSlave> found);

/// Number of the [[slave]] table for each slave of the line. Where the line differs from its description, which is
/// refused later, the order of the file counts.
[[nodiscard]] std::vector<std::optional<std::size_t>> tables_of(const LineConfig& config,
                                                                std::span<const ecat_master::ConfiguredSlave> slaves);

}  // namespace driveline::runtime
