// Drives with implausible actual positions: reaction of the master, and motion of the shaft meanwhile.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "drive_line.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionFailure;
using motion::MotionPhase;
using motion::cia402::Mode;
using snapshot::AxisState;
using std::chrono::seconds;

constexpr double kIncrementsPerRad = 1048576.0 / (2.0 * std::numbers::pi);
constexpr double kLeap = 2e6;

void set(slaves::msd::DriveCore& drive, std::string_view input, double value) {
  const auto place = drive.signals().find_signal(slaves::SignalId::Direction::kInput, input);
  ASSERT_TRUE(place) << input;
  drive.signals().set_signal(place->number, value);
}

/// A line in motion, and the behaviour of drive 1 from then on.
class ImplausiblePosition : public testing::TestWithParam<Mode> {
 protected:
  ImplausiblePosition() : drives(2), operation(drives, RunOptions{.mode = GetParam(), .amplitude_rad = 6.0}) {}

  void start() {
    follow_path(operation);
    operation.run(milliseconds{80});
  }
  /// Runs one cycle. Speeds are those of the shaft.
  void step() {
    operation.cycle();
    fastest_rad_s = std::max(fastest_rad_s, std::abs(liar().velocity_rad_s()));
    const double demand = operation.axis_samples.back().target_velocity;
    steepest_rad_s2 = std::max(steepest_rad_s2, std::abs(demand - demand_rad_s) / kCycleSeconds);
    demand_rad_s = demand;
  }
  void run_until(MotionPhase phase, nanoseconds limit) {
    const auto end = drives.clock.now() + limit;
    while (operation.motion().phase() != phase && drives.clock.now() < end) step();
    EXPECT_EQ(operation.motion().phase(), phase) << to_text(operation.motion().phase());
  }
  slaves::msd::DriveCore& liar() { return drives.drive(1); }

  static constexpr double kCycleSeconds = 125e-6;
  DriveLine drives;
  LineOperation operation;
  double fastest_rad_s = 0.0;
  double steepest_rad_s2 = 0.0;
  double demand_rad_s = 0.0;
};

TEST_P(ImplausiblePosition, ThatLeapsStopsAllAxesWithinTheirLimits) {
  start();
  const double speed = std::abs(liar().velocity_rad_s());
  ASSERT_GT(speed, 10.0);
  demand_rad_s = operation.axis_samples.back().target_velocity;
  set(liar(), "POSITION_ERROR", kLeap);
  for (int i = 0; i < 3; ++i) step();
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kStopping) << "the first such value counts";
  run_until(MotionPhase::kIdle, seconds{2});
  EXPECT_LT(fastest_rad_s, 1.15 * speed) << "the shaft knows nothing of it";
  EXPECT_LE(steepest_rad_s2, 1.05 * 1000.0) << "nothing but the limit of the axis";
  const auto failure = operation.motion().failure();
  EXPECT_EQ(failure.cause, MotionFailure::Cause::kPositionLeap);
  EXPECT_EQ(failure.axis, 1);
  EXPECT_NEAR(failure.position.moved, kLeap / kIncrementsPerRad, 0.1);
  EXPECT_LT(std::abs(liar().velocity_rad_s()), 0.1);
}

TEST_P(ImplausiblePosition, ThatIsWrongOnceStopsThemAsWell) {
  start();
  set(liar(), "POSITION_ERROR", -kLeap);
  step();
  set(liar(), "POSITION_ERROR", 0.0);
  run_until(MotionPhase::kIdle, seconds{2});
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kPositionLeap);
}

TEST_P(ImplausiblePosition, ThatStandsWhileTheAxisIsSentOnStopsThem) {
  start();
  set(liar(), "POSITION_HELD", 1.0);
  const auto before = drives.clock.now();
  run_until(MotionPhase::kStopping, milliseconds{60});
  EXPECT_GE(drives.clock.now() - before, milliseconds{49});
  run_until(MotionPhase::kIdle, seconds{2});
  const auto failure = operation.motion().failure();
  EXPECT_EQ(failure.cause, MotionFailure::Cause::kPositionFrozen);
  EXPECT_EQ(failure.axis, 1);
  EXPECT_GE(failure.position.within_s, 0.05);
  EXPECT_GT(std::abs(failure.position.moved), 0.05);
  EXPECT_LE(fastest_rad_s, 1.1 * 50.0) << "the limit of the axis";
}

TEST_P(ImplausiblePosition, ThatStandsWhereTheAxisIsHeldIsTrue) {
  ASSERT_EQ(sentence(operation.to_motion()), "");
  ASSERT_TRUE(operation.run_until(MotionPhase::kHolding, seconds{2}));
  operation.run(milliseconds{100});
  set(liar(), "POSITION_HELD", 1.0);
  operation.run(seconds{1});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kHolding);
}

