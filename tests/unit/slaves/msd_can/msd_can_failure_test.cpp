// Faults of the MSD on a CAN bus: EMCY, heartbeat, guarding, telegram failure, bus off (MSD manual 8.4, 8.5, 13).
#include "can_drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

class MsdCanFailure : public MsdCan {
 protected:
  /// A drive that is on, in profile velocity at standstill.
  void switch_on() {
    ASSERT_EQ(rig.write(0x6060, 0, 3, 1), 0U);
    rig.operate();
    rig.enable();
    ASSERT_EQ(rig.drive.core().state(), PowerState::kOperationEnabled);
  }
  /// Acknowledges by a rising edge of bit 7.
  void acknowledge() {
    rig.control(0);
    rig.control(0x80);
  }
  [[nodiscard]] std::optional<Fault> fault() const { return rig.drive.core().fault(); }
};

class MsdCanEmergency : public EachCanDrive {};

// Code, register, number, location, and the operating hours in bytes 5 to 7 (MSD manual 13.1).
TEST_P(MsdCanEmergency, HasNumberLocationAndHours) {
  MsdParameters old = parameters();
  old.operating_hours = std::chrono::hours{0x0B1C2D};
  CanDriveRig rig(old);
  rig.run(5ms);
  rig.drive.core().set_cause(Fault::kOvercurrent, true);
  rig.run(5ms);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("10 23 03 03 01 2D 1C 0B")));
  EXPECT_EQ(rig.read(0x1001), 3U);
  EXPECT_EQ(rig.read(0x603F), 0x2310U);
  EXPECT_EQ(rig.read(0x1003, 1), 0x0103'2310U);
  // A cause that is still there is a fault again, with another EMCY.
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("10 23 03 03 01 2D 1C 0B"), hex("00 00 00 00 00 00 00 00"),
                                             hex("10 23 03 03 01 2D 1C 0B")));
  rig.drive.core().set_cause(Fault::kOvercurrent, false);
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(rig.emergencies().back(), hex("00 00 00 00 00 00 00 00"));
  EXPECT_EQ(rig.read(0x1001), 0U);
  EXPECT_EQ(rig.read(0x1003, 0), 1U) << "the history stays";
}

TEST_P(MsdCanFailure, ResetNodeForgetsTheFault) {
  rig.drive.core().raise(Fault::kEncoder);
  rig.run(2ms);
  ASSERT_EQ(rig.read(0x1001), 0x21U);
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(rig.read(0x1001), 0x21U) << "the drive goes on, with its fault";
  EXPECT_EQ(fault(), Fault::kEncoder);
  rig.nmt(NmtCommand::kResetNode);
  rig.run(5ms);
  EXPECT_EQ(fault(), std::nullopt);
  EXPECT_EQ(rig.read(0x1001), 0U);
  EXPECT_EQ(rig.emergencies().size(), 1U);
}

// A fault that is there at the start is told behind the boot-up message.
TEST_P(MsdCanEmergency, OfTheStartFollowsTheBootUp) {
  MsdParameters unreadable = parameters();
  unreadable.parameter_file = "/dev/null/none";
  CanDriveRig rig(unreadable);
  rig.run(10ms);
  ASSERT_EQ(rig.master.received.size(), 2U);
  EXPECT_EQ(rig.master.received[0].frame.identifier.value, 0x70CU);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("20 63 21 02 05 00 00 00")));
}

// The ServoOne has no heartbeat consumer.
class MsdCanHeartbeat : public MsdCanFailure {};

TEST_P(MsdCanHeartbeat, MissingHeartbeatIsAFaultUntilItIsBack) {
  ASSERT_EQ(rig.write(0x1016, 1, 0x0005'0014, 4), 0U);  // node 5, 20 ms
  switch_on();
  rig.run(100ms);
  EXPECT_EQ(fault(), std::nullopt) << "unknown before the first one";
  for (int i = 0; i < 5; ++i) rig.send(0x705, "05", 15ms);
  EXPECT_EQ(fault(), std::nullopt);
  rig.run(4ms);
  EXPECT_EQ(fault(), std::nullopt) << "19 ms";
  rig.run(3ms);
  EXPECT_EQ(fault(), Fault::kHeartbeat);
  EXPECT_EQ(rig.drive.device().state(), NmtState::kPreOperational);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("00 FF 11 0C 03 00 00 00")));
  rig.run(100ms);
  EXPECT_EQ(rig.drive.core().state(), PowerState::kFault);
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(fault(), Fault::kHeartbeat) << "it is still missing";
  rig.send(0x705, "05");
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(fault(), std::nullopt);
}

