// Movements of the MSD on a CAN bus: profile modes, homing, and interpolated position with SYNC (MSD manual 12).
#include <numbers>

#include "can_drive_rig.hpp"
#include "driveline/slaves/cia402/words.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kNewSetpoint = 0x10;
constexpr std::uint32_t kInterpolationData = 0x60C1'0120;
constexpr std::uint32_t kStatusWord = 0x6041'0010;
constexpr std::uint32_t kActualPosition = 0x6064'0020;

Frame setpoint(std::int32_t value) {
  return Frame::of(0x30C, bytes::to_le_bytes(static_cast<std::uint32_t>(value)));
}
/// Values of a TPDO with status word and position.
std::uint16_t status_in(const Frame& frame) {
  return bytes::load_le<std::uint16_t>(frame.payload());
}
std::int32_t position_in(const Frame& frame) {
  return static_cast<std::int32_t>(bytes::load_le<std::uint32_t>(frame.payload().subspan(2)));
}

class MsdCanMotion : public MsdCan {
 protected:
  /// Profile of 10 turns/s, 50 turns/s2 up and 100 turns/s2 down.
  void profile() {
    ASSERT_EQ(rig.write(0x6081, 0, 10 * kTurn, 4), 0U);
    ASSERT_EQ(rig.write(0x6083, 0, 50 * kTurn, 4), 0U);
    ASSERT_EQ(rig.write(0x6084, 0, 100 * kTurn, 4), 0U);
  }
};

// Target and control word by RxPDO, status word and position by TxPDO.
TEST_P(MsdCanMotion, ProfilePositionByPdos) {
  profile();
  ASSERT_EQ(rig.write(0x6060, 0, 1, 1), 0U);
  rig.map(0x1401, {kTargetPosition});
  rig.map(0x1801, {kStatusWord, kActualPosition});
  rig.operate();
  rig.enable();
  ASSERT_EQ(rig.drive.core().state(), PowerState::kOperationEnabled);
  const auto begin = rig.bus.now();
  rig.send(setpoint(5 * kTurn));
  rig.control(kEnable | kNewSetpoint);
  EXPECT_TRUE(rig.status() & 0x1000) << "setpoint acknowledge";
  rig.control(kEnable);
  // 0.2 s up (1 turn), 0.1 s down (0.5 turns), 3.5 turns at 10.
  rig.run(600ms);
  EXPECT_EQ(status_in(rig.seen(0x28C).back().frame) & kReached, 0);
  rig.run(200ms);
  const auto reports = rig.seen(0x28C);
  const auto reached = std::find_if(reports.begin(), reports.end(), [&](const auto& one) {
    return one.time > begin + 20ms && (status_in(one.frame) & kReached) != 0;
  });
  ASSERT_NE(reached, reports.end());
  EXPECT_NEAR(std::chrono::duration<double>(reached->time - begin).count(), 0.65, 0.03);
  EXPECT_NEAR(position_in(reached->frame), 5 * kTurn, 1000);
  EXPECT_NEAR(rig.position(), 5 * kTurn, 60);
  EXPECT_NEAR(rig.drive.core().position_rad(), 10.0 * std::numbers::pi, 1e-3);
  EXPECT_THAT(rig.emergencies(), IsEmpty());
}

// All of it by SDO, as far as Pre-operational.
TEST_P(MsdCanMotion, ProfilePositionBySdo) {
  profile();
  ASSERT_EQ(rig.write(0x6060, 0, 1, 1), 0U);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) ASSERT_EQ(rig.write(0x6040, 0, word, 2), 0U);
  EXPECT_EQ(rig.read(0x6041) & 0x6FU, 0x27U);
  ASSERT_EQ(rig.write(0x607A, 0, static_cast<std::uint32_t>(-3 * kTurn), 4), 0U);
  ASSERT_EQ(rig.write(0x6040, 0, 0x1F, 2), 0U);
  rig.run(700ms);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x6064)), -3 * kTurn, 60);
  EXPECT_TRUE(rig.read(0x6041) & kReached);
}

