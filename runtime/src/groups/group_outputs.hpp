#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/groups/group_moves.hpp"

namespace driveline::runtime {

/// Writes the outputs of a group ([[axis_group.output]]) into the process data. change() is called in the cycle in
/// which the axes pass the position of the change; the value is sent with their setpoints of that cycle. Outputs are
/// zero before the first change; a value stays until the next change, whatever happens to the motion.
class GroupOutputs final : public motion::PathOutputs, public motion::CycleTask {
 public:
  /// Makes the outputs of all groups; null for a group without outputs. Errors, with the place in the file: an output
  /// that the process data do not contain, or that is written by something else.
  [[nodiscard]] static Result<std::vector<std::unique_ptr<GroupOutputs>>> make(
      const LineConfig& config, const ecat_master::ProcessVariables& variables,
      std::span<const motion::ProcessDataCopy> copies);

  /// Returns the permitted values, in the order of the line description.
  [[nodiscard]] const std::vector<GroupOutputLimits>& limits() const noexcept { return limits_; }

  void change(const trajectory::PathOutput& output) noexcept override;
  void update(const motion::TaskCycle& cycle) noexcept override;

 private:
  void add(const std::string& name, std::size_t bit_offset, unsigned bits);

  std::vector<GroupOutputLimits> limits_;
  std::vector<motion::PdoBits> places_;
  std::array<std::uint32_t, AxisGroupConfig::kMaxOutputs> values_{};
};

}  // namespace driveline::runtime
