#include "driveline/ecat_master/discovery/topology.hpp"

#include <gmock/gmock.h>

#include <map>
#include <random>

#include "drive_line.hpp"
#include "fault_ports.hpp"
#include "support/must.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::build_topology;
using ecat_master::Master;
using ecat_master::PortRef;
using ecat_master::SlavePortFacts;
using ecat_master::Topology;
using slaves::MasterPort;
using slaves::PortId;
using slaves::Wiring;

/// The expected topology: for each slave (by its position on the line) the port of the parent that it is connected to.
struct Truth {
  std::map<std::uint16_t, std::optional<PortRef>> parents;
  std::map<std::uint16_t, std::uint8_t> entries;
};

/// Follows the wiring from the master. `position`: position on the line of each slave of the wiring.
Truth truth_of(const Wiring& wiring, const std::vector<std::uint16_t>& position) {
  Truth truth;
  const auto first = *wiring.master(MasterPort::kPrimary);
  std::vector<std::pair<PortId, std::optional<PortRef>>> waiting{{first, std::nullopt}};
  while (!waiting.empty()) {
    const auto [at, parent] = waiting.back();
    waiting.pop_back();
    truth.parents[position[at.slave]] = parent;
    truth.entries[position[at.slave]] = static_cast<std::uint8_t>(at.port);
    for (unsigned port = 0; port < slaves::kPortCount; ++port) {
      const auto& end = wiring.at({at.slave, port});
      if (port == at.port || end.kind != Wiring::End::Kind::kSlave) continue;
      waiting.push_back({end.slave, PortRef{position[at.slave], static_cast<std::uint8_t>(port)}});
    }
  }
  return truth;
}

/// Both interfaces of a ring as far as discovery needs them: sends at the first, receives at either.
class RingPort final : public PassingPort {
 public:
  explicit RingPort(slaves::SimulatedLine& line) : PassingPort(line), far_(line.secondary()) {}
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    auto frame = inner_.receive();
    return frame ? frame : far_.receive();
  }
  bool wait_readable(nanoseconds deadline) noexcept override { return far_.wait_readable(deadline); }

 private:
  port::Port& far_;
};

/// Scans the line and compares the topology found by the master with the wiring.
Topology expect_found(const Wiring& wiring) {
  const auto count = wiring.slave_count();
  slaves::LineOptions options;
  DriveLine drives(count, {}, options, wiring);
  RingPort ring(drives.line());
  port::Port& port = wiring.master(MasterPort::kSecondary) ? static_cast<port::Port&>(ring) : drives.line();
  Master master(port, drives.clock);
  EXPECT_EQ(sentence(master.scan()), "");
  const auto& found = master.topology();
  EXPECT_EQ(found.slaves.size(), count);
  if (found.slaves.size() != count) return {};
  std::vector<std::uint16_t> position;
  for (std::size_t i = 0; i < count; ++i) {
    const auto station = drives.slave(i).esc().memory().get(wire::reg::kStationAddress);
    position.push_back(static_cast<std::uint16_t>(station - ecat_master::kFirstStationAddress));
  }
  const auto truth = truth_of(wiring, position);
  for (std::uint16_t i = 0; i < count; ++i) {
    EXPECT_EQ(found.slaves[i].parent, truth.parents.at(i)) << "slave " << i;
    EXPECT_EQ(found.slaves[i].entry_port, truth.entries.at(i)) << "slave " << i;
  }
  return found;
}

constexpr nanoseconds kCable{50};

TEST(TopologyOnTheLine, OneSlave) {
  const auto found = expect_found(Wiring::line(1, kCable));
  EXPECT_EQ(found.first(), 0);
  EXPECT_FALSE(found.ring_end);
}

TEST(TopologyOnTheLine, PlainLine) {
  const auto found = expect_found(Wiring::line(20, kCable));
  EXPECT_EQ(found.slaves[19].depth, 19);
  EXPECT_TRUE(found.swapped().empty());
  EXPECT_GT(found.slaves[0].span_ns, found.slaves[18].span_ns);
  EXPECT_EQ(found.slaves[19].span_ns, 0U);
}

TEST(TopologyOnTheLine, Ring) {
  const auto found = expect_found(Wiring::ring(6, kCable));
  ASSERT_TRUE(found.ring_end);
  EXPECT_EQ(*found.ring_end, (PortRef{5, 1}));
}

