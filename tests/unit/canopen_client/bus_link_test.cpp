#include "driveline/canopen_client/bus_link.hpp"

#include "driveline/canopen_client/nmt_commands.hpp"
#include "scripted_port.hpp"

namespace driveline::canopen {
namespace {

using BusLinkTest = ScriptedBus;

TEST_F(BusLinkTest, WaitsUntilTheDeadline) {
  port.arrives(1s + 30ms, "701#05");
  EXPECT_FALSE(link.receive(1s + 20ms));
  EXPECT_EQ(clock.now(), 1s + 20ms);
  const auto received = must(link.receive(2s));
  EXPECT_EQ(received->time, 1s + 30ms);
  EXPECT_EQ(clock.now(), 1s + 30ms);
}

TEST_F(BusLinkTest, StopsAndNoticesThatTheBusIsGone) {
  link.set_stop([] { return true; });
  EXPECT_FALSE(link.receive(100s));
  link.set_stop({});
  port.status = SendStatus::kDown;
  EXPECT_FALSE(link.receive(100s));
  EXPECT_LT(clock.now(), 2s);
  EXPECT_EQ(link.send(*candump::parse_frame("123#"), 1s).error().kind, ClientErrorKind::kDown);
}

TEST_F(BusLinkTest, HasPatienceWithAFullQueue) {
  port.status = SendStatus::kBusy;
  const auto sent = link.send(*candump::parse_frame("123#"), 20ms);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, ClientErrorKind::kBusy);
  EXPECT_GE(clock.now(), 1s + 20ms);
  EXPECT_LT(clock.now(), 1s + 30ms);
  EXPECT_NE(describe(sent.error()).find("took no frame for 20 ms"), std::string::npos);
}

// CiA 301 7.2.8.3.1: command specifier and node-ID on identifier 0.
TEST_F(BusLinkTest, NmtCommandsAreThoseOfTheStandard) {
  NmtCommands nmt(link);
  EXPECT_TRUE(nmt.start(3));
  EXPECT_TRUE(nmt.stop(3));
  EXPECT_TRUE(nmt.enter_pre_operational(3));
  EXPECT_TRUE(nmt.reset_node(NmtCommands::kAll));
  EXPECT_TRUE(nmt.reset_communication(127));
  EXPECT_THAT(port.sent, ElementsAre("000#0103", "000#0203", "000#8003", "000#8100", "000#827F"));
}

TEST_F(BusLinkTest, GuardingAsksByARemoteFrame) {
  NmtCommands nmt(link);
  port.answers({{1ms, "704#05"}, {2ms, "703#7F00"}, {3ms, "703#FF"}});
  const auto state = must(nmt.guard(3, 100ms));
  EXPECT_EQ(state->state, NmtState::kPreOperational);
  EXPECT_TRUE(state->toggle);
  EXPECT_THAT(port.sent, ElementsAre("703#R1"));
  EXPECT_EQ(nmt.guard(3, 100ms).error().kind, ClientErrorKind::kNoAnswer);
  port.status = SendStatus::kNotValid;
  const auto refused = nmt.guard(3, 100ms);
  ASSERT_FALSE(refused);
  EXPECT_EQ(describe(refused.error()), "node 3: the CAN adapter cannot carry this frame");
}

}  // namespace
}  // namespace driveline::canopen
