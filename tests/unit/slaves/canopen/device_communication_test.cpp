#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

// C22: SYNC producer with a period in us; bits 0-29 are locked while bit 30 is set.
TEST_F(CanopenDevice, C22ProducesSync) {
  ASSERT_EQ(rig.write(0x1006, 0, 2500, 4), 0U);
  rig.run(20ms);
  EXPECT_THAT(rig.seen(0x080), IsEmpty());
  ASSERT_EQ(rig.write(0x1005, 0, 0x4000'0080, 4), 0U);
  EXPECT_EQ(rig.write(0x1005, 0, 0x4000'0081, 4), 0x0609'0030U);
  rig.run(20ms);
  const auto syncs = rig.seen(0x080);
  ASSERT_GE(syncs.size(), 8U);
  EXPECT_EQ(syncs.back().frame.length, 0);
  EXPECT_NEAR(nanos(syncs[7].time - syncs[0].time), 7 * 2.5e6, 300e3);
  EXPECT_GE(rig.application.syncs.size(), syncs.size());  // it takes its own
  ASSERT_EQ(rig.write(0x1005, 0, 0x0000'0081, 4), 0U);
  rig.master.received.clear();
  rig.run(20ms);
  EXPECT_THAT(rig.seen(0x080), IsEmpty());
  EXPECT_THAT(rig.seen(0x081), IsEmpty());
}

TEST_F(CanopenDevice, C22AProducerLeavesOutWhatItMissedInStopped) {
  ASSERT_EQ(rig.write(0x1006, 0, 2500, 4), 0U);
  ASSERT_EQ(rig.write(0x1005, 0, 0x4000'0080, 4), 0U);
  rig.nmt(canopen::NmtCommand::kStop);
  rig.master.received.clear();
  rig.run(100ms);
  EXPECT_THAT(rig.seen(0x080), IsEmpty());  // C14
  rig.start();
  EXPECT_LE(rig.seen(0x080).size(), 2U);
}

TEST_F(CanopenDevice, C22OtherIdentifiers) {
  EXPECT_EQ(rig.write(0x1005, 0, 0x0000'0605, 4), 0x0609'0030U);  // of an SDO
  EXPECT_EQ(rig.write(0x1005, 0, 0x0000'0880, 4), 0x0609'0030U);  // 12 bits
  EXPECT_EQ(rig.write(0x1006, 0, 99, 4), 0x0609'0032U);           // no bus has room for that
  EXPECT_EQ(rig.write(0x1006, 0, 100, 4), 0U);
  ASSERT_EQ(rig.write(0x1005, 0, 0x2001'2345, 4), 0U);
  rig.send(0x080, "");
  EXPECT_THAT(rig.application.syncs, IsEmpty());
  rig.send(Frame::of(canopen::Identifier{0x1'2345, true}, {}));
  EXPECT_EQ(rig.application.syncs.size(), 1U);
}

// C23: SYNC with 0 bytes, or with a counter where the device has it. CANopenNode #323: SYNC 03.
TEST_F(CanopenDevice, C23Counter) {
  rig.send(0x080, "07");
  EXPECT_THAT(rig.application.syncs, IsEmpty());
  EXPECT_EQ(rig.device.ignored(), 1U);
  rig.send(0x080, "");
  EXPECT_EQ(rig.application.syncs.size(), 1U);
  EXPECT_EQ(rig.write(0x1019, 0, 1, 1), 0x0609'0030U);
  EXPECT_EQ(rig.write(0x1019, 0, 241, 1), 0x0609'0030U);
  ASSERT_EQ(rig.write(0x1019, 0, 3, 1), 0U);
  rig.send(0x080, "");
  EXPECT_EQ(rig.application.syncs.size(), 1U);
  rig.send(0x080, "02");
  EXPECT_EQ(rig.application.syncs.back().first, 2U);
  ASSERT_EQ(rig.write(0x1006, 0, 2500, 4), 0U);
  EXPECT_EQ(rig.write(0x1019, 0, 5, 1), 0x0800'0022U);  // locked while there is a period
  ASSERT_EQ(rig.write(0x1005, 0, 0x4000'0080, 4), 0U);
  rig.run(14ms);
  const auto counters = rig.payloads(0x080);
  ASSERT_GE(counters.size(), 5U);
  EXPECT_THAT((std::vector(counters.begin(), counters.begin() + 5)),
              ElementsAre(hex("01"), hex("02"), hex("03"), hex("01"), hex("02")));
}

// TIME: consumed while bit 31 of 1012h is set (C14: in Pre-operational and Operational).
TEST_F(CanopenDevice, TimeOfDay) {
  rig.send(0x100, "0B FB 61 04 39 3D");
  EXPECT_EQ(rig.application.time_of_day, (canopen::TimeOfDay{73'530'123, 15'673}));
  rig.send(0x100, "00 00 00 00 39");
  EXPECT_EQ(rig.application.time_of_day.milliseconds, 73'530'123U);
  ASSERT_EQ(rig.write(0x1012, 0, 0x0000'0100, 4), 0U);
  rig.send(0x100, "01 00 00 00 02 00");
  EXPECT_EQ(rig.application.time_of_day.milliseconds, 73'530'123U);
}

// Two producers of SYNC, a second NMT master: each message counts.
TEST_F(CanopenDevice, TwoProducersAndTwoMasters) {
  can::ScriptedNode other;
  rig.bus.attach(other);
  rig.map(0x1800, {0x2001'0008}, 2);
  rig.start();
  for (int i = 0; i < 4; ++i) {
    other.send_at(rig.bus.now() + 200us, Frame::of(0x080, {}));
    rig.sync();
  }
  EXPECT_EQ(rig.seen(0x185).size(), 4U);  // of eight SYNCs, the master has seen the other's
  other.send_at(rig.bus.now() + 200us, canopen::NmtRequest{canopen::NmtCommand::kStop, 5}.frame());
  rig.start();
  EXPECT_EQ(rig.device.state(), NmtState::kStopped);
}

}  // namespace
}  // namespace driveline::slaves::cia301
