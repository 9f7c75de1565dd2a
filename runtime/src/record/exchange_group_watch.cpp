#include "driveline/runtime/record/exchange_group_watch.hpp"

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {

ExchangeGroupWatch::ExchangeGroupWatch(const ProcessDataConfig& config)
    : config_(config), zeroed_(config.groups.size()), zeroings_(config.groups.size()) {}

std::vector<EventFacts> ExchangeGroupWatch::poll(ecat_master::CyclicCore& core) {
  std::vector<EventFacts> changes;
  for (std::size_t i = 0; i < zeroed_.size() && i < core.groups().size(); ++i) {
    const auto& counters = core.groups()[i];
    const auto& group = config_.groups[i];
    if (counters.outputs_zeroed && zeroed_[i] == 0) {
      zeroed_[i] = 1;
      ++zeroings_[i];
      changes.push_back(events::ExchangeGroupZeroed{group.name, group.settings.bad_cycle_limit});
    }
    if (zeroed_[i] == 0 || counters.bad_cycles != 0) continue;
    core.release_outputs(i);
    zeroed_[i] = 0;
    changes.push_back(events::ExchangeGroupReleased{group.name});
  }
  return changes;
}

}  // namespace driveline::runtime