// The drive produces and consumes heartbeats at the same time.
TEST_P(MsdCanHeartbeat, ProducesAndConsumesHeartbeats) {
  ASSERT_EQ(rig.write(0x1016, 1, 0x0005'0014, 4), 0U);
  ASSERT_EQ(rig.write(0x1017, 0, 10, 2), 0U);
  rig.start();
  rig.master.received.clear();
  for (int i = 0; i < 10; ++i) rig.send(0x705, "05", 15ms);
  EXPECT_EQ(rig.count(0x70C), 15U);
  EXPECT_EQ(rig.payloads(0x70C).back(), hex("05"));
  EXPECT_EQ(fault(), std::nullopt);
}

// 1017h: off from the factory, at once when written; from the boot-up message on when it is stored.
TEST_P(MsdCanFailure, HeartbeatBeginsAtOnceAndWithTheBootUp) {
  rig.run(200ms);
  EXPECT_EQ(rig.count(0x70C), 1U) << "the boot-up message";
  ASSERT_EQ(rig.write(0x1017, 0, 40, 2), 0U);
  EXPECT_THAT(rig.payloads(0x70C), ElementsAre(hex("00"), hex("7F")));
  ASSERT_EQ(rig.save(), 0U);
  rig.master.received.clear();
  rig.nmt(NmtCommand::kResetNode);
  rig.run(60ms);
  const auto heartbeats = rig.seen(0x70C);
  ASSERT_EQ(heartbeats.size(), 2U);
  EXPECT_EQ(heartbeats[0].frame.payload()[0], std::byte{0});
  EXPECT_EQ(heartbeats[1].frame.payload()[0], std::byte{0x7F});
  EXPECT_NEAR(std::chrono::duration<double>(heartbeats[1].time - heartbeats[0].time).count(), 0.040, 1e-5);
}

// MSD manual Figure 8.2: bit 7 is 0, the others are the state.
TEST_P(MsdCanFailure, HeartbeatBytesAreThoseOfTheManual) {
  ASSERT_EQ(rig.write(0x1017, 0, 6, 2), 0U);
  const auto next = [&] {
    rig.run(7ms);
    return std::to_integer<unsigned>(rig.payloads(0x70C).back()[0]);
  };
  EXPECT_EQ(next(), 127U);
  EXPECT_EQ(next(), 127U) << "no toggle bit";
  rig.start();
  EXPECT_EQ(next(), 5U);
  EXPECT_EQ(next(), 5U);
  rig.nmt(NmtCommand::kStop);
  EXPECT_EQ(next(), 4U);
  rig.nmt(NmtCommand::kResetCommunication);
  EXPECT_EQ(std::to_integer<unsigned>(rig.payloads(0x70C).back()[0]), 0U);
}

TEST_P(MsdCanFailure, MissingGuardingIsAFault) {
  ASSERT_EQ(rig.write(0x100C, 0, 10, 2), 0U);
  ASSERT_EQ(rig.write(0x100D, 0, 3, 1), 0U);
  switch_on();
  rig.run(100ms);
  EXPECT_EQ(fault(), std::nullopt) << "before the first remote frame";
  rig.master.received.clear();
  rig.send(Frame::remote({0x70C, false}, 1), 10ms);
  rig.send(Frame::remote({0x70C, false}, 1), 10ms);
  EXPECT_THAT(rig.payloads(0x70C), ElementsAre(hex("05"), hex("85")));
  rig.run(25ms);
  EXPECT_EQ(fault(), Fault::kLifeGuarding);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("00 FF 11 0C 02 00 00 00")));
  EXPECT_EQ(rig.drive.device().state(), NmtState::kPreOperational);
  rig.send(Frame::remote({0x70C, false}, 1));
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(fault(), std::nullopt);
}

// With a heartbeat, guarding is not answered.
TEST_P(MsdCanFailure, HeartbeatAndGuardingAreNotThereAtTheSameTime) {
  ASSERT_EQ(rig.write(0x1017, 0, 500, 2), 0U);
  const std::size_t before = rig.count(0x70C);
  rig.send(Frame::remote({0x70C, false}, 1));
  EXPECT_EQ(rig.count(0x70C), before);
}

// P 2061 = 0, P 2062 = 12 ms: SYNC is monitored in Operational, from the first one on.
TEST_P(MsdCanFailure, MissingSyncIsATelegramFailure) {
  ASSERT_EQ(rig.write(0x280E, 0, 12, 4), 0U);
  rig.sync();
  switch_on();
  rig.run(50ms);
  EXPECT_EQ(fault(), std::nullopt) << "none since Operational";
  for (int i = 0; i < 5; ++i) rig.send(0x80, "", 11ms);
  EXPECT_EQ(fault(), std::nullopt);
  rig.run(3ms);
  EXPECT_EQ(fault(), Fault::kTelegramFailure);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("00 FF 11 0C 04 00 00 00")));
  EXPECT_EQ(rig.drive.device().state(), NmtState::kOperational);
  rig.run(50ms);
  acknowledge();
  EXPECT_EQ(fault(), Fault::kTelegramFailure) << "SYNC is still missing";
  rig.send(0x80, "", 1ms);
  acknowledge();
  EXPECT_EQ(fault(), std::nullopt);
}

