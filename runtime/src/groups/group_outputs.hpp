#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/ecat_master/cyclic/cycle_task.hpp"
#include "driveline/ecat_master/group/axis_groups.hpp"
#include "driveline/ecat_master/process_data/pdo_entry.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/groups/group_way.hpp"

namespace driveline::runtime {

/// Writes the outputs of a group ([[axis_group.output]]) into the process data: told of a change in the cycle in which
/// the axes pass its place, it leaves with their setpoints of that cycle. Zero before the first change; a value stays
/// until the next one, whatever becomes of the motion.
class GroupOutputs final : public ecat_master::PathOutputs, public ecat_master::CycleTask {
 public:
  /// Those of all groups, null for a group without. Errors, with the place in the file: an output that the process data
  /// do not have, or that something else writes.
  [[nodiscard]] static Result<std::vector<std::unique_ptr<GroupOutputs>>> make(
      const LineConfig& config, const ecat_master::ProcessVariables& variables,
      std::span<const ecat_master::ProcessDataCopy> copies);

  /// Which values they take, in the order of the line description.
  [[nodiscard]] const std::vector<GroupOutputLimits>& limits() const noexcept { return limits_; }

  void change(const trajectory::PathOutput& output) noexcept override;
  void update(const ecat_master::TaskCycle& cycle) noexcept override;

 private:
  void add(const std::string& name, std::size_t bit_offset, unsigned bits);

  std::vector<GroupOutputLimits> limits_;
  std::vector<ecat_master::PdoBits> places_;
  std::array<std::uint32_t, AxisGroupConfig::kMostOutputs> values_{};
};

}  // namespace driveline::runtime
