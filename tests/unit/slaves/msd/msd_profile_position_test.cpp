// Profile position mode (MSD manual 12.2.1), round table (14.2).
#include <algorithm>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kNewSetpoint = 0x10;
constexpr std::uint16_t kImmediately = 0x20;
constexpr std::uint16_t kRelative = 0x40;
constexpr std::uint16_t kAcknowledge = 0x1000;

class MsdProfilePosition : public testing::Test {
 protected:
  explicit MsdProfilePosition(const MsdParameters& parameters = {}) : rig(parameters) { rig.operate(); }
  /// Profile velocity, acceleration and deceleration in revolutions.
  void profile(unsigned velocity, unsigned acceleration, unsigned deceleration) {
    ASSERT_EQ(rig.write(0x6081, 0, velocity * kRevolution, 4), 0U);
    ASSERT_EQ(rig.write(0x6083, 0, acceleration * kRevolution, 4), 0U);
    ASSERT_EQ(rig.write(0x6084, 0, deceleration * kRevolution, 4), 0U);
  }
  /// A complete handshake.
  void go_to(std::int32_t target, std::uint16_t bits = 0) {
    rig.target_position = target;
    rig.command(kEnabled | bits | kNewSetpoint, 2);
    EXPECT_TRUE(rig.status & kAcknowledge);
    rig.command(kEnabled | bits, 2);
  }
  /// Cycles until target reached; fails after `most` seconds.
  int until_reached(double most = 20.0) {
    int cycles = 0;
    while ((rig.status & kReached) == 0) {
      rig.cycle();
      if (++cycles * 125e-6 > most) {
        ADD_FAILURE() << "not reached";
        break;
      }
    }
    return cycles;
  }
  DriveRig rig;
};

TEST_F(MsdProfilePosition, MovesOnATrapezoidAndReportsTheTarget) {
  profile(10, 50, 100);
  rig.enable(1);
  EXPECT_EQ(rig.mode_display, 1);
  rig.cycles(8);
  EXPECT_TRUE(rig.status & kReached) << "stands where it is to stand";
  go_to(5 * kRevolution);
  EXPECT_EQ(rig.status & kReached, 0);
  std::int32_t peak = 0;
  int cycles = 0;
  while ((rig.status & kReached) == 0 && ++cycles < 16000) {
    rig.cycle();
    peak = std::max(peak, rig.velocity);
  }
  // 0.2 s up (1 rev), 0.1 s down (0.5 rev), 3.5 rev at 10
  EXPECT_NEAR(cycles * 125e-6, 0.2 + 0.1 + 0.35, 0.02);
  EXPECT_NEAR(peak, 10 * kRevolution, kRevolution / 5.0);
  EXPECT_NEAR(rig.position, 5 * kRevolution, 1000);
  rig.cycles(800);
  EXPECT_NEAR(rig.position, 5 * kRevolution, 60);
  EXPECT_TRUE(rig.status & 0x4000) << "ROT_0";
}

TEST_F(MsdProfilePosition, RampsHaveTheSlopesOfTheObjects) {
  profile(20, 50, 200);
  rig.enable(1);
  go_to(20 * kRevolution);
  rig.cycles(800);
  const double start = rig.velocity;
  rig.cycles(800);  // 0.1 s
  EXPECT_NEAR(rig.velocity - start, 5.0 * kRevolution, 0.1 * kRevolution);
  while (rig.position < 19.2 * kRevolution) rig.cycle();  // 1 rev to go at 20 rev/s: braking from there
  const double before = rig.velocity;
  rig.cycles(160);  // 20 ms
  EXPECT_NEAR(rig.velocity - before, -4.0 * kRevolution, 0.2 * kRevolution);
}