Wiring star() {
  // A junction with a drive at each of its three ports, two more behind the drive at port 1.
  Wiring wiring(6);
  wiring.connect_master(MasterPort::kPrimary, {0, 0}, kCable);
  wiring.connect({0, 3}, {1, 0}, kCable);
  wiring.connect({0, 1}, {2, 0}, kCable);
  wiring.connect({0, 2}, {3, 0}, kCable);
  wiring.connect({2, 1}, {4, 0}, kCable);
  wiring.connect({4, 1}, {5, 0}, kCable);
  return wiring;
}

TEST(TopologyOnTheLine, Star) {
  const auto found = expect_found(star());
  // The frame visits port 3, then port 1 with its chain, then port 2.
  EXPECT_EQ(found.slaves[0].children[3], 1);
  EXPECT_EQ(found.slaves[0].children[1], 2);
  EXPECT_EQ(found.slaves[0].children[2], 5);
}

TEST(TopologyOnTheLine, InAndOutSwappedInTheMiddle) {
  Wiring wiring(4);
  wiring.connect_master(MasterPort::kPrimary, {0, 0}, kCable);
  wiring.connect({0, 1}, {1, 1}, kCable);  // plugged in at OUT
  wiring.connect({1, 0}, {2, 0}, kCable);
  wiring.connect({2, 1}, {3, 0}, kCable);
  const auto found = expect_found(wiring);
  // The swapped slave processes the frame on its way back, so it is the last of the line.
  EXPECT_THAT(found.swapped(), testing::ElementsAre(3));
}

TEST(TopologyOnTheLine, SwappedFirstOrSecondLookTheSameButForTheTimes) {
  for (const bool first : {false, true}) {
    Wiring wiring(3);
    wiring.connect_master(MasterPort::kPrimary, first ? PortId{2, 1} : PortId{0, 0}, kCable);
    wiring.connect(first ? PortId{2, 0} : PortId{0, 1}, first ? PortId{0, 0} : PortId{2, 1}, kCable);
    wiring.connect(first ? PortId{0, 1} : PortId{2, 0}, {1, 0}, kCable);
    expect_found(wiring);
  }
}

TEST(TopologyOnTheLine, SwappedLastSlave) {
  Wiring wiring(3);
  wiring.connect_master(MasterPort::kPrimary, {0, 0}, kCable);
  wiring.connect({0, 1}, {1, 0}, kCable);
  wiring.connect({1, 1}, {2, 1}, kCable);
  EXPECT_THAT(expect_found(wiring).swapped(), testing::ElementsAre(2));
}

/// A random tree; one slave in four is swapped, and then has a slave at its port 0.
Wiring random_tree(std::mt19937& random, std::size_t count) {
  Wiring wiring(count);
  wiring.connect_master(MasterPort::kPrimary, {0, 0}, kCable);
  std::vector<PortId> free{{0, 1}, {0, 2}, {0, 3}};
  auto delay = [&random] { return nanoseconds{static_cast<int>(random() % 500)}; };
  for (std::size_t slave = 1; slave < count; ++slave) {
    const auto pick = random() % free.size();
    const auto at = free[pick];
    free.erase(free.begin() + static_cast<std::ptrdiff_t>(pick));
    const bool swapped = slave + 1 < count && random() % 4 == 0;
    const unsigned entry = swapped ? 1 + static_cast<unsigned>(random() % 3) : 0U;
    wiring.connect(at, {slave, entry}, delay());
    for (unsigned port = 1; port < slaves::kPortCount; ++port) {
      if (port != entry) free.push_back({slave, port});
    }
    if (!swapped) continue;
    wiring.connect({slave, 0}, {slave + 1, 0}, delay());
    ++slave;
    for (unsigned port = 1; port < slaves::kPortCount; ++port) free.push_back({slave, port});
  }
  return wiring;
}

TEST(TopologyOnTheLine, RandomTreesWithSwappedSlaves) {
  std::mt19937 random(20'240'611);
  for (int i = 0; i < 200 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    expect_found(random_tree(random, 2 + random() % 14));
  }
}

