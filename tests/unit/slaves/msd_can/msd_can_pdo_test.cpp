// PDOs of the MSD on a CAN bus: transmission types, events and their masks, times, mapping (MSD manual 8.3).
#include "can_drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint32_t kName = 0x2003'0010;
constexpr std::uint32_t kFiller = 0x2807'0008;  ///< P 2055
constexpr std::uint32_t kOutputs = 0x60FE'0120;

class MsdCanPdo : public MsdCan {
 protected:
  /// Sends the filler byte by RxPDO 2 and lets the cycle of PDOs pass.
  void fill(std::uint8_t value, std::chrono::nanoseconds then = 3ms) {
    rig.send(Frame::of(0x30C, std::array{static_cast<std::byte>(value)}), then);
  }
  [[nodiscard]] std::uint64_t filler() const { return rig.value(0x2807); }
};

TEST_P(MsdCanPdo, TypesAreThoseOfTheManual) {
  for (const std::uint32_t type : {0U, 1U, 17U, 240U, 254U, 255U}) {
    EXPECT_EQ(rig.write(0x1400, 2, type, 1), 0U) << type;
    EXPECT_EQ(rig.write(0x1803, 2, type, 1), 0U) << type;
  }
  for (const std::uint32_t type : {241U, 251U, 252U, 253U}) {
    EXPECT_EQ(rig.write(0x1400, 2, type, 1), 0x0609'0030U) << type;
    EXPECT_EQ(rig.write(0x1803, 2, type, 1), 0x0609'0030U) << type;
  }
}

TEST_P(MsdCanPdo, WithoutMappingNothingIsSentOrTaken) {
  rig.start();
  fill(0x5A);
  rig.run(100ms);
  EXPECT_EQ(filler(), 0U);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(rig.count(0x18C + 0x100 * i), 0U);
  EXPECT_THAT(rig.emergencies(), IsEmpty());
}

// A synchronous RxPDO is applied with the next SYNC, whatever its number of SYNCs is.
TEST_P(MsdCanPdo, SynchronousRxPdoWaitsForItsSync) {
  for (const std::uint8_t type : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{5}}) {
    rig.nmt(NmtCommand::kEnterPreOperational);
    rig.map(0x1401, {kFiller}, type);
    rig.start();
    const auto value = static_cast<std::uint8_t>(0x40 + type);
    fill(0x33);
    fill(value);
    EXPECT_NE(filler(), value);
    rig.sync();
    EXPECT_EQ(filler(), value) << "the newest one";
    fill(0x11);
  }
}

// Types FEh and FFh: applied in the cycle of PDOs of 1 ms, in which the newest frame counts; SYNC is irrelevant.
TEST_P(MsdCanPdo, EventDrivenRxPdoIsAppliedEveryMillisecond) {
  rig.map(0x1401, {kFiller}, 254);
  rig.start();
  rig.bus.advance((rig.bus.now() / 1ms + 1) * 1ms);
  fill(0x21, 200us);
  EXPECT_EQ(filler(), 0U);
  fill(0x22, 200us);
  rig.send(0x80, "", 200us);
  EXPECT_EQ(filler(), 0U);
  rig.run(399us);
  EXPECT_EQ(filler(), 0U) << "999 us of the cycle";
  rig.run(1us);
  EXPECT_EQ(filler(), 0x22U) << "the one before it was overwritten";
}

// A TxPDO with types FEh, FFh is sent after the RxPDO of its number, even without a change.
TEST_P(MsdCanPdo, RxPdoIsAnsweredByTheTxPdoOfItsNumber) {
  rig.map(0x1401, {kFiller});
  rig.map(0x1801, {0x6060'0008});
  rig.map(0x1802, {0x6060'0008});
  rig.start();
  rig.run(10ms);
  rig.master.received.clear();
  fill(0x21);
  EXPECT_EQ(rig.count(0x28C), 1U);
  fill(0x21);
  EXPECT_EQ(rig.count(0x28C), 2U);
  EXPECT_EQ(rig.count(0x38C), 0U);
  ASSERT_EQ(rig.write(0x1801, 2, 0, 1), 0U);
  rig.sync();
  rig.master.received.clear();
  fill(0x21);
  rig.sync();
  EXPECT_EQ(rig.count(0x28C), 0U) << "a synchronous one is sent for an event of its own";
  ASSERT_EQ(rig.write(0x1801, 2, 255, 1), 0U);
  ASSERT_EQ(rig.write(0x1401, 2, 1, 1), 0U);
  rig.master.received.clear();
  fill(0x21);
  rig.sync();
  EXPECT_EQ(rig.count(0x28C), 0U) << "a synchronous RxPDO is not answered";
}

TEST_P(MsdCanPdo, SynchronousTxPdoIsSentEveryNthSync) {
  rig.map(0x1801, {0x6041'0010}, 3);
  rig.start();
  for (int i = 1; i <= 9; ++i) {
    rig.sync();
    EXPECT_EQ(rig.count(0x28C), static_cast<std::size_t>(i / 3)) << i;
  }
}

// Values of a TxPDO are those behind the application of the RxPDOs of its SYNC.
TEST_P(MsdCanPdo, SynchronousTxPdoIsSentBehindTheRxPdo) {
  rig.map(0x1401, {kFiller}, 1);
  rig.map(0x1801, {kFiller}, 1);
  rig.start();
  fill(0x6B, 1ms);
  rig.sync();
  EXPECT_THAT(rig.payloads(0x28C), ElementsAre(hex("6B")));
}

TEST_P(MsdCanPdo, AcyclicTxPdoWaitsForAnEventAndTheNextSync) {
  rig.map(0x1801, {0x6041'0010}, 0);
  rig.start();
  rig.sync();  // the first values
  rig.master.received.clear();
  rig.sync();
  EXPECT_EQ(rig.count(0x28C), 0U);
  rig.drive.core().set_dc_link(false);
  rig.run(20ms);
  EXPECT_EQ(rig.count(0x28C), 0U);
  rig.sync();
  EXPECT_EQ(rig.count(0x28C), 1U);
  rig.sync();
  EXPECT_EQ(rig.count(0x28C), 1U);
}

// Any bit of the mapped data is an event for this TxPDO and no other.
TEST_P(MsdCanPdo, ChangedBitsSendTheirOwnTxPdo) {
  rig.map(0x1800, {kFiller});
  rig.map(0x1801, {kOutputs});
  rig.map(0x1403, {kFiller});
  rig.start();
  rig.run(10ms);
  rig.master.received.clear();
  rig.send(0x50C, "01", 3ms);
  EXPECT_THAT(rig.payloads(0x18C), ElementsAre(hex("01")));
  rig.send(0x50C, "01", 3ms);
  EXPECT_EQ(rig.count(0x18C), 1U);
  rig.send(0x50C, "81", 3ms);
  EXPECT_EQ(rig.count(0x18C), 2U);
  EXPECT_EQ(rig.count(0x28C), 0U);
}

// P 2007 (MSD manual Table 8.4): 8 bytes of TxPDO 1 with [0] = 0000FFFFh, [1] = 0, as in the example of the manual, and
// the other way round for TxPDO 3.
TEST_P(MsdCanPdo, EventMasksInhibitBits) {
  rig.map(0x1403, {kFiller, kTargetPosition});
  rig.map(0x1800, {kFiller, kFiller, kTargetVelocity, 0x6042'0010});
  rig.map(0x1802, {kFiller, kFiller, kTargetPosition, 0x6042'0010});
  ASSERT_EQ(rig.write(0x27D7, 0, 0x0000'FFFF, 4), 0U);
  ASSERT_EQ(rig.write(0x27D7, 1, 0, 4), 0U);
  ASSERT_EQ(rig.write(0x27D7, 4, 0, 4), 0U);
  ASSERT_EQ(rig.write(0x27D7, 5, 0x0000'00FF, 4), 0U);  // byte 4: bits 16 to 23 of the position
  rig.start();
  rig.run(10ms);
  rig.master.received.clear();
  rig.send(0x50C, "A5 00 00 00 00", 3ms);
  EXPECT_THAT(rig.payloads(0x18C), ElementsAre(hex("A5 A5 00 00 00 00 00 00")));
  EXPECT_EQ(rig.count(0x38C), 0U);
  rig.send(0x50C, "A5 34 12 00 00", 3ms);
  EXPECT_EQ(rig.count(0x38C), 0U) << "bytes 2 and 3";
  rig.send(0x50C, "A5 34 12 07 00", 3ms);
  EXPECT_THAT(rig.payloads(0x38C), ElementsAre(hex("A5 A5 34 12 07 00 00 00")));
  ASSERT_EQ(rig.write(0x60FF, 0, 0x1234'5678, 4), 0U);
  ASSERT_EQ(rig.write(0x6042, 0, 77, 2), 0U);
  EXPECT_EQ(rig.count(0x18C), 1U);
  EXPECT_EQ(rig.count(0x38C), 1U);
}

TEST_P(MsdCanPdo, InhibitTimeIsWholeMilliseconds) {
  for (const std::uint32_t time : {1U, 5U, 15U, 101U}) EXPECT_EQ(rig.write(0x1800, 3, time, 2), 0x0609'0030U) << time;
  ASSERT_EQ(rig.write(0x1803, 3, 150, 2), 0U);  // 15 ms
  rig.map(0x1803, {kFiller});
  rig.map(0x1401, {kFiller});
  rig.start();
  rig.run(30ms);
  rig.master.received.clear();
  for (std::uint8_t i = 1; i <= 20; ++i) fill(i);  // 60 ms
  rig.run(20ms);
  const auto sent = rig.seen(0x48C);
  ASSERT_EQ(sent.size(), 5U);
  for (std::size_t i = 1; i < sent.size(); ++i) EXPECT_GE(sent[i].time - sent[i - 1].time, 14'900us);
  EXPECT_EQ(sent.back().frame.payload()[0], std::byte{20}) << "the newest value";
}

TEST_P(MsdCanPdo, EventTimerSendsCyclically) {
  ASSERT_EQ(rig.write(0x1801, 5, 7, 2), 0U);
  rig.map(0x1801, {kFiller});
  rig.start();
  rig.run(10ms);
  rig.master.received.clear();
  rig.run(70ms);
  EXPECT_EQ(rig.count(0x28C), 10U);
}

TEST_P(MsdCanPdo, TakesEightObjectsAndEightBytes) {
  EXPECT_EQ(rig.write(0x1600, 9, kFiller, 4), 0x0609'0011U) << "there is no ninth";
  for (std::uint8_t sub = 1; sub <= 8; ++sub) ASSERT_EQ(rig.write(0x1600, sub, kFiller, 4), 0U);
  EXPECT_EQ(rig.write(0x1600, 0, 9, 1), 0x0604'0042U);
  EXPECT_EQ(rig.write(0x1600, 0, 8, 1), 0U);
  ASSERT_EQ(rig.write(0x1600, 0, 0, 1), 0U);
  ASSERT_EQ(rig.write(0x1600, 8, 0x6040'0010, 4), 0U);
  EXPECT_EQ(rig.write(0x1600, 0, 8, 1), 0x0604'0042U) << "nine bytes";
  EXPECT_EQ(rig.write(0x1601, 1, kName, 4), 0x0604'0041U) << "a text";
  EXPECT_EQ(rig.write(0x1601, 1, 0x6064'0020, 4), 0x0604'0041U) << "an actual value is not received";
  EXPECT_EQ(rig.write(0x1601, 1, 0x0005'0008, 4), 0x0602'0000U) << "the filler is P 2055";
}

// The images of the terminals (MSD manual 8.3.2).
TEST_P(MsdCanPdo, ImagesOfTheTerminalsCanBeMapped) {
  rig.map(0x1802, {0x2079'0020, 0x208F'0020});
  rig.start();
  rig.run(5ms);
  const auto before = rig.payloads(0x38C);
  ASSERT_FALSE(before.empty());
  rig.drive.core().set_input(Input::kIsd03, true);
  rig.run(5ms);
  const auto after = rig.payloads(0x38C);
  ASSERT_EQ(after.size(), before.size() + 1) << "an input is an event";
  EXPECT_EQ(after.back()[0] ^ before.back()[0], std::byte{0x10}) << "bit 4: ISD03";
}

// Parameters can be mapped; what an SDO would refuse changes nothing (MSD manual 8.3.2).
TEST_P(MsdCanPdo, ParametersInAnRxPdoActAsWrittenBySdo) {
  rig.map(0x1401, {0x2177'0020});  // P 375 in %
  rig.start();
  rig.send(Frame::of(0x30C, bytes::to_le_bytes(std::bit_cast<std::uint32_t>(37.5F))), 3ms);
  EXPECT_EQ(rig.value(0x2177), std::bit_cast<std::uint32_t>(37.5F));
  EXPECT_NEAR(rig.drive.core().motion().settings().speed_feed_forward, 0.375, 1e-9);
  rig.send(Frame::of(0x30C, bytes::to_le_bytes(std::bit_cast<std::uint32_t>(101.0F))), 3ms);
  EXPECT_EQ(rig.value(0x2177), std::bit_cast<std::uint32_t>(37.5F)) << "beyond its limit";
}

// Firmware before 124.15-02 needs PDOs of an even length (MSD manual 8.3.3).
TEST(MsdCanFirmware, OldOneNeedsAnEvenNumberOfBytes) {
  MsdParameters parameters;
  parameters.firmware = FirmwareVersion{124, 15, 1};
  CanDriveRig rig(parameters);
  rig.run(5ms);
  ASSERT_EQ(rig.write(0x1600, 1, kFiller, 4), 0U);
  EXPECT_EQ(rig.write(0x1600, 0, 1, 1), 0x0604'0043U);
  ASSERT_EQ(rig.write(0x1600, 2, kFiller, 4), 0U);
  EXPECT_EQ(rig.write(0x1600, 0, 2, 1), 0U);
}

TEST_P(MsdCanPdo, RemoteFramesAreAnswered) {
  rig.map(0x1801, {kFiller});
  rig.start();
  rig.run(5ms);
  rig.master.received.clear();
  rig.send(Frame::remote({0x28C, false}, 1));
  EXPECT_EQ(rig.count(0x28C), 1U);
}

INSTANTIATE_TEST_SUITE_P(Drives, MsdCanPdo, kEachDrive, drive_name);

}  // namespace
}  // namespace driveline::slaves::msd
