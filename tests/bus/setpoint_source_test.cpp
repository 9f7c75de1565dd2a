// Setpoints from another source than a path: accepted at standstill during the cycle, and only within the limits.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "drive_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionFailure;
using motion::MotionPhase;
using motion::SetpointCycle;
using motion::SetpointSource;
using motion::SourceRefusal;
using motion::cia402::Mode;
using trajectory::AxisSetpoint;
using Setpoints = std::span<AxisSetpoint>;

constexpr double kPeriodSeconds = 125e-6;

/// Base of the tests' sources: they start at the positions of the axes, and have no time limit.
class TestSource : public SetpointSource {
 public:
  explicit TestSource(std::size_t axes) : begin_(axes) {}
  [[nodiscard]] std::size_t axis_count() const noexcept override { return begin_.size(); }
  void rewind(Setpoints first) noexcept override { std::copy(first.begin(), first.end(), begin_.begin()); }
  void begin(bool) noexcept override {}
  void end() noexcept override {}
  void run(bool) noexcept override {}
  void fall_behind(double) noexcept override {}
  [[nodiscard]] double behind_s() const noexcept override { return 0.0; }

 protected:
  std::vector<AxisSetpoint> begin_;
};

/// Endless raised cosines of 2 rad and two seconds, with an occasional wrong setpoint.
class Swing final : public TestSource {
 public:
  using TestSource::TestSource;
  double wrong_at_s = std::numeric_limits<double>::infinity();
  AxisSetpoint wrong{};  ///< added to the setpoint of axis 0 from then on
  int asked = 0;

  [[nodiscard]] bool next(const SetpointCycle& cycle, Setpoints setpoints) noexcept override {
    ++asked;
    const double angle = std::numbers::pi * cycle.time_s;
    for (std::size_t i = 0; i < setpoints.size(); ++i) {
      setpoints[i] = {begin_[i].position + 1.0 - std::cos(angle), std::numbers::pi * std::sin(angle),
                      std::numbers::pi * std::numbers::pi * std::cos(angle)};
    }
    if (cycle.time_s < wrong_at_s) return true;
    setpoints[0].position += wrong.position;
    setpoints[0].velocity += wrong.velocity;
    return true;
  }
};

/// A controller: springs and dampers that pull each axis to a position 1 rad from its start, by torque only.
class Spring final : public TestSource {
 public:
  using TestSource::TestSource;
  double stiffness = 0.5;     ///< Nm/rad
  double damping = 0.02;      ///< Nm s/rad
  double least_torque = 0.0;  ///< Nm, in addition

  [[nodiscard]] bool next(const SetpointCycle& cycle, Setpoints setpoints) noexcept override {
    for (std::size_t i = 0; i < setpoints.size(); ++i) {
      const auto& now = cycle.axes[i].inputs();
      const double torque =
          stiffness * (begin_[i].position + 1.0 - now.position) - damping * now.velocity + least_torque;
      setpoints[i] = {now.position, now.velocity, 0.0, torque};
    }
    return true;
  }
};

/// Largest step of the setpoints of an axis from one cycle to the next, and largest change of the step.
std::pair<double, double> largest_steps(const std::vector<snapshot::AxisSample>& samples, std::uint16_t axis) {
  std::vector<double> targets;
  for (const auto& sample : samples) {
    if (sample.axis == axis && sample.state == snapshot::AxisState::kOperationEnabled)
      targets.push_back(sample.target_position);
  }
  double step = 0.0;
  double change = 0.0;
  for (std::size_t i = 2; i < targets.size(); ++i) {
    step = std::max(step, std::abs(targets[i] - targets[i - 1]));
    change = std::max(change, std::abs(targets[i] - 2 * targets[i - 1] + targets[i - 2]));
  }
  return {step, change};
}

void expect_within_limits(const LineOperation& operation, const RunOptions& options) {
  for (std::uint16_t axis = 0; axis < 2; ++axis) {
    const auto limits = LineOperation::axis(axis, options).limits;
    const auto [step, change] = largest_steps(operation.axis_samples, axis);
    EXPECT_LE(step, 1.001 * limits.max_velocity * kPeriodSeconds) << "axis " << axis;
    EXPECT_LE(change, 1.001 * limits.max_acceleration * kPeriodSeconds * kPeriodSeconds) << "axis " << axis;
  }
}

TEST(SetpointSource, IsTakenWhileTheAxesHoldTheEndOfThePath) {
  DriveLine drives(2);
  const RunOptions options;
  LineOperation operation(drives, options);
  ASSERT_EQ(sentence(operation.to_motion()), "");
  ASSERT_TRUE(operation.run_until(MotionPhase::kHolding, std::chrono::seconds{3}));
  const auto cycles = operation.master().core()->cycles();
  Swing swing(2);
  ASSERT_TRUE(operation.motion().use(swing));
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, milliseconds{100}));
  EXPECT_EQ(&operation.motion().using_source(), &swing);
  operation.run(std::chrono::seconds{1});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kFollowing);
  EXPECT_GT(operation.master().core()->cycles(), cycles + 8000) << "the cycle has not stopped";
  EXPECT_EQ(operation.statistics().missed_periods, 0U);
  for (std::uint16_t axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(drives.drive(axis).position_rad(), operation.motion().setpoints()[axis].position, 0.01);
  }
  expect_within_limits(operation, options);
  operation.motion().request_stop();
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  expect_within_limits(operation, options);
}

