// The following error is computed by the master, in every mode and with any process data; the drive's own value is
// recorded beside it.
#include <gmock/gmock.h>

#include <cmath>

#include "drive_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionPhase;
using motion::cia402::Mode;
using snapshot::AxisSample;

/// A path fast enough to reveal a wrong pairing of setpoint and position: 8 rad/s.
constexpr double kAmplitudeRad = 1.0;
/// Setpoints are rounded to increments, and so are positions and the drive's own value.
constexpr double kIncrementRad = 2.0 * 3.14159265 / 1048576.0;

/// Samples of all axes while they were on the path.
std::vector<AxisSample> samples_on_the_path(LineOperation& operation) {
  follow_path(operation);
  operation.axis_samples.clear();
  EXPECT_TRUE(operation.run_until(MotionPhase::kHolding, std::chrono::seconds{2}));
  return operation.axis_samples;
}

double largest(const std::vector<AxisSample>& samples, double AxisSample::*figure) {
  double maximum = 0.0;
  for (const auto& sample : samples) maximum = std::max(maximum, std::abs(sample.*figure));
  return maximum;
}

struct Exchange {
  nanoseconds period;
  std::uint32_t divider;
  double delay_cycles;
};

class FollowingErrorInCsp : public testing::TestWithParam<Exchange> {};

TEST_P(FollowingErrorInCsp, IsThatOfTheDrive) {
  const auto& exchange = GetParam();
  DriveLine drives(3);
  RunOptions options;
  options.period = exchange.period;
  options.amplitude_rad = kAmplitudeRad;
  options.layout.groups = {{exchange.divider, 0, 0}};
  options.setpoint_delay_cycles = exchange.delay_cycles;
  LineOperation operation(drives, options);
  const auto samples = samples_on_the_path(operation);
  ASSERT_GT(samples.size(), 300U);
  EXPECT_GT(largest(samples, &AxisSample::drive_following_error), 10 * kIncrementRad) << "there is something to see";
  double difference = 0.0;
  for (const auto& sample : samples) {
    difference = std::max(difference, std::abs(sample.following_error - sample.drive_following_error));
  }
  EXPECT_LT(difference, 3 * kIncrementRad);
}

INSTANTIATE_TEST_SUITE_P(Exchanges, FollowingErrorInCsp,
                         testing::Values(Exchange{microseconds{125}, 1, 3.0}, Exchange{milliseconds{1}, 1, 3.0},
                                         Exchange{microseconds{500}, 2, 5.0}),
                         [](const auto& row) {
                           return std::to_string(row.param.period.count() / 1000) + "usBy" +
                                  std::to_string(row.param.divider);
                         });

TEST(FollowingError, IsKnownWithoutTheObjectOfTheDrive) {
  RunOptions options;
  options.pdos = motion::PdoConfiguration{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}}},
                                          {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}}}};
  DriveLine with(1);
  DriveLine without(1);
  LineOperation reported(with, RunOptions{});
  LineOperation computed(without, options);
  const auto samples = samples_on_the_path(computed);
  for (const auto& sample : samples) ASSERT_TRUE(std::isnan(sample.drive_following_error));
  const double told = largest(samples_on_the_path(reported), &AxisSample::drive_following_error);
  EXPECT_NEAR(largest(samples, &AxisSample::following_error), told, 0.1 * told);
}

/// The thread wakes up late within its period, so the position is nearly a period younger than usual.
TEST(FollowingError, OfALateFrameIsThatOfTheInstantOfItsPosition) {
  constexpr auto kPeriod = milliseconds{1};
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity}) {
    DriveLine drives(1);
    FollowingOperation operation(drives, RunOptions{.period = kPeriod, .mode = mode, .amplitude_rad = kAmplitudeRad});
    operation.run(milliseconds{100});
    operation.cycle();
    const auto on_time = operation.axis_samples.back();
    const auto now = drives.clock.now();
    drives.leave_alone(now / kPeriod * kPeriod + kPeriod + microseconds{800} - now);
    operation.cycle();
    const auto late = operation.axis_samples.back();
    EXPECT_EQ(operation.statistics().missed_periods, 0U);
    EXPECT_EQ(late.cycle, on_time.cycle + 1);
    const double way = late.actual_position - on_time.actual_position;
    EXPECT_GT(way, 10e-3) << to_text(mode) << ": there is something to see, 7.8 mrad per period";
    EXPECT_NEAR(late.following_error, on_time.following_error, 1e-3) << to_text(mode);
  }
}

class FollowingErrorOfTheLoop : public testing::TestWithParam<Mode> {};

TEST_P(FollowingErrorOfTheLoop, IsSetpointMinusActualPosition) {
  DriveLine drives(2);
  LineOperation operation(drives, RunOptions{.mode = GetParam()});
  const auto samples = samples_on_the_path(operation);
  EXPECT_EQ(largest(samples, &AxisSample::drive_following_error), 0.0) << "it has no position loop";
  EXPECT_GT(largest(samples, &AxisSample::following_error), 10 * kIncrementRad);
  for (const auto& sample : samples) {
    ASSERT_NEAR(sample.following_error, sample.target_position - sample.actual_position, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, FollowingErrorOfTheLoop, testing::Values(Mode::kCyclicVelocity, Mode::kCyclicTorque),
                         [](const auto& row) { return std::string(to_text(row.param)); });

TEST(FollowingError, OfAnAxisThatIsHeldGrowsWithItsPath) {
  for (const auto mode : {Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    DriveLine drives(1);
    FollowingOperation operation(drives, RunOptions{.mode = mode});
    auto& drive = drives.drive(0);
    const auto blocked = drive.signals().find_signal(slaves::SignalId::Direction::kInput, "AXIS_BLOCKED");
    ASSERT_TRUE(blocked);
    operation.run(milliseconds{100});
    drive.signals().set_signal(blocked->number, 1.0);
    operation.axis_samples.clear();
    operation.run(milliseconds{40});
    const auto& last = operation.axis_samples.back();
    EXPECT_NEAR(last.following_error, last.target_position - last.actual_position, 1e-9);
    EXPECT_GT(std::abs(last.following_error), 0.1) << to_text(mode);
  }
}

}  // namespace
}  // namespace driveline::bus_test
