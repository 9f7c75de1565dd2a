// Velocity mode (U/f operation, MSD manual 12.2.2) of the drives as seen by the master.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "profile_line.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Variant;

class EveryVelocityMode : public testing::TestWithParam<Variant> {};

TEST_P(EveryVelocityMode, RunsAtAVelocityUntilItIsHalted) {
  ProfileLine line(velocity_mode_options(GetParam()));
  for (const double rpm : {200.0, -150.0}) {
    const auto running = line.submit(run_at(rpm * kRpm));
    line.cycles(2000);
    EXPECT_EQ(line.phase(running), RequestPhase::kReached);
    EXPECT_EQ(line.state(), PlcopenState::kContinuousMotion);
    EXPECT_EQ(line.now().mode, 2);
    EXPECT_EQ(line.drives.drive(0).dictionary().get(slaves::msd::kValue.velocity_setpoint), rpm);
    EXPECT_NEAR(line.now().velocity, rpm * kRpm, 0.5);
    EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
    EXPECT_EQ(line.phase(running), RequestPhase::kAborted);
    line.expect_use();
    EXPECT_EQ(line.drives.drive(0).dictionary().get(slaves::msd::kValue.velocity_setpoint), 0)
        << "nothing is left for the next change into the mode";
  }
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EveryVelocityMode, testing::Values(Variant::kMsd, Variant::kServoOne),
                         [](const auto& row) { return std::string(row.param == Variant::kMsd ? "Msd" : "ServoOne"); });

TEST(DriveVelocityMode, ANewVelocityIsTakenAtOnceAndAnotherModeNot) {
  ProfileLine line(velocity_mode_options());
  const auto slow = line.submit(run_at(10.0));
  line.cycles(1000);
  const auto fast = line.submit(run_at(30.0));
  line.cycles(1500);
  EXPECT_EQ(line.phase(slow), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(fast), RequestPhase::kReached);
  EXPECT_NEAR(line.now().velocity, 30.0, 1.0);
  EXPECT_EQ(line.ask(at(10.0)).error, AxisError::kNotAtRest) << "profile velocity mode";
  EXPECT_EQ(line.ask(to(0.0)).error, AxisError::kNotAtRest);
}

TEST(DriveVelocityMode, AMotionOfTheMasterFollowsBehindAHalt) {
  ProfileLine line(velocity_mode_options());
  const auto driven = line.submit(run_at(20.0));
  line.cycles(1000);
  EXPECT_EQ(line.finish(line.submit(move(1.0, 20.0)), 20'000).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(driven), RequestPhase::kAborted);
  EXPECT_NEAR(line.setpoint(), 1.0, 1e-9);
  EXPECT_EQ(line.now().mode, 8);
}

TEST(DriveVelocityMode, AStopAtAnyMomentLeavesTheAxisAtRest) {
  for (const int moment : {0, 1, 5, 9, 12, 20, 24, 40, 400}) {
    SCOPED_TRACE(testing::Message() << "cycle " << moment);
    ProfileLine line(velocity_mode_options());
    line.submit(run_at(20.0));
    line.cycles(moment);
    EXPECT_EQ(line.ask(request(AxisCommand::kStop)).phase, RequestPhase::kDone);
    EXPECT_EQ(line.state(), PlcopenState::kStopping);
    EXPECT_NEAR(line.now().velocity, 0.0, 0.3);
    EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop)).phase, RequestPhase::kDone);
    line.expect_use();
  }
}

TEST(DriveVelocityMode, CountsOfTheDriveDecideWhatCanBeAsked) {
  auto options = velocity_mode_options();
  ProfileLine line(options);
  EXPECT_EQ(line.ask(run_at(0.4 * kRpm)).error, AxisError::kVelocityCount) << "nothing would be left of it";
  EXPECT_EQ(line.ask(run_at(51.0)).error, AxisError::kOverLimit);
  auto ramped = run_at(10.0);
  ramped.acceleration_si = 100.0;
  EXPECT_EQ(line.ask(ramped).error, AxisError::kMode) << "its ramps are set in the drive";
  EXPECT_EQ(line.ask(run_at(std::numeric_limits<double>::infinity())).error, AxisError::kNotFinite);
  const auto still = line.submit(run_at(0.0));
  line.cycles(1000);
  EXPECT_EQ(line.phase(still), RequestPhase::kReached);
  EXPECT_EQ(line.now().mode, 2);
  EXPECT_NEAR(line.now().velocity, 0.0, 0.1);

  options.velocity_count = 1e-3;
  ProfileLine fine(options);
  EXPECT_EQ(fine.ask(run_at(32.8)).error, AxisError::kVelocityCount) << "more than 16 bits";
  options.velocity_count = 0.0;
  ProfileLine unknown(options);
  EXPECT_EQ(unknown.ask(run_at(1.0)).error, AxisError::kVelocityCount);
  options.supported_modes = 0x03E7U & ~(1U << 1U);
  ProfileLine none(options);
  EXPECT_EQ(none.ask(run_at(1.0)).error, AxisError::kNoSuchMode);
  EXPECT_EQ(ProfileLine().ask(run_at(1.0)).error, AxisError::kMode) << "6042h is not mapped";
}

TEST(DriveVelocityMode, OfAReversedAxisRunsAsTheAxisCounts) {
  auto options = velocity_mode_options();
  options.reversed = true;
  ProfileLine line(options);
  line.submit(run_at(20.0));
  line.cycles(2000);
  EXPECT_NEAR(line.now().velocity, 20.0, 0.5);
  EXPECT_LT(line.drives.drive(0).velocity_rad_s(), -19.0);
}

TEST(DriveVelocityMode, EndsAtTheSoftwareLimits) {
  auto options = velocity_mode_options();
  options.software_limits = trajectory::PositionRange{-5.0, 5.0};
  ProfileLine line(options);
  EXPECT_EQ(line.finish(line.submit(run_at(10.0))).error, AxisError::kOutsideRange);
  line.cycles(1000);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_LT(line.now().position, 5.2) << "as the drive halts";
  EXPECT_EQ(line.ask(move(0.0)).phase, RequestPhase::kDone);
}

TEST(DriveVelocityMode, AFaultEndsItAndNothingIsLeftOfIt) {
  ProfileLine line(velocity_mode_options());
  const auto driven = line.submit(run_at(20.0));
  line.cycles(500);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(driven).error, AxisError::kFault);
  line.cycles(8000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable();
  line.expect_use();
  EXPECT_EQ(line.drives.drive(0).dictionary().get(slaves::msd::kValue.velocity_setpoint), 0);
}

TEST(DriveVelocityMode, LostFramesAreNoMatterAndAnAbsenceOfTheMasterEndsIt) {
  ProfileLine line(velocity_mode_options());
  const auto driven = line.submit(run_at(20.0));
  for (int cycle = 0; cycle < 2000; ++cycle) {
    line.lose_out = cycle % 3 == 1;
    line.lose_back = cycle % 5 == 1;
    line.cycle();
  }
  line.lose_out = line.lose_back = false;
  EXPECT_EQ(line.phase(driven), RequestPhase::kReached);
  line.stall(9);
  EXPECT_EQ(line.axes().report(driven).error, AxisError::kMasterAway);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  line.cycles(20'000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable();
  line.expect_use();
}

}  // namespace
}  // namespace driveline::bus_test