TEST(SetpointSource, OfAnIdleMotionIsThatOfTheNextStart) {
  DriveLine drives(2);
  ConfiguredOperation operation(drives, RunOptions{});
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.to_op()), "");
  Swing swing(2);
  ASSERT_TRUE(operation.motion().use(swing));
  operation.run(milliseconds{10});
  EXPECT_EQ(swing.asked, 0);
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  operation.run(milliseconds{100});
  EXPECT_GT(swing.asked, 700);
}

TEST(SetpointSource, IsRefusedInMotionAndForOtherAxes) {
  DriveLine drives(2);
  LineOperation operation(drives, RunOptions{});
  ASSERT_EQ(sentence(operation.to_motion()), "");
  Swing swing(2);
  Swing three(3);
  const auto* path = &operation.motion().using_source();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  EXPECT_EQ(operation.motion().use(swing).error(), SourceRefusal::kInMotion);
  EXPECT_EQ(operation.motion().use(three).error(), SourceRefusal::kWrongAxes);
  ASSERT_TRUE(operation.run_until(MotionPhase::kHolding, std::chrono::seconds{2}));
  operation.run(milliseconds{10});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kHolding) << "what was refused does not come later";
  EXPECT_EQ(&operation.motion().using_source(), path);
  EXPECT_EQ(swing.asked, 0);
}

TEST(SetpointSource, ThatLeadsOutOfTheSoftwareLimitsIsStoppedBeforeThem) {
  DriveLine drives(2);
  RunOptions options;
  options.software_limits = trajectory::PositionRange{-1.0, 1.5};
  ConfiguredOperation operation(drives, options);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.to_op()), "");
  Swing swing(2);
  ASSERT_TRUE(operation.motion().use(swing));
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kStopping, std::chrono::seconds{3}));
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kOutsideRange);
  EXPECT_GT(operation.motion().failure().reaches, 1.5);
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  expect_within_limits(operation, options);
  double farthest = 0.0;
  for (const auto& sample : operation.axis_samples) farthest = std::max(farthest, sample.target_position);
  EXPECT_LE(farthest, 1.5);
  EXPECT_GT(farthest, 1.49) << "no sooner than it must";
}

TEST(SetpointSource, ThatBeginsOutsideTheSoftwareLimitsMovesNothing) {
  DriveLine drives(2);
  RunOptions options;
  options.software_limits = trajectory::PositionRange{1.0, 5.0};
  ConfiguredOperation operation(drives, options);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.to_op()), "");
  Swing swing(2);
  ASSERT_TRUE(operation.motion().use(swing));
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kQuickStop, std::chrono::seconds{3}));
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kOutsideRange);
  EXPECT_NEAR(operation.motion().failure().reaches, 0.0, 0.01);
  EXPECT_EQ(swing.asked, 0);
}

class WrongSetpoint : public testing::TestWithParam<AxisSetpoint> {};

TEST_P(WrongSetpoint, NeverLeavesAndStopsTheAxesWithinTheirLimits) {
  DriveLine drives(2);
  const RunOptions options;
  ConfiguredOperation operation(drives, options);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.to_op()), "");
  Swing swing(2);
  swing.wrong_at_s = 0.5;
  swing.wrong = GetParam();
  ASSERT_TRUE(operation.motion().use(swing));
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  ASSERT_TRUE(operation.run_until(MotionPhase::kStopping, std::chrono::seconds{1}));
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kSetpoint);
  EXPECT_EQ(operation.motion().failure().axis, 0);
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{2}));
  expect_within_limits(operation, options);
}

INSTANTIATE_TEST_SUITE_P(Kinds, WrongSetpoint,
                         testing::Values(AxisSetpoint{1.0, 0.0, 0.0}, AxisSetpoint{-0.2, 0.0, 0.0},
                                         AxisSetpoint{std::nan(""), 0.0, 0.0}, AxisSetpoint{0.0, 1e4, 0.0},
                                         AxisSetpoint{0.0, std::numeric_limits<double>::infinity(), 0.0}),
                         [](const auto& row) { return "Number" + std::to_string(row.index); });

TEST(SetpointSource, ThatGivesTorquesIsTheController) {
  DriveLine drives(2);
  RunOptions options;
  options.mode = Mode::kCyclicTorque;
  ConfiguredOperation operation(drives, options);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.to_op()), "");
  Spring spring(2);
  ASSERT_TRUE(operation.motion().use(spring));
  const double before = drives.drive(0).position_rad();
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  operation.run(std::chrono::seconds{2});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kFollowing);
  EXPECT_NEAR(drives.drive(0).position_rad(), before + 1.0, 0.1);
  const auto& last = operation.axis_samples.back();
  EXPECT_NEAR(last.following_error, 0.0, 1e-3) << "there is no place to follow";
  operation.motion().request_stop();
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
}

TEST(SetpointSource, ThatLetsAnAxisGetTooFastIsStopped) {
  DriveLine drives(1);
  RunOptions options;
  options.mode = Mode::kCyclicTorque;
  ConfiguredOperation operation(drives, options);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.to_op()), "");
  Spring spring(1);
  spring.stiffness = 0.0;
  spring.damping = 0.0;
  spring.least_torque = 0.3;
  ASSERT_TRUE(operation.motion().use(spring));
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  ASSERT_TRUE(operation.run_until(MotionPhase::kStopping, std::chrono::seconds{5}));
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kTooFast);
  EXPECT_TRUE(operation.run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
  EXPECT_LT(std::abs(drives.drive(0).velocity_rad_s()), 1.0);
}

}  // namespace
}  // namespace driveline::bus_test
