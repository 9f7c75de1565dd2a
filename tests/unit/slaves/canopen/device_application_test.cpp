// What an application can do beyond its dictionary: start slowly, store by itself, have cycles, tell of failures
// itself.
#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

using canopen::NmtCommand;
using canopen::NmtState;

// Until the application has started, the device is silent and takes nothing.
TEST(CanopenApplication, TheBootUpMessageWaitsForItsStart) {
  DeviceRig rig;
  rig.application.start_up = 7ms;
  rig.run(6900us);
  rig.send(Frame::remote({0x705, false}, 1));  // at 6.9 ms; it takes until 7.9 ms
  EXPECT_EQ(rig.seen(0x705).size(), 1U) << "the boot-up message, no answer to guarding";
  EXPECT_NEAR(nanos(rig.seen(0x705)[0].time), 7e6, 2e5);
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
  rig.nmt(NmtCommand::kResetNode);
  EXPECT_EQ(rig.device.node_id(), 0);
  rig.start();
  rig.run(20ms);
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational) << "what comes in between is lost";
  EXPECT_EQ(rig.seen(0x705).size(), 2U);
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.seen(0x705).size(), 3U) << "the application goes on";
}

TEST(CanopenApplication, ThatStoresByItselfRestoresItsValues) {
  DeviceRig rig({.stores = false});
  rig.run(2ms);
  ASSERT_EQ(rig.write(0x1006, 0, 4000, 4), 0U);
  ASSERT_EQ(rig.write(0x2000, 0, 77, 2), 0U);
  EXPECT_EQ(rig.write(0x1010, 1, 1, 4), 0U) << "it checks the signature, too";
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.application.restored, 1U);
  EXPECT_EQ(rig.value(0x1006), 4000U);
  rig.nmt(NmtCommand::kResetNode);
  EXPECT_EQ(rig.application.restored, 1U);
  EXPECT_THAT(rig.application.restarts, ElementsAre(Reset::kPowerOn, Reset::kNode));
  EXPECT_EQ(rig.value(0x2000), 77U);
}

TEST(CanopenApplication, IsAwakeWhenItWantsToBe) {
  DeviceRig rig;
  rig.application.wake = 3'300'300ns;
  rig.run(10ms);
  EXPECT_THAT(rig.application.advances, ElementsAre(3'300'300ns));
}

