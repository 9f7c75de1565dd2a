// Device control of the drive: effect of the state machine on the motion, option codes, terminals, display.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr double kQuickStopIncrements = 419430400.0;  // 6085h default
constexpr double kSlowDownIncrements = 104857600.0;   // 6084h default
constexpr std::int32_t kSpeed = 10'000'000;           // 9.5 rev/s

TEST(MsdState, StatusWordThroughTheStates) {
  OperatingRig rig;
  rig.mode = 9;
  const auto status_after = [&](std::uint16_t control) {
    rig.command(control, 2);
    return rig.status & 0x6F;
  };
  EXPECT_EQ(status_after(0x00), 0x40);
  EXPECT_EQ(status_after(0x06), 0x21);
  EXPECT_EQ(status_after(0x07), 0x23);
  EXPECT_EQ(status_after(0x0F), 0x27);
  EXPECT_EQ(rig.status & 0x1300, 0x1200);        // remote, target used, bit 8 always 0
  EXPECT_EQ(status_after(0x0F | 0xFF00), 0x27);  // bits 8 to 15 command nothing in mode 9
  EXPECT_EQ(rig.mode_display, 9);
  EXPECT_TRUE(rig.status & 0x10);  // DC link
}

TEST(MsdState, QuickStopRampIsThatOf6085) {
  OperatingRig rig;
  rig.run_at(kSpeed);
  rig.control = 0x02;
  const double stop_time = kSpeed / kQuickStopIncrements;
  rig.cycles(static_cast<int>(0.5 * stop_time / 125e-6));
  EXPECT_EQ(rig.status & 0x6F, 0x07);
  EXPECT_NEAR(rig.velocity, 0.5 * kSpeed, 0.03 * kSpeed);
  rig.cycles(static_cast<int>(0.6 * stop_time / 125e-6) + 40);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 1.1);
}

TEST(MsdState, SlowDownRampIsThatOf6084) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x605A, 0, 5, 2), 0U);
  rig.run_at(kSpeed);
  rig.control = 0x02;
  const double stop_time = kSpeed / kSlowDownIncrements;
  rig.cycles(static_cast<int>(0.5 * stop_time / 125e-6));
  EXPECT_NEAR(rig.velocity, 0.5 * kSpeed, 0.03 * kSpeed);
  rig.cycles(static_cast<int>(0.6 * stop_time / 125e-6) + 40);
  EXPECT_EQ(rig.drive.state(), PowerState::kQuickStopActive);
  EXPECT_TRUE(rig.status & 0x0400) << "target reached after a quick stop that stays";
  EXPECT_EQ(rig.status & 0x6F, 0x07);
  rig.target_velocity = 0;
  rig.command(0x0F, 2);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
}

TEST(MsdState, RampFollowsTheObject) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6085, 0, 200'000'000, 4), 0U);
  rig.run_at(kSpeed);
  rig.command(0x02, 200);  // 25 ms
  EXPECT_NEAR(rig.velocity, kSpeed - 200e6 * 0.025, 0.03 * kSpeed);
}

TEST(MsdState, CurrentLimitStopsWithAllTheTorqueThereIs) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x605A, 0, 3, 2), 0U);
  rig.run_at(5 * kSpeed);
  rig.command(0x02, 10);
  EXPECT_LT(rig.torque, -2800);  // peak torque is 3000 permille
  rig.cycles(400);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
}

/// An axis that swings through standstill has not stopped: status bit 14 requires some time within the window.
TEST(MsdState, StandstillIsMoreThanPassingZero) {
  OperatingRig rig;
  rig.run_at(kSpeed);
  rig.target_velocity = -kSpeed;
  double last = rig.drive.velocity_rad_s();
  bool passed = false;
  for (int i = 0; i < 800; ++i) {
    rig.cycle();
    passed = passed || (last > 0.0 && rig.drive.velocity_rad_s() < 0.0);
    last = rig.drive.velocity_rad_s();
    EXPECT_FALSE(rig.status & 0x4000);
  }
  EXPECT_TRUE(passed);
  rig.turn(0, 800);
  EXPECT_TRUE(rig.status & 0x4000);
}

TEST(MsdState, DisableVoltageCoasts) {
  OperatingRig rig;
  rig.run_at(kSpeed);
  rig.command(0x00, 80);  // 10 ms
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(rig.torque, 0);
  // Coulomb and viscous friction alone: (0.03 + 2e-4 * 60) / 3e-4 is about 140 rad/s2
  EXPECT_NEAR(rig.drive.velocity_rad_s(), kSpeed / kIncrementsPerRadian - 1.4, 0.3);
}

TEST(MsdState, DisableOperationAndShutdownFollowTheirOptionCodes) {
  for (const bool ramp : {true, false}) {
    OperatingRig rig;
    ASSERT_EQ(rig.write(0x605C, 0, ramp ? 1 : 0, 2), 0U);
    ASSERT_EQ(rig.write(0x605B, 0, ramp ? 1 : 0, 2), 0U);
    for (const std::uint16_t word : {std::uint16_t{0x07}, std::uint16_t{0x06}}) {
      rig.run_at(kSpeed);
      rig.command(word, 400);  // 50 ms, half of the slow down ramp
      EXPECT_EQ(rig.drive.state() == PowerState::kOperationEnabled, ramp);
      EXPECT_NEAR(rig.drive.velocity_rad_s(), ramp ? 30.0 : 53.0, 3.0);
      rig.cycles(600);
      EXPECT_EQ(rig.drive.state(), word == 0x07 ? PowerState::kSwitchedOn : PowerState::kReadyToSwitchOn);
    }
  }
}

