// Requests with numbers that no motion can reach: refused, and the motion under way continues.
#include <gmock/gmock.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

/// In 100000 s an axis with 50 rad/s covers 5e6 rad.
constexpr double kTooLongWay = 6e6;
/// 2^42 increments are 2.64e7 rad of an axis with 2^20 increments per revolution.
constexpr double kBeyondNumbers = 3e7;
constexpr double kTiny = 1e-300;

struct Impossible {
  std::string name;
  AxisRequest asked;
  AxisError error = AxisError::kTooLong;
};

AxisRequest with(AxisRequest asked, double AxisRequest::*value, double number) {
  asked.*value = number;
  return asked;
}

std::vector<Impossible> impossible() {
  const auto run = request(AxisCommand::kMoveVelocity, 7.0);
  const auto by = request(AxisCommand::kMoveRelative, -2.0);
  return {
      {"a far position", move(kTooLongWay)},
      {"a far position, backwards", move(-kTooLongWay)},
      {"a long distance", request(AxisCommand::kMoveRelative, kTooLongWay)},
      {"an added distance", request(AxisCommand::kMoveAdditive, kTooLongWay)},
      {"a low velocity", move(90.0, 1e-4)},
      {"a tiny velocity", move(90.0, kTiny)},
      {"a tiny acceleration", with(by, &AxisRequest::acceleration_si, kTiny)},
      {"a tiny deceleration", with(by, &AxisRequest::deceleration_si, kTiny)},
      {"a tiny jerk", with(by, &AxisRequest::jerk_si, kTiny)},
      {"a velocity with a tiny acceleration", with(run, &AxisRequest::acceleration_si, kTiny)},
      {"a velocity with a tiny jerk", with(run, &AxisRequest::jerk_si, kTiny)},
      {"a halt with a tiny deceleration", with(request(AxisCommand::kHalt), &AxisRequest::deceleration_si, kTiny)},
      {"a position beyond the numbers", move(kBeyondNumbers), AxisError::kTooFar},
      {"a distance beyond the numbers", request(AxisCommand::kMoveRelative, -1e300), AxisError::kTooFar},
      {"a name beyond the numbers", request(AxisCommand::kSetPosition, 1e300), AxisError::kTooFar},
  };
}

/// An axis that jogs at 4 rad/s.
class JoggingLine : public SingleLine {
 public:
  explicit JoggingLine(const RunOptions& options = single_options()) : SingleLine(1, options) {
    enable();
    jog_ = submit(request(AxisCommand::kMoveVelocity, 4.0));
    cycles(1000);
    EXPECT_EQ(phase(jog_), RequestPhase::kReached);
  }
  void expect_jog() {
    EXPECT_EQ(phase(jog_), RequestPhase::kReached);
    EXPECT_EQ(state(), PlcopenState::kContinuousMotion);
    const double before = setpoint();
    cycles(8);
    EXPECT_NEAR(setpoint() - before, 4.0 * 0.001, 1e-9);
    expect_obedience();
  }

 private:
  std::uint64_t jog_ = 0;
};

TEST(OutOfReach, ARefusedRequestLeavesTheMotionUnderWay) {
  for (const auto& row : impossible()) {
    SCOPED_TRACE(row.name);
    JoggingLine line;
    const auto report = line.ask(row.asked);
    EXPECT_EQ(report.phase, RequestPhase::kError);
    EXPECT_EQ(report.error, row.error) << to_text(report.error);
    line.expect_jog();
  }
}

TEST(OutOfReach, AnAxisAtRestStaysReady) {
  for (const auto& row : impossible()) {
    SCOPED_TRACE(row.name);
    Enabled<SingleLine> line;
    const double from = line.setpoint();
    const bool halts = row.asked.command == AxisCommand::kHalt;  // nothing is left to brake
    EXPECT_EQ(line.ask(row.asked).error, halts ? AxisError::kNone : row.error);
    EXPECT_EQ(line.state(), PlcopenState::kStandstill);
    EXPECT_EQ(line.setpoint(), from);
    EXPECT_EQ(line.ask(move(from + 0.5, 20.0)).phase, RequestPhase::kDone);
  }
}

TEST(OutOfReach, AWaitingMotionEndsInItsTurnAndTheAxisStands) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  const auto first = line.submit(move(from + 3.0, 20.0));
  const auto second = line.submit(move(kTooLongWay, 20.0, BufferMode::kBuffered));
  EXPECT_EQ(line.finish(first).phase, RequestPhase::kDone);
  EXPECT_EQ(line.finish(second).error, AxisError::kTooLong);
  line.cycles(100);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_NEAR(line.setpoint(), from + 3.0, 1e-9);
}

TEST(OutOfReach, AnOverrideThatMakesTheMotionTooLongIsRefused) {
  for (const bool runs : {false, true}) {
    SCOPED_TRACE(runs);
    auto options = single_options();
    options.software_limits = trajectory::PositionRange{-900.0, 900.0};
    Enabled<SingleLine> line(1, options);
    const auto moving = line.submit(runs ? request(AxisCommand::kMoveVelocity, 20.0) : move(800.0, 20.0));
    line.cycles(1000);
    EXPECT_EQ(line.ask(request(AxisCommand::kSetOverride, 1e-6)).error, AxisError::kTooLong);
    EXPECT_EQ(line.axes().axis_report(0).override_factor, 1.0);
    EXPECT_FALSE(line.axes().report(moving).over());
    EXPECT_EQ(line.ask(request(AxisCommand::kSetOverride, 0.5)).phase, RequestPhase::kDone);
    line.cycles(1000);
    const double before = line.setpoint();
    line.cycles(8);
    EXPECT_NEAR(line.setpoint() - before, 10.0 * 0.001, 1e-9);
    EXPECT_EQ(line.ask(request(AxisCommand::kSetOverride, 0.0)).phase, RequestPhase::kDone) << "holds the axis";
    line.expect_obedience();
  }
}

TEST(OutOfReach, ASuperimposedDistanceLeavesTheMotionBelow) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  const auto below = line.submit(move(from + 8.0, 20.0));
  line.cycles(1000);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveSuperimposed, kTooLongWay)).error, AxisError::kTooLong);
  EXPECT_EQ(line.finish(below).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 8.0, 1e-9);
  JoggingLine jogging;
  EXPECT_EQ(jogging.ask(request(AxisCommand::kMoveSuperimposed, kTooLongWay)).error, AxisError::kTooLong);
  jogging.expect_jog();
}

TEST(OutOfReach, AMoveHeldByAnOverrideOfZeroIsAcceptedInsideTheSoftwareLimits) {
  auto options = single_options();
  options.software_limits = trajectory::PositionRange{-5.0, 9.0};
  Enabled<SingleLine> line(1, options);
  const double from = line.setpoint();
  ASSERT_EQ(line.ask(request(AxisCommand::kSetOverride, 0.0)).phase, RequestPhase::kDone);
  const auto held = line.submit(move(from + 2.0, 20.0));
  line.cycles(400);
  EXPECT_EQ(line.phase(held), RequestPhase::kActive) << to_text(line.axes().report(held).error);
  EXPECT_EQ(line.setpoint(), from);
  ASSERT_EQ(line.ask(request(AxisCommand::kSetOverride, 0.5)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.finish(held).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 2.0, 1e-9);
}

}  // namespace
}  // namespace driveline::bus_test