TEST_F(MsdProfilePosition, ProfileVelocityIsLimitedBy607FAnd6080) {
  profile(40, 200, 200);
  ASSERT_EQ(rig.write(0x607F, 0, 8 * kRevolution, 4), 0U);
  rig.enable(1);
  const auto peak_of_a_move = [&] {
    std::int32_t peak = 0;
    go_to(rig.position + 10 * kRevolution);
    for (int i = 0; i < 12000; ++i) {
      rig.cycle();
      peak = std::max(peak, rig.velocity);
    }
    return peak;
  };
  EXPECT_NEAR(peak_of_a_move(), 8 * kRevolution, 0.2 * kRevolution);
  ASSERT_EQ(rig.write(0x6080, 0, 300, 4), 0U);  // 5 rev/s
  EXPECT_NEAR(peak_of_a_move(), 5 * kRevolution, 0.2 * kRevolution);
}

TEST_F(MsdProfilePosition, JerkLimitedProfileHasNoStepOfAcceleration) {
  profile(10, 50, 50);
  rig.set({{0x6086, 0, 3, 2}, real_value(0x20A6, 0, 100.0F)});
  rig.enable(1);
  go_to(5 * kRevolution);
  const double step_nm = 3e-4 * 50 * 2 * std::numbers::pi * 0.125 / 100;  // inertia * jerk * cycle
  double torque = rig.drive.torque_nm();
  double largest = 0.0;
  int cycles = 0;
  while ((rig.status & kReached) == 0 && ++cycles < 16000) {
    rig.cycle();
    largest = std::max(largest, std::abs(rig.drive.torque_nm() - torque));
    torque = rig.drive.torque_nm();
  }
  EXPECT_NEAR(cycles * 125e-6, 0.5 + 0.2 + 0.1, 0.02) << "0.1 s longer than the trapezoid";
  EXPECT_LT(largest, 4 * step_nm + 0.012) << "the rest is the friction that turns round with the speed";
}

TEST_F(MsdProfilePosition, AcknowledgeFollowsTheNewSetpointBit) {
  rig.enable(1);
  rig.target_position = kRevolution;
  rig.control = kEnabled | kNewSetpoint;
  EXPECT_EQ(rig.status & kAcknowledge, 0);
  rig.cycles(2);
  EXPECT_TRUE(rig.status & kAcknowledge);
  rig.cycles(20);
  EXPECT_TRUE(rig.status & kAcknowledge) << "until the master clears its bit";
  rig.command(kEnabled, 2);
  EXPECT_EQ(rig.status & kAcknowledge, 0);
}

TEST_F(MsdProfilePosition, TargetAloneDoesNotMove) {
  rig.enable(1);
  rig.target_position = 3 * kRevolution;
  rig.cycles(800);
  EXPECT_NEAR(rig.position, 0, 60);
  rig.command(kEnabled | kNewSetpoint, 2);
  rig.target_position = 5 * kRevolution;  // after the edge: too late
  rig.cycles(2);
  until_reached();
  EXPECT_NEAR(rig.position, 3 * kRevolution, 1000);
}

TEST_F(MsdProfilePosition, ABitThatIsSetWhileEnablingIsNoEdge) {
  rig.mode = 1;
  rig.target_position = kRevolution;
  for (const std::uint16_t word :
       {std::uint16_t{0x10}, std::uint16_t{0x16}, std::uint16_t{0x17}, std::uint16_t{0x1F}}) {
    rig.command(word, 2);
  }
  rig.cycles(800);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  EXPECT_NEAR(rig.position, 0, 60);
}

TEST_F(MsdProfilePosition, RelativeTargetsAddToTheTargetBefore) {
  rig.enable(1);
  for (int i = 1; i <= 3; ++i) {
    go_to(kRevolution / 2, kRelative);
    until_reached();
    rig.cycles(200);
    EXPECT_NEAR(rig.position, i * kRevolution / 2.0, 100);
  }
  go_to(-kRevolution, kRelative | kImmediately);
  until_reached();
  rig.cycles(200);
  EXPECT_NEAR(rig.position, kRevolution / 2.0, 100);
}

