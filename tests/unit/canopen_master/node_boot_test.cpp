#include "fake_node.hpp"

namespace driveline::canopen {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using NodeBootTest = FakeLine;

TEST_F(NodeBootTest, BootsInTheOrderOfCia302) {
  plan.nodes[0].device_type = 0x0002'0192;
  plan.nodes[0].startup_sdos.push_back({0x60C2, 1, {std::byte{2}}});
  auto& node = bus.add(10);
  node.set(0x60C2, 1, 10, 1);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(view(0).phase, NodePhase::kConfigured);
  EXPECT_EQ(view(0).identity, (NodeIdentity{0x0002'0192, 0x107, 0x207, 0x307, 0x407}));
  // The steps one behind the other; PDO 2 and 1 are switched on last, when they are complete.
  EXPECT_THAT(node.writes, ElementsAre("60C2:01=2", "1006:00=7D0",                                        //
                                       "1601:00=0", "1601:01=60C10120", "1601:00=1", "1401:02=1",         //
                                       "1401:01=30A",                                                     //
                                       "1A00:00=0", "1A00:01=60410010", "1A00:02=60640020", "1A00:00=2",  //
                                       "1800:02=1", "1800:01=4000018A",                                   //
                                       "1016:01=7E0046", "1017:00=64"));
}

TEST_F(NodeBootTest, FramesOnTheWire) {
  // By hand from CiA 301 7.2.8.2.1 and 7.2.4.3: reset communication, then 1000h and 1018h are read.
  ASSERT_THAT(boot(), IsEmpty());
  ASSERT_GT(bus.sent.size(), 6U);
  EXPECT_THAT(std::vector(bus.sent.begin(), bus.sent.begin() + 6),
              ElementsAre("000#820A", "60A#4000100000000000", "60A#4018100100000000", "60A#4018100200000000",
                          "60A#4018100300000000", "60A#4018100400000000"));
  // 1016h:01: the master 126 within 70 ms (CiA 301 7.5.2.18); 1017h: 100 ms.
  EXPECT_THAT(std::vector(bus.sent.end() - 3, bus.sent.end()),
              ElementsAre("60A#2316100146007E00", "60A#4017100000000000", "60A#2B17100064000000"));
}

TEST_F(NodeBootTest, WhatIsAsWantedIsReadAndNotWritten) {
  auto& node = bus.add(10);
  ASSERT_THAT(boot(), IsEmpty());
  node.writes.clear();
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_THAT(node.writes, ElementsAre("1017:00=64")) << "the reset has lost it";
}

TEST_F(NodeBootTest, BitsOfTheDeviceArePreservedWhenAPdoIsChanged) {
  auto& node = bus.add(10);
  node.set(0x1401, 1, 0x4000'0345, 4);  // valid, another identifier
  node.set(0x1800, 1, 0x0000'018A, 4);  // valid, remote frames are answered
  ASSERT_THAT(boot(), IsEmpty());
  std::vector<std::string> cob_ids;
  for (const auto& write : node.writes) {
    if (write.substr(0, 7) == "1401:01" || write.substr(0, 7) == "1800:01") cob_ids.push_back(write);
  }
  EXPECT_THAT(cob_ids, ElementsAre("1401:01=C0000345", "1401:01=4000030A", "1800:01=8000018A", "1800:01=18A"));
}

TEST_F(NodeBootTest, APdoThatNobodyHasPlannedIsSwitchedOff) {
  auto& node = bus.add(10);
  node.set(0x1402, 1, 0x0000'040A, 4);
  node.set(0x1803, 1, 0x4000'048A, 4);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(node.value(0x1402, 1), 0x8000'040AU);
  EXPECT_EQ(node.value(0x1803, 1), 0xC000'048AU);
}

TEST_F(NodeBootTest, TimesOfATpdoAreSetWhileItIsOff) {
  plan.nodes[0].tpdos.push_back({.number = 2,
                                 .transmission = 255,
                                 .exchange = PdoExchange::kOnChange,
                                 .inhibit_100us = std::uint16_t{50},
                                 .event_ms = std::uint16_t{400},
                                 .objects = {{0x6061, 0, 8}}});
  auto& node = bus.add(10);
  node.set(0x1801, 1, 0x4000'028A, 4);
  ASSERT_THAT(boot(), IsEmpty());
  const auto at = std::find(node.writes.begin(), node.writes.end(), "1801:01=C000028A");
  ASSERT_NE(at, node.writes.end());
  EXPECT_THAT(std::vector(at + 1, at + 7), ElementsAre("1A01:00=0", "1A01:01=60610008", "1A01:00=1", "1801:03=32",
                                                       "1801:05=190", "1801:01=4000028A"));
}

TEST_F(NodeBootTest, AMappingThatThePlanLeavesToTheNodeIsRead) {
  plan.nodes[0].tpdos[0].objects.clear();
  auto& node = bus.add(10);
  node.set(0x1A00, 0, 2, 1);
  node.set(0x1A00, 1, 0x6041'0010, 4);
  node.set(0x1A00, 2, 0x6077'0010, 4);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(line->node(0).plan().tpdos[0].objects,
            (std::vector<motion::MappedObject>{{0x6041, 0, 16}, {0x6077, 0, 16}}));
}

TEST_F(NodeBootTest, AFixedMappingIsGoodWhenItIsTheWantedOne) {
  auto& node = bus.add(10);
  node.set(0x1A00, 0, 2, 1);
  node.set(0x1A00, 1, 0x6041'0010, 4);
  node.set(0x1A00, 2, 0x6064'0020, 4);
  for (unsigned sub = 0; sub <= 8; ++sub) node.refuses[{0x1A00, sub}] = 0x0601'0002;
  EXPECT_THAT(boot(), IsEmpty());
}

TEST_F(NodeBootTest, AFixedMappingThatDiffersIsAClearError) {
  auto& node = bus.add(10);
  node.set(0x1A00, 0, 2, 1);
  node.set(0x1A00, 1, 0x6041'0010, 4);
  node.set(0x1A00, 2, 0x6077'0010, 4);
  for (unsigned sub = 0; sub <= 8; ++sub) node.refuses[{0x1A00, sub}] = 0x0601'0002;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kFrozenMapping);
  EXPECT_EQ(errors[0].object, (SdoObject{0x1A00, 2}));
  EXPECT_EQ(errors[0].wanted, 0x6064'0020U);
  EXPECT_EQ(errors[0].found, 0x6077'0010U);
  EXPECT_THAT(describe(errors[0], "x"), ::testing::StartsWith("node 10 (x): the mapping of TPDO 1 cannot be changed: "
                                                              "0x1A00:02 is 0x60770010, wanted is 0x60640020"));
}

TEST_F(NodeBootTest, SilentNodeGetsAnAbortAndIsAbsent) {
  bus.add(10).there = false;
  const auto begin = clock.now();
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kAbsent);
  EXPECT_GE(clock.now() - begin, 350ms) << "the time of the boot-up message, and that of an answer";
  // 1000h is asked for, and the transfer is ended with 05040000h, or the server would wait for ever.
  EXPECT_THAT(bus.sent, ElementsAre("000#820A", "000#800A", "60A#4000100000000000", "60A#8000100000000405"));
}

/// Only its SDO server is silent: it is not said to be absent.
TEST_F(NodeBootTest, ASilentSdoServerBehindABootUpMessageIsNamed) {
  bus.add(10).mute = true;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRequestFailed);
  EXPECT_EQ(describe(errors[0], "x"),
            "node 10 (x): sent its boot-up message, but its SDO server did not answer within 50 ms");
}

TEST_F(NodeBootTest, ANodeWithoutBootUpMessageIsFoundByItsAnswer) {
  bus.add(10).boots = false;
  EXPECT_THAT(boot(), IsEmpty());
}

TEST_F(NodeBootTest, ABootUpMessageThatIsLateButInTimeIsEnough) {
  auto& node = bus.add(10);
  node.boots = false;
  bus.arrives(clock.now() + 290ms, "70A#00");
  EXPECT_THAT(boot(), IsEmpty());
  EXPECT_EQ(std::count(bus.sent.begin(), bus.sent.end(), "000#800A"), 0);
}

TEST_F(NodeBootTest, ATimeOutIsAbortedAndNamed) {
  auto& node = bus.add(10);
  node.delay = 60ms;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRequestFailed) << "it answers too late";
  EXPECT_EQ(bus.sent.back(), "60A#8000100000000405");
}

TEST_F(NodeBootTest, ALengthThatLiesIsRefused) {
  auto& node = bus.add(10);
  node.entries[{0x1018, 2}].resize(9);  // announced, and never sent
  auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRequestFailed);
  EXPECT_EQ(errors[0].object, (SdoObject{0x1018, 2}));
  EXPECT_EQ(bus.sent.back(), "60A#8018100200000405");
  node.set(0x1018, 2, 7, 2);
  errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kBadValue);
  EXPECT_EQ(errors[0].wanted, 4U);
  EXPECT_EQ(errors[0].found, 2U);
}

TEST_F(NodeBootTest, MappingsThatAreNoneAreRefused) {
  auto& node = bus.add(10);
  node.set(0x1A00, 0, 254, 1);  // a multiplexed PDO
  auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kBadMapping);
  EXPECT_EQ(errors[0].found, 254U);
  plan.nodes[0].tpdos[0].objects.clear();
  node.set(0x1A00, 0, 3, 1);
  for (unsigned sub = 1; sub <= 3; ++sub) node.set(0x1A00, sub, 0x6064'0020, 4);
  errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kBadMapping);
  EXPECT_EQ(errors[0].wanted, 96U);
  node.set(0x1A00, 0, 0, 1);
  errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kEmptyMapping);
}

TEST_F(NodeBootTest, AMappingThatIsAcceptedAndNotKeptIsFound) {
  auto& node = bus.add(10);
  node.forgets.insert({0x1601, 1});
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kNotTaken);
  EXPECT_EQ(errors[0].object, (SdoObject{0x1601, 1}));
  EXPECT_EQ(errors[0].wanted, 0x60C1'0120U);
}

TEST_F(NodeBootTest, ARefusedEntryOfAMappingIsNamed) {
  bus.add(10).refuses[{0x1601, 1}] = 0x0604'0041;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRefused);
  EXPECT_EQ(errors[0].pdo, 2);
  EXPECT_TRUE(errors[0].rpdo);
  EXPECT_EQ(errors[0].request->code, SdoAbort::kNotMappable);
}

TEST_F(NodeBootTest, OptionalStartupSdosAreNotedWhenTheyAreRefused) {
  auto& sdos = plan.nodes[0].startup_sdos;
  sdos.push_back(
      {0x2345, 0, {std::byte{5}}, false, motion::StartupState::kPreOperational, motion::WriteNeed::kOptional});
  sdos.push_back(
      {0x2346, 0, {std::byte{5}}, false, motion::StartupState::kPreOperational, motion::WriteNeed::kOmitted});
  ASSERT_THAT(boot(), IsEmpty());
  const auto notes = line->node(0).take_notes();
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].object, (SdoObject{0x2345, 0}));
  EXPECT_EQ(notes[0].request->code, SdoAbort::kObjectDoesNotExist);
  sdos[0].need = motion::WriteNeed::kMandatory;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRefused);
  EXPECT_EQ(errors[0].step, BootStep::kStartupSdos);
}

TEST_F(NodeBootTest, ANodeThatProducesSyncStopsDoingSo) {
  auto& node = bus.add(10);
  node.set(0x1005, 0, 0x4000'0081, 4);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(node.writes[0], "1005:00=81") << "locked while the node produces it";
  EXPECT_EQ(node.writes[1], "1005:00=80");
}

TEST_F(NodeBootTest, TheConsumerOfTheMasterGoesWhereItIsOrWhereThereIsRoom) {
  auto& node = bus.add(10);
  node.set(0x1016, 1, 0x0005'0100, 4);  // another node
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(node.value(0x1016, 1), 0x0005'0100U);
  EXPECT_EQ(node.value(0x1016, 2), 0x007E'0046U);
  node.set(0x1016, 1, 0, 4);
  node.set(0x1016, 2, 0x007E'1000, 4);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(node.value(0x1016, 1), 0U);
  EXPECT_EQ(node.value(0x1016, 2), 0x007E'0046U);
  node.set(0x1016, 1, 0x0005'0100, 4);
  node.set(0x1016, 2, 0x0006'0100, 4);
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRefused);
  EXPECT_EQ(describe(errors[0], "x"),
            "node 10 (x): none of the 2 entries of 0x1016 is free for the heartbeat of the master");
}

TEST_F(NodeBootTest, ErrorControlThatIsNotWantedIsSwitchedOffBeforeTheRest) {
  plan.nodes[0].error_control = {};
  auto& node = bus.add(10);
  node.boots = false;  // and keeps what it has
  node.set(0x100C, 0, 500, 2);
  node.set(0x1016, 2, 0x007E'0046, 4);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_THAT(std::vector(node.writes.begin(), node.writes.begin() + 2), ElementsAre("100C:00=0", "1016:02=0"));
}

TEST_F(NodeBootTest, GuardingIsTriedBeforeTheNodeWatchesTheMaster) {
  auto& control = plan.nodes[0].error_control;
  control = {};
  control.guard_time = 50ms;
  control.life_time_factor = 4;
  auto& node = bus.add(10);
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_THAT(std::vector(bus.sent.end() - 5, bus.sent.end()),
              ElementsAre("70A#R1", "60A#400C100000000000", "60A#2B0C100032000000", "60A#400D100000000000",
                          "60A#2F0D100004000000"));
  node.guards = false;
  auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kNoGuarding);
  bus.carries_remote = false;
  errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kNoRemote);
}

TEST_F(NodeBootTest, ANodeThatBootsIntoOperationalIsTakenBack) {
  auto& node = bus.add(10);
  bus.arrives(clock.now() + 5ms, "70A#05");
  ASSERT_THAT(boot(), IsEmpty());
  EXPECT_EQ(std::count(bus.sent.begin(), bus.sent.end(), "000#800A"), 1);
  for (int i = 1; i < 6; ++i) bus.arrives(clock.now() + 4ms * i, "70A#05");
  node.delay = 2ms;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kWrongState);
  EXPECT_EQ(errors[0].found_state, NmtState::kOperational);
}

TEST_F(NodeBootTest, ANodeThatRestartsBeginsAnewButNotForEver) {
  auto& node = bus.add(10);
  node.delay = 1ms;
  bus.arrives(clock.now() + 10ms, "70A#00");
  ASSERT_THAT(boot(), IsEmpty());
  for (int i = 0; i < 20; ++i) bus.arrives(clock.now() + 10ms * i, "70A#00");
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kRestarts);
}

TEST_F(NodeBootTest, ABusThatIsGoneEndsTheBoot) {
  bus.status = SendStatus::kDown;
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kBusDown);
}

TEST_F(NodeBootTest, ABusThatTakesNoFrameIsGiven500Milliseconds) {
  bus.status = SendStatus::kBusy;
  const auto begin = clock.now();
  const auto errors = boot();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kBusDown);
  EXPECT_NEAR(std::chrono::duration<double>(clock.now() - begin).count(), 0.5, 0.01);
}

/// What the plan wants, and whether the node, which has 0000307h, is the one.
struct IdentityCase {
  const char* name;
  std::optional<std::uint32_t> NodePlan::*entry;
  std::uint32_t wanted;
  std::uint32_t found;
  bool right;
};

class NodeIdentityTest : public FakeLine, public ::testing::WithParamInterface<IdentityCase> {};

TEST_P(NodeIdentityTest, IsCompared) {
  const auto& param = GetParam();
  plan.nodes[0].*param.entry = param.wanted;
  auto& node = bus.add(10);
  const std::vector<std::pair<std::optional<std::uint32_t> NodePlan::*, FakeNode::Key>> places{
      {&NodePlan::device_type, {0x1000, 0}},
      {&NodePlan::vendor_id, {0x1018, 1}},
      {&NodePlan::product_code, {0x1018, 2}},
      {&NodePlan::revision, {0x1018, 3}},
      {&NodePlan::serial_number, {0x1018, 4}}};
  FakeNode::Key key;
  for (const auto& [entry, place] : places) {
    if (entry == param.entry) key = place;
  }
  node.set(key.first, key.second, param.found, 4);
  const auto errors = boot();
  EXPECT_EQ(errors.empty(), param.right);
  if (param.right) return;
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].kind, NodeErrorKind::kOtherDevice);
  EXPECT_EQ(errors[0].object.index, key.first);
  EXPECT_EQ(errors[0].wanted, param.wanted);
  EXPECT_EQ(errors[0].found, param.found);
  EXPECT_THAT(node.writes, IsEmpty()) << "nothing is written into another device";
}

INSTANTIATE_TEST_SUITE_P(
    Entries, NodeIdentityTest,
    ::testing::Values(IdentityCase{"Type", &NodePlan::device_type, 0x0002'0192, 0x0002'0192, true},
                      IdentityCase{"OtherType", &NodePlan::device_type, 0x0002'0192, 0x000F'0191, false},
                      IdentityCase{"Vendor", &NodePlan::vendor_id, 0x5A, 0x5A, true},
                      IdentityCase{"OtherVendor", &NodePlan::vendor_id, 0x5A, 0x5B, false},
                      IdentityCase{"OtherProduct", &NodePlan::product_code, 3, 4, false},
                      IdentityCase{"Revision", &NodePlan::revision, 0x0002'0003, 0x0002'0003, true},
                      IdentityCase{"NewerMinorRevision", &NodePlan::revision, 0x0002'0003, 0x0002'0009, true},
                      IdentityCase{"OlderMinorRevision", &NodePlan::revision, 0x0002'0003, 0x0002'0002, false},
                      IdentityCase{"NewerMajorRevision", &NodePlan::revision, 0x0002'0003, 0x0003'0003, false},
                      IdentityCase{"OtherSerial", &NodePlan::serial_number, 77, 78, false}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace driveline::canopen
