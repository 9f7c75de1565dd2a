// Profile velocity mode (MSD manual 12.2.3), velocity mode (12.2.2), interpolated position mode (12.3.1), changes of
// mode.
#include <algorithm>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

class MsdProfileVelocity : public testing::Test {
 protected:
  MsdProfileVelocity() {
    rig.operate();
    EXPECT_EQ(rig.write(0x6083, 0, 50 * kRevolution, 4), 0U);
    EXPECT_EQ(rig.write(0x6084, 0, 100 * kRevolution, 4), 0U);
  }
  DriveRig rig;
};

TEST_F(MsdProfileVelocity, RampsToTheTargetWithItsOwnSlopes) {
  rig.enable(3);
  EXPECT_EQ(rig.mode_display, 3);
  rig.turn(10 * kRevolution, 800);  // 0.1 s of 0.2 s
  EXPECT_NEAR(rig.velocity, 5 * kRevolution, 0.1 * kRevolution);
  EXPECT_EQ(rig.status & kReached, 0);
  rig.cycles(1000);
  EXPECT_NEAR(rig.velocity, 10 * kRevolution, 3000);
  EXPECT_TRUE(rig.status & kReached);
  rig.turn(0, 400);  // half of 0.1 s
  EXPECT_NEAR(rig.velocity, 5 * kRevolution, 0.15 * kRevolution);
  EXPECT_EQ(rig.status & kReached, 0) << "a new setpoint";
}

TEST_F(MsdProfileVelocity, TargetIsCutAt607F) {
  ASSERT_EQ(rig.write(0x607F, 0, 3 * kRevolution, 4), 0U);
  rig.enable(3);
  for (const int sign : {1, -1}) {
    rig.turn(sign * 10 * kRevolution, 4000);
    EXPECT_NEAR(rig.velocity, sign * 3 * kRevolution, 3000);
    EXPECT_TRUE(rig.status & 0x0800);
  }
  rig.turn(kRevolution, 4000);
  EXPECT_EQ(rig.status & 0x0800, 0);
}

TEST_F(MsdProfileVelocity, PositionIsUpdatedAlongWithTheSpeed) {
  rig.enable(3);
  rig.turn(10 * kRevolution, 2400);
  const auto before = rig.position;
  rig.cycles(8);  // 1 ms
  EXPECT_NEAR(rig.position - before, 10486, 200);
}

TEST_F(MsdProfileVelocity, SpeedBitIsSetAtStandstill) {
  rig.enable(3);
  rig.cycles(80);
  EXPECT_TRUE(rig.status & 0x1000) << "speed is 0";
  EXPECT_EQ(rig.status & 0x4000, 0) << "no ROT_0 in this mode";
  rig.turn(2 * kRevolution, 800);
  EXPECT_EQ(rig.status & 0x1000, 0);
  rig.turn(0, 1600);
  EXPECT_TRUE(rig.status & 0x1000);
}

TEST_F(MsdProfileVelocity, HaltBrakesAndReleaseGoesOn) {
  rig.enable(3);
  rig.turn(10 * kRevolution, 2400);
  rig.command(kEnabled | kHalt, 400);
  EXPECT_NEAR(rig.velocity, 5 * kRevolution, 0.2 * kRevolution) << "6084h";
  EXPECT_EQ(rig.status & kReached, 0) << "axis slows down";
  rig.cycles(1000);
  EXPECT_NEAR(rig.velocity, 0, 3000);
  EXPECT_TRUE(rig.status & kReached) << "axis has velocity 0";
  rig.command(kEnabled, 2400);
  EXPECT_NEAR(rig.velocity, 10 * kRevolution, 3000);
}

TEST_F(MsdProfileVelocity, MaxSlippageShowsTheSpeedDifference) {
  ASSERT_EQ(rig.write(0x60F8, 0, kRevolution, 4), 0U);
  ASSERT_EQ(rig.write(0x6083, 0, 2000 * kRevolution, 4), 0U);
  ASSERT_EQ(rig.write(0x6072, 0, 500, 2), 0U);  // not enough for it
  rig.enable(3);
  EXPECT_EQ(rig.status & 0x2000, 0);
  rig.turn(40 * kRevolution, 40);
  EXPECT_TRUE(rig.status & 0x2000);
  rig.cycles(4000);
  EXPECT_EQ(rig.status & 0x2000, 0);
}

TEST_F(MsdProfileVelocity, JerkTimeMakesTheRampLonger) {
  rig.set({{0x6086, 0, 3, 2}, real_value(0x20A6, 0, 100.0F)});
  rig.enable(3);
  rig.turn(10 * kRevolution, 1200);  // half of 0.2 s + 0.1 s
  EXPECT_NEAR(rig.velocity, 5 * kRevolution, 0.1 * kRevolution);
  rig.cycles(1280);
  EXPECT_NEAR(rig.velocity, 10 * kRevolution, 0.02 * kRevolution);
}

