// Mode 2, U/f operation, of the drive (MSD manual 12.2.2): the differences from modes with the speed controller.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kRun = 0x0F | 0x20 | 0x40;
constexpr std::uint16_t kInternalLimit = 0x0800;

MsdParameters with_weight(double nm) {
  MsdParameters parameters;
  parameters.motor.load.gravity_nm = nm;
  return parameters;
}

/// Velocity unit 1/1000 revolution per second, ramps of 20 rev/s2.
void use_milli_revolutions(DriveRig& rig) {
  rig.set({{0x6092, 1, 3000, 4},  // in 3 revolutions
           {0x6092, 2, 3, 4},
           {0x6048, 1, 20'000, 4},
           {0x6049, 1, 20'000, 4},
           {0x6084, 0, 20'000, 4},
           {0x6085, 0, 50'000, 4}});
}

void order(DriveRig& rig, int setpoint, int cycles) {
  ASSERT_EQ(rig.write(0x6042, 0, static_cast<std::uint16_t>(setpoint), 2), 0U);
  rig.command(kRun, cycles);
}

TEST(MsdFrequency, TurnsExactlyAsOftenAsTheFieldAlsoUnderLoad) {
  for (const double weight : {0.0, 0.7, -0.7}) {
    DriveRig rig(with_weight(weight));
    use_milli_revolutions(rig);
    rig.start(2);
    order(rig, 10'000, 8000);
    const double from = rig.drive.position_rad();
    rig.cycles(8000);
    EXPECT_NEAR((rig.drive.position_rad() - from) / kTurnRad, 10.0, 0.002) << weight << " Nm";
    EXPECT_NEAR(rig.torque, weight / 2.4 * 1000.0 + 30.0, 20.0) << "what weight and friction ask for";
    EXPECT_EQ(rig.status & kInternalLimit, 0);
  }
}

TEST(MsdFrequency, PullsOutWhenOverloadedAndTheSpeedControllerDoesNotHelp) {
  // A load that the speed controller holds easily is too much for the field at this speed.
  DriveRig held(with_weight(4.5));
  use_milli_revolutions(held);
  held.start(3);
  held.turn(2'000, 4000);
  EXPECT_NEAR(held.velocity, 2'000, 50);
  held.mode = 2;
  order(held, 2'000, 0);
  bool limited = false;
  for (int i = 0; i < 4000; ++i) {
    held.cycle();
    limited = limited || (held.status & kInternalLimit) != 0;
  }
  EXPECT_TRUE(limited) << "the current has been at its limit";
  EXPECT_LT(held.drive.velocity_rad_s(), -kTurnRad) << "the weight falls";
  EXPECT_EQ(static_cast<std::int32_t>(held.read(0x606B)), 2'000) << "the field goes on";
  EXPECT_GT(std::abs(static_cast<std::int16_t>(held.read(0x6078))), 1000);
}

TEST(MsdFrequency, CurrentLimitFollowsTheTorqueLimit) {
  DriveRig rig;
  use_milli_revolutions(rig);
  rig.start(2);
  order(rig, 0, 800);
  EXPECT_NEAR(static_cast<std::int16_t>(rig.read(0x6078)), 800, 20) << "boost: 80 % of the rated current";
  EXPECT_EQ(rig.status & kInternalLimit, 0);
  ASSERT_EQ(rig.write(0x6072, 0, 300, 2), 0U);
  rig.cycles(4000);
  EXPECT_NE(rig.status & kInternalLimit, 0);
  EXPECT_NEAR(static_cast<std::int16_t>(rig.read(0x6078)), 300, 30);
}

TEST(MsdFrequency, VoltageFollowsTheCharacteristicOfTheParameters) {
  DriveRig rig;
  use_milli_revolutions(rig);
  const auto parameter = [&rig](std::uint16_t number) {
    return std::bit_cast<float>(rig.read(static_cast<std::uint16_t>(0x2000 + number)));
  };
  // The standard motor: 3.2 Ohm, 2.5 A, 6000 rev/min with four pole pairs.
  EXPECT_NEAR(parameter(313), 0.8 * 3.2 * 2.5 * std::numbers::sqrt3, 1e-4);
  EXPECT_NEAR(parameter(314), 400.0, 1e-3);
  EXPECT_NEAR(parameter(315), 381.0, 3.0) << "311 V of a phase, below the 396 V that 560 V give";
  ASSERT_EQ(rig.write_real(0x2000 + 313, 0, parameter(313) / 2.0F), 0U);
  rig.start(2);
  order(rig, 0, 800);
  EXPECT_NEAR(static_cast<std::int16_t>(rig.read(0x6078)), 400, 20) << "half the boost, half the current";
}

/// Modes with the speed and the position controller before and after; the weight is always attached to the axis.
TEST(MsdFrequency, ChangesOfModeUnderLoadDoNotJump) {
  for (const bool windings : {false, true}) {
    auto parameters = with_weight(0.8);
    parameters.motor.winding.simulated = windings;
    DriveRig rig(parameters);
    use_milli_revolutions(rig);
    rig.start(9);
    rig.turn(5'000, 8000);
    ASSERT_NEAR(rig.velocity, 5'000, 20);
    ASSERT_EQ(rig.write(0x6042, 0, 5'000, 2), 0U);
    rig.control = kRun;
    double last = rig.drive.velocity_rad_s();
    double largest = 0.0;
    const auto run = [&](std::int8_t mode, int cycles) {
      rig.mode = mode;
      for (int i = 0; i < cycles; ++i) {
        rig.cycle();
        largest = std::max(largest, std::abs(rig.drive.velocity_rad_s() - last));
        last = rig.drive.velocity_rad_s();
        ASSERT_NEAR(rig.velocity, 5'000, 250) << "mode " << int{mode} << " cycle " << i;
      }
      EXPECT_EQ(rig.mode_display, mode);
    };
    for (int i = 0; i < 3; ++i) {
      run(2, 4000);
      EXPECT_EQ(static_cast<std::int32_t>(rig.read(0x606B)), 5'000);
      run(9, 4000);
      run(2, 57);  // before the transition of the vector has ended
      run(3, 4000);
    }
    // The ramps allow 20 rev/s2, 0.016 rad/s in a cycle; a missing newton metre would be 0.42.
    EXPECT_LT(largest, 0.1);
  }
}

TEST(MsdFrequency, QuickStopAndHaltAreRampsOfTheFrequency) {
  DriveRig rig;
  use_milli_revolutions(rig);
  rig.start(2);
  order(rig, 10'000, 8000);
  rig.command(kRun | 0x100, 2000);  // 20 rev/s2: half way after 250 ms
  EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x606B)), 5'000, 50);
  EXPECT_NEAR(rig.velocity, 5'000, 300);
  rig.cycles(8000);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 1e-6);
  EXPECT_NEAR(static_cast<std::int16_t>(rig.read(0x6078)), 800, 20) << "the field still holds the rotor";
  order(rig, 10'000, 8000);
  EXPECT_NEAR(rig.velocity, 10'000, 20);
  rig.control = 0x02;  // quick stop, option 2: 50 rev/s2, then off
  rig.cycles(800);
  EXPECT_NEAR(rig.velocity, 5'000, 400);
  EXPECT_EQ(rig.drive.state(), PowerState::kQuickStopActive);
  rig.cycles(4000);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(rig.read(0x6078), 0U) << "and the current is gone";
}

TEST(MsdFrequency, DisableVoltageCoasts) {
  DriveRig rig;
  use_milli_revolutions(rig);
  rig.start(2);
  order(rig, 10'000, 8000);
  rig.command(0, 80);
  EXPECT_GT(rig.drive.velocity_rad_s(), 9.5 * kTurnRad);
  EXPECT_EQ(rig.torque, 0);
}

TEST(MsdFrequency, SameRunTwiceIsTheSameToTheBit) {
  const auto run = [] {
    DriveRig rig(with_weight(0.5));
    use_milli_revolutions(rig);
    rig.start(2);
    order(rig, 12'345, 5000);
    return std::pair(rig.drive.position_rad(), rig.drive.torque_nm());
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace driveline::slaves::msd
