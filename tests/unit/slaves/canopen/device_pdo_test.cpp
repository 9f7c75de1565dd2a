#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

// C38: an RPDO shorter than its mapping is not used, EMCY 8210h, once; it goes with the next good one.
TEST_F(CanopenDevice, C38ShortRpdo) {
  rig.map(0x1400, {0x2000'0010, 0x2001'0008});
  rig.start();
  rig.send(0x205, "34 12");
  rig.send(0x205, "35 12");
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);
  EXPECT_THAT(rig.application.applied, IsEmpty());
  EXPECT_THAT(rig.payloads(0x085), ElementsAre(hex("10 82 11 00 00 00 00 00")));
  rig.send(0x205, "36 12 07");
  EXPECT_EQ(rig.value(0x2000), 0x1236U);
  EXPECT_EQ(rig.payloads(0x085).back(), hex("00 00 00 00 00 00 00 00"));
  EXPECT_EQ(rig.device.state(), NmtState::kOperational);
}

// C38 (CANopenNode #21): of a longer RPDO the first bytes are used.
TEST_F(CanopenDevice, C38LongRpdo) {
  rig.map(0x1400, {0x2000'0010});
  rig.start();
  rig.send(0x205, "34 12 99 99");
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_THAT(rig.seen(0x085), IsEmpty());
}

TEST(CanopenLongRpdo, C38IsAnErrorWhereTheDeviceSaysSo) {
  DeviceRig rig({.long_rpdo_emergency = true});
  rig.run(2ms);
  rig.map(0x1401, {0x2000'0010});
  rig.start();
  rig.send(0x305, "34 12 99");
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_THAT(rig.payloads(0x085), ElementsAre(hex("20 82 11 00 00 00 00 00")));
  rig.send(0x305, "35 12");
  EXPECT_EQ(rig.payloads(0x085).back(), hex("00 00 00 00 00 00 00 00"));
}

// C39 (CANopenNode #23): types 0 to 240: the newest frame since the last SYNC, at the next SYNC, kept until then.
TEST_F(CanopenDevice, C39SynchronousRpdoWaitsForItsSync) {
  for (const std::uint8_t type : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{240}}) {
    rig.nmt(canopen::NmtCommand::kResetNode);
    rig.map(0x1400, {0x2000'0010}, type);
    rig.start();
    rig.send(0x205, "11 11");
    rig.send(0x205, "22 22");
    rig.run(500ms);  // kept
    EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17) << int{type};
    rig.sync();
    EXPECT_EQ(rig.value(0x2000), 0x2222U) << int{type};
    rig.set(0x2000, 5);
    rig.sync();
    EXPECT_EQ(rig.value(0x2000), 5U) << int{type};  // once
  }
}

// MC7000 manual 6.5.1: type n waits for n SYNCs; newer frames replace the one that waits.
TEST(CanopenSyncCount, AnRpdoWaitsForAsManySyncsAsItsTypeSays) {
  DeviceRig rig({.rpdo_counts_syncs = true});
  rig.run(2ms);
  rig.map(0x1400, {0x2000'0010}, 3);
  rig.start();
  rig.sync();
  rig.send(0x205, "11 11");
  rig.sync();
  rig.send(0x205, "22 22");
  rig.sync();
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);
  rig.sync();
  EXPECT_EQ(rig.value(0x2000), 0x2222U);
  rig.map(0x1400, {0x2000'0010}, 0);
  rig.send(0x205, "33 33");
  rig.sync();
  EXPECT_EQ(rig.value(0x2000), 0x3333U) << "type 0: the next one";
}

TEST_F(CanopenDevice, C39EventDrivenRpdoAtOnce) {
  for (const std::uint8_t type : {std::uint8_t{254}, std::uint8_t{255}}) {
    rig.nmt(canopen::NmtCommand::kResetNode);
    rig.map(0x1400, {0x2000'0010}, type);
    rig.start();
    rig.send(0x205, "11 F1");
    EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), static_cast<std::int16_t>(0xF111)) << int{type};
  }
}

// C40: type 0: after an event at the next SYNC.
TEST_F(CanopenDevice, C40AcyclicTpdo) {
  rig.map(0x1800, {0x2001'0008}, 0);
  rig.start();
  rig.sync();
  EXPECT_EQ(rig.seen(0x185).size(), 1U);  // the first values
  rig.sync();
  EXPECT_EQ(rig.seen(0x185).size(), 1U);
  rig.set(0x2001, 42);
  rig.device.watch(rig.bus.now());
  rig.run(5ms);
  EXPECT_EQ(rig.seen(0x185).size(), 1U);
  rig.sync();
  rig.sync();
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("05"), hex("2A")));
}

// C40: types 1 to 240: each n-th SYNC, counted from Operational.
TEST_F(CanopenDevice, C40CyclicTpdo) {
  rig.map(0x1800, {0x2001'0008}, 1);
  rig.map(0x1801, {0x2001'0008}, 3);
  rig.sync();
  rig.sync();  // of Pre-operational
  rig.start();
  for (int i = 0; i < 7; ++i) rig.sync();
  EXPECT_EQ(rig.seen(0x185).size(), 7U);
  EXPECT_EQ(rig.seen(0x285).size(), 2U);
}

// C40: types 254, 255: on a change of a bit under the mask, and cyclically by the event timer.
TEST_F(CanopenDevice, C40EventsOfAMask) {
  rig.map(0x1800, {0x2000'0010, 0x2001'0008});
  rig.application.mask = 0x00F0'FFFF;
  rig.start();
  EXPECT_EQ(rig.seen(0x185).size(), 1U);
  rig.set(0x2001, 0x0F);
  rig.device.watch(rig.bus.now());
  rig.run(1ms);
  EXPECT_EQ(rig.seen(0x185).size(), 1U);
  rig.set(0x2001, 0x1F);
  rig.device.watch(rig.bus.now());
  rig.run(1ms);
  EXPECT_EQ(rig.payloads(0x185).back(), hex("EF FF 1F"));
  rig.sync();
  EXPECT_EQ(rig.seen(0x185).size(), 2U);  // SYNC does not matter to it
}

TEST_F(CanopenDevice, C40EventTimer) {
  rig.map(0x1800, {0x2001'0008}, 254);
  ASSERT_EQ(rig.write(0x1800, 5, 8, 2), 0U);
  rig.start();
  rig.run(40ms);
  const auto frames = rig.seen(0x185);
  ASSERT_GE(frames.size(), 5U);
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_NEAR(nanos(frames[i].time - frames[i - 1].time), 8e6, 100e3);
  ASSERT_EQ(rig.write(0x1800, 5, 0, 2), 0U);
  rig.master.received.clear();
  rig.run(40ms);
  EXPECT_THAT(rig.seen(0x185), IsEmpty());
}

// C41: synchronous TPDOs carry values sampled at the SYNC, also when their frame leaves late.
TEST_F(CanopenDevice, C41ValuesOfTheSync) {
  rig.map(0x1800, {0x2002'0020}, 1);
  rig.start();
  rig.set(0x2002, 0x1111'1111);
  can::ScriptedNode other;
  rig.bus.attach(other);
  // Better frames occupy the bus behind the SYNC, while the value changes.
  const nanoseconds begin = rig.bus.now();
  rig.master.send_at(begin, Frame::of(0x080, {}));
  for (int i = 0; i < 5; ++i) other.send_at(begin, Frame::of(0x090, hex("01 02 03 04 05 06 07 08")));
  rig.run(200us);
  rig.set(0x2002, 0x2222'2222);
  rig.run(3ms);
  EXPECT_EQ(rig.payloads(0x185).back(), hex("11 11 11 11"));
  EXPECT_GT(rig.seen(0x185).back().time, begin + 600us);
}

// C42 (CANFestivino #8): an event inside the inhibit time is sent once, with the newest value, when it ends.
TEST_F(CanopenDevice, C42InhibitTime) {
  rig.map(0x1800, {0x2001'0008});
  ASSERT_EQ(rig.write(0x1800, 3, 100, 2), 0U);  // 10 ms
  rig.start();
  for (unsigned value = 50; value < 60; ++value) {
    rig.set(0x2001, value);
    rig.device.watch(rig.bus.now());
    rig.run(700us);
  }
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("05")));
  rig.run(100ms);
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("05"), hex("3B")));
  EXPECT_NEAR(nanos(rig.seen(0x185)[1].time - rig.seen(0x185)[0].time), 10e6, 50e3);
}

TEST_F(CanopenDevice, C42TheEventTimerObeysTheInhibitTime) {
  rig.map(0x1800, {0x2001'0008});
  ASSERT_EQ(rig.write(0x1800, 3, 200, 2), 0U);  // 20 ms
  ASSERT_EQ(rig.write(0x1800, 5, 5, 2), 0U);
  rig.start();
  rig.run(100ms);
  EXPECT_NEAR(static_cast<double>(rig.seen(0x185).size()), 5.5, 1.0);
}

// C43: a remote frame of a valid TPDO with bit 30 = 0 is answered.
TEST_F(CanopenDevice, C43RemoteFrames) {
  rig.map(0x1800, {0x2001'0008});
  rig.map(0x1801, {0x2001'0008}, 9);
  ASSERT_EQ(rig.write(0x1802, 1, 0x4000'0385, 4), 0U);
  rig.map(0x1802, {0x2001'0008});
  rig.start();
  rig.master.received.clear();
  rig.set(0x2001, 33);
  for (const std::uint32_t identifier : {0x185U, 0x285U, 0x385U, 0x485U})
    rig.send(Frame::remote({identifier, false}, 1));
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("21")));
  EXPECT_THAT(rig.payloads(0x285), ElementsAre(hex("05")));  // synchronous: sampled before
  EXPECT_EQ(rig.seen(0x485).size(), 0U);                     // nothing is mapped
  ASSERT_EQ(rig.write(0x1800, 1, 0x4000'0185, 4), 0U);
  rig.master.received.clear();
  rig.send(Frame::remote({0x185, false}, 1));
  EXPECT_THAT(rig.seen(0x185), IsEmpty());
}

// C44: PDOs exist in Operational only.
TEST_F(CanopenDevice, C44PdosOutsideOperational) {
  rig.map(0x1400, {0x2000'0010}, 1);
  rig.map(0x1800, {0x2001'0008}, 1);
  rig.send(0x205, "34 12");
  rig.sync();
  rig.send(Frame::remote({0x185, false}, 1));
  rig.send(0x205, "34");  // too short, and nobody cares
  rig.start();
  rig.sync();
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);  // what came before is dropped
  EXPECT_EQ(rig.seen(0x185).size(), 1U);
  EXPECT_THAT(rig.seen(0x085), IsEmpty());
  rig.send(0x205, "35 12");
  rig.nmt(canopen::NmtCommand::kEnterPreOperational);
  rig.start();
  rig.sync();
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);
}

// Two RPDOs with one identifier are both taken; a PDO that is off takes nothing.
TEST_F(CanopenDevice, C35SharedAndInvalidRpdos) {
  rig.map(0x1400, {0x2000'0010});
  rig.map(0x1401, {0x2001'0008});
  ASSERT_EQ(rig.write(0x1401, 1, 0x8000'0205, 4), 0U);
  ASSERT_EQ(rig.write(0x1401, 1, 0x0000'0205, 4), 0U);
  rig.start();
  rig.send(0x205, "34 12");
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_EQ(rig.value(0x2001), 0x34U);
  ASSERT_EQ(rig.write(0x1400, 1, 0x8000'0205, 4), 0U);
  rig.send(0x205, "35 12");
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_EQ(rig.value(0x2001), 0x35U);
}

// A mapping that is changed in Operational counts from the next message on.
TEST_F(CanopenDevice, C36AMappingOfARunningTpdoIsReadAgain) {
  rig.map(0x1800, {0x2001'0008}, 1);
  rig.start();
  rig.sync();
  rig.map(0x1800, {0x2000'0010, 0x2001'0008}, 1);
  rig.sync();
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("05"), hex("EF FF 05")));
}

}  // namespace
}  // namespace driveline::slaves::cia301