class MsdVelocityMode : public testing::Test {
 protected:
  /// Velocity unit 1/1000 revolution per second: 16-bit setpoints reach 32 rev/s.
  MsdVelocityMode() {
    rig.set({{0x6092, 1, 3000, 4},  // in 3 revolutions
             {0x6092, 2, 3, 4},
             {0x6048, 1, 50'000, 4},  // 50 rev/s in 1 s
             {0x6049, 1, 200'000, 4},
             {0x6049, 2, 2, 4}});
    rig.start(2);
  }
  void setpoint(int value) { ASSERT_EQ(rig.write(0x6042, 0, static_cast<std::uint16_t>(value), 2), 0U); }
  void run(std::uint16_t bits, int cycles) { rig.command(kEnabled | bits, cycles); }
  static constexpr std::uint16_t kUnlock = 0x20;
  static constexpr std::uint16_t kReference = 0x40;
  DriveRig rig;
};

TEST_F(MsdVelocityMode, FollowsItsRamps) {
  // 606Bh is the frequency; the rotor oscillates a little around it at the start and end of a ramp.
  const auto demand = [this] { return static_cast<std::int32_t>(rig.read(0x606B)); };
  setpoint(10'000);
  run(kUnlock | kReference, 800);
  EXPECT_NEAR(demand(), 5'000, 10) << "50 rev/s2";
  EXPECT_NEAR(rig.velocity, 5'000, 300);
  run(kUnlock | kReference, 4000);
  EXPECT_EQ(demand(), 10'000);
  EXPECT_NEAR(rig.velocity, 10'000, 10);
  setpoint(0);
  run(kUnlock | kReference, 400);
  EXPECT_NEAR(demand(), 5'000, 30) << "100 rev/s2";
  EXPECT_NEAR(rig.velocity, 5'000, 300);
  setpoint(-3'000);
  run(kUnlock | kReference, 4000);
  EXPECT_NEAR(rig.velocity, -3'000, 10);
}

TEST_F(MsdVelocityMode, MinimumAndMaximumLimitTheAmount) {
  rig.set({{0x6046, 1, 1'000, 4}, {0x6046, 2, 4'000, 4}});
  for (const int sign : {1, -1}) {
    setpoint(sign * 20);
    run(kUnlock | kReference, 4000);
    EXPECT_NEAR(rig.velocity, sign * 1'000, 10);
    setpoint(sign * 30'000);
    run(kUnlock | kReference, 4000);
    EXPECT_NEAR(rig.velocity, sign * 4'000, 10);
    EXPECT_TRUE(rig.status & 0x0800);
  }
  setpoint(0);
  run(kUnlock | kReference, 4000);
  EXPECT_NEAR(rig.velocity, 0, 10);
}

TEST_F(MsdVelocityMode, LockedRampKeepsItsOutput) {
  setpoint(10'000);
  run(kUnlock | kReference, 800);
  run(kReference, 80);
  const auto frozen = static_cast<std::int32_t>(rig.read(0x606B));
  EXPECT_NEAR(frozen, 5'000, 50);
  run(kReference, 4000);
  EXPECT_EQ(static_cast<std::int32_t>(rig.read(0x606B)), frozen);
  EXPECT_NEAR(rig.velocity, frozen, 10);
  run(kUnlock | kReference, 4000);
  EXPECT_NEAR(rig.velocity, 10'000, 10);
}

TEST_F(MsdVelocityMode, WithoutReferenceTheRampRunsToZero) {
  setpoint(10'000);
  run(kUnlock | kReference, 3000);
  run(kUnlock, 400);
  EXPECT_NEAR(rig.velocity, 5'000, 200);
  run(kUnlock, 1600);
  EXPECT_NEAR(rig.velocity, 0, 10);
}

TEST_F(MsdVelocityMode, HaltStops) {
  setpoint(10'000);
  run(kUnlock | kReference, 3000);
  run(kUnlock | kReference | kHalt, 6000);
  EXPECT_NEAR(rig.velocity, 0, 10);
  EXPECT_TRUE(rig.status & kReached);
  run(kUnlock | kReference, 3000);
  EXPECT_NEAR(rig.velocity, 10'000, 10);
}

TEST_F(MsdVelocityMode, Bit4HasNoFunction) {
  setpoint(10'000);
  run(kUnlock | kReference | 0x10, 3000);
  EXPECT_NEAR(rig.velocity, 10'000, 10);
}

class MsdInterpolatedPosition : public testing::Test {
 protected:
  MsdInterpolatedPosition() { rig.start(7); }
  void target(std::int32_t value) { ASSERT_EQ(rig.write(0x60C1, 1, static_cast<std::uint32_t>(value), 4), 0U); }
  DriveRig rig;
};

TEST_F(MsdInterpolatedPosition, FollowsTheDataRecordWhileEnabled) {
  EXPECT_EQ(rig.status & 0x1000, 0);
  rig.command(kEnabled | 0x10, 2);
  EXPECT_TRUE(rig.status & 0x1000) << "IP mode active";
  for (int i = 1; i <= 1000; ++i) {
    target(i * 100);
    rig.cycle();
  }
  rig.cycles(400);
  EXPECT_NEAR(rig.position, 100'000, 200);
  EXPECT_TRUE(rig.status & kReached);
  EXPECT_EQ(rig.mode_display, 7);
}

TEST_F(MsdInterpolatedPosition, WithoutBit4TheAxisStands) {
  target(500'000);
  rig.cycles(1600);
  EXPECT_NEAR(rig.position, 0, 60);
  rig.command(kEnabled | 0x10, 2);
  target(1000);
  rig.cycles(400);
  rig.command(kEnabled, 2);
  EXPECT_EQ(rig.status & 0x1000, 0);
  const auto stands = rig.position;
  target(300'000);
  rig.cycles(800);
  EXPECT_NEAR(rig.position, stands, 100);
}

TEST_F(MsdInterpolatedPosition, HaltStopsTheAxis) {
  rig.control = kEnabled | 0x10;
  for (int i = 1; i <= 1000; ++i) {
    target(i * 1000);
    rig.cycle();
  }
  rig.command(kEnabled | 0x10 | kHalt, 8);
  EXPECT_EQ(rig.status & kReached, 0) << "axis is braking";
  rig.cycles(1600);
  EXPECT_NEAR(rig.velocity, 0, 3000);
  EXPECT_TRUE(rig.status & kReached);
  EXPECT_EQ(rig.status & 0x1000, 0);
}

TEST(MsdModes, SwitchingInMotionKeepsTheSpeed) {
  // Under the load of friction the axis runs at 5 rev/s; a change of mode that commands the same speed again does not
  // affect it, and a change to a mode with standstill as its target brakes on its ramp.
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6092, 1, 7 * kRevolution, 4), 0U);
  ASSERT_EQ(rig.write(0x6092, 2, 7, 4), 0U);
  rig.run_at(5 * kRevolution);
  double last = rig.drive.velocity_rad_s();
  double largest = 0.0;
  const auto run = [&](std::int8_t mode, int cycles, auto&& setpoints) {
    rig.mode = mode;
    for (int i = 0; i < cycles; ++i) {
      setpoints();
      rig.cycle();
      largest = std::max(largest, std::abs(rig.drive.velocity_rad_s() - last));
      last = rig.drive.velocity_rad_s();
    }
    EXPECT_EQ(rig.mode_display, mode);
    EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  };
  const auto nothing = [] {};
  const auto follow = [&] { rig.target_position = rig.position + 655; };  // the predicted position
  run(3, 400, nothing);
  run(8, 1, follow);
  run(8, 400, [&] { rig.target_position += 655; });
  run(9, 400, nothing);
  rig.target_torque = 13;  // the friction
  run(10, 100, nothing);
  run(3, 400, nothing);
  run(1, 1600, nothing);
  run(6, 400, nothing);
  run(7, 400, nothing);
  run(3, 1600, nothing);
  EXPECT_NEAR(rig.velocity, 5 * kRevolution, 5000);
  // 600 rad/s2 of the ramps are 0.08 rad/s per cycle; twice that is allowed.
  EXPECT_LT(largest, 0.16);
}

TEST(MsdModes, ModeIsShownAtOnceAlsoWithoutPower) {
  OperatingRig rig;
  for (const std::int8_t mode : {std::int8_t{1}, std::int8_t{2}, std::int8_t{3}, std::int8_t{6}, std::int8_t{7},
                                 std::int8_t{8}, std::int8_t{9}, std::int8_t{10}, std::int8_t{0}}) {
    rig.mode = mode;
    rig.cycles(2);
    EXPECT_EQ(rig.mode_display, mode);
  }
}

TEST(MsdModes, NothingMovesUnlessOperationIsEnabled) {
  for (const std::int8_t mode : {std::int8_t{1}, std::int8_t{3}, std::int8_t{6}, std::int8_t{7}, std::int8_t{8},
                                 std::int8_t{9}, std::int8_t{10}}) {
    EnabledRig rig(mode);
    rig.command(0x07, 800);
    ASSERT_EQ(rig.drive.state(), PowerState::kSwitchedOn);
    rig.target_position = 100'000;
    rig.target_velocity = 5 * kRevolution;
    rig.target_torque = 500;
    rig.command(0x17, 800);
    EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0) << int{mode};
  }
}

TEST(MsdModes, SynchronisedBitNeedsRegularSetpoints) {
  EnabledRig rig(8);
  rig.cycles(20);
  EXPECT_TRUE(rig.status & 0x8000);
  rig.pass(5ms);
  EXPECT_EQ(rig.status & 0x8000, 0);
  rig.cycles(20);
  EXPECT_TRUE(rig.status & 0x8000);
  rig.mode = 3;
  rig.cycles(2);
  EXPECT_EQ(rig.status & 0x8000, 0) << "not a bit of this mode";
}

}  // namespace
}  // namespace driveline::slaves::msd