TEST_P(MsdCanMotion, ProfileVelocityByPdo) {
  profile();
  ASSERT_EQ(rig.write(0x6060, 0, 3, 1), 0U);
  rig.map(0x1401, {kTargetVelocity});
  rig.operate();
  rig.enable();
  rig.send(setpoint(4 * kTurn));
  rig.run(300ms);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x606C)), 4 * kTurn, kTurn / 50.0);
  rig.send(setpoint(-2 * kTurn));
  rig.run(300ms);
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x606C)), -2 * kTurn, kTurn / 50.0);
}

TEST_P(MsdCanMotion, HomingByPdo) {
  ASSERT_EQ(rig.write(0x6060, 0, 6, 1), 0U);
  ASSERT_EQ(rig.write(0x6098, 0, 34, 1), 0U);  // index pulse in positive direction
  ASSERT_EQ(rig.write(0x607C, 0, 777, 4), 0U);
  ASSERT_EQ(rig.write(0x6099, 2, kTurn / 2, 4), 0U);
  ASSERT_EQ(rig.write(0x609A, 0, 20 * kTurn, 4), 0U);
  rig.operate();
  rig.enable();
  rig.control(kEnable | kNewSetpoint);
  rig.run(4s);
  EXPECT_TRUE(rig.status() & 0x1000) << "homing attained";
  EXPECT_TRUE(rig.status() & kReached);
  EXPECT_EQ(rig.status() & 0x2000, 0);
}

/// A drive that follows positions with SYNCs of 2 ms: RxPDO 1 control word, RxPDO 2 60C1h:01 with type 1, TxPDO 1
/// status word and position with type 1.
class MsdCanInterpolation : public MsdCan {
 protected:
  MsdCanInterpolation() {
    EXPECT_EQ(rig.write_real(0x2132, 2.0F), 0U);  // P 306
    EXPECT_EQ(rig.write(0x1006, 0, 2000, 4), 0U);
    EXPECT_EQ(rig.write(0x60C2, 1, 2, 1), 0U);
    EXPECT_EQ(rig.write(0x6060, 0, 7, 1), 0U);
    rig.map(0x1401, {kInterpolationData}, 1);
    rig.map(0x1800, {kStatusWord, kActualPosition}, 1);
    rig.operate();
  }
  /// One SYNC cycle of 2 ms: setpoint, SYNC, and perhaps a control word later.
  void cycle(std::int32_t target, std::optional<std::uint16_t> word = {}) {
    rig.master.send_at(rig.bus.now(), setpoint(target));
    rig.master.send_at(rig.bus.now(), Frame::of(0x080, {}));
    if (word) rig.master.send_at(rig.bus.now() + 700us, Frame::of(0x20C, bytes::to_le_bytes(*word)));
    rig.run(2ms);
  }
  void cycles(int count, std::int32_t target) {
    for (int i = 0; i < count; ++i) cycle(target);
  }
  /// Sends a control word within a cycle.
  void command(std::uint16_t word, std::int32_t target) {
    cycle(target, word);
    cycle(target);
  }
  void enable_at(std::int32_t target) {
    for (const std::uint16_t word : {kShutDown, kSwitchOn, kEnable}) command(word, target);
    cycles(20, target);
    command(kEnable | control_word::kEnableIp, target);
  }
};

