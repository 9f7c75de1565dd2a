// The holding brake before the drive is enabled for the first time, and at the output it hangs at.
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

/// The lowest place of the axis while the drive runs by itself for this time.
double lowest(MsdDrive& drive, std::chrono::nanoseconds from, std::chrono::nanoseconds time) {
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
    ASSERT_EQ(rig.write_real(0x20D6, 0, 250.0F), 0U);  // close time
    ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  }
  for (const auto start_up : {std::chrono::nanoseconds{1ms}, std::chrono::nanoseconds{1s}}) {
    parameters.start_up_time = start_up;
    MsdDrive drive(parameters);
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
    ASSERT_EQ(rig.write_real(0x20D6, 0, 50.0F), 0U);
    ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
    rig.pass(5ms);
    rig.operate();
    rig.enable(8);
    for (auto t = 0ms; t < open_before; t += 1ms) rig.cycles(8);
    const double held = rig.drive.position_rad();
    rig.drive.restart();
    rig.now += 1ms;
    const double fallen = held - lowest(rig.drive, rig.now, 900ms);
    const double way = 0.5 * (1.0 - 0.03) / 3.0e-4 * kTimeS * kTimeS;  // until it holds; then 4 Nm stop the fall
    EXPECT_GT(fallen, way);
    EXPECT_LT(fallen, 1.5 * way);
    EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0) << "it holds before the self-test is over";
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
