#include "fake_node.hpp"

namespace driveline::canopen {
namespace {

using Kind = MasterEvent::Kind;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

/// Three nodes in operation, at the beginning of each test.
class NodeSupervisorTest : public FakeLine {
 protected:
  NodeSupervisorTest() {
    plan.nodes.push_back(drive(11));
    plan.nodes.push_back(drive(12));
  }
  [[nodiscard]] FakeNode& node(std::size_t number) { return bus.nodes[number]; }
  [[nodiscard]] bool others_run() const { return line->node(0).operational() && line->node(2).operational(); }
  [[nodiscard]] std::size_t count(const std::string& frame) const {
    return static_cast<std::size_t>(std::count(bus.sent.begin(), bus.sent.end(), frame));
  }
};

TEST_F(NodeSupervisorTest, ALostNodeIsToldAfterItsToleranceAndComesBackByItself) {
  operate();
  bus.power(node(1), false);
  const auto begin = clock.now();
  pass(150ms);
  EXPECT_THAT(events, IsEmpty()) << "one heartbeat may be missing";
  pass(300ms);
  ASSERT_THAT(kinds(), ElementsAre(Kind::kNodeLost));
  EXPECT_EQ(events[0].node, 1U);
  EXPECT_EQ(events[0].id, 11);
  EXPECT_EQ(events[0].waited_ms, 250U);
  EXPECT_LE(events[0].time - begin, 260ms);
  EXPECT_EQ(view(1).phase, NodePhase::kLost);
  EXPECT_TRUE(others_run());
  bus.power(node(1), true);
  pass(400ms);
  EXPECT_THAT(kinds(), ElementsAre(Kind::kNodeLost, Kind::kNodeRebooted, Kind::kNodeBack));
  EXPECT_EQ(view(1).phase, NodePhase::kOperational);
  EXPECT_EQ(view(1).recoveries, 1U);
  EXPECT_EQ(node(1).state, 5U);
  EXPECT_EQ(node(1).value(0x1017, 0), 100U) << "configured anew";
  EXPECT_TRUE(others_run());
  EXPECT_EQ(count("000#820A") + count("000#820C") + count("000#800A") + count("000#800C"), 0U);
}

TEST_F(NodeSupervisorTest, ANodeWhoseBootUpMessageIsLostIsFoundByAsking) {
  operate();
  bus.power(node(1), false);
  pass(300ms);
  node(1).boots = false;
  bus.power(node(1), true);
  pass(1s);
  EXPECT_THAT(kinds(), ElementsAre(Kind::kNodeLost, Kind::kNodeBack));
}

TEST_F(NodeSupervisorTest, APowerCycleThatIsShorterThanTheToleranceIsSeenByTheBootUpMessage) {
  operate();
  bus.power(node(1), false);
  pass(20ms);
  bus.power(node(1), true);
  pass(400ms);
  EXPECT_THAT(kinds(), ElementsAre(Kind::kNodeRebooted, Kind::kNodeBack));
  EXPECT_TRUE(others_run());
}

TEST_F(NodeSupervisorTest, AnotherDeviceInThePlaceOfALostOneIsNotStarted) {
  plan.nodes[1].serial_number = 0x407;
  operate();
  bus.power(node(1), false);
  pass(300ms);
  node(1).set(0x1018, 4, 0x408, 4);
  bus.power(node(1), true);
  pass(3s);
  ASSERT_THAT(kinds(), ElementsAre(Kind::kNodeLost, Kind::kNodeRebooted, Kind::kRecoveryFailed)) << "told once";
  EXPECT_EQ(events[2].error.kind, NodeErrorKind::kOtherDevice);
  EXPECT_EQ(view(1).phase, NodePhase::kFailed);
  EXPECT_NE(node(1).state, 5U);
  node(1).set(0x1018, 4, 0x407, 4);
  pass(1s);
  EXPECT_EQ(kinds().back(), Kind::kNodeBack) << "and is tried again";
}

TEST_F(NodeSupervisorTest, ANodeThatLeavesOperationalIsComparedAndStartedAgain) {
  operate();
  node(1).state = 127;
  node(1).writes.clear();
  pass(500ms);
  ASSERT_THAT(kinds(), ElementsAre(Kind::kWrongState, Kind::kNodeBack));
  EXPECT_EQ(events[0].state, NmtState::kPreOperational);
  EXPECT_THAT(node(1).writes, IsEmpty()) << "it had kept its configuration";
  EXPECT_EQ(node(1).state, 5U);
  events.clear();
  node(1).state = 4;
  pass(500ms);
  ASSERT_THAT(kinds(), ElementsAre(Kind::kWrongState, Kind::kNodeBack));
  EXPECT_EQ(events[0].state, NmtState::kStopped);
  EXPECT_TRUE(others_run());
}

TEST_F(NodeSupervisorTest, ANodeThatDoesNotStartIsAnError) {
  ASSERT_THAT(boot(), IsEmpty());
  node(1).deaf = true;
  line->watch(clock.now());
  line->start(clock.now());
  pass(350ms);
  EXPECT_EQ(view(1).phase, NodePhase::kFailed);
  ASSERT_TRUE(view(1).error);
  EXPECT_EQ(view(1).error->kind, NodeErrorKind::kWrongState);
  EXPECT_EQ(view(1).error->wanted_state, NmtState::kOperational);
  EXPECT_TRUE(others_run());
}

TEST_F(NodeSupervisorTest, AStartCommandThatIsLostIsRepeated) {
  ASSERT_THAT(boot(), IsEmpty());
  line->watch(clock.now());
  bus.lose_next = 3;
  line->start(clock.now());
  pass(290ms);
  EXPECT_TRUE(line->all([](auto& one) { return one.operational(); }));
}

TEST_F(NodeSupervisorTest, EmergenciesAreToldAndChangeNothing) {
  operate();
  bus.arrives(clock.now() + 3ms, "08B#1023050A0B0C0D0E");
  bus.arrives(clock.now() + 9ms, "08B#0000000000000000");
  bus.arrives(clock.now() + 12ms, "08B#00000100");  // no EMCY
  pass(100ms);
  ASSERT_THAT(kinds(), ElementsAre(Kind::kEmergency, Kind::kErrorReset));
  EXPECT_EQ(events[0].emergency.code, 0x2310);
  EXPECT_EQ(
      describe(events[0], "x"),
      "node 11 (x): emergency 0x2310, continuous overcurrent; error register 0x05, manufacturer bytes 0A 0B 0C 0D "
      "0E");
  EXPECT_EQ(describe(events[1], "x"), "node 11 (x): error reset; error register 0x00");
  EXPECT_EQ(view(1).emergencies, 1U);
  EXPECT_TRUE(line->all([](auto& one) { return one.operational(); }));
  EXPECT_THAT(bus.sent, IsEmpty()) << "no EMCY message changes a state";
}

TEST_F(NodeSupervisorTest, TheAxesOfOthersDoNotWaitForANodeThatIsSilentInTheMiddleOfItsBoot) {
  operate();
  node(1).mute = true;
  bus.power(node(1), false);
  pass(20ms);
  bus.power(node(1), true);
  pass(300ms);
  EXPECT_EQ(view(1).phase, NodePhase::kLost);
  EXPECT_TRUE(others_run());
  node(1).mute = false;
  pass(700ms);
  EXPECT_TRUE(line->node(1).operational());
}

TEST_F(NodeSupervisorTest, GuardingAsksByRemoteFramesAndChecksTheToggleBit) {
  auto& control = plan.nodes[1].error_control;
  control = {};
  control.guard_time = 50ms;
  control.life_time_factor = 3;
  operate();
  pass(500ms);
  EXPECT_NEAR(static_cast<double>(count("70B#R1")), 10.0, 1.0);
  EXPECT_THAT(events, IsEmpty());
  node(1).keeps_toggle = true;
  pass(110ms);
  EXPECT_THAT(kinds(), AllOf(Contains(Kind::kGuardToggle), Not(Contains(Kind::kNodeLost))));
  EXPECT_TRUE(line->node(1).operational());
  node(1).keeps_toggle = false;
  pass(200ms);
  events.clear();
  node(1).guards = false;
  pass(240ms);
  ASSERT_THAT(kinds(), ElementsAre(Kind::kNodeLost));
  EXPECT_EQ(events[0].waited_ms, 150U);
}

TEST_F(NodeSupervisorTest, TheToggleBitBeginsAnewWithTheNode) {
  plan.nodes[1].error_control = {};
  plan.nodes[1].error_control.guard_time = 50ms;
  operate();
  for (int i = 0; i < 4; ++i) {
    bus.power(node(1), false);
    pass(10ms + 50ms * (i % 2));
    bus.power(node(1), true);
    pass(400ms);
  }
  EXPECT_THAT(kinds(), Not(Contains(Kind::kGuardToggle)));
  EXPECT_TRUE(line->node(1).operational());
}

TEST_F(NodeSupervisorTest, TwoDevicesWithOneNodeIdAreSuspected) {
  operate();
  node(1).answers = 2;
  node(1).state = 127;
  pass(300ms);
  const auto all = kinds();
  EXPECT_EQ(std::count(all.begin(), all.end(), Kind::kDoubleAnswers), 1);
}

TEST_F(NodeSupervisorTest, AnswersToAnotherClientAreNoSecondDevice) {
  operate();
  for (int i = 0; i < 10; ++i) {
    bus.arrives(clock.now() + i * 10ms, "60B#4000100000000000");
    bus.arrives(clock.now() + i * 10ms + 1ms, "58B#4300100092010200");
  }
  pass(200ms);
  EXPECT_THAT(events, IsEmpty());
}

TEST_F(NodeSupervisorTest, AnOptionalNodeMayBeMissingAndJoins) {
  plan.nodes[1].optional = true;
  bus.add(10);
  bus.add(11).there = false;
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_TRUE(line->node(1).excused());
  line->watch(clock.now());
  line->start(clock.now());
  pass(300ms);
  EXPECT_TRUE(others_run());
  EXPECT_FALSE(line->node(1).operational());
  events.clear();
  bus.power(node(1), true);
  pass(500ms);
  EXPECT_THAT(kinds(), ElementsAre(Kind::kNodeJoined));
  EXPECT_TRUE(line->node(1).operational());
}

TEST_F(NodeSupervisorTest, WithoutRecoveryALostNodeStaysLost) {
  operate();
  line.emplace(plan, SupervisorSettings{false, 100ms});
  line->boot(clock.now());
  pass(300ms);
  line->watch(clock.now());
  line->start(clock.now());
  pass(200ms);
  events.clear();
  bus.power(node(1), false);
  pass(300ms);
  bus.power(node(1), true);
  pass(1s);
  EXPECT_THAT(kinds(), ElementsAre(Kind::kNodeLost, Kind::kNodeRebooted));
  EXPECT_EQ(view(1).phase, NodePhase::kLost);
}

TEST_F(NodeSupervisorTest, AReleasedNodeIsPreOperationalAndDoesNotMissTheMaster) {
  operate();
  line->release(clock.now());
  pass(50ms);
  EXPECT_TRUE(line->all([](auto& one) { return one.released() && !one.release_error(); }));
  for (auto& one : bus.nodes) {
    EXPECT_EQ(one.state, 127U);
    EXPECT_EQ(one.value(0x1016, 1), 0U);
  }
  bus.power(node(1), false);
  pass(1s);
  EXPECT_THAT(events, IsEmpty());
}

TEST_F(NodeSupervisorTest, AnOwnerThatStoodStillLosesNobody) {
  operate();
  clock.advance(200ms);  // heartbeats wait in the queue meanwhile, and the last one is old
  pass(300ms);
  EXPECT_THAT(events, IsEmpty());
}

TEST(NodeWatchTest, AMessageThatHasWaitedInAQueueShortensNoTime) {
  ErrorControlPlan control;
  control.heartbeat = 100ms;
  NodeWatch watch(control, 10);
  watch.begin(10s, false);
  EXPECT_TRUE(watch.receive({NmtState::kPreOperational}, 5s));
  EXPECT_FALSE(watch.missing(10s + 300ms));
  EXPECT_TRUE(watch.missing(10s + 301ms)) << "three times the heartbeat, where the plan has no tolerance";
}

TEST_F(NodeSupervisorTest, RequestsOfOthersGoBetweenTheStepsOfABoot) {
  operate();
  std::optional<std::vector<std::byte>> type;
  node(1).state = 127;
  pass(110ms);
  line->node(1).sdo().ask({0x1000, 0}, std::nullopt, [&](auto& result) { type = *result; });
  pass(5ms);
  ASSERT_TRUE(type);
  EXPECT_EQ(type->size(), 4U);
  pass(300ms);
  EXPECT_TRUE(line->node(1).operational());
}

}  // namespace
}  // namespace driveline::canopen
