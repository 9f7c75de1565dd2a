// Several drives on one bus: a common path, the causes for drives that do not answer, and frames that mean nothing.
#include <numbers>
#include <random>

#include "can_drive_rig.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint8_t kFirstNode = 31;  ///< P 2005 = 30, S4 from 1 on

/// Writes the parameters that eight drives share: interpolated position with SYNCs of 2 ms.
void write_common_parameters(const MsdParameters& parameters) {
  CanDriveRig rig(parameters);
  rig.run(5ms);
  ASSERT_EQ(rig.write(0x27D5, 0, 30, 1), 0U);
  ASSERT_EQ(rig.write_real(0x2132, 2.0F), 0U);
  ASSERT_EQ(rig.write(0x1006, 0, 2000, 4), 0U);
  ASSERT_EQ(rig.write(0x60C2, 1, 2, 1), 0U);
  rig.map(0x1400, {0x6040'0010});
  rig.map(0x1401, {0x60C1'0120}, 1);
  rig.map(0x1800, {0x6041'0010, 0x6064'0020}, 1);
  ASSERT_EQ(rig.save(), 0U);
}

/// Eight drives with these parameters and a master that moves them.
class EightDrives {
 public:
  explicit EightDrives(const MsdParameters& parameters) {
    bus.attach(master);
    for (std::uint8_t i = 1; i <= 8; ++i) {
      drives.push_back(std::make_unique<MsdCanDrive>(parameters, CanConnection{DipSwitch{i}, {}, 500us}));
      bus.attach(drives.back()->device());
    }
    run(10ms);
  }
  void run(std::chrono::nanoseconds time) { bus.advance(bus.now() + time); }
  void send(const Frame& frame) { master.send_at(bus.now(), frame); }
  /// Sends a setpoint to each drive, then SYNC.
  void cycle(double share) {
    for (std::uint8_t i = 0; i < 8; ++i) {
      const auto target = static_cast<std::int32_t>(std::lrint(share * turns(i) * kTurn));
      send(Frame::of(0x300U + kFirstNode + i, bytes::to_le_bytes(static_cast<std::uint32_t>(target))));
    }
    send(Frame::of(0x080, {}));
    run(2ms);
  }
  void command(std::uint16_t word, double share) {
    for (std::uint8_t i = 0; i < 8; ++i) send(Frame::of(0x200U + kFirstNode + i, bytes::to_le_bytes(word)));
    run(2ms);
    cycle(share);
    cycle(share);
  }
  /// Length of the path of a drive, in turns: each has another one, and every second the other direction.
  static double turns(std::uint8_t drive) { return (drive % 2 == 0 ? 1.0 : -1.0) * (1.5 + 0.25 * drive); }

  can::Bus bus;
  can::ScriptedNode master;
  std::vector<std::unique_ptr<MsdCanDrive>> drives;
};

class MsdCanLine : public EachCanDrive {};

TEST_P(MsdCanLine, EightDrivesWithOneFileFollowTheirPaths) {
  const test::TemporaryFolder folder;
  MsdParameters shared = parameters();
  shared.parameter_file = (folder.path / "drives.txt").string();
  write_common_parameters(shared);
  EightDrives line(shared);
  for (std::uint8_t i = 0; i < 8; ++i) {
    EXPECT_EQ(line.drives[i]->device().node_id(), kFirstNode + i);
    line.send(Frame::of(0x600U + kFirstNode + i,
                        canopen::SdoMessage{canopen::expedited_command(canopen::SdoRequest::kInitiateDownload, 1),
                                            0x6060, 0, bytes::to_le_bytes(std::uint32_t{7})}
                            .encode()));
    line.run(2ms);
  }
  line.send(canopen::NmtRequest{NmtCommand::kStart, 0}.frame());
  line.run(2ms);
  for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}})
    line.command(word, 0);
  for (int i = 0; i < 20; ++i) line.cycle(0);
  line.command(0x1F, 0);
  line.master.received.clear();
  const auto busy = line.bus.statistics().busy;
  constexpr int kCycles = 600;
  for (int i = 1; i <= kCycles; ++i) line.cycle(0.5 - 0.5 * std::cos(std::numbers::pi * i / kCycles));
  // 72 % without stuff bits, 87 % with the most: 8 x (4 and 6 bytes) and a SYNC in 2 ms.
  const double load = std::chrono::duration<double>(line.bus.statistics().busy - busy) / (kCycles * 2ms);
  EXPECT_GT(load, 0.72);
  EXPECT_LT(load, 0.87);
  for (int i = 0; i < 100; ++i) line.cycle(1);
  for (std::uint8_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(line.drives[i]->core().position_rad(), EightDrives::turns(i) * 2.0 * std::numbers::pi, 1e-3) << int{i};
    EXPECT_EQ(line.drives[i]->core().fault(), std::nullopt);
  }
  const std::size_t reports = line.master.received.size();
  EXPECT_EQ(reports, 8U * (kCycles + 100)) << "one TxPDO of each drive per SYNC, and nothing else";
  EXPECT_EQ(line.bus.statistics().error_frames, 0U);
}

// An SDO takes the time of its frames on the bus and the delay of the server for each answer, to 1 %.
TEST(MsdCanLine, AnUploadOf100BytesTakesItsBitsAndItsDelays) {
  CanDriveRig rig;
  rig.run(5ms);
  const auto busy = rig.bus.statistics().busy;
  std::chrono::nanoseconds taken{0};
  for (int i = 0; i <= 15; ++i) {
    const auto begin = rig.bus.now();
    const auto answer = rig.ask(i == 0       ? "40 03 20 00 00 00 00 00"
                                : i % 2 == 1 ? "60 00 00 00 00 00 00 00"
                                             : "70 00 00 00 00 00 00 00");
    ASSERT_FALSE(answer.empty());
    EXPECT_EQ(i == 15, answer == hex("0B 00 00 00 00 00 00 00")) << i;
    taken += rig.master.received.back().time - begin;
  }
  const double expected = std::chrono::duration<double>(rig.bus.statistics().busy - busy + 16 * 500us).count();
  EXPECT_NEAR(std::chrono::duration<double>(taken).count(), expected, 0.01 * expected);
}

// Causes for a drive that does not answer (MSD manual 6.5.2).
TEST_P(MsdCanLine, AnotherBitRateIsNotAnswered) {
  CanDriveRig rig(parameters());
  rig.run(5ms);
  rig.master.controller().set_bit_rate(500'000);
  EXPECT_THAT(rig.ask("40 00 10 00 00 00 00 00"), IsEmpty());
  EXPECT_GT(rig.bus.statistics().error_frames, 0U);
}

/// Answers that are equal to the bit pass as one. Others are errors until the drives are error passive, and then a
/// master gets two answers to one request.
TEST_P(MsdCanLine, TwoDrivesWithOneAddressDestroyTheirAnswers) {
  can::Bus bus;
  can::ScriptedNode master;
  MsdParameters other = parameters();
  other.name = "Another";
  MsdCanDrive first(parameters(), {kTwelve, {}, 500us});
  MsdCanDrive second(other, {kTwelve, {}, 500us});
  bus.attach(master);
  bus.attach(first.device());
  bus.attach(second.device());
  bus.advance(10ms);
  master.received.clear();
  master.send_at(bus.now(), Frame::of(0x60C, hex("40 03 20 00 00 00 00 00")));
  bus.advance(bus.now() + 5ms);
  ASSERT_EQ(master.received.size(), 1U);
  EXPECT_EQ(master.received[0].frame, Frame::of(0x58C, hex("41 03 20 00 64 00 00 00")));
  EXPECT_EQ(bus.statistics().error_frames, 0U);
  master.received.clear();
  master.send_at(bus.now(), Frame::of(0x60C, hex("60 00 00 00 00 00 00 00")));
  bus.advance(bus.now() + 50ms);
  // + 8 for each error up to error passive, 128; then a flag is recessive, and the answers pass one after the other.
  EXPECT_GE(bus.statistics().error_frames, 16U);
  std::vector<std::vector<std::byte>> answers;
  for (const auto& seen : master.received) {
    if (seen.frame.identifier.value == 0x58C) answers.push_back(bytes_test::copy_of(seen.frame.payload()));
  }
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_NE(answers[0], answers[1]);
}

// MSD manual 4.6.3: a cable that is too long for the bit rate lets no frame pass.
TEST_P(MsdCanLine, CableBeyondTheLengthOfTheBitRate) {
  struct Row {
    std::uint32_t kilobits;
    double metres;
  };
  for (const auto& [kilobits, metres] :
       {Row{1000, 25}, Row{500, 100}, Row{250, 250}, Row{125, 500}, Row{50, 1000}, Row{20, 2500}}) {
    for (const bool longer : {false, true}) {
      can::Bus bus({.length_m = metres + (longer ? 1.0 : 0.0)});
      can::ScriptedNode master;
      MsdCanDrive drive(parameters(), {kTwelve, {}, 500us});
      bus.attach(master, {.bit_rate = kilobits * 1000});
      auto& controller = bus.attach(drive.device());
      bus.advance(1us);
      controller.set_bit_rate(kilobits * 1000);
      bus.advance(100ms);
      EXPECT_EQ(master.received.empty(), longer) << kilobits;
    }
  }
}

/// A frame with an identifier that concerns the drive more often than not.
Frame any_frame(std::mt19937& random) {
  constexpr std::array<std::uint32_t, 12> kIdentifiers{0x000, 0x080, 0x08C, 0x18C, 0x20C, 0x30C,
                                                       0x40C, 0x50C, 0x60C, 0x60C, 0x60C, 0x70C};
  const auto below = [&](std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); };
  const std::uint32_t identifier = below(8) == 0 ? below(0x800) : kIdentifiers[below(kIdentifiers.size())];
  std::array<std::byte, 8> data{};
  for (auto& byte : data) byte = static_cast<std::byte>(random());
  const std::size_t length = below(4) == 0 ? below(9) : 8;
  if (identifier == 0x60C) {
    constexpr std::array<std::uint8_t, 8> kCommands{0x40, 0x2F, 0x2B, 0x23, 0x60, 0x70, 0x21, 0x00};
    constexpr std::array<std::uint16_t, 10> kObjects{0x1003, 0x1010, 0x1017, 0x1400, 0x1600,
                                                     0x1801, 0x1A01, 0x2003, 0x200B, 0x6060};
    data[0] = static_cast<std::byte>(kCommands[below(kCommands.size())]);
    bytes::store_le(std::span(data).subspan(1), kObjects[below(kObjects.size())]);
    data[3] = static_cast<std::byte>(below(4));
  }
  if (below(16) == 0) return Frame::remote({identifier, false}, static_cast<std::uint8_t>(length));
  return Frame::of(identifier, std::span(data).first(length));
}

// Whatever comes, the drive keeps its axis still without 6040h, and a reset makes it a good one again.
TEST(MsdCanAdversary, RandomFramesMoveNothingAndAResetHelps) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    CanDriveRig rig;
    rig.run(5ms);
    for (int i = 0; i < 300; ++i) {
      Frame frame = any_frame(random);
      const bool control = frame.identifier.value == 0x60C && frame.length == 8 && frame.data[2] == std::byte{0x60} &&
                           frame.data[1] == std::byte{0x40};
      if (control) continue;
      rig.send(frame, std::chrono::microseconds(100 + random() % 2000));
      rig.master.received.clear();
      ASSERT_FALSE(rig.drive.core().power_on()) << seed;
    }
    rig.drive.set_dip_switch(kTwelve);
    rig.drive.restart();
    rig.run(11s);  // perhaps after a factory reset
    rig.node = rig.drive.device().node_id();
    ASSERT_NE(rig.node, 0) << seed;
    EXPECT_EQ(rig.read(0x1000), 0x0002'0192U) << seed;
    EXPECT_LT(std::abs(rig.drive.core().position_rad()), 1e-6) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, MsdCanLine, kEachDrive, drive_name);

}  // namespace
}  // namespace driveline::slaves::msd