TEST_F(MsdProfilePosition, SetpointWaitsForTheEndOfTheOneBeforeAtStandstill) {
  profile(10, 100, 100);
  rig.enable(1);
  go_to(2 * kRevolution);
  rig.cycles(400);
  go_to(3 * kRevolution);
  EXPECT_TRUE(rig.status & kAcknowledge) << "no room for a third one";
  std::int32_t slowest = 100 * kRevolution;
  while (rig.position < 2.9 * kRevolution) {
    rig.cycle();
    if (std::abs(rig.position - 2 * kRevolution) < 200) slowest = std::min(slowest, std::abs(rig.velocity));
  }
  EXPECT_LT(slowest, kRevolution / 50) << "velocity 0 at the first target";
  EXPECT_EQ(rig.status & kAcknowledge, 0) << "room again";
  until_reached();
  rig.cycles(200);
  EXPECT_NEAR(rig.position, 3 * kRevolution, 100);
}

TEST_F(MsdProfilePosition, AThirdSetpointIsNotTaken) {
  profile(10, 100, 100);
  rig.enable(1);
  go_to(kRevolution);
  go_to(2 * kRevolution);
  rig.target_position = 5 * kRevolution;
  rig.command(kEnabled | kNewSetpoint, 2);
  rig.control = kEnabled;
  until_reached();
  rig.cycles(8000);
  EXPECT_NEAR(rig.position, 2 * kRevolution, 100);
}

TEST_F(MsdProfilePosition, ChangeImmediatelyGoesOnWithoutStopping) {
  profile(10, 100, 100);
  rig.enable(1);
  go_to(2 * kRevolution);
  while (rig.position < kRevolution) rig.cycle();
  go_to(4 * kRevolution, kImmediately);
  std::int32_t slowest = 100 * kRevolution;
  while (rig.position < 3 * kRevolution) {
    rig.cycle();
    slowest = std::min(slowest, rig.velocity);
  }
  EXPECT_GT(slowest, 9.5 * kRevolution);
  until_reached();
  rig.cycles(200);
  EXPECT_NEAR(rig.position, 4 * kRevolution, 100);
}

TEST_F(MsdProfilePosition, ChangeImmediatelyDropsTheWaitingSetpointAndTurnsRound) {
  profile(10, 100, 100);
  rig.enable(1);
  go_to(2 * kRevolution);
  go_to(3 * kRevolution);
  rig.cycles(800);
  go_to(-kRevolution, kImmediately);
  until_reached();
  rig.cycles(8000);
  EXPECT_NEAR(rig.position, -kRevolution, 100);
}

TEST_F(MsdProfilePosition, HaltStopsOnTheRampOf605DAndGoesOnAfterwards) {
  struct Case {
    std::uint32_t code;
    double seconds;  ///< from 10 rev/s to standstill
  };
  for (const auto& c : {Case{1, 0.2}, Case{2, 0.05}}) {
    OperatingRig fresh;
    ASSERT_EQ(fresh.write(0x605D, 0, c.code, 2), 0U);
    ASSERT_EQ(fresh.write(0x6081, 0, 10 * kRevolution, 4), 0U);
    ASSERT_EQ(fresh.write(0x6084, 0, 50 * kRevolution, 4), 0U);
    ASSERT_EQ(fresh.write(0x6085, 0, 200 * kRevolution, 4), 0U);
    fresh.enable(1);
    fresh.target_position = 8 * kRevolution;
    fresh.command(kEnabled | kNewSetpoint, 2);
    while (fresh.position < 3 * kRevolution) fresh.cycle();
    fresh.command(kEnabled | kNewSetpoint | kHalt, static_cast<int>(0.5 * c.seconds / 125e-6));
    EXPECT_NEAR(fresh.velocity, 5 * kRevolution, 0.4 * kRevolution) << c.code;
    EXPECT_EQ(fresh.status & kReached, 0) << "axis is braking";
    fresh.cycles(static_cast<int>(0.6 * c.seconds / 125e-6) + 80);
    EXPECT_TRUE(fresh.status & kReached) << "halt: velocity is 0";
    EXPECT_EQ(fresh.drive.state(), PowerState::kOperationEnabled);
    const auto halted_at = fresh.position;
    fresh.cycles(800);
    EXPECT_NEAR(fresh.position, halted_at, 2000);
    fresh.command(kEnabled | kNewSetpoint, 16000);
    EXPECT_NEAR(fresh.position, 8 * kRevolution, 100);
    EXPECT_TRUE(fresh.status & kReached);
  }
}

