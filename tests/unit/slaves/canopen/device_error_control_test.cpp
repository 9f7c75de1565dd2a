#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

using canopen::NmtCommand;

// C17: heartbeat at once when 1017h is written, with an exact period and the state.
TEST_F(CanopenDevice, C17HeartbeatHasAnExactPeriod) {
  rig.master.received.clear();
  ASSERT_EQ(rig.write(0x1017, 0, 7, 2), 0U);
  rig.run(20ms);
  rig.start();
  rig.run(7ms);
  rig.nmt(NmtCommand::kStop);
  rig.run(7ms);
  const auto beats = rig.seen(0x705);
  ASSERT_GE(beats.size(), 5U);
  for (std::size_t i = 2; i < beats.size(); ++i) EXPECT_NEAR(nanos(beats[i].time - beats[i - 1].time), 7e6, 300e3) << i;
  const auto bytes = rig.payloads(0x705);
  EXPECT_EQ(bytes.front(), hex("7F"));
  EXPECT_THAT(bytes, ::testing::Contains(hex("05")));
  EXPECT_EQ(bytes.back(), hex("04"));
  rig.nmt(NmtCommand::kEnterPreOperational);
  ASSERT_EQ(rig.write(0x1017, 0, 0, 2), 0U);
  rig.master.received.clear();
  rig.run(30ms);
  EXPECT_THAT(rig.seen(0x705), IsEmpty());
}

// C17: the boot-up message is the first heartbeat; no burst after reset (CANopenNode #30).
TEST_F(CanopenDevice, C17NoBurstAfterReset) {
  ASSERT_EQ(rig.write(0x1017, 0, 10, 2), 0U);
  ASSERT_EQ(rig.write(0x1010, 1, 0x65766173, 4), 0U);
  rig.run(100ms);
  rig.master.received.clear();
  rig.nmt(NmtCommand::kResetNode);
  rig.run(25ms);
  const auto beats = rig.seen(0x705);
  ASSERT_EQ(beats.size(), 3U);
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("00"), hex("7F"), hex("7F")));
  EXPECT_NEAR(nanos(beats[1].time - beats[0].time), 10e6, 5e3);  // the frames differ by some stuff bits
  EXPECT_EQ(beats[2].time - beats[1].time, 10ms);
}

// C18: the toggle bit starts with 0 after boot-up and reset communication.
TEST_F(CanopenDevice, C18GuardingToggles) {
  const auto guard = [&] { rig.send(Frame::remote({0x705, false}, 1)); };
  rig.master.received.clear();
  guard();
  guard();
  rig.start();
  guard();
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("7F"), hex("FF"), hex("05")));
  rig.nmt(NmtCommand::kResetCommunication);
  rig.master.received.clear();
  guard();
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("7F")));
  rig.send(0x705, "");  // a data frame is no guarding
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("7F")));
}

// C19: life guarding begins with the first remote frame, is one event, and begins again with the next remote frame.
TEST_F(CanopenDevice, C19LifeGuarding) {
  ASSERT_EQ(rig.write(0x100C, 0, 20, 2), 0U);
  ASSERT_EQ(rig.write(0x100D, 0, 3, 1), 0U);
  rig.start();
  rig.run(200ms);
  EXPECT_THAT(rig.application.events, IsEmpty());
  rig.send(Frame::remote({0x705, false}, 1));
  const nanoseconds asked = rig.seen(0x705).back().time;
  rig.run(58ms);
  EXPECT_THAT(rig.application.events, IsEmpty());
  rig.run(200ms);
  ASSERT_EQ(rig.application.events.size(), 1U);
  EXPECT_EQ(rig.application.events[0].first, CommunicationEvent::kLifeGuardingLost);
  EXPECT_NEAR(nanos(rig.application.events[0].second - asked), 60e6, 200e3);
  EXPECT_EQ(rig.device.state(), NmtState::kPreOperational);  // C27
  EXPECT_THAT(rig.payloads(0x085), ElementsAre(hex("30 81 11 00 00 00 00 00")));
  rig.send(Frame::remote({0x705, false}, 1));
  ASSERT_EQ(rig.application.events.size(), 2U);
  EXPECT_EQ(rig.application.events[1].first, CommunicationEvent::kLifeGuardingBack);
  EXPECT_EQ(rig.payloads(0x085).back(), hex("00 00 00 00 00 00 00 00"));
  rig.run(70ms);
  EXPECT_EQ(rig.application.events.size(), 3U);
}

