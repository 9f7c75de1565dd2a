#include "groups/group_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "driveline/runtime/setup/process_data_plan.hpp"

namespace driveline::runtime {
namespace {

/// Bits in the outputs of the process image that a group writes.
struct Written {
  std::size_t begin;
  std::size_t end;
  std::string name;  ///< "robot.vacuum"
};

Result<Written> find_bits(const LineConfig& config, const GroupOutputConfig& output,
                          const ecat_master::ProcessVariables& variables,
                          std::span<const motion::ProcessDataCopy> copies) {
  const auto variable = find_free_output(config, output.to, output.to_place, variables, copies);
  if (!variable) return tl::unexpected(variable.error());
  if (!output.bit && variable->bits > motion::PdoBits::kMaxBits) {
    return fail(
        ErrorKind::kSetting,
        fmt::format("{} has {} bits, the limit is {}", variable->text(), variable->bits, motion::PdoBits::kMaxBits),
        output.to_place);
  }
  if (output.bit && *output.bit >= variable->bits) {
    return fail(ErrorKind::kSetting,
                fmt::format("{} has no bit {}, 0 to {} is expected", variable->text(), *output.bit, variable->bits - 1),
                output.to_place);
  }
  const auto begin = variable->bit_offset + output.bit.value_or(0);
  return Written{begin, begin + (output.bit ? 1 : variable->bits), output.name};
}

}  // namespace

Result<std::vector<std::unique_ptr<GroupOutputs>>> GroupOutputs::make(const LineConfig& config,
                                                                      const ecat_master::ProcessVariables& variables,
                                                                      std::span<const motion::ProcessDataCopy> copies) {
  std::vector<std::unique_ptr<GroupOutputs>> made;
  std::vector<Written> all;
  for (const auto& group : config.axis_groups) {
    auto& outputs = made.emplace_back(group.outputs.empty() ? nullptr : std::make_unique<GroupOutputs>());
    for (const auto& output : group.outputs) {
      const auto bits = find_bits(config, output, variables, copies);
      if (!bits) return tl::unexpected(bits.error());
      const auto other = std::find_if(all.begin(), all.end(), [&](const Written& each) {
        return each.begin < bits->end && bits->begin < each.end;
      });
      if (other != all.end())
        return fail(ErrorKind::kSetting, fmt::format("is already written by the output \"{}\"", other->name),
                    output.to_place);
      all.push_back(*bits);
      outputs->add(output.name, bits->begin, static_cast<unsigned>(bits->end - bits->begin));
    }
  }
  return made;
}

/// Adds a whole number of `bits` bits, signed or unsigned.
void GroupOutputs::add(const std::string& name, std::size_t bit_offset, unsigned bits) {
  const double all = std::ldexp(1.0, static_cast<int>(bits));
  limits_.push_back({name, bits == 1 ? 0.0 : -0.5 * all, all - 1.0});
  places_.emplace_back(bit_offset, bits);
}

void GroupOutputs::change(const trajectory::PathOutput& output) noexcept {
  if (output.output >= places_.size()) return;
  values_[output.output] = static_cast<std::uint32_t>(static_cast<std::int64_t>(output.value));
}

void GroupOutputs::update(const motion::TaskCycle& cycle) noexcept {
  for (std::size_t i = 0; i < places_.size(); ++i) places_[i].set(cycle.outputs, values_[i]);
}

}  // namespace driveline::runtime
