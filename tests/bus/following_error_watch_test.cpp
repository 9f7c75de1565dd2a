// Axes that lag behind their setpoints are detected by the master in every mode.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "single_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionFailure;
using motion::MotionPhase;
using motion::cia402::Mode;

constexpr double kWindow = 0.05;
constexpr double kPeriodS = 125e-6;

void block(slaves::msd::DriveCore& drive, bool blocked) {
  const auto place = drive.signals().find_signal(slaves::SignalId::Direction::kInput, "AXIS_BLOCKED");
  ASSERT_TRUE(place);
  drive.signals().set_signal(place->number, blocked ? 1.0 : 0.0);
}

RunOptions watched(double window) {
  RunOptions options;
  options.amplitude_rad = 6.0;
  options.following_error_window = window;
  return options;
}

class WatchedFollowingError : public testing::TestWithParam<Mode> {};

TEST_P(WatchedFollowingError, StopsAllAxesWithinTheirLimits) {
  auto options = watched(GetParam() == Mode::kCyclicTorque ? 4 * kWindow : kWindow);
  options.mode = GetParam();
  DriveLine drives(2);
  FollowingOperation operation(drives, options);
  operation.run(milliseconds{80});
  ASSERT_EQ(operation.motion().phase(), MotionPhase::kFollowing) << "nothing is wrong so far";
  block(drives.drive(1), true);
  const auto blocked = drives.clock.now();
  ASSERT_TRUE(operation.run_until(MotionPhase::kStopping, milliseconds{60}));
  EXPECT_GE(drives.clock.now() - blocked, milliseconds{10}) << "the time-out";
  const auto failure = operation.motion().failure();
  EXPECT_EQ(failure.cause, MotionFailure::Cause::kFollowingError);
  EXPECT_EQ(failure.axis, 1);
  EXPECT_GT(std::abs(failure.following_error), *options.following_error_window);
  // Setpoints of the other axis: the samples of a cycle are in the order of the axes.
  std::vector<double> setpoints;
  for (int i = 0; i < 4000 && operation.motion().phase() == MotionPhase::kStopping; ++i) {
    operation.cycle();
    setpoints.push_back(operation.axis_samples[operation.axis_samples.size() - 2].target_position);
  }
  ASSERT_GT(setpoints.size(), 80U) << "it has a way to stop";
  for (std::size_t i = 2; i < setpoints.size(); ++i) {
    const double change = setpoints[i] - 2.0 * setpoints[i - 1] + setpoints[i - 2];
    ASSERT_LE(std::abs(change), 1.01 * 1000.0 * kPeriodS * kPeriodS) << i;
  }
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
}

TEST_P(WatchedFollowingError, IsNotThereWithoutAWindow) {
  RunOptions options;
  options.amplitude_rad = 6.0;
  options.mode = GetParam();
  DriveLine drives(1);
  FollowingOperation operation(drives, options);
  operation.run(milliseconds{80});
  block(drives.drive(0), true);
  operation.run(milliseconds{30});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kFollowing);
}

INSTANTIATE_TEST_SUITE_P(Modes, WatchedFollowingError,
                         testing::Values(Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque));

TEST(FollowingErrorOfASingleAxis, IsAnErrorStopOfThatAxisAlone) {
  auto options = single_options();
  options.following_error_window = kWindow;
  SingleLine line(2, options);
  for (const std::size_t axis : {0U, 1U}) line.enable(axis);
  const auto moved = line.submit(move(40.0, 20.0), 0);
  const auto other = line.submit(move(3.0), 1);
  line.cycles(800);
  ASSERT_EQ(line.phase(moved), RequestPhase::kActive);
  block(line.drives.drive(0), true);
  EXPECT_EQ(line.finish(moved).error, AxisError::kFollowingError);
  EXPECT_EQ(line.state(0), PlcopenState::kErrorStop);
  EXPECT_EQ(line.finish(other).phase, RequestPhase::kDone);
  block(line.drives.drive(0), false);
  line.cycles(2000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable(0);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
}

}  // namespace
}  // namespace driveline::bus_test