TEST_P(ImplausiblePosition, IsNotThePlaceWhereAnAxisIsEnabled) {
  ASSERT_EQ(sentence(operation.to_op()), "");
  operation.run(milliseconds{20});
  const double place = liar().position_rad();
  operation.motion().request_start();
  // Wrong during the transition to Operation enabled, and correct again before the axis gets there.
  for (int i = 0; i < 1000 && operation.motion().axes()[1].inputs().state != AxisState::kReadyToSwitchOn; ++i) {
    operation.cycle();
  }
  ASSERT_EQ(operation.motion().axes()[1].inputs().state, AxisState::kReadyToSwitchOn);
  set(liar(), "POSITION_ERROR", kLeap);
  operation.run(milliseconds{1});
  ASSERT_FALSE(operation.motion().axes()[1].enabled());
  set(liar(), "POSITION_ERROR", 0.0);
  while (operation.motion().phase() == MotionPhase::kEnabling) {
    operation.cycle();
    ASSERT_NEAR(liar().position_rad(), place, 1e-3);
    ASSERT_NEAR(operation.motion().setpoints()[1].position, place, 1e-3);
  }
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kApproach);
}

TEST_P(ImplausiblePosition, KeepsAnAxisFromBeingEnabledAsLongAsItLeaps) {
  ASSERT_EQ(sentence(operation.to_op()), "");
  operation.motion().request_start();
  const auto end = drives.clock.now() + seconds{3};
  bool there = false;
  while (operation.motion().phase() != MotionPhase::kQuickStop && drives.clock.now() < end) {
    set(liar(), "POSITION_ERROR", there ? 0.0 : kLeap);
    there = !there;
    operation.run(milliseconds{2});
    ASSERT_NE(operation.motion().axes()[1].inputs().state, AxisState::kOperationEnabled);
  }
  const auto failure = operation.motion().failure();
  EXPECT_EQ(failure.cause, MotionFailure::Cause::kPositionUnsteady);
  EXPECT_EQ(failure.axis, 1);
  EXPECT_NEAR(std::abs(failure.position.moved), kLeap / kIncrementsPerRad, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Modes, ImplausiblePosition,
                         testing::Values(Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque),
                         [](const auto& row) { return std::string(to_text(row.param)); });

class PlausiblePosition : public testing::TestWithParam<Mode> {};

TEST_P(PlausiblePosition, GoesOnWhereTheThirtyTwoBitsEnd) {
  constexpr double kEnd = 2147483648.0 / kIncrementsPerRad;
  for (const double side : {1.0, -1.0}) {
    DriveLine drives(1, {}, {}, std::nullopt, slaves::msd::Variant::kMsd, side * (kEnd - 0.5));
    LineOperation operation(drives, RunOptions{.mode = GetParam(), .relative = true, .amplitude_rad = side});
    const double begin = drives.drive(0).position_rad();
    follow_path(operation);
    double farthest = 0.0;
    double fastest = 0.0;
    while (operation.motion().phase() == MotionPhase::kFollowing) {
      operation.cycle();
      farthest = std::max(farthest, side * (drives.drive(0).position_rad() - begin));
      fastest = std::max(fastest, std::abs(drives.drive(0).velocity_rad_s()));
    }
    EXPECT_EQ(operation.motion().phase(), MotionPhase::kHolding) << to_text(operation.motion().phase());
    EXPECT_NEAR(farthest, 1.0, 0.05) << "half of it beyond the end";
    EXPECT_LT(fastest, 10.0);
    EXPECT_LT(std::abs(operation.axis_samples.back().following_error), 0.06);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, PlausiblePosition,
                         testing::Values(Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque),
                         [](const auto& row) { return std::string(to_text(row.param)); });

/// New units take effect at the next start of the control (MSD manual 10.3): the position jumps during the transition
/// to Operation enabled, but the shaft does not move.
TEST(PlausibleFactors, MakeANewPlaceToBeEnabledAt) {
  DriveLine drives(2);
  IdleOperation operation(drives, RunOptions{.relative = true});
  operation.run(milliseconds{20});
  const double before = operation.motion().axes()[1].inputs().position;
  const double shaft = drives.drive(1).position_rad();
  ecat_master::CoeClient coe(*operation.master().mailbox(1));
  ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6092, 1, 10'485'760)), "");
  operation.motion().request_start();
  operation.cycle();
  double farthest = 0.0;
  while (operation.motion().phase() == MotionPhase::kEnabling) {
    operation.cycle();
    farthest = std::max(farthest, std::abs(drives.drive(1).position_rad() - shaft));
  }
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kApproach) << to_text(operation.motion().phase());
  EXPECT_GT(std::abs(operation.motion().axes()[1].inputs().position - before), 1.0) << "as good as a leap";
  operation.run(milliseconds{1});
  EXPECT_LT(std::max(farthest, std::abs(drives.drive(1).position_rad() - shaft)), 5e-3);
  EXPECT_TRUE(operation.run_until(MotionPhase::kHolding, seconds{3}));
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone);
}

}  // namespace
}  // namespace driveline::bus_test
