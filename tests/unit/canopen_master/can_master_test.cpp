#include "simulated_line.hpp"

namespace driveline::canopen {
namespace {

using Kind = MasterEvent::Kind;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using CanMasterTest = SimulatedLine;

TEST_F(CanMasterTest, BootsStartsAndShutsDown) {
  make();
  std::vector<BootStep> steps;
  ASSERT_EQ(failure(master->boot([&](std::size_t node, BootStep step) {
              if (node == 1) steps.push_back(step);
            })),
            "");
  EXPECT_THAT(steps, ElementsAre(BootStep::kReset, BootStep::kDeviceType, BootStep::kIdentity, BootStep::kQuiet,
                                 BootStep::kStartupSdos, BootStep::kSync, BootStep::kPdos, BootStep::kErrorControl,
                                 BootStep::kConfigured));
  EXPECT_EQ(state(0), NmtState::kPreOperational);
  EXPECT_EQ(value(0, 0x1006), 2000U);
  EXPECT_EQ(value(0, 0x1016, 1), 0x007E'0064U);
  EXPECT_EQ(value(2, 0x1017), 50U);
  EXPECT_EQ(master->node(1).identity.serial_number, 104U);
  ASSERT_TRUE(start_cycle());
  ASSERT_EQ(failure(master->go_operational()), "");
  EXPECT_TRUE(master->all_operational());
  master->pass(500ms);
  for (std::size_t i = 0; i < drives.size(); ++i) {
    EXPECT_EQ(state(i), NmtState::kOperational) << i;
    const auto report = master->cycle()->node_report(i);
    EXPECT_TRUE(report.valid && report.heard) << i;
    EXPECT_EQ(report.lost, 0U) << i;
    EXPECT_GE(master->node(i).heartbeats, 9U) << i;
  }
  EXPECT_THAT(take_events(), IsEmpty());
  ASSERT_EQ(failure(master->shut_down()), "");
  EXPECT_FALSE(master->cycling());
  bus.advance(clock.now() + 3s);
  for (std::size_t i = 0; i < drives.size(); ++i) {
    EXPECT_EQ(state(i), NmtState::kPreOperational) << i;
    EXPECT_EQ(emergencies(plan.nodes[i].id), 0) << "a master that leaves is no fault";
  }
}

/// A TPDO of three bytes where six are mapped: told once, by its number.
TEST_F(CanMasterTest, ATpdoThatIsShorterThanItsMappingIsNamedOnce) {
  operate();
  for (const auto after : {11ms, 31ms}) {
    tool.send_at(clock.now() + after, Frame::of(0x184, bytes_test::hex("27 02 55")));
  }
  master->pass(60ms);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kNote));
  EXPECT_EQ(describe(events[0], "y"), "node 4 (y): TPDO 1 is shorter than its mapping: 6 bytes are expected, 3 came");
  EXPECT_EQ(master->cycle()->node_report(1).wrong_length, 2U);
}

TEST_F(CanMasterTest, ANodeThatNothingWatchesIsTold) {
  plan.nodes[1].error_control = {};
  make();
  ASSERT_EQ(failure(master->boot()), "");
  const auto notes = master->take_notes();
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(describe(notes[0], "y"),
            "node 4 (y): nothing watches this node, as it has neither heartbeat nor node guarding: it counts as "
            "Operational until a PDO of it that is due with SYNC fails");
}

TEST_F(CanMasterTest, ASecondBootWritesNothingThatTheNodesHave) {
  operate();
  ASSERT_EQ(failure(master->shut_down()), "");
  tool.received.clear();
  make();
  ASSERT_EQ(failure(master->boot()), "");
  for (const auto& one : tool.received) {
    const bool download =
        one.frame.identifier.value == 0x603 && (one.frame.data[0] & std::byte{0xE0}) == std::byte{0x20};
    // Reset communication brings stored values back, which are those of the factory: the mappings are written again.
    EXPECT_FALSE(download && one.frame.data[2] == std::byte{0x60}) << "60C2h is not one of them";
  }
}

TEST_F(CanMasterTest, DrivesFaultWhenTheMasterDies) {
  operate();
  bus.advance(clock.now() + 300ms);  // no cycle sends anything
  EXPECT_EQ(state(0), NmtState::kPreOperational);
  EXPECT_EQ(emergencies(3), 1);
  EXPECT_EQ(emergencies(4), 1);
}

TEST_F(CanMasterTest, APowerCycledDriveComesBackAloneWhileTheOthersRun) {
  operate();
  drives[1]->restart();
  master->pass(2s);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kNodeRebooted, Kind::kNodeBack));
  EXPECT_EQ(state(1), NmtState::kOperational);
  EXPECT_TRUE(master->all_operational());
  EXPECT_EQ(master->recoveries(), 1U);
  EXPECT_TRUE(master->cycle()->node_report(1).valid);
  for (const std::size_t other : {0U, 2U}) EXPECT_EQ(master->cycle()->node_report(other).lost, 0U) << other;
}

