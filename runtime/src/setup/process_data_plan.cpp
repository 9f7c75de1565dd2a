#include "driveline/runtime/setup/process_data_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/configuration/pdo_discovery.hpp"
#include "driveline/motion/drive/axis_objects.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::ProcessVariable;
using ecat_master::ProcessVariables;
using motion::ProcessDataCopy;
using std::chrono::nanoseconds;

Result<void> give_names(const LineConfig& config, ProcessVariables& variables) {
  for (const auto& slave : config.slaves) {
    for (const auto& entry : slave.names) {
      const auto named = variables.rename(fmt::format("{}.{}", slave.name, entry.object), entry.name);
      if (!named) return fail(ErrorKind::kSetting, describe(named.error()), entry.place);
    }
  }
  return {};
}

/// Target of interpolated position, which the standard PDOs of EtherCAT do not have.
constexpr std::uint16_t kInterpolationData = 0x60C1;

/// Returns the axis whose cycle writes this output; null: the output is free.
const motion::AxisConfig* writer_of(const LineConfig& config, const ProcessVariable& variable) {
  const auto& pdos = motion::axis_pdo_configuration().outputs;
  const auto writes = [&](const motion::AxisConfig& axis) {
    if (axis.is_virtual() || config.slaves[axis.slave].name != variable.slave_name) return false;
    const auto is_it = [&](const motion::MappedObject& object) {
      return motion::object_of_drive(object.index, axis.drive) == variable.index &&
             object.subindex == variable.subindex;
    };
    if (motion::object_of_drive(kInterpolationData, axis.drive) == variable.index) return true;
    return std::any_of(pdos.begin(), pdos.end(),
                       [&](const auto& pdo) { return std::any_of(pdo.objects.begin(), pdo.objects.end(), is_it); });
  };
  const auto axis = std::find_if(config.axes.begin(), config.axes.end(), writes);
  return axis == config.axes.end() ? nullptr : &*axis;
}

bool overlap(const ProcessDataCopy& a, const ProcessDataCopy& b) {
  return a.to_bit < b.to_bit + b.bits && b.to_bit < a.to_bit + a.bits;
}

Result<ProcessDataCopy> make_copy(const LineConfig& config, const CopyConfig& wanted,
                                  const ProcessVariables& variables) {
  if (const auto source = variables.find(wanted.from); !source) {
    return fail(ErrorKind::kSetting, describe(source.error()), wanted.from_place);
  }
  const auto target = variables.find(wanted.to);
  if (!target) return fail(ErrorKind::kSetting, describe(target.error()), wanted.to_place);
  if (const auto* axis = writer_of(config, *target)) {
    return fail(ErrorKind::kSetting, fmt::format("{} is written by the axis \"{}\"", target->text(), axis->name),
                wanted.to_place);
  }
  const auto copy = variables.copy(wanted.from, wanted.to);
  if (!copy) return fail(ErrorKind::kSetting, describe(copy.error()), wanted.to_place);
  return *copy;
}

}  // namespace

Result<ProcessVariable> find_free_output(const LineConfig& config, std::string_view name, const std::string& place,
                                         const ProcessVariables& variables, std::span<const ProcessDataCopy> copies) {
  const auto variable = variables.find(name);
  if (!variable) return fail(ErrorKind::kSetting, describe(variable.error()), place);
  if (!variable->output) {
    return fail(ErrorKind::kSetting, fmt::format("{} is an input, an output is expected", variable->text()), place);
  }
  if (const auto* axis = writer_of(config, *variable))
    return fail(ErrorKind::kSetting, fmt::format("{} is written by the axis \"{}\"", variable->text(), axis->name),
                place);
  ProcessDataCopy whole;
  whole.to_bit = variable->bit_offset;
  whole.bits = variable->bits;
  if (std::any_of(copies.begin(), copies.end(), [&](const auto& copy) { return overlap(copy, whole); }))
    return fail(ErrorKind::kSetting, fmt::format("{} is written by a [[copy]]", variable->text()), place);
  return *variable;
}

ecat_master::Master::Settings master_settings(const LineConfig& config) {
  ecat_master::Master::Settings settings;
  settings.layout.layout = config.process_data.layout;
  for (const auto& group : config.process_data.groups) settings.layout.groups.push_back(group.settings);
  if (config.esi_library) {
    settings.describe = [library = config.esi_library](const ecat_master::SlaveInfo& info) {
      const auto& found = info.description;
      return library->find(found.vendor_id, found.product_code, found.revision);
    };
  }
  return settings;
}

Result<void> check_planned_pdos(const LineConfig& config, std::span<const ecat_master::ConfiguredSlave> slaves) {
  const auto tables = tables_of(config, slaves);
  const auto plans = make_slave_plans(config);
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!tables[i]) continue;
    const auto& found = slaves[i].info.description;
    auto file = config.slaves[*tables[i]].esi;
    if (!file && config.esi_library) {
      file = config.esi_library->find(found.vendor_id, found.product_code, found.revision);
    }
    // PDOs of modules are not in the file: only the slave knows them.
    if (!file || (file->rx_pdos.empty() && file->tx_pdos.empty())) continue;
    auto pdos = plans[*tables[i]].pdos;
    const bool planned = !pdos.outputs.empty() || !pdos.inputs.empty();
    if (!planned) pdos = ecat_master::pdo_configuration_from_sii(*file);
    ecat_master::complete_pdos(*file, pdos);
    const auto fit = ecat_master::check_pdos(*file, pdos);
    if (fit) continue;
    return fail(ErrorKind::kLine,
                fmt::format("slave {} ({}): {} cannot be configured by the ESI file of \"{}\": {}", i,
                            config.slaves[*tables[i]].name, planned ? "the planned PDOs" : "the PDOs that it assigns",
                            file->type, describe(fit.error())));
  }
  return {};
}

Result<void> check_axis_objects(const LineConfig& config, const ecat_master::Master& master) {
  for (const auto& axis : config.axes) {
    if (axis.is_virtual()) continue;
    const auto position = master.position_of(axis.slave).value_or(axis.slave);
    const auto& plan = master.slaves()[position].plan;
    const auto missing =
        motion::missing_objects(axis.mode, motion::pdos_of_drive(plan.pdos, axis.drive), axis.feed_forward.any());
    if (missing.empty()) continue;
    return fail(ErrorKind::kSetting, fmt::format("axis {}, slave {} ({}): {}", axis.name, position, plan.name,
                                                 motion::describe_missing(axis.mode, missing, plan.pdos, axis.drive)));
  }
  return {};
}

Result<NamedProcessData> name_process_data(const LineConfig& config, const ecat_master::Master& master) {
  return name_process_data(config, ProcessVariables(master.slaves(), master.image()));
}

Result<NamedProcessData> name_process_data(const LineConfig& config, ProcessVariables variables) {
  NamedProcessData named{std::move(variables), {}};
  if (auto done = give_names(config, named.variables); !done) return tl::unexpected(done.error());
  for (const auto& wanted : config.process_data.copies) {
    const auto copy = make_copy(config, wanted, named.variables);
    if (!copy) return tl::unexpected(copy.error());
    for (std::size_t i = 0; i < named.copies.size(); ++i) {
      if (!overlap(named.copies[i], *copy)) continue;
      return fail(ErrorKind::kSetting,
                  fmt::format("\"{}\" is already written by the copy from \"{}\"", wanted.to,
                              config.process_data.copies[i].from),
                  wanted.to_place);
    }
    named.copies.push_back(*copy);
  }
  return named;
}

}  // namespace driveline::runtime