TEST_F(MsdProfilePosition, HaltCodeZeroLetsTheMotorCoast) {
  ASSERT_EQ(rig.write(0x605D, 0, 0, 2), 0U);
  rig.enable(1);
  go_to(50 * kRevolution);
  rig.cycles(2400);
  ASSERT_GT(rig.velocity, 9 * kRevolution);
  rig.command(kEnabled | kHalt, 160);
  EXPECT_EQ(rig.torque, 0);
  EXPECT_GT(rig.velocity, 8.5 * kRevolution);
}

TEST_F(MsdProfilePosition, HaltCodesThreeAndFourUseAllTheTorque) {
  for (const std::uint32_t code : {3U, 4U}) {
    ASSERT_EQ(rig.write(0x605D, 0, code, 2), 0U);
    rig.enable(1);
    go_to(rig.position + 50 * kRevolution);
    rig.cycles(2400);
    ASSERT_GT(rig.velocity, 9 * kRevolution);
    rig.command(kEnabled | kHalt, 8);
    EXPECT_LT(rig.torque, -2800);
    rig.cycles(800);
    EXPECT_NEAR(rig.velocity, 0, 3000);
  }
}

TEST_F(MsdProfilePosition, SoftwareLimitsCutTheTarget) {
  rig.set({{0x607D, 1, static_cast<std::uint32_t>(-kRevolution), 4}, {0x607D, 2, kRevolution, 4}});
  rig.enable(1);
  go_to(3 * kRevolution);
  EXPECT_TRUE(rig.status & 0x0800);
  until_reached();
  rig.cycles(400);
  EXPECT_NEAR(rig.position, kRevolution, 100);
  go_to(0);
  EXPECT_EQ(rig.status & 0x0800, 0);
  until_reached();
}

TEST_F(MsdProfilePosition, FollowingErrorShowsInBit13) {
  rig.set({{0x6065, 0, 100, 4},
           {0x6066, 0, 1, 2},
           real_value(0x2177, 0, 0.0F)});  // no speed feed-forward: the error is speed over gain
  rig.enable(1);
  go_to(3 * kRevolution);
  rig.cycles(400);
  EXPECT_TRUE(rig.status & 0x2000);
  EXPECT_EQ(rig.error_code, 0x8611);
}

TEST_F(MsdProfilePosition, TargetReachedNeedsTheWindowTime) {
  ASSERT_EQ(rig.write(0x6068, 0, 50, 2), 0U);
  rig.enable(1);
  go_to(kRevolution);
  while (std::abs(rig.position - kRevolution) > 1000) rig.cycle();
  EXPECT_GE(until_reached() * 0.125, 48.0);
}

TEST_F(MsdProfilePosition, RunsOverTheEndOf32Bits) {
  MsdParameters parameters;
  parameters.initial_position_rad = (2147483647.0 - 0.5 * kRevolution) / kIncrementsPerRadian;
  EnabledRig far(parameters, 1);
  far.target_position = kRevolution;
  far.command(kEnabled | kNewSetpoint | kRelative, 4000);
  const double moved = far.drive.position_rad() - parameters.initial_position_rad;
  EXPECT_NEAR(moved, 2.0 * std::numbers::pi, 1e-3);
  EXPECT_LT(far.position, -2140000000);
}