TEST_F(CanMasterTest, ADriveWithoutBusSupplyIsLostAndComesBack) {
  operate();
  drives[0]->set_bus_supply(false);
  master->pass(1s);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kNodeLost));
  EXPECT_EQ(master->node(0).phase, NodePhase::kLost);
  EXPECT_FALSE(master->all_operational());
  drives[0]->set_bus_supply(true);
  master->pass(3s);
  EXPECT_EQ(take_events().back(), Kind::kNodeBack);
  EXPECT_EQ(state(0), NmtState::kOperational);
  for (const std::size_t other : {1U, 2U}) EXPECT_EQ(master->cycle()->node_report(other).lost, 0U) << other;
}

TEST_F(CanMasterTest, ObjectsAreReadAndWrittenInOperation) {
  operate();
  const auto name = master->upload(0, {0x1008, 0});
  ASSERT_TRUE(name) << describe(name.error());
  EXPECT_GT(name->size(), 4U) << "segmented";
  EXPECT_EQ(master->upload(1, {0x3FFF, 0}).error().code, SdoAbort::kObjectDoesNotExist);
  ASSERT_TRUE(master->download(1, {0x60C2, 1}, std::array{std::byte{4}}));
  EXPECT_EQ(value(1, 0x60C2, 1), 4U);
  EXPECT_EQ(master->cycle()->node_report(0).lost, 0U);
}

TEST_F(CanMasterTest, AnotherMasterIsNotJoinedUnlessForced) {
  for (int i = 0; i < 400; ++i) tool.send_at(clock.now() + i * 10ms, Sync{}.frame({0x80, false}));
  make();
  const auto refused = master->boot();
  EXPECT_EQ(failure(refused), "another master is on this bus: SYNC was heard, which a node may produce, too (1005h)\n");
  settings.force = true;
  make();
  ASSERT_EQ(failure(master->boot()), "");
  EXPECT_THAT(master->take_notes(), ::testing::SizeIs(1));
}

TEST_F(CanMasterTest, AMasterThatAppearsInOperationIsTold) {
  operate();
  tool.send_at(clock.now() + 5ms, NmtRequest{NmtCommand::kStop, 4}.frame());
  tool.send_at(clock.now() + 6ms, Sync{}.frame({0x80, false}));
  master->pass(500ms);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kOtherMaster, Kind::kOtherMaster, Kind::kWrongState, Kind::kNodeBack));
  EXPECT_EQ(events[0].other, OtherMasterSign::kNmt);
  EXPECT_EQ(events[1].other, OtherMasterSign::kSync);
  EXPECT_EQ(state(1), NmtState::kOperational);
}

TEST_F(CanMasterTest, ErrorsOfAllNodesAreCollected) {
  plan.nodes[0].serial_number = 5;
  plan.nodes[2].device_type = 7;
  plan.nodes.push_back(drive(9, true));
  make();
  const auto text = failure(master->boot());
  EXPECT_THAT(text, HasSubstr("node 3 (drive 3): is another device: 0x1018:04 is 0x00000067, wanted is 0x00000005\n"));
  EXPECT_THAT(text, HasSubstr("node 5 (drive 5): is another device: 0x1000:00 is 0x"));
  EXPECT_THAT(text, HasSubstr("node 9 (drive 9): sent no boot-up message and did not answer within 500 ms\n"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("node 4")));
}