// It is at the time of a PDO before its values are written or read.
TEST_F(CanopenDevice, TheApplicationComesToTheTimeOfItsPdos) {
  rig.map(0x1401, {0x2001'0008}, 1);
  rig.start();
  rig.application.advances.clear();
  rig.sync();
  ASSERT_EQ(rig.application.advances.size(), 1U);
  EXPECT_EQ(rig.application.advances[0], rig.application.syncs.back().second);
  rig.send(0x305, "37");
  ASSERT_EQ(rig.application.frames.size(), 1U);
  EXPECT_EQ(rig.application.advances.back(), rig.application.frames[0].second);
  EXPECT_THAT(rig.application.applied, IsEmpty());
  rig.sync();
  EXPECT_EQ(rig.application.applied.size(), 1U);
}

// A stored entry in an RPDO is written as by SDO: the application is asked, and told of changes.
TEST_F(CanopenDevice, SettingsInAnRpdoActAsWritten) {
  rig.map(0x1400, {0x2000'0010});
  rig.start();
  rig.application.told.clear();
  rig.send(0x205, "39 05");
  rig.send(0x205, "39 05");
  EXPECT_THAT(rig.application.told, ElementsAre(0x2000));
  rig.application.verdict = tl::unexpected(sdo::SdoAbort::kValueRange);
  rig.send(0x205, "40 05");
  EXPECT_EQ(rig.value(0x2000), 0x539U) << "refused";
  EXPECT_THAT(rig.application.told, ElementsAre(0x2000));
}

// Event-driven RPDOs are applied in the cycle of PDOs, with the newest frame.
TEST(CanopenPdoCycle, AppliesTheNewestFrame) {
  DeviceRig rig({.pdo_cycle = 3ms});
  rig.run(2ms);
  rig.map(0x1401, {0x2001'0008});
  rig.start();
  rig.bus.advance((rig.bus.now() / 3ms + 1) * 3ms);
  const auto begin = rig.bus.now();
  rig.send(0x305, "21");
  rig.send(0x305, "22");
  EXPECT_THAT(rig.application.applied, IsEmpty());
  rig.sync();
  EXPECT_THAT(rig.application.applied, ElementsAre(std::pair(std::size_t{1}, begin + 3ms)));
  EXPECT_EQ(rig.value(0x2001), 0x22U);
  EXPECT_EQ(rig.application.frames.size(), 2U);
  rig.run(10ms);
  EXPECT_EQ(rig.application.applied.size(), 1U);
  rig.send(0x305, "23");
  rig.nmt(NmtCommand::kEnterPreOperational);
  rig.run(10ms);
  EXPECT_EQ(rig.value(0x2001), 0x22U) << "PDOs exist in Operational only";
}

// NMT requests are obeyed in their cycle, in their order; those behind a reset are lost with it.
TEST(CanopenNmtCycle, ObeysAllRequestsInTheirOrder) {
  DeviceRig rig({.nmt_cycle = 5ms});
  rig.bus.advance(20ms);
  rig.start();
  rig.nmt(NmtCommand::kStop);
  rig.run(2999us);
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
  rig.run(1us);
  EXPECT_EQ(rig.device.state(), NmtState::kStopped);
  rig.nmt(NmtCommand::kResetCommunication);
  rig.start();
  rig.run(10ms);
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
  const auto before = rig.device.ignored();
  for (int i = 0; i < 10; ++i) rig.master.send_at(rig.bus.now(), canopen::NmtRequest{NmtCommand::kStart, 5}.frame());
  rig.run(10ms);
  EXPECT_EQ(rig.device.ignored(), before + 2) << "eight of them fit in";
  EXPECT_EQ(rig.device.state(), NmtState::kOperational);
}

// Obeyed behind the failure, a start made a device operational that was bus off.
TEST(CanopenNmtCycle, ForgetsInBusOffWhatItHasNotObeyed) {
  DeviceRig rig({.nmt_cycle = 5ms});
  rig.bus.advance(20ms);
  rig.start();
  rig.device.error_state_changed(can::ErrorState::kBusOff, rig.bus.now());
  rig.run(10ms);
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
}

TEST(CanopenFailure, IsToldByTheApplicationWhereItDoesSo) {
  for (const bool by_the_stack : {true, false}) {
    DeviceRig rig({.failure_emergencies = by_the_stack});
    rig.run(2ms);
    ASSERT_EQ(rig.write(0x1016, 2, 0x0007'0014, 4), 0U);
    rig.start();
    rig.send(0x707, "05");
    EXPECT_FALSE(rig.device.persists(CommunicationEvent::kHeartbeatLost));
    rig.run(30ms);
    EXPECT_EQ(rig.seen(0x085).size(), by_the_stack ? 1U : 0U);
    EXPECT_EQ(rig.value(0x1001), by_the_stack ? 0x11U : 0U);
    EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);
    ASSERT_EQ(rig.application.events.size(), 1U);
    EXPECT_EQ(rig.application.events[0].first, CommunicationEvent::kHeartbeatLost);
    EXPECT_TRUE(rig.device.persists(CommunicationEvent::kHeartbeatLost));
    rig.send(0x707, "05");
    EXPECT_FALSE(rig.device.persists(CommunicationEvent::kHeartbeatLost));
  }
}

// A reset ends the errors of what it resets: nothing would end them later.
TEST_F(CanopenDevice, AResetForgetsTheErrorsOfWhatItResets) {
  ASSERT_EQ(rig.write(0x1016, 3, 0x0007'0014, 4), 0U);
  rig.device.raise({0x4310, 8, {}}, rig.bus.now());
  rig.send(0x707, "05");
  rig.run(30ms);
  ASSERT_EQ(rig.value(0x1001), 0x19U);
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.value(0x1001), 0x09U) << "the temperature is still too high";
  const std::size_t messages = rig.seen(0x085).size();
  rig.nmt(NmtCommand::kResetNode);
  EXPECT_EQ(rig.value(0x1001), 0U);
  EXPECT_EQ(rig.seen(0x085).size(), messages);
}

TEST(CanopenRestart, OfTheCommunicationAlone) {
  DeviceRig rig;
  rig.run(2ms);
  ASSERT_EQ(rig.write(0x1006, 0, 4000, 4), 0U);
  rig.device.restart_communication();
  rig.run(2ms);
  EXPECT_EQ(rig.seen(0x705).size(), 2U);
  EXPECT_EQ(rig.value(0x1006), 0U);
  EXPECT_THAT(rig.application.restarts, ElementsAre(Reset::kPowerOn));
}

}  // namespace
}  // namespace driveline::slaves::cia301
