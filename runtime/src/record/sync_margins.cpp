#include "driveline/runtime/record/sync_margins.hpp"

#include <algorithm>

namespace driveline::runtime {

std::vector<SlaveMargin> read_sync_margins(ecat_master::Master& master) {
  std::vector<SlaveMargin> margins;
  if (master.clocks() == nullptr) return margins;
  const auto& clocks = master.clocks()->slaves;
  for (std::size_t i = 0; i < std::min(clocks.size(), master.slaves().size()); ++i) {
    auto* mailbox = master.mailbox(i);
    if (!clocks[i].signals.sync0() || mailbox == nullptr) continue;
    if (!master.slaves()[i].info.description.mailbox.coe) continue;
    ecat_master::CoeClient coe(*mailbox);
    const auto report = ecat_master::dc::read_sync_margin(coe);
    if (report && *report) margins.push_back({i, **report});
  }
  return margins;
}

}  // namespace driveline::runtime
