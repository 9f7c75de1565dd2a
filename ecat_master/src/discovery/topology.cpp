#include "driveline/ecat_master/discovery/topology.hpp"

#include <algorithm>

namespace driveline::ecat_master {
namespace {

/// Frames leave a controller at the next open port after the one where they arrived.
constexpr std::array<std::uint8_t, kSlavePorts> kNextPort = {3, 2, 0, 1};

struct Slave {
  std::uint8_t entry = 0;
  /// Open ports except the entry, in the order in which a frame leaves by them; `before` the processing unit, then
  /// `behind`.
  std::vector<std::uint8_t> before;
  std::vector<std::uint8_t> behind;
  std::uint32_t span_ns = 0;                         ///< time from the first to the last port
  std::array<std::uint32_t, kSlavePorts> stay_ns{};  ///< time from leaving by a port to returning there, cable included
};

/// The port that the frame reached first; the other times are within half the range of the 32-bit clock after it.
std::uint8_t first_port(const SlavePortFacts& facts) {
  std::uint8_t first = 0;
  while (first < kSlavePorts && !facts.open[first]) ++first;
  if (first == kSlavePorts) return 0;
  for (std::uint8_t port = 0; port < kSlavePorts; ++port) {
    const auto ahead = static_cast<std::int32_t>(facts.receive_time_ns[first] - facts.receive_time_ns[port]);
    if (facts.open[port] && ahead > 0) first = port;
  }
  return first;
}

Slave sort_ports(const SlavePortFacts& facts, bool trust_times) {
  Slave slave;
  const bool times = trust_times && facts.receive_times_valid;
  slave.entry = times ? first_port(facts) : std::uint8_t{0};
  bool behind = slave.entry == 0;
  std::uint32_t left_ns = 0;
  for (auto port = kNextPort[slave.entry]; port != slave.entry; port = kNextPort[port]) {
    if (facts.open[port]) (behind ? slave.behind : slave.before).push_back(port);
    // A frame that returns at port 0 passes the processing unit.
    behind = behind || port == 0;
    if (!facts.open[port] || !times) continue;
    slave.span_ns = facts.receive_time_ns[port] - facts.receive_time_ns[slave.entry];
    slave.stay_ns[port] = slave.span_ns - left_ns;
    left_ns = slave.span_ns;
  }
  return slave;
}

/// Splits the sequence of slaves into nested subtrees.
class TreeBuilder {
 public:
  TreeBuilder(std::span<const Slave> slaves, Topology& topology) : slaves_(slaves), topology_(topology) {}

  /// For slaves that are all entered at port 0: the sequence is the pre-order of the tree. Returns the ports that lead
  /// to no slave, the outermost last.
  [[nodiscard]] std::vector<PortRef> build_plain() {
    std::vector<PortRef> open;
    const auto count = static_cast<std::uint16_t>(slaves_.size());
    for (std::uint16_t i = 0; i < count; ++i) {
      if (i > 0) {
        if (open.empty()) return {PortRef{i, 0}, PortRef{i, 0}};
        attach(open.back(), i);
        open.pop_back();
      }
      const auto& ports = slaves_[i].behind;
      for (auto port = ports.rbegin(); port != ports.rend(); ++port) open.push_back({i, *port});
    }
    return open;
  }

  /// For swapped slaves: the root of a sequence is the slave with the longest span, and the parts before and behind it
  /// must be split into as many subtrees as it has ports on either side. Returns the root.
  [[nodiscard]] std::optional<std::uint16_t> build(std::size_t begin, std::size_t end) {
    if (begin == end) return std::nullopt;
    const auto root = longest(begin, end);
    if (!split(root, slaves_[root].before, begin, root) || !split(root, slaves_[root].behind, root + 1, end))
      return std::nullopt;
    return static_cast<std::uint16_t>(root);
  }

 private:
  /// Slaves minus open downstream ports, summed over a sequence: 1 for every sequence that can be one subtree.
  [[nodiscard]] std::ptrdiff_t surplus(std::size_t i) const {
    return 1 - static_cast<std::ptrdiff_t>(slaves_[i].before.size() + slaves_[i].behind.size());
  }

