#include "driveline/runtime/record/group_watch.hpp"

#include <fmt/format.h>

namespace driveline::runtime {

GroupWatch::GroupWatch(const ProcessDataConfig& config)
    : config_(config), zeroed_(config.groups.size()), zeroings_(config.groups.size()) {}

std::vector<std::string> GroupWatch::poll(ecat_master::CyclicCore& core) {
  std::vector<std::string> told;
  for (std::size_t i = 0; i < zeroed_.size() && i < core.groups().size(); ++i) {
    const auto& counters = core.groups()[i];
    const auto& group = config_.groups[i];
    if (counters.outputs_zeroed && zeroed_[i] == 0) {
      zeroed_[i] = 1;
      ++zeroings_[i];
      told.push_back(fmt::format("group {}: outputs zeroed after {} exchanges in a row that were not whole", group.name,
                                 group.settings.bad_cycle_limit));
    }
    if (zeroed_[i] == 0 || counters.bad_cycles != 0) continue;
    core.release_outputs(i);
    zeroed_[i] = 0;
    told.push_back(fmt::format("group {}: whole again, outputs released", group.name));
  }
  return told;
}

}  // namespace driveline::runtime
