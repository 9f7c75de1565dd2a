// Hot-connect slaves that are not on the line yet.
#include <algorithm>
#include <array>

#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/master.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;

/// The description assumed for a slave of an unknown type: the usual sync managers (ETG.1000.4 6.6: 0 and 1 for the
/// mailbox, 2 for outputs, 3 for inputs). Their addresses become known when it joins.
esi::DeviceDescription unseen(const SlavePlan& plan) {
  esi::DeviceDescription description;
  description.vendor_id = plan.vendor_id;
  description.product_code = plan.product_code;
  constexpr std::array kUses{Use::kMailboxOut, Use::kMailboxIn, Use::kOutputs, Use::kInputs};
  for (std::size_t i = 0; i < kUses.size(); ++i) {
    esi::SyncManager manager;
    manager.use = kUses[i];
    manager.start_address = static_cast<std::uint16_t>(0x1000 + 0x400 * i);
    description.sync_managers.push_back(manager);
  }
  return description;
}

bool alike(const SlavePlan& plan, const SlaveInfo& other) {
  return other.usable() && plan.vendor_id == other.description.vendor_id &&
         plan.product_code == other.description.product_code;
}

}  // namespace

void Master::drop_absent() {
  while (!slaves_.empty() && !slaves_.back().present) {
    slaves_.pop_back();
    refs_.pop_back();
  }
}

/// Adds a slave behind all found slaves, with the description of an identical slave if there is one.
void Master::add_absent(std::size_t number, SlavePlan plan) {
  const auto position = static_cast<std::uint16_t>(slaves_.size());
  ConfiguredSlave slave;
  slave.present = false;
  const auto model = std::find_if(slaves_.begin(), slaves_.end(),
                                  [&plan](const ConfiguredSlave& other) { return alike(plan, other.info); });
  slave.info.description = model == slaves_.end() ? unseen(plan) : model->info.description;
  slave.info.ref = {position, static_cast<std::uint16_t>(kFirstStationAddress + position)};
  slave.plan = std::move(plan);
  apply_description(slave);
  refs_.push_back(slave.info.ref);
  slaves_.push_back(std::move(slave));
  comparison_.plan_of_slave.emplace_back(number);
}

std::vector<SlaveRef> Master::reachable() const {
  std::vector<SlaveRef> refs;
  for (const auto& slave : slaves_) {
    if (slave.present) refs.push_back(slave.info.ref);
  }
  return refs;
}

}  // namespace driveline::ecat_master