TEST_P(MsdCanInterpolation, FollowsAPathOfSyncs) {
  const std::int32_t start = rig.position();
  enable_at(start);
  ASSERT_TRUE(rig.status() & status_word::kIpActive);
  constexpr int kCycles = 500;
  int before = start;
  for (int i = 1; i <= kCycles; ++i) {
    const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * i / kCycles);
    const auto target = start + static_cast<std::int32_t>(std::lrint(3.0 * kTurn * share));
    cycle(target);
    const Frame report = rig.seen(0x18C).back().frame;
    ASSERT_GE(position_in(report), before - 20) << "it never goes back, " << i;
    ASSERT_LT(std::abs(position_in(report) - target), kTurn / 10) << i;
    before = position_in(report);
    if (i == kCycles / 2) {
      EXPECT_TRUE(status_in(report) & status_word::kAxisSynchronised);
    }
  }
  cycles(100, start + 3 * kTurn);
  EXPECT_NEAR(rig.position(), start + 3 * kTurn, 50);
  EXPECT_EQ(rig.drive.core().fault(), std::nullopt);
  EXPECT_THAT(rig.emergencies(), IsEmpty());
  // One TxPDO per SYNC, behind it.
  const auto is_sync = [](const auto& one) { return one.frame.identifier.value == 0x80; };
  const auto syncs = std::count_if(rig.master.sent.begin(), rig.master.sent.end(), is_sync);
  EXPECT_EQ(rig.count(0x18C), static_cast<std::size_t>(syncs));
}

// A control word between two setpoints is no setpoint: speed stays as it is.
TEST_P(MsdCanInterpolation, AControlWordBetweenSetpointsDisturbsNothing) {
  const std::int32_t start = rig.position();
  enable_at(start);
  std::int32_t target = start;
  for (int i = 0; i < 300; ++i) cycle(target += 4000);
  const double speed = rig.drive.core().motion().velocity_demand();
  for (int i = 0; i < 40; ++i) {
    cycle(target += 4000, static_cast<std::uint16_t>(0x1F));
    ASSERT_NEAR(rig.drive.core().motion().velocity_demand(), speed, std::abs(speed) / 100) << i;
  }
  EXPECT_EQ(rig.drive.core().fault(), std::nullopt);
}

// P 306, 1006h and 60C2h must name the same cycle: otherwise interpolation is a fault (MSD manual 6.4.2).
TEST_P(MsdCanInterpolation, AnotherCommunicationCycleIsAFaultWhenItStarts) {
  ASSERT_EQ(rig.write(0x1006, 0, 4000, 4), 0U);
  const std::int32_t start = rig.position();
  for (const std::uint16_t word : {kShutDown, kSwitchOn, kEnable}) command(word, start);
  cycles(20, start);
  EXPECT_EQ(rig.drive.core().fault(), std::nullopt) << "nothing before the interpolation";
  command(kEnable | control_word::kEnableIp, start);
  EXPECT_EQ(rig.drive.core().fault(), Fault::kInvalidConfiguration);
  ASSERT_EQ(rig.emergencies().size(), 1U);
  EXPECT_EQ(rig.emergencies()[0], hex("00 FF 11 0E 04 00 00 00"));
  cycles(100, start);
  command(0x80, start);
  EXPECT_EQ(rig.drive.core().fault(), Fault::kInvalidConfiguration) << "the cause is there";
  ASSERT_EQ(rig.write(0x1006, 0, 2000, 4), 0U);
  command(0, start);
  command(0x80, start);
  EXPECT_EQ(rig.drive.core().fault(), std::nullopt);
}

TEST_P(MsdCanInterpolation, HaltStopsAndReleasesTheAxis) {
  const std::int32_t start = rig.position();
  enable_at(start);
  command(kEnable | control_word::kEnableIp | control_word::kHalt, start);
  EXPECT_EQ(rig.status() & status_word::kIpActive, 0);
  command(kEnable | control_word::kEnableIp, start);
  EXPECT_TRUE(rig.status() & status_word::kIpActive);
  command(kEnable, start);
  EXPECT_EQ(rig.status() & status_word::kIpActive, 0) << "bit 4";
}

INSTANTIATE_TEST_SUITE_P(Drives, MsdCanMotion, kEachDrive, drive_name);
INSTANTIATE_TEST_SUITE_P(Drives, MsdCanInterpolation, kEachDrive, drive_name);

}  // namespace
}  // namespace driveline::slaves::msd
