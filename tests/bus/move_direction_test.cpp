// Positions of axes with a modulo: the direction selected by MC_Direction.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MoveDirection;

constexpr double kModulo = 6.283185307179586;
constexpr double kHair = 1e-9;

RunOptions round_options() {
  auto options = single_options();
  options.modulo = kModulo;
  return options;
}

AxisRequest place(double target, MoveDirection direction) {
  auto asked = move(target, 40.0);
  asked.direction = direction;
  return asked;
}

double within(double position) {
  const double rest = std::fmod(position, kModulo);
  return rest < 0.0 ? rest + kModulo : rest;
}

class RoundLine : public SingleLine {
 public:
  RoundLine() : SingleLine(1, round_options()) {
    enable();
    EXPECT_EQ(ask(move(0.0, 40.0)).phase, RequestPhase::kDone);
  }
  /// Returns the travelled distance.
  double way(double target, MoveDirection direction) {
    const double from = setpoint();
    EXPECT_EQ(ask(place(target, direction)).phase, RequestPhase::kDone);
    EXPECT_NEAR(std::remainder(setpoint() - target, kModulo), 0.0, kHair);
    return setpoint() - from;
  }
};

TEST(MoveDirection, LeadsFromAStandstillTheWayThatItSays) {
  RoundLine line;
  EXPECT_NEAR(line.way(1.0, MoveDirection::kShortest), 1.0, kHair);
  EXPECT_NEAR(line.way(6.0, MoveDirection::kShortest), 5.0 - kModulo, kHair);
  EXPECT_NEAR(line.way(1.0, MoveDirection::kNegative), -5.0, kHair);
  EXPECT_NEAR(line.way(0.5, MoveDirection::kPositive), kModulo - 0.5, kHair);
  EXPECT_NEAR(line.way(0.5, MoveDirection::kPositive), 0.0, kHair) << "it is there";
  EXPECT_NEAR(line.way(0.5, MoveDirection::kNegative), 0.0, kHair);
  EXPECT_NEAR(line.way(0.5 + 3.0 * kModulo, MoveDirection::kShortest), 0.0, kHair) << "the same name";
  ASSERT_EQ(line.finish(line.submit(move(50.0, 40.0)), 20'000).phase, RequestPhase::kDone)
      << "without a direction: the position itself";
  EXPECT_NEAR(line.setpoint(), 50.0, kHair);
  EXPECT_NEAR(line.way(0.0, MoveDirection::kNegative), -within(50.0), kHair);
  line.expect_obedience();
}

TEST(MoveDirection, CountsFromTheNameThatThePlaceHasBeenGiven) {
  RoundLine line;
  ASSERT_EQ(line.ask(request(AxisCommand::kSetPosition, 2.0)).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.axes().axis_report(0).setpoint, 2.0, kHair);
  EXPECT_EQ(line.ask(place(1.5, MoveDirection::kPositive)).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.axes().axis_report(0).setpoint, 1.5 + kModulo, kHair);
}

/// From any velocity, to any position, with any deceleration: it does not reverse, unless it already moves the other
/// way.
TEST(MoveDirection, OfAnAxisThatMovesIsKeptWithoutTurningRound) {
  std::mt19937 random(5);
  const auto number = [&random](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  RoundLine line;
  for (int run = 0; run < 60; ++run) {
    SCOPED_TRACE(run);
    const double velocity = number(5.0, 45.0);
    line.submit(request(AxisCommand::kMoveVelocity, velocity));
    line.cycles(300 + static_cast<int>(number(0.0, 400.0)));
    const double from = line.setpoint();
    auto asked = place(number(0.0, kModulo), run % 3 == 0 ? MoveDirection::kNegative : MoveDirection::kPositive);
    asked.deceleration_si = number(200.0, 1000.0);
    if (run % 2 == 0) asked.jerk_si = number(1e4, 1e6);
    const auto id = line.submit(asked);
    double highest = from;
    double last = from;
    double back = 0.0;
    for (int i = 0; i < 40'000 && !line.axes().report(id).over(); ++i) {
      line.cycle();
      back = std::max(back, last - line.setpoint());
      last = line.setpoint();
      highest = std::max(highest, last);
    }
    ASSERT_EQ(line.phase(id), RequestPhase::kDone);
    EXPECT_NEAR(std::remainder(last - asked.target_si, kModulo), 0.0, kHair);
    if (asked.direction == MoveDirection::kPositive) {
      EXPECT_LT(back, kHair) << "it never goes back";
    } else {
      EXPECT_LE(last, highest + kHair);
      EXPECT_GT(last, highest - kModulo - 0.1) << "not a turn more than it needs";
    }
  }
  line.expect_obedience();
}

TEST(MoveDirection, OfMotionsThatWaitCountsFromTheEndOfTheOneBefore) {
  for (const auto buffer : {BufferMode::kBuffered, BufferMode::kBlendingPrevious}) {
    RoundLine line;
    double last = line.setpoint();
    double back = 0.0;
    std::uint64_t id = 0;
    for (const double target : {1.5, 3.0, 4.5, 0.0, 1.0}) {
      auto asked = place(target, MoveDirection::kPositive);
      asked.buffer = buffer;
      id = line.submit(asked);
    }
    for (int i = 0; i < 40'000 && !line.axes().report(id).over(); ++i) {
      line.cycle();
      back = std::max(back, last - line.setpoint());
      last = line.setpoint();
    }
    EXPECT_EQ(line.phase(id), RequestPhase::kDone);
    EXPECT_NEAR(last, kModulo + 1.0, kHair);
    EXPECT_LT(back, kHair);
  }
}

TEST(MoveDirection, IsRefusedWhereItMeansNothing) {
  RoundLine line;
  auto relative = request(AxisCommand::kMoveRelative, 1.0);
  relative.direction = MoveDirection::kPositive;
  EXPECT_EQ(line.ask(relative).error, AxisError::kDirection);
  Enabled<SingleLine> straight;
  EXPECT_EQ(straight.ask(place(1.0, MoveDirection::kShortest)).error, AxisError::kDirection) << "no modulo";
}

}  // namespace
}  // namespace driveline::bus_test
