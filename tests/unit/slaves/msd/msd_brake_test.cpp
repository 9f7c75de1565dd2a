// The holding brake before the drive is first enabled, and at the output that it is connected to.
#include <unistd.h>

#include <filesystem>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr auto kCycle = 125us;

MsdParameters vertical_axis() {
  MsdParameters parameters;
  parameters.motor.brake_torque_nm = 5.0;
  parameters.motor.load.gravity_nm = 1.0;
  return parameters;
}

/// The lowest position of the axis while the drive runs on its own for this time.
double lowest(DriveCore& drive, std::chrono::nanoseconds from, std::chrono::nanoseconds time) {
  double low = drive.position_rad();
  for (auto t = from; t <= from + time; t += kCycle) {
    drive.advance(t);
    low = std::min(low, drive.position_rad());
  }
  return low;
}

TEST(MsdBrake, HoldsFromPowerOnAndThroughTheSelfTest) {
  const auto file = std::filesystem::path(testing::TempDir()) / ("brake-" + std::to_string(::getpid()));
  MsdParameters parameters = vertical_axis();
  parameters.parameter_file = file.string();
  {
    DriveRig rig(parameters);
    rig.set({real_value(0x20D6, 0, 250.0F),  // close time
             {0x200B, 1, 1, 1}});
  }
  for (const auto start_up : {std::chrono::nanoseconds{1ms}, std::chrono::nanoseconds{1s}}) {
    parameters.start_up_time = start_up;
    MsdDrive device(parameters);
    DriveCore& drive = device.core();
    EXPECT_GT(lowest(drive, 0ns, 2s), -0.01) << "a brake that has no current holds";
    EXPECT_EQ(drive.state(), PowerState::kSwitchOnDisabled);
  }
  std::filesystem::remove(file);
}

TEST(MsdBrake, HoldsWhileItsCloseTimeIsWrittenBeforeTheFirstEnable) {
  DriveRig rig(vertical_axis());
  ASSERT_EQ(rig.write_real(0x20D6, 0, 10'000.0F), 0U);
  EXPECT_GT(lowest(rig.drive, rig.now, 500ms), -0.01);
}

TEST(MsdBrake, ClosesInItsTimeWhenTheDriveIsSwitchedOffWhileItIsOpen) {
  constexpr double kTimeS = 0.05;
  for (const auto open_before : {50ms, 400ms}) {
    MsdParameters parameters = vertical_axis();
    parameters.start_up_time = 1s;
    DriveRig rig(parameters);
    rig.pass(1s);
    rig.set({real_value(0x20D6, 0, 50.0F), {0x200B, 1, 1, 1}});
    rig.pass(5ms);
    rig.start(8);
    for (auto t = 0ms; t < open_before; t += 1ms) rig.cycles(8);
    const double held = rig.drive.position_rad();
    rig.device.restart();
    rig.now += 1ms;
    const double fallen = held - lowest(rig.drive, rig.now, 900ms);
    const double way = 0.5 * (1.0 - 0.03) / 3.0e-4 * kTimeS * kTimeS;  // until it holds; then 4 Nm stop the fall
    EXPECT_GT(fallen, way);
    EXPECT_LT(fallen, 1.5 * way);
    EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0) << "it holds before the self-test is over";
  }
}

/// P 125 is the function of the brake's output; the brake follows the output.
TEST(MsdBrake, StaysClosedAtAnOutputThatIsOff) {
  for (const std::uint32_t function : {0U, 39U, 40U}) {
    SCOPED_TRACE(function);
    auto parameters = vertical_axis();
    parameters.motor.brake_torque_nm = 10.0;  // more than the motor has
    DriveRig rig(parameters);
    ASSERT_EQ(rig.write(0x207D, 0, function, 2), 0U);
    rig.start(8);
    for (int i = 0; i < 400; ++i) {
      rig.target_position += 131;
      rig.cycle();
    }
    EXPECT_FALSE(rig.drive.output(Output::kBrake));
    EXPECT_NEAR(rig.drive.position_rad(), 0.0, 0.01) << "10 Nm hold";
    EXPECT_GT(rig.following_error, 40'000);
  }
}

TEST(MsdBrake, OpensByTheBusAlone) {
  for (const std::uint32_t function : {39U, 40U}) {
    SCOPED_TRACE(function);
    DriveRig rig(vertical_axis());
    ASSERT_EQ(rig.write(0x207D, 0, function, 2), 0U);
    ASSERT_EQ(rig.write_real(0x20D5, 0, 20.0F), 0U);  // lift time
    rig.operate();
    rig.cycles(80);
    ASSERT_NEAR(rig.drive.position_rad(), 0.0, 0.001);
    ASSERT_EQ(rig.write(0x60FE, 1, 1U << 22U, 4), 0U);
    rig.cycles(120);  // 15 ms
    EXPECT_TRUE(rig.drive.output(Output::kBrake));
    EXPECT_NEAR(rig.drive.position_rad(), 0.0, 0.001) << "still lifting";
    rig.cycles(400);
    EXPECT_LT(rig.drive.position_rad(), -1.0) << "nobody holds the weight";
    ASSERT_EQ(rig.write(0x60FE, 1, 0, 4), 0U);
    rig.cycles(1600);
    EXPECT_FALSE(rig.drive.output(Output::kBrake));
    EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
  }
}

TEST(MsdBrake, ClosesWhenADriveThatTheBusOpenedItOnIsSwitchedOff) {
  DriveRig rig(vertical_axis());
  rig.set({{0x207D, 0, 40, 2}, {0x200B, 1, 1, 1}});
  rig.pass(5ms);
  ASSERT_EQ(rig.write(0x60FE, 1, 1U << 22U, 4), 0U);
  rig.pass(50ms);
  ASSERT_LT(rig.drive.velocity_rad_s(), -50.0);
  rig.device.restart();
  rig.pass(500ms);
  EXPECT_FALSE(rig.drive.output(Output::kBrake));
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
}

TEST(MsdBrake, SetpointsNeedNotWaitForABrakeThatTheDriveDoesNotControl) {
  DriveRig rig;
  rig.set({{0x207D, 0, 0, 2}, real_value(0x20D5, 0, 1000.0F)});
  rig.start(9);
  rig.turn(1 << 20, 400);
  EXPECT_NEAR(rig.velocity, 1 << 20, 5000);
}

}  // namespace
}  // namespace driveline::slaves::msd
