// MC_MoveSuperimposed and MC_HaltSuperimposed on endless motions, and the demands of the drives meanwhile.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "driveline/motion/single_axis/couplings.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::Couplings;

constexpr double kCyclePeriodS = 125e-6;

AxisRequest on_top(double way, double velocity = 0.0) {
  return request(AxisCommand::kMoveSuperimposed, way, velocity);
}

/// An axis moving at constant velocity.
class RunningLine : public SingleLine {
 public:
  explicit RunningLine(double velocity, const RunOptions& options = single_options()) : SingleLine(1, options) {
    enable();
    running = submit(request(AxisCommand::kMoveVelocity, velocity));
    cycles(2000);
  }
  /// Its setpoint after `passed` cycles without a superimposed motion.
  [[nodiscard]] double without(double from, int passed, double velocity) const {
    return from + velocity * kCyclePeriodS * passed;
  }
  std::uint64_t running = 0;
};

TEST(Superimposed, OnAVelocityItAddsItsWayAndNothingElse) {
  RunningLine line(20.0);
  for (const double way : {2.0, -3.0}) {
    const double from = line.setpoint();
    const auto id = line.submit(on_top(way, 10.0));
    int passed = 0;
    double fastest = 20.0;
    double slowest = 20.0;
    double before = from;
    while (!line.axes().report(id).over() && passed < 8000) {
      line.cycle();
      ++passed;
      fastest = std::max(fastest, (line.setpoint() - before) / kCyclePeriodS);
      slowest = std::min(slowest, (line.setpoint() - before) / kCyclePeriodS);
      before = line.setpoint();
    }
    EXPECT_EQ(line.phase(id), RequestPhase::kDone);
    EXPECT_NEAR(way > 0.0 ? fastest : slowest, way > 0.0 ? 30.0 : 10.0, 0.1);
    EXPECT_NEAR(line.setpoint(), line.without(from, passed, 20.0) + way, 1e-9);
    line.cycles(100);
    EXPECT_NEAR(line.setpoint(), line.without(from, passed + 100, 20.0) + way, 1e-9);
    EXPECT_EQ(line.phase(line.running), RequestPhase::kReached) << "it is in velocity all the time";
    EXPECT_EQ(line.state(), PlcopenState::kContinuousMotion);
  }
  line.expect_obedience();
}

TEST(Superimposed, HasWhatTheVelocityLeavesAndNoMore) {
  RunningLine line(45.0);
  EXPECT_EQ(line.ask(on_top(1.0, 6.0)).error, AxisError::kOverLimit);
  const double from = line.setpoint();
  const auto id = line.submit(on_top(1.0));
  int passed = 0;
  while (!line.axes().report(id).over() && passed < 8000) {
    line.cycle();
    ++passed;
  }
  EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), line.without(from, passed, 45.0) + 1.0, 1e-9);
  line.submit(request(AxisCommand::kMoveVelocity, 50.0));
  line.cycles(400);
  EXPECT_EQ(line.ask(on_top(1.0)).error, AxisError::kOverLimit) << "there is nothing left";
  line.expect_obedience();
}

TEST(Superimposed, KeepsItsShareOfTheLimitWhenTheVelocityIsRaised) {
  RunningLine line(50.0);
  line.ask(request(AxisCommand::kSetOverride, 0.5));
  line.cycles(400);
  const auto id = line.submit(on_top(10.0, 25.0));
  line.cycles(400);
  line.ask(request(AxisCommand::kSetOverride, 1.0));
  double fastest = 0.0;
  double before = line.setpoint();
  for (int i = 0; i < 8000 && !line.axes().report(id).over(); ++i) {
    line.cycle();
    fastest = std::max(fastest, (line.setpoint() - before) / kCyclePeriodS);
    before = line.setpoint();
    ASSERT_LE(fastest, 50.0 * (1.0 + 1e-9));
  }
  EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  EXPECT_GT(fastest, 49.9);
  line.cycles(400);
  EXPECT_EQ(line.phase(line.running), RequestPhase::kReached);
  before = line.setpoint();
  line.cycle();
  EXPECT_NEAR((line.setpoint() - before) / kCyclePeriodS, 50.0, 1e-6);
  line.expect_obedience();
}

/// The underlying motion is replanned from the position of the axis without the superimposed part.
TEST(Superimposed, GoesOnThroughAChangeOfModeBehindAGap) {
  for (const int after : {1, 2, 4}) {
    SCOPED_TRACE(after);
    RunningLine line(20.0);
    const double from = line.setpoint();
    int passed = 600 + 3 + after - 1;
    const auto id = line.submit(on_top(-8.0, 12.0));
    line.cycles(600);
    lose_outputs(line, 3);
    line.cycles(after - 1);
    auto change = request(AxisCommand::kSetMode);
    change.mode = static_cast<std::int8_t>(motion::cia402::Mode::kCyclicVelocity);
    const auto changed = line.submit(change);
    for (int i = 0; i < 8000 && !line.axes().report(id).over(); ++i, ++passed) line.cycle();
    EXPECT_EQ(line.phase(changed), RequestPhase::kDone);
    EXPECT_EQ(line.phase(id), RequestPhase::kDone);
    // Except for the cycles in which the motion has waited.
    EXPECT_NEAR(line.setpoint(), line.without(from, passed, 20.0) - 8.0, 0.05);
    line.expect_obedience();
  }
}