TEST(TopologyOnTheLine, SurvivesLostFrames) {
  DriveLine drives(5);
  Master master(drives.line(), drives.clock);
  drives.line().drop_frames(2);
  ASSERT_EQ(sentence(master.scan()), "");
  EXPECT_EQ(master.topology().slaves[4].parent, (PortRef{3, 1}));
}

SlavePortFacts facts(std::initializer_list<unsigned> open) {
  SlavePortFacts slave;
  for (const auto port : open) slave.open[port] = slave.link[port] = true;
  return slave;
}

TEST(TopologyOfFacts, WithoutReceiveTimesTheOrderIsEnough) {
  const std::vector<SlavePortFacts> line{facts({0, 1, 2, 3}), facts({0}), facts({0, 1}), facts({0}), facts({0})};
  const auto found = must(build_topology(line));
  EXPECT_EQ(found->slaves[1].parent, (PortRef{0, 3}));
  EXPECT_EQ(found->slaves[2].parent, (PortRef{0, 1}));
  EXPECT_EQ(found->slaves[3].parent, (PortRef{2, 1}));
  EXPECT_EQ(found->slaves[4].parent, (PortRef{0, 2}));
}

TEST(TopologyOfFacts, ClocksThatComeRoundChangeNothing) {
  std::vector<SlavePortFacts> line{facts({0, 1}), facts({0})};
  line[0].receive_times_valid = line[1].receive_times_valid = true;
  line[0].receive_time_ns = {0xFFFF'FFF0U, 0x10U, 0, 0};
  const auto found = must(build_topology(line));
  EXPECT_EQ(found->slaves[0].entry_port, 0);
  EXPECT_EQ(found->slaves[0].span_ns, 0x20U);
}

TEST(TopologyOfFacts, TooManyOpenPortsAreAnErrorWithTheSlave) {
  // Two ports lead nowhere, which is neither a tree nor a ring.
  const std::vector<SlavePortFacts> line{facts({0, 1, 3}), facts({0, 1})};
  EXPECT_EQ(sentence(build_topology(line)),
            "slave 1: its 2 open ports do not match any tree of the slaves that answer");
}

TEST(TopologyOfFacts, TooFewOpenPortsAreAnErrorWithTheSlave) {
  const std::vector<SlavePortFacts> line{facts({0}), facts({0})};
  EXPECT_EQ(sentence(build_topology(line)),
            "slave 1: its 1 open ports do not match any tree of the slaves that answer");
}

TEST(TopologyOfFacts, NoSlavesNoTree) {
  const auto found = must(build_topology({}));
  EXPECT_FALSE(found->first());
  EXPECT_EQ(to_tree_text(*found, {}), "master\n");
}

TEST(TopologyText, DrawsChainsAndBranches) {
  std::vector<SlavePortFacts> line{facts({0, 1, 2, 3}), facts({0}), facts({0, 1}), facts({0}), facts({0})};
  line[4].link[1] = true;
  const auto found = must(build_topology(line));
  const std::vector<std::string> labels{"junction", "a", "b", "c", "d"};
  EXPECT_EQ(to_tree_text(*found, labels),
            "master\n"
            "  0  junction\n"
            "  ├─ port 3   1  a\n"
            "  ├─ port 1   2  b\n"
            "  │           3  c\n"
            "  └─ port 2   4  d  (link at port 1, no answer)\n");
}

TEST(TopologyText, GraphvizNamesThePortsOfEveryCable) {
  const std::vector<SlavePortFacts> line{facts({0, 1}), facts({0, 1})};
  const auto found = must(build_topology(line));
  const std::vector<std::string> labels{"the \"first\"", "last"};
  EXPECT_EQ(to_graphviz(*found, labels),
            "digraph line {\n"
            "  rankdir=LR;\n"
            "  node [shape=box];\n"
            "  master [shape=ellipse];\n"
            "  s0 [label=\"0 the \\\"first\\\"\"];\n"
            "  s1 [label=\"1 last\"];\n"
            "  master -> s0 [taillabel=\"\", headlabel=\"0\"];\n"
            "  s0 -> s1 [taillabel=\"1\", headlabel=\"0\"];\n"
            "  s1 -> master [taillabel=\"1\", style=dashed];\n"
            "}\n");
}

}  // namespace
}  // namespace driveline::bus_test