TEST_P(MsdCanFailure, MissingRxPdoIsATelegramFailure) {
  ASSERT_EQ(rig.write(0x280D, 0, 1, 1), 0U);
  ASSERT_EQ(rig.write(0x280E, 0, 12, 4), 0U);
  switch_on();
  for (int i = 0; i < 4; ++i) {
    rig.control(kEnable);
    rig.run(8ms);
  }
  EXPECT_EQ(fault(), std::nullopt);
  for (int i = 0; i < 3; ++i) rig.send(0x80, "", 3ms);
  EXPECT_EQ(fault(), Fault::kTelegramFailure) << "SYNC is something else";
}

TEST_P(MsdCanFailure, TelegramsAreNotMonitoredByDefault) {
  switch_on();
  rig.sync();
  rig.run(500ms);
  EXPECT_EQ(fault(), std::nullopt);
}

// Ours: leaving Operational with the power on is a fault; without power it is none.
TEST_P(MsdCanFailure, LeavingOperationalWithPowerOnIsAFault) {
  rig.operate();
  rig.nmt(NmtCommand::kEnterPreOperational);
  EXPECT_EQ(fault(), std::nullopt);
  switch_on();
  rig.nmt(NmtCommand::kStop);
  EXPECT_EQ(fault(), Fault::kCommunicationEnded);
  EXPECT_THAT(rig.emergencies(), IsEmpty()) << "not in Stopped";
  rig.nmt(NmtCommand::kEnterPreOperational);
  EXPECT_THAT(rig.emergencies(), ElementsAre(hex("00 FF 11 0C 05 00 00 00")));
}

TEST_P(MsdCanFailure, BusOffIsAFaultThatIsToldWhenTheBusIsBack) {
  switch_on();
  // Frames of its own that others destroy until it is bus off.
  ASSERT_EQ(rig.write(0x1017, 0, 1, 2), 0U);
  rig.bus.inject({.kind = can::FrameFaultKind::kBitError, .identifier = 0x70C, .mask = 0x7FF, .count = 40});
  rig.run(100ms);
  EXPECT_EQ(fault(), Fault::kBusOff);
  EXPECT_EQ(rig.drive.device().state(), NmtState::kPreOperational);
  rig.drive.device().controller()->recover(rig.bus.now());
  rig.run(20ms);
  ASSERT_FALSE(rig.emergencies().empty());
  EXPECT_EQ(rig.read(0x1003, 1), 0x010C'FF00U);
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(fault(), std::nullopt);
}

// Its controller starts again with the voltage, so bus off is over: the fault had stayed for ever.
TEST_P(MsdCanFailure, BusOffThatEndsWithTheVoltageAtX32CanBeAcknowledged) {
  ASSERT_EQ(rig.write(0x1017, 0, 1, 2), 0U);
  rig.bus.inject({.kind = can::FrameFaultKind::kBitError, .identifier = 0x70C, .mask = 0x7FF, .count = 40});
  rig.run(20ms);
  ASSERT_EQ(fault(), Fault::kBusOff);
  rig.drive.set_bus_supply(false);
  rig.run(1ms);
  rig.drive.set_bus_supply(true);
  rig.run(5ms);
  EXPECT_EQ(fault(), Fault::kBusOff) << "until it is acknowledged";
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  EXPECT_EQ(fault(), std::nullopt);
}

// Acknowledge: rising edge of bit 7 in an RxPDO, in the cycle of PDOs.
TEST_P(MsdCanFailure, IsAcknowledgedByTheControlWord) {
  rig.operate();
  rig.drive.core().raise(Fault::kEncoder);
  rig.run(20ms);
  rig.control(0x80);
  EXPECT_EQ(fault(), std::nullopt);
  EXPECT_EQ(rig.emergencies().back(), hex("00 00 00 00 00 00 00 00"));
  rig.drive.core().raise(Fault::kEncoder);
  rig.run(20ms);
  rig.control(0x80);
  EXPECT_EQ(fault(), Fault::kEncoder) << "no edge";
}

INSTANTIATE_TEST_SUITE_P(Drives, MsdCanEmergency, kEachDrive, drive_name);
INSTANTIATE_TEST_SUITE_P(Drives, MsdCanFailure, kEachDrive, drive_name);
INSTANTIATE_TEST_SUITE_P(Drives, MsdCanHeartbeat, ::testing::Values(Variant::kMsd), drive_name);

}  // namespace
}  // namespace driveline::slaves::msd