/// The superimposed motion must wait for the underlying one to slow down.
TEST(Superimposed, OnAVelocityThatSlowsDownTheSumKeepsTheLimits) {
  for (const bool lost : {false, true}) {
    RunningLine line(48.0);
    auto slower = request(AxisCommand::kMoveVelocity, 10.0);
    slower.acceleration_si = 100.0;
    line.submit(slower);
    const auto id = line.submit(on_top(8.0));
    line.cycles(300);
    line.lose_out = line.lose_back = lost;
    line.cycles(2);
    line.lose_out = line.lose_back = false;
    EXPECT_EQ(line.finish(id, 16'000).phase, RequestPhase::kDone);
    line.expect_obedience();
  }
}

TEST(Superimposed, IsHaltedAloneAndTheMotionGoesOn) {
  RunningLine line(20.0);
  EXPECT_EQ(line.ask(request(AxisCommand::kHaltSuperimposed)).error, AxisError::kNothingToDo);
  const double from = line.setpoint();
  const auto id = line.submit(on_top(20.0, 5.0));
  line.cycles(1600);
  EXPECT_EQ(line.phase(id), RequestPhase::kActive);
  const auto halt = line.submit(request(AxisCommand::kHaltSuperimposed));
  line.cycles(400);
  EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(halt), RequestPhase::kDone);
  const double gone = line.setpoint() - line.without(from, 2000, 20.0);
  EXPECT_GT(gone, 0.8);
  EXPECT_LT(gone, 1.1);
  line.cycles(400);
  EXPECT_NEAR(line.setpoint() - line.without(from, 2400, 20.0), gone, 1e-9);
  line.expect_obedience();
}

TEST(Superimposed, AnotherMotionBeginsWithTheSum) {
  for (const bool halted : {true, false}) {
    RunningLine line(20.0);
    const auto id = line.submit(on_top(20.0, 15.0));
    line.cycles(1000);
    const auto next = line.submit(halted ? request(AxisCommand::kHalt) : move(60.0));
    EXPECT_EQ(line.finish(next, 20'000).phase, RequestPhase::kDone);
    EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
    line.expect_obedience();
  }
}

TEST(Superimposed, OnASynchronisedMotionItStaysBesideItsMaster) {
  SingleLine line(2);
  Couplings couplings(line.axes(), std::vector<Couplings::Pair>{{1, 0}}, kSinglePeriod);
  line.enable(0);
  line.enable(1);
  const auto ratio = trajectory::GearRatio::make(1, 2).value();
  const auto law = trajectory::CouplingLaw::gear(ratio, line.setpoint(0), line.setpoint(1));
  ASSERT_NE(couplings.engage(1, law, trajectory::CatchUp::kPosition), 0U);
  line.submit(request(AxisCommand::kMoveVelocity, 30.0), 0);
  line.cycles(2000);
  const auto beside = [&] { return line.setpoint(1) - law.at(line.setpoint(0)).position; };
  EXPECT_NEAR(beside(), 0.0, 1e-10);
  EXPECT_EQ(line.ask(on_top(0.75, 4.0), 1).phase, RequestPhase::kDone);
  EXPECT_NEAR(beside(), 0.75, 1e-9);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  line.submit(request(AxisCommand::kMoveVelocity, -10.0), 0);
  line.cycles(2000);
  EXPECT_NEAR(beside(), 0.75, 1e-9) << "whatever the master does";
  const auto back = line.submit(on_top(-5.0, 4.0), 1);
  line.cycles(800);
  EXPECT_EQ(line.ask(request(AxisCommand::kHaltSuperimposed), 1).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(back), RequestPhase::kAborted);
  const double stays = beside();
  EXPECT_LT(stays, 0.6);
  EXPECT_GT(stays, 0.2);
  line.cycles(400);
  EXPECT_NEAR(beside(), stays, 1e-9);
  line.expect_obedience();
}

TEST(Superimposed, KeepsTheSoftwareLimits) {
  auto options = single_options();
  options.software_limits = trajectory::PositionRange{-1.0, 30.0};
  Enabled<SingleLine> line(1, options);
  line.submit(request(AxisCommand::kMoveVelocity, 10.0));
  line.cycles(800);
  const auto id = line.submit(on_top(40.0, 20.0));
  line.cycles(8000);
  EXPECT_TRUE(line.axes().report(id).over());
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_LE(line.setpoint(), 30.0);
  line.expect_obedience();
}

TEST(Superimposed, NoOrderOfEventsBreaksALimit) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto any = [&random](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
    RunningLine line(any(-40, 40));
    for (int event = 0; event < 60; ++event) {
      switch (any(0, 7)) {
        case 0:
          line.submit(request(AxisCommand::kMoveVelocity, any(-50, 50)));
          break;
        case 1:
        case 2:
          line.submit(on_top(0.1 * any(-30, 30), any(0, 1) == 0 ? 0.0 : any(1, 20)));
          break;
        case 3:
          line.submit(request(AxisCommand::kHaltSuperimposed));
          break;
        case 4:
          line.submit(request(AxisCommand::kSetOverride, 0.1 * any(0, 15)));
          break;
        case 5:
          lose_outputs(line, any(1, 3));
          break;
        case 6:
          line.submit(any(0, 1) == 0 ? request(AxisCommand::kHalt) : move(0.1 * any(-300, 300)));
          break;
        default:
          line.stall(any(1, 5));
          break;
      }
      line.cycles(any(1, 250));
      ASSERT_NE(line.state(), PlcopenState::kErrorStop);
    }
    line.expect_obedience();
  }
}

}  // namespace
}  // namespace driveline::bus_test
