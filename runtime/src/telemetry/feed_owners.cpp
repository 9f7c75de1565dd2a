#include "telemetry/feed_owners.hpp"

namespace driveline::runtime {

bool set_feed_owners(const std::vector<std::string>& owners, snapshot::FeedCondition& condition) {
  bool changed = condition.owners.size() != owners.size();
  condition.owners.resize(owners.size());
  for (std::size_t i = 0; i < owners.size(); ++i) {
    snapshot::FeedOwner told;
    told.name.set(owners[i]);
    changed = changed || told.name.bytes != condition.owners[i].name.bytes;
    condition.owners[i] = told;
  }
  return changed;
}

}  // namespace driveline::runtime