// C20: 1017h other than 0 switches guarding off.
TEST_F(CanopenDevice, C20HeartbeatInsteadOfGuarding) {
  ASSERT_EQ(rig.write(0x100C, 0, 20, 2), 0U);
  ASSERT_EQ(rig.write(0x100D, 0, 3, 1), 0U);
  rig.send(Frame::remote({0x705, false}, 1));
  ASSERT_EQ(rig.write(0x1017, 0, 1000, 2), 0U);
  rig.master.received.clear();
  rig.send(Frame::remote({0x705, false}, 1));
  EXPECT_THAT(rig.seen(0x705), IsEmpty());
  rig.run(200ms);
  EXPECT_THAT(rig.application.events, IsEmpty());  // and life guarding is over
}

TEST(CanopenGuarding, ItsIdentifierIsASetting) {  // as guarding identifiers in an object of their own
  DeviceRig rig({.error_control = 0x640});
  rig.run(2ms);
  rig.send(Frame::remote({0x645, false}, 1));
  EXPECT_THAT(rig.payloads(0x645), ElementsAre(hex("7F")));
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("00")));
}

// C21: begins with the first heartbeat; lost is one event; heartbeat again is its end; boot-up is an event, too.
TEST_F(CanopenDevice, C21HeartbeatConsumer) {
  ASSERT_EQ(rig.write(0x1016, 2, 0x0009'0032, 4), 0U);  // node 9, 50 ms; sub-index 1 is unused (CANopenNode #229)
  rig.start();
  rig.run(300ms);
  EXPECT_THAT(rig.application.events, IsEmpty());
  rig.send(0x709, "05");
  rig.run(40ms);
  rig.send(0x709, "05");
  rig.send(0x70A, "05");  // another one
  rig.run(300ms);
  rig.send(0x709, "05");
  rig.send(0x709, "00");
  std::vector<CommunicationEvent> events;
  for (const auto& event : rig.application.events) events.push_back(event.first);
  EXPECT_THAT(events, ElementsAre(CommunicationEvent::kHeartbeatLost, CommunicationEvent::kHeartbeatBack,
                                  CommunicationEvent::kMonitoredNodeBoot));
  // CANopenNode #631, #632: the error goes away when the heartbeat is back.
  EXPECT_THAT(rig.payloads(0x085), ElementsAre(hex("30 81 11 00 00 00 00 00"), hex("00 00 00 00 00 00 00 00")));
  EXPECT_EQ(rig.value(0x1001), 0U);
}

TEST_F(CanopenDevice, C21TheErrorGoesWhenTheLastLostNodeIsBack) {
  ASSERT_EQ(rig.write(0x1016, 1, 0x0007'0014, 4), 0U);
  ASSERT_EQ(rig.write(0x1016, 3, 0x0009'0028, 4), 0U);
  rig.send(0x707, "05");
  rig.send(0x709, "05");
  rig.run(100ms);
  EXPECT_EQ(rig.application.events.size(), 2U);
  EXPECT_EQ(rig.payloads(0x085).size(), 1U);  // one error, one message
  rig.send(0x707, "05");
  EXPECT_EQ(rig.value(0x1001), 0x11U);
  rig.send(0x709, "05");
  EXPECT_EQ(rig.value(0x1001), 0U);
}

TEST_F(CanopenDevice, C21ANodeIsNotMonitoredTwice) {
  ASSERT_EQ(rig.write(0x1016, 1, 0x0007'0014, 4), 0U);
  EXPECT_EQ(rig.write(0x1016, 2, 0x0007'0032, 4), 0x0604'0043U);
  EXPECT_EQ(rig.write(0x1016, 2, 0x0007'0000, 4), 0U);  // time 0: off
  EXPECT_EQ(rig.write(0x1016, 1, 0x0007'0015, 4), 0U);
  rig.send(0x707, "");  // CANopenNode #102: no state in it
  rig.run(100ms);
  EXPECT_THAT(rig.application.events, IsEmpty());
}

// C27: 1029h decides what a loss of error control does in Operational.
TEST_F(CanopenDevice, C27ErrorBehaviour) {
  struct Row {
    std::uint32_t behaviour;
    NmtState state;
  };
  for (const auto& row :
       {Row{0, NmtState::kPreOperational}, Row{1, NmtState::kOperational}, Row{2, NmtState::kStopped}}) {
    rig.nmt(NmtCommand::kResetCommunication);
    ASSERT_EQ(rig.write(0x1016, 1, 0x0007'0014, 4), 0U);
    ASSERT_EQ(rig.write(0x1029, 1, row.behaviour, 1), 0U);
    rig.start();
    rig.send(0x707, "05");
    rig.run(40ms);
    EXPECT_EQ(rig.device.state(), row.state);
    rig.send(0x707, "05");
  }
}

// C27: bus off leads to Pre-operational; after the recovery a message tells of it.
TEST(CanopenBusOff, C27LeadsToPreOperational) {
  can::Bus bus;
  can::ScriptedNode master;
  ObjectDictionary dictionary(sample_table());
  SampleApplication application;
  Device device(dictionary, application);
  bus.attach(master);
  can::Controller& controller = bus.attach(device, {.automatic_recovery = true});
  bus.advance(2ms);
  master.send_at(2ms, Frame::of(0x000, hex("01 05")));
  bus.advance(4ms);
  ASSERT_EQ(device.state(), NmtState::kOperational);
  master.send_at(4ms, Frame::of(0x605, hex("2B 17 10 00 28 00 00 00")));  // heartbeat, 40 ms
  bus.advance(20ms);
  bus.inject({.count = 32});  // every frame, also the messages about it
  bus.advance(60ms);
  EXPECT_EQ(device.state(), NmtState::kPreOperational);
  EXPECT_EQ(controller.errors().state(), can::ErrorState::kActive);
  std::vector<CommunicationEvent> events;
  for (const auto& event : application.events) events.push_back(event.first);
  EXPECT_THAT(events, ElementsAre(CommunicationEvent::kBusOff, CommunicationEvent::kBusRecovered));
  EXPECT_THAT(master.identifiers(), ElementsAre(0x705, 0x585, 0x705, 0x085, 0x085, 0x085));
  EXPECT_EQ(master.received[4].frame, Frame::of(0x085, hex("40 81 11 00 00 00 00 00")));
}

// The recovery takes 128 times 11 bits, the start of a device less: its boot-up message was lost.
TEST(CanopenBusOff, EndsWithPowerOnBeforeTheBootUpMessage) {
  can::Bus bus;
  can::ScriptedNode master;
  ObjectDictionary dictionary(sample_table());
  SampleApplication application;
  Device device(dictionary, application);
  bus.attach(master);
  can::Controller& controller = bus.attach(device);
  bus.advance(2ms);
  bus.inject({.identifier = 0x585, .mask = 0x7FF, .count = 40});
  master.send_at(2ms, Frame::of(0x605, hex("40 00 10 00 00 00 00 00")));
  bus.advance(20ms);
  ASSERT_EQ(controller.errors().state(), can::ErrorState::kBusOff);
  ASSERT_TRUE(device.persists(CommunicationEvent::kBusOff));
  master.received.clear();
  device.power_on();
  bus.advance(21ms);
  EXPECT_EQ(controller.errors().state(), can::ErrorState::kActive);
  EXPECT_FALSE(device.persists(CommunicationEvent::kBusOff));
  ASSERT_EQ(master.received.size(), 1U);
  EXPECT_EQ(master.received[0].frame, Frame::of(0x705, hex("00")));
}

}  // namespace
}  // namespace driveline::slaves::cia301
