// The drive with its machine: weight, end stops, winding, encoder.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

TEST(MsdMachine, WeightDropsWithoutABrakeAndStaysWithOne) {
  for (const double brake_nm : {0.0, 5.0}) {
    MsdParameters parameters;
    parameters.motor.load.gravity_nm = 1.0;
    parameters.motor.brake_torque_nm = brake_nm;
    EnabledRig rig(parameters, 8);
    rig.cycles(800);
    EXPECT_NEAR(rig.torque, 417, 20) << "holds 1 Nm of 2.4";
    const double held = rig.drive.position_rad();
    rig.command(0x00, 800);
    if (brake_nm > 0.0) {
      EXPECT_NEAR(rig.drive.position_rad(), held, 0.01);
    } else {
      EXPECT_LT(rig.drive.position_rad(), held - 5.0);
    }
  }
}

TEST(MsdMachine, EndStopEndsInAFollowingError) {
  MsdParameters parameters;
  parameters.motor.load.end_stop_max_rad = 3.0;
  DriveRig rig(parameters);
  ASSERT_EQ(rig.write(0x6065, 0, kRevolution / 4, 4), 0U);
  rig.start(1);
  rig.target_position = 5 * kRevolution;
  rig.command(0x1F, 8000);
  EXPECT_EQ(rig.drive.fault(), Fault::kFollowingError);
  EXPECT_NEAR(rig.drive.position_rad(), 3.0, 0.1);
}

TEST(MsdMachine, SimulatedWindingTracksLikeTheLagAndRunsOutOfVoltage) {
  MsdParameters parameters;
  parameters.motor.winding.simulated = true;
  EnabledRig rig(parameters, 3);
  rig.turn(50 * kRevolution, 8000);
  EXPECT_NEAR(rig.velocity, 50 * kRevolution, kRevolution / 20.0);
  rig.drive.set_dc_link_voltage(260.0);
  rig.turn(99 * kRevolution, 16'000);
  EXPECT_LT(rig.velocity, 95 * kRevolution) << "the back EMF leaves no voltage";
}

/// Friction alone: (0.03 Nm + 2e-4 Nm s at 126 rad/s) / 3e-4 kg m2, over 20 ms.
TEST(MsdMachine, PowerStageOffIsAnOpenCircuitWithoutDcLinkToo) {
  enum class Off : std::uint8_t { kDcLink, kSag, kControlWord, kEnpo, kSafeTorqueOff, kHalt };
  for (const Off off : {Off::kDcLink, Off::kSag, Off::kControlWord, Off::kEnpo, Off::kSafeTorqueOff, Off::kHalt}) {
    for (const bool winding : {false, true}) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(off) << (winding ? " winding" : " lag"));
      MsdParameters parameters;
      parameters.motor.winding.simulated = winding;
      OperatingRig rig(parameters);
      ASSERT_EQ(rig.write(0x605D, 0, 0, 2), 0U);  // halt: drive function off
      rig.enable(3);
      rig.turn(20 * kRevolution, 2400);
      const double before = rig.drive.velocity_rad_s();
      ASSERT_NEAR(before, 125.7, 0.5);
      if (off == Off::kDcLink) rig.drive.set_dc_link(false);
      if (off == Off::kSag) rig.drive.set_dc_link_voltage(30.0);  // half of the back EMF
      if (off == Off::kControlWord) rig.control = 0x00;
      if (off == Off::kEnpo) rig.drive.set_enpo(false);
      if (off == Off::kSafeTorqueOff) rig.drive.set_isdsh(false);
      if (off == Off::kHalt) rig.control = 0x10F;
      rig.cycles(160);
      EXPECT_NEAR(rig.drive.velocity_rad_s(), before - 0.02 * (0.03 + 2e-4 * 125.0) / 3.0e-4, 0.3);
      EXPECT_NEAR(rig.drive.torque_nm(), 0.0, 1e-6);
      EXPECT_EQ(rig.torque, 0);
    }
  }
}

TEST(MsdMachine, PowerComesBackToATurningMotorWithoutAJerk) {
  MsdParameters parameters;
  parameters.motor.winding.simulated = true;
  OperatingRig rig(parameters);
  rig.run_at(20 * kRevolution);
  rig.command(0x00, 400);
  const double coasting = rig.drive.velocity_rad_s();
  ASSERT_GT(coasting, 100.0);
  rig.enable(9);
  rig.target_velocity = rig.velocity;
  for (int i = 0; i < 80; ++i) {
    rig.cycle();
    // The present speed fades out while the setpoint, which came later, fades in.
    EXPECT_NEAR(rig.drive.velocity_rad_s(), coasting, 8.0);
  }
}

TEST(MsdMachine, TwoMassAxisWithEncoderNoiseMovesToItsTarget) {
  MsdParameters parameters;
  parameters.motor.load.inertia_kg_m2 = 1e-4;
  parameters.motor.load.stiffness_nm_rad = 1000.0;
  parameters.motor.load.damping_nm_s = 0.02;
  parameters.motor.encoder_noise_increments = 2.0;
  const auto run = [&] {
    EnabledRig rig(parameters, 1);
    rig.target_position = 3 * kRevolution;
    rig.command(0x1F, 16'000);
    EXPECT_TRUE(rig.status & 0x0400);
    EXPECT_NEAR(rig.position, 3 * kRevolution, 200);
    return rig.drive.position_rad();
  };
  EXPECT_EQ(run(), run()) << "bit-identical with the same seed";
}

TEST(MsdMachine, EncoderForgetsWhatItDoesNotKnowAtPowerOn) {
  MsdParameters parameters;
  parameters.initial_position_rad = 2.0 * std::numbers::pi * 3.25;
  for (const std::uint32_t turns : {0U, 1U, MotorParameters::kAllTurns}) {
    parameters.motor.encoder_turns = turns;
    DriveRig rig(parameters);
    const double expected = turns == 0 ? 0.0 : turns == 1 ? 0.25 : 3.25;
    EXPECT_NEAR(static_cast<std::int32_t>(rig.read(0x6064)), expected * kRevolution, 2.0);
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