/// 360 degrees in millidegrees; starts at 350 degrees.
class MsdRoundTable : public testing::Test {
 protected:
  MsdRoundTable() : rig(at(350.0)) {
    rig.set({{0x6092, 1, 1'800'000, 4},  // in 5 revolutions
             {0x6092, 2, 5, 4},
             {0x607B, 1, 0, 4},
             {0x607B, 2, 359'999, 4},
             {0x6081, 0, 720'000, 4},
             {0x6083, 0, 72'000'000, 4},
             {0x6084, 0, 72'000'000, 4},
             {0x6067, 0, 100, 4}});
    rig.start(1);
    start_ = degrees();
    EXPECT_NEAR(rig.position, 350'000, 2);
  }
  static MsdParameters at(double degrees) {
    MsdParameters parameters;
    parameters.initial_position_rad = degrees * std::numbers::pi / 180.0;
    return parameters;
  }
  [[nodiscard]] double degrees() const { return rig.drive.position_rad() * 180.0 / std::numbers::pi; }
  /// Degrees actually travelled.
  double travel(std::int32_t target, std::uint32_t option, std::uint16_t bits = 0) {
    EXPECT_EQ(rig.write(0x60F2, 0, option, 2), 0U);
    rig.target_position = target;
    rig.command(kEnabled | kNewSetpoint | bits, 4);
    rig.command(kEnabled, 40000);
    EXPECT_TRUE(rig.status & kReached);
    return degrees() - start_;
  }
  DriveRig rig;
  double start_ = 0.0;
};

TEST_F(MsdRoundTable, LinearNeverCrossesTheEnds) {
  EXPECT_NEAR(travel(10'000, 0x00), -340.0, 0.1);
  EXPECT_NEAR(rig.position, 10'000, 30);
}

TEST_F(MsdRoundTable, CounterClockwiseGoesDown) {
  EXPECT_NEAR(travel(10'000, 0x40), -340.0, 0.1);
  EXPECT_NEAR(travel(355'000, 0x40), -355.0, 0.1) << "on through 0";
  EXPECT_NEAR(rig.position, 355'000, 30);
}

TEST_F(MsdRoundTable, ClockwiseGoesUp) {
  EXPECT_NEAR(travel(10'000, 0x80), 20.0, 0.1);
  EXPECT_NEAR(rig.position, 10'000, 30);
  EXPECT_NEAR(travel(5'000, 0x80), 375.0, 0.1);
}

TEST_F(MsdRoundTable, OptimisedTakesTheShorterWay) {
  EXPECT_NEAR(travel(10'000, 0xC0), 20.0, 0.1);
  EXPECT_NEAR(travel(300'000, 0xC0), -50.0, 0.1);
}

TEST_F(MsdRoundTable, OnlyBitsSixAndSevenCount) {
  EXPECT_NEAR(travel(10'000, 0xFF3F | 0x80), 20.0, 0.1);
}

/// The circumference is that of 607Bh, not of the feed: here three quarters of a turn, from -90 degrees on.
TEST_F(MsdRoundTable, EndsWhere607BSays) {
  rig.set({{0x607B, 1, static_cast<std::uint32_t>(-90'000), 4}, {0x607B, 2, 179'999, 4}});
  rig.cycles(2);
  EXPECT_NEAR(rig.position, 80'000, 2) << "350 degrees";
  EXPECT_NEAR(travel(-80'000, 0xC0), 110.0, 0.1) << "on through 180, which is -90";
  EXPECT_NEAR(rig.position, -80'000, 30);
  EXPECT_NEAR(travel(80'000, 0x80), 270.0, 0.1);
}

TEST_F(MsdRoundTable, RelativeTargetsMayExceedTheCircumference) {
  EXPECT_NEAR(travel(800'000, 0x00, kRelative), 800.0, 0.1);
  EXPECT_NEAR(rig.position, 350'000 + 800'000 - 3 * 360'000, 30);
}

}  // namespace
}  // namespace driveline::slaves::msd