TEST_F(CanMasterTest, BusOffAndTheWayBack) {
  operate();
  port.controller().fail(clock.now());
  master->pass(150ms);
  EXPECT_THAT(take_events(), Contains(Kind::kBusOff));
  port.controller().recover(clock.now());
  master->pass(4s);
  const auto after = take_events();
  EXPECT_THAT(after, Contains(Kind::kBusBack));
  EXPECT_TRUE(master->all_operational());
  for (std::size_t i = 0; i < drives.size(); ++i) EXPECT_EQ(state(i), NmtState::kOperational) << i;
}

TEST_F(CanMasterTest, AnAdapterThatIsUnpluggedIsTold) {
  operate();
  port.unplugged = true;
  master->pass(300ms);
  EXPECT_THAT(take_events(), Contains(Kind::kBusDown));
  EXPECT_FALSE(master->all_operational());
  EXPECT_EQ(master->upload(0, {0x1000, 0}).error().kind, ClientErrorKind::kDown);
  static_cast<void>(master->shut_down());
  EXPECT_FALSE(master->cycling());
}

TEST_F(CanMasterTest, AnAdapterThatIsGoneEndsTheBoot) {
  port.unplugged = true;
  make();
  EXPECT_THAT(failure(master->boot()), HasSubstr("the CAN bus cannot be reached"));
}

TEST_F(CanMasterTest, AnOptionalDriveJoins) {
  plan.nodes[1].optional = true;
  drives[1]->set_bus_supply(false);
  operate();
  EXPECT_TRUE(master->all_operational());
  EXPECT_EQ(master->node(1).phase, NodePhase::kNotSeen);
  drives[1]->set_bus_supply(true);
  master->pass(3s);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kNodeJoined));
  EXPECT_EQ(state(1), NmtState::kOperational);
  EXPECT_TRUE(master->cycle()->node_report(1).valid);
}

TEST_F(CanMasterTest, AnOptionalDriveWhoseMappingNobodyKnowsIsNotPossible) {
  plan.nodes[1].optional = true;
  plan.nodes[1].tpdos[0].objects.clear();
  drives[1]->set_bus_supply(false);
  make();
  EXPECT_EQ(failure(master->boot()),
            "node 4 (drive 4): neither the line description nor the node has a mapping for TPDO 1\n");
}

TEST_F(CanMasterTest, ADriveWithNodeGuardingIsWatchedAndWatches) {
  auto& control = plan.nodes[2].error_control;
  control = {};
  control.guard_time = 60ms;
  control.life_time_factor = 3;
  operate();
  master->pass(1s);
  EXPECT_THAT(take_events(), IsEmpty());
  EXPECT_GE(master->node(2).heartbeats, 15U);
  drives[2]->set_bus_supply(false);
  master->pass(400ms);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kNodeLost));
  drives[2]->set_bus_supply(true);
  master->pass(3s);
  EXPECT_EQ(take_events().back(), Kind::kNodeBack);
  ASSERT_EQ(failure(master->shut_down()), "");
  const auto before = emergencies(5);
  bus.advance(clock.now() + 3s);
  EXPECT_EQ(emergencies(5), before) << "life guarding is off";
}

// A node that is compared and started again watches its master meanwhile.
TEST_F(CanMasterTest, AGuardedNodeIsGuardedWhileItIsConfiguredAgain) {
  auto& control = plan.nodes[2].error_control;
  control = {};
  control.guard_time = 20ms;
  control.life_time_factor = 3;
  operate();
  tool.send_at(clock.now() + 5ms, NmtRequest{NmtCommand::kEnterPreOperational, 5}.frame());
  master->pass(2s);
  EXPECT_THAT(take_events(), ElementsAre(Kind::kOtherMaster, Kind::kWrongState, Kind::kNodeBack));
  EXPECT_EQ(emergencies(5), 0) << "it has not missed the master";
}

TEST_F(CanMasterTest, NothingIsRequestedOfALineThatWasNotBooted) {
  make();
  EXPECT_EQ(master->upload(0, {0x1000, 0}).error().kind, ClientErrorKind::kStopped);
  EXPECT_TRUE(master->shut_down());
}

}  // namespace
}  // namespace driveline::canopen