  [[nodiscard]] std::size_t longest(std::size_t begin, std::size_t end) const {
    auto root = begin;
    for (auto i = begin; i < end; ++i) {
      if (slaves_[i].span_ns > slaves_[root].span_ns) root = i;
    }
    return root;
  }

  /// Splits a sequence into one subtree per port. Where several cuts are possible, the correct one has a root whose
  /// span equals the time for which the frame was away from the port, minus the cable.
  [[nodiscard]] bool split(std::size_t root, std::span<const std::uint8_t> ports, std::size_t begin, std::size_t end) {
    if (ports.empty()) return begin == end;
    const auto stay = slaves_[root].stay_ns[ports.front()];
    std::vector<std::pair<std::uint32_t, std::size_t>> cuts;  // remainder of the stay, end of the subtree
    std::ptrdiff_t sum = 0;
    for (auto cut = begin; cut < end; ++cut) {
      sum += surplus(cut);
      if (sum != 1 || (ports.size() == 1 && cut + 1 != end)) continue;
      const auto span = slaves_[longest(begin, cut + 1)].span_ns;
      if (stay == 0 || span < stay) cuts.emplace_back(stay - std::min(span, stay), cut + 1);
    }
    std::sort(cuts.begin(), cuts.end());
    for (const auto& [left, cut] : cuts) {
      const auto child = build(begin, cut);
      if (!child || !split(root, ports.subspan(1), cut, end)) continue;
      attach({static_cast<std::uint16_t>(root), ports.front()}, *child);
      return true;
    }
    return false;
  }

  void attach(PortRef parent, std::uint16_t child) {
    topology_.slaves[parent.slave].children[parent.port] = child;
    topology_.slaves[child].parent = parent;
  }

  std::span<const Slave> slaves_;
  Topology& topology_;
};

Error topology_error(std::uint16_t slave, const SlavePortFacts& port_facts) {
  const auto open = std::count(port_facts.open.begin(), port_facts.open.end(), true);
  return {facts::PortsFitNoTree{static_cast<std::uint32_t>(open)}, slave};
}

Error silent(std::size_t slave, std::uint16_t working_counter) {
  return {facts::WorkingCounter{.address = wire::reg::kDlStatus.address, .received = working_counter},
          static_cast<std::uint16_t>(slave)};
}

/// Where a slave is swapped, parents may come after their children, so walk down from the root.
void number_depths(Topology& topology, std::uint16_t root) {
  std::vector<std::uint16_t> waiting{root};
  while (!waiting.empty()) {
    const auto slave = waiting.back();
    waiting.pop_back();
    for (const auto& child : topology.slaves[slave].children) {
      if (!child) continue;
      topology.slaves[*child].depth = static_cast<std::uint16_t>(topology.slaves[slave].depth + 1);
      waiting.push_back(*child);
    }
  }
}

}  // namespace

std::optional<std::uint16_t> Topology::first() const noexcept {
  const auto found = std::find_if(slaves.begin(), slaves.end(), [](const TopologyNode& n) { return !n.parent; });
  if (found == slaves.end()) return std::nullopt;
  return static_cast<std::uint16_t>(found - slaves.begin());
}

std::vector<std::uint16_t> Topology::swapped() const {
  std::vector<std::uint16_t> list;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (slaves[i].entry_port != 0) list.push_back(static_cast<std::uint16_t>(i));
  }
  return list;
}

