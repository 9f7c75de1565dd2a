// The path of a frame through lines, branches and rings (ESC data sheet I, frame processing order).
#include "driveline/slaves/line/frame_path.hpp"

#include <gmock/gmock.h>

namespace driveline::slaves {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

/// All loops as set by auto control when every cable works.
std::vector<SlavePorts> ports_of(const Wiring& wiring, SlaveDelays delays = {500ns, 300ns}) {
  std::vector<SlavePorts> ports(wiring.slave_count());
  for (std::size_t i = 0; i < ports.size(); ++i) {
    ports[i].delays = delays;
    for (unsigned p = 0; p < kPortCount; ++p) {
      const auto& end = wiring.at({i, p});
      ports[i].closed[p] = end.kind == Wiring::End::Kind::kNothing || end.broken;
    }
  }
  return ports;
}

std::vector<std::size_t> order(const FramePath& path) {
  std::vector<std::size_t> slaves;
  for (const auto& step : path.steps()) slaves.push_back(step.slave);
  return slaves;
}

TEST(FramePathTest, PlainLineThereAndBack) {
  const auto wiring = Wiring::line(3, 10ns);
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U, 1U, 2U));
  ASSERT_TRUE(path.exit());
  EXPECT_EQ(*path.exit(), MasterPort::kPrimary);
  EXPECT_EQ(path.steps()[0].time, 10ns);
  EXPECT_EQ(path.steps()[1].time, 10ns + 510ns);
  EXPECT_EQ(path.steps()[2].time, 10ns + 2 * 510ns);
  // Back: slave 1 and slave 0 are passed from port 1 to port 0 without processing.
  EXPECT_EQ(path.received(1)[1], 10ns + 3 * 510ns);
  EXPECT_EQ(path.received(0)[1], 10ns + 3 * 510ns + 310ns);
  EXPECT_EQ(path.received(2)[1], FramePath::kNotReceived);
  EXPECT_EQ(path.delay(), 10ns + 3 * 510ns + 2 * 310ns);
  for (const auto& step : path.steps()) EXPECT_FALSE(step.circulates);
}

TEST(FramePathTest, BranchesInTheOrderOfPorts3Then1Then2) {
  Wiring wiring(4);
  wiring.connect_master(MasterPort::kPrimary, {0, 0});
  ASSERT_TRUE(wiring.connect({0, 1}, {1, 0}));
  ASSERT_TRUE(wiring.connect({0, 2}, {2, 0}));
  ASSERT_TRUE(wiring.connect({0, 3}, {3, 0}));
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U, 3U, 1U, 2U));
  EXPECT_LT(path.received(0)[3], path.received(0)[1]);
  EXPECT_LT(path.received(0)[1], path.received(0)[2]);
  EXPECT_TRUE(path.exit());
}

TEST(FramePathTest, NestedBranch) {
  // 0 - 1 - 2, and 3 - 4 are on port 3 of slave 1.
  Wiring wiring(5);
  wiring.connect_master(MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 1}, {1, 0});
  wiring.connect({1, 1}, {2, 0});
  wiring.connect({1, 3}, {3, 0});
  wiring.connect({3, 1}, {4, 0});
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U, 1U, 3U, 4U, 2U));
}

TEST(FramePathTest, WholeRingComesOutAtTheOtherEnd) {
  const auto wiring = Wiring::ring(3);
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U, 1U, 2U));
  EXPECT_EQ(path.exit(), MasterPort::kSecondary);
  path.trace(wiring, ports_of(wiring), MasterPort::kSecondary);
  EXPECT_TRUE(path.steps().empty()) << "against the processing direction nothing is processed";
  EXPECT_EQ(path.exit(), MasterPort::kPrimary);
}

TEST(FramePathTest, BrokenRingIsTwoLines) {
  auto wiring = Wiring::ring(4);
  wiring.break_cable({1, 1});
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U, 1U));
  EXPECT_EQ(path.exit(), MasterPort::kPrimary);
  path.trace(wiring, ports_of(wiring), MasterPort::kSecondary);
  EXPECT_THAT(order(path), ElementsAre(2U, 3U)) << "processed on the way back from slave 2";
  EXPECT_EQ(path.exit(), MasterPort::kSecondary);
  EXPECT_TRUE(path.steps()[0].circulates) << "slave 2 turns the frame round at its closed port 0";
  EXPECT_FALSE(path.steps()[1].circulates);
}

TEST(FramePathTest, OpenLoopWithoutACableLosesTheFrame) {
  const auto wiring = Wiring::line(2);
  auto ports = ports_of(wiring);
  ports[1].closed[1] = false;
  FramePath path;
  path.trace(wiring, ports, MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U, 1U));
  EXPECT_FALSE(path.exit());
}

TEST(FramePathTest, ClosedPortDestroysWhatComesIn) {
  const auto wiring = Wiring::line(2);
  auto ports = ports_of(wiring);
  ports[1].closed[0] = true;
  FramePath path;
  path.trace(wiring, ports, MasterPort::kPrimary);
  EXPECT_THAT(order(path), ElementsAre(0U));
  EXPECT_FALSE(path.exit());
  EXPECT_EQ(path.blocked(), (PortId{1, 0}));
}

TEST(FramePathTest, WiringWithoutAnEndIsNotFollowedForever) {
  // Slaves 1, 2 and 3 in a circle that the frame can enter but never leave: port 0 of slave 1 leads forward, not back.
  Wiring wiring(3);
  wiring.connect_master(MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 1}, {1, 1});
  wiring.connect({1, 2}, {2, 1});
  wiring.connect({2, 2}, {1, 0});
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_LE(path.steps().size(), wiring.slave_count() * kPortCount);
}

TEST(FramePathTest, NoMasterNoPath) {
  const Wiring wiring(2);
  FramePath path;
  path.trace(wiring, ports_of(wiring), MasterPort::kPrimary);
  EXPECT_TRUE(path.steps().empty());
  EXPECT_FALSE(path.exit());
}

TEST(WiringTest, RefusesWhatCannotBePluggedIn) {
  Wiring wiring(2);
  EXPECT_TRUE(wiring.connect({0, 1}, {1, 0}));
  EXPECT_FALSE(wiring.connect({0, 1}, {1, 2})) << "taken";
  EXPECT_FALSE(wiring.connect({1, 1}, {1, 1})) << "to itself";
  EXPECT_FALSE(wiring.connect({0, 4}, {1, 1})) << "no such port";
  EXPECT_FALSE(wiring.connect({0, 2}, {2, 0})) << "no such slave";
  EXPECT_TRUE(wiring.connect_master(MasterPort::kPrimary, {0, 0}));
  EXPECT_FALSE(wiring.connect_master(MasterPort::kPrimary, {1, 1}));
  EXPECT_FALSE(wiring.connect_master(MasterPort::kSecondary, {1, 0}));
  EXPECT_FALSE(wiring.break_cable({1, 3}));
  EXPECT_TRUE(wiring.break_cable({1, 0}));
  EXPECT_TRUE(wiring.at({0, 1}).broken) << "both ends of the cable";
  EXPECT_TRUE(wiring.break_cable({0, 1}, false));
  EXPECT_FALSE(wiring.at({1, 0}).broken);
}

}  // namespace
}  // namespace driveline::slaves
