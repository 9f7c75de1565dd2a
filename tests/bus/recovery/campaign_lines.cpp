#include "campaign_lines.hpp"

#include <algorithm>

namespace driveline::bus_test {
namespace {

using slaves::MasterPort;
using slaves::PortId;
using slaves::Wiring;

/// "parent:port" of slaves 1, 2, ...: their port 0 leads to the parent.
Wiring tree(std::initializer_list<PortId> parents) {
  Wiring wiring(parents.size() + 1);
  wiring.connect_master(MasterPort::kPrimary, {0, 0});
  std::size_t slave = 1;
  for (const auto parent : parents) wiring.connect(parent, {slave++, 0});
  return wiring;
}

/// Follows the wiring from a port; true: it reaches the other interface of the master.
bool walk(const Wiring& wiring, const Cuts& cuts, PortId at, std::set<std::size_t>& found) {
  bool other_interface = false;
  std::vector<PortId> waiting{at};
  while (!waiting.empty()) {
    const auto entry = waiting.back();
    waiting.pop_back();
    if (cuts.off.contains(entry.slave) || !found.insert(entry.slave).second) continue;
    for (unsigned port = 0; port < slaves::kPortCount; ++port) {
      const PortId here{entry.slave, port};
      const auto& end = wiring.at(here);
      const auto cut = [&](PortId cable) {
        return cable == here || (end.kind == Wiring::End::Kind::kSlave && cable == end.slave);
      };
      if (here == entry || std::any_of(cuts.broken.begin(), cuts.broken.end(), cut)) continue;
      if (end.kind == Wiring::End::Kind::kMaster) other_interface = true;
      if (end.kind == Wiring::End::Kind::kSlave) waiting.push_back(end.slave);
    }
  }
  return other_interface;
}

}  // namespace

std::vector<CampaignLine> campaign_lines() {
  return {
      {"line", Wiring::line(5)},
      {"star", tree({{0, 3}, {0, 1}, {0, 2}})},
      {"branch", tree({{0, 1}, {1, 3}, {2, 1}, {1, 1}, {4, 1}})},
      {"two stars", tree({{0, 3}, {1, 3}, {1, 1}, {0, 1}, {4, 3}, {4, 1}})},
      {"ring", Wiring::ring(5), true},
      {"branch with a hot-connected slave", tree({{0, 1}, {1, 3}, {1, 1}, {3, 1}}), false, {2}},
      {"star with two hot-connected slaves", tree({{0, 3}, {0, 1}, {0, 2}}), false, {1, 3}},
  };
}

Reached reached(const Wiring& wiring, const Cuts& cuts) {
  Reached result;
  const auto& primary = wiring.master(MasterPort::kPrimary);
  if (primary) result.closed = walk(wiring, cuts, *primary, result.slaves);
  result.primary = result.slaves.size();
  const auto& secondary = wiring.master(MasterPort::kSecondary);
  if (!secondary || result.closed) return result;
  std::set<std::size_t> behind;
  walk(wiring, cuts, *secondary, behind);
  result.secondary = behind.size();
  result.slaves.merge(behind);
  return result;
}

std::vector<PortId> cables(const Wiring& wiring) {
  std::vector<PortId> all;
  for (std::size_t slave = 0; slave < wiring.slave_count(); ++slave) {
    for (unsigned port = 0; port < slaves::kPortCount; ++port) {
      const auto& end = wiring.at({slave, port});
      if (end.kind == Wiring::End::Kind::kSlave && slave < end.slave.slave) all.push_back({slave, port});
    }
  }
  return all;
}

}  // namespace driveline::bus_test