Result<Topology> build_topology(std::span<const SlavePortFacts> facts) {
  Topology topology;
  topology.slaves.resize(facts.size());
  if (facts.empty()) return topology;
  std::size_t open_ports = 0;
  for (const auto& slave : facts) {
    open_ports += static_cast<std::size_t>(std::count(slave.open.begin(), slave.open.end(), true));
  }
  // Each slave has one port towards the master; a closed ring has one more, through which a frame of the primary
  // interface leaves permanently: the receive times of ports on the way back then belong to another frame.
  const bool ring = open_ports == 2 * facts.size();
  std::vector<Slave> slaves;
  for (const auto& slave : facts) slaves.push_back(sort_ports(slave, !ring));
  TreeBuilder builder(slaves, topology);
  const bool plain = std::all_of(slaves.begin(), slaves.end(), [](const Slave& s) { return s.entry == 0; });
  std::uint16_t root = 0;
  if (plain) {
    const auto left = builder.build_plain();
    if (left.size() > 1 || (left.size() == 1 && left[0].slave >= facts.size())) {
      return tl::unexpected(topology_error(left.back().slave, facts[left.back().slave]));
    }
    if (left.size() == 1) topology.ring_end = left[0];
  } else {
    const auto found = builder.build(0, slaves.size());
    if (!found) {
      const auto swapped = std::find_if(slaves.begin(), slaves.end(), [](const Slave& s) { return s.entry != 0; });
      const auto position = static_cast<std::uint16_t>(swapped - slaves.begin());
      return tl::unexpected(topology_error(position, facts[position]));
    }
    root = *found;
    // Clears the results of failed attempts.
    topology.slaves[root].parent.reset();
  }
  for (std::size_t i = 0; i < facts.size(); ++i) {
    topology.slaves[i].entry_port = slaves[i].entry;
    topology.slaves[i].span_ns = slaves[i].span_ns;
    for (std::uint8_t port = 0; port < kSlavePorts; ++port) {
      if (facts[i].link[port] && !facts[i].open[port])
        topology.silent_ports.push_back({static_cast<std::uint16_t>(i), port});
    }
  }
  number_depths(topology, root);
  return topology;
}

namespace {

Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::size_t count, auto&& request_of) {
  // ESC feature register, bit 2: distributed clocks, which include the receive times (ETG.1000.4 Table 31).
  constexpr std::uint16_t kFeatureDistributedClocks = 0x0004;
  // Any write to the first receive time latches all of them (ETG.1000.4 Table 60).
  const std::array<std::byte, 4> latch{};
  if (auto done = bus.broadcast_write(wire::reg::kReceiveTimePort.at(0), latch); !done)
    return tl::unexpected(done.error());

  struct PortAnswers {
    std::array<std::byte, 2> features{};
    std::array<std::byte, 2> dl_status{};
    std::array<std::byte, 4 * kSlavePorts> times{};
  };
  std::vector<PortAnswers> answers(count);
  std::vector<Request> requests;
  for (std::size_t i = 0; i < count; ++i) {
    requests.push_back(request_of(i, wire::reg::kFeatures.address, answers[i].features));
    requests.push_back(request_of(i, wire::reg::kDlStatus.address, answers[i].dl_status));
    requests.push_back(request_of(i, wire::reg::kReceiveTimePort.at(0), answers[i].times));
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());

  std::vector<SlavePortFacts> facts(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (requests[3 * i + 1].working_counter != 1) {
      return tl::unexpected(silent(i, requests[3 * i + 1].working_counter));
    }
    const auto status = wire::DlStatus::from_raw(bytes::load_le<std::uint16_t>(answers[i].dl_status));
    const auto features = bytes::load_le<std::uint16_t>(answers[i].features);
    facts[i].receive_times_valid =
        requests[3 * i + 2].working_counter == 1 && (features & kFeatureDistributedClocks) != 0;
    for (std::size_t port = 0; port < kSlavePorts; ++port) {
      facts[i].link[port] = status.ports[port].link;
      facts[i].open[port] = !status.ports[port].loop_closed && status.ports[port].communication;
      facts[i].receive_time_ns[port] = bytes::load_le<std::uint32_t>(std::span(answers[i].times).subspan(4 * port));
    }
  }
  return facts;
}

}  // namespace

Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::span<const SlaveRef> slaves) {
  auto facts = read_port_facts(
      bus, slaves.size(), [slaves](std::size_t i, std::uint16_t address, std::span<std::byte> data) -> Request {
        return {wire::Command::kFprd, wire::DatagramAddress::physical(slaves[i].station, address), data, 0, false};
      });
  if (!facts && facts.error().is<facts::WorkingCounter>()) facts.error().slave = slaves[facts.error().slave].position;
  return facts;
}

Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::uint16_t count) {
  return read_port_facts(bus, count, [](std::size_t i, std::uint16_t address, std::span<std::byte> data) -> Request {
    const auto position = static_cast<std::uint16_t>(i);
    return {wire::Command::kAprd, wire::DatagramAddress::position(position, address), data, 0, false};
  });
}

}  // namespace driveline::ecat_master