TEST(MsdState, HardwareEnableAndSafeTorqueOffTakeThePower) {
  OperatingRig rig;
  for (const bool sto : {true, false}) {
    rig.run_at(kSpeed);
    sto ? rig.drive.set_isdsh(false) : rig.drive.set_enpo(false);
    rig.cycles(2);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
    EXPECT_EQ(rig.drive.torque_nm() > 0.02, false);
    EXPECT_EQ(rig.read(0x60FD), sto ? 0xC0000U : 0U) << "bit 18 safe stop, bit 19 ENPO";
    EXPECT_EQ(rig.read(0x2079), sto ? 0x01U : 0x80U) << "bit 0 ENPO, bit 7 ISDSH";
    rig.command(0x06, 2);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
    sto ? rig.drive.set_isdsh(true) : rig.drive.set_enpo(true);
  }
}

TEST(MsdState, WithoutDcLinkTheDriveStaysInSwitchOnDisabled) {
  OperatingRig rig;
  rig.drive.set_dc_link(false);
  rig.command(0x06, 4);
  EXPECT_EQ(rig.status & 0x7F, 0x40);
  EXPECT_EQ(rig.read(0x6079), 0U);
  rig.drive.set_dc_link(true);
  rig.cycles(2);
  EXPECT_EQ(rig.status & 0x7F, 0x31);
}

TEST(MsdState, ControlWordCountsOnlyWithControlLocationCia402) {
  EnabledRig rig(9);
  ASSERT_EQ(rig.write(0x209F, 0, 1, 2), 0U);
  rig.cycles(2);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(rig.status & 0x0200, 0);
  ASSERT_EQ(rig.write(0x209F, 0, 5, 2), 0U);
  rig.enable(9);
  EXPECT_EQ(rig.status & 0x0200, 0x0200);
}

TEST(MsdState, SetpointsCountOnlyWithReferenceSourceCia402) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x20A5, 0, 0, 2), 0U);
  rig.enable(9);
  rig.turn(kSpeed, 800);
  EXPECT_EQ(rig.status & 0x1000, 0);
  EXPECT_NEAR(rig.velocity, 0, 2000);
}

TEST(MsdState, ControlWordIsOneObjectWithTwoAddresses) {
  DriveRig rig;
  EXPECT_EQ(rig.write(0x28A0, 0, 0x06, 2), 0U);
  rig.pass(250us);
  EXPECT_EQ(rig.read(0x6040), 0x06U);
  EXPECT_EQ(rig.read(0x28A1) & 0x6F, 0x21U);
  EXPECT_EQ(rig.read(0x28A1), rig.read(0x6041));
}

TEST(MsdState, DisplayShowsStatePowerAndSafeTorqueOff) {
  OperatingRig rig;
  rig.drive.set_isdsh(false);
  rig.cycles(2);
  EXPECT_EQ(rig.drive.display(), "S2");
  rig.drive.set_isdsh(true);
  rig.cycles(2);
  EXPECT_EQ(rig.drive.display(), "2");
  rig.command(0x06, 2);
  EXPECT_EQ(rig.drive.display(), "3");
  rig.enable(9);
  EXPECT_EQ(rig.drive.display(), "5.");
}

TEST(MsdState, DisplayOneIsNoDcLinkVoltage) {
  OperatingRig rig;
  rig.drive.set_dc_link(false);
  rig.cycles(2);
  EXPECT_EQ(rig.drive.display(), "1");
  EXPECT_EQ(rig.status & 0x006F, 0x0040) << "Switch on disabled on the bus";
  EXPECT_EQ(rig.drive.display_now(), display_frame({.state = PowerState::kNotReadyToSwitchOn}, 0ns));
  rig.drive.set_dc_link(true);
  rig.cycles(2);
  EXPECT_EQ(rig.drive.display(), "2");
}

TEST(MsdState, PowerSectionIsOnInSwitchedOn) {
  OperatingRig rig;
  rig.command(0x06, 2);
  EXPECT_EQ(rig.drive.display(), "3");
  EXPECT_EQ(rig.write(0x607E, 0, 0x80, 1), 0U);
  rig.command(0x07, 2);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchedOn);
  EXPECT_EQ(rig.drive.display(), "4.");
  EXPECT_EQ(rig.write(0x607E, 0, 0x00, 1), 0x08000022U);
  EXPECT_EQ(rig.drive.torque_nm(), 0.0) << "drive function deactivated";
}

TEST(MsdState, NetworkStateFollowsTheSlaveController) {
  DriveRig rig;
  EXPECT_EQ(rig.read(0x280C), 127U);
  rig.operate();
  EXPECT_EQ(rig.read(0x280C), 5U);
  rig.to(AlState::kOp, AlState::kSafeOp);
  EXPECT_EQ(rig.read(0x280C), 4U);
}

}  // namespace
}  // namespace driveline::slaves::msd
