// Gears and cams between axes that are commanded individually, and the demands of the drives meanwhile.
#include "driveline/motion/single_axis/couplings.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::Couplings;
using trajectory::CatchUp;
using trajectory::CouplingLaw;
using trajectory::CouplingRefusal;
using trajectory::CouplingState;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kExact = 1e-10;

/// A line of axes in operation, some of which follow others.
class CoupledLine : public SingleLine {
 public:
  CoupledLine(std::size_t count, const std::vector<Couplings::Pair>& pairs)
      : SingleLine(count), couplings(axes(), pairs, kSinglePeriod) {
    for (std::size_t i = 0; i < count; ++i) enable(i);
  }

  [[nodiscard]] CouplingLaw gear(std::int64_t numerator, std::int64_t denominator, std::size_t master = 0,
                                 std::size_t slave = 1) {
    const auto ratio = trajectory::GearRatio::make(numerator, denominator).value();
    return CouplingLaw::gear(ratio, setpoint(master), setpoint(slave));
  }
  [[nodiscard]] double apart(const CouplingLaw& law, std::size_t master = 0, std::size_t slave = 1) {
    return std::abs(setpoint(slave) - law.at(setpoint(master)).position);
  }
  [[nodiscard]] CouplingState coupled(std::size_t slave = 1) const { return couplings.report(slave).state; }
  /// Runs cycles until the slave is in synchronism, or for two seconds.
  void synchronise(std::size_t slave = 1) {
    for (int i = 0; i < 16000 && coupled(slave) != CouplingState::kInSync; ++i) cycle();
    ASSERT_EQ(coupled(slave), CouplingState::kInSync);
  }
  void run_master(double velocity, double acceleration = 200.0) {
    auto asked = request(AxisCommand::kMoveVelocity, velocity);
    asked.acceleration_si = acceleration;
    ASSERT_NE(submit(asked, 0), 0U);
  }

  Couplings couplings;
};

std::string refusal_of(std::size_t count, const std::vector<Couplings::Pair>& pairs) {
  SingleLine line(count);
  try {
    const Couplings couplings(line.axes(), pairs, kSinglePeriod);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Couplings, AMovingMasterIsCaughtUpWithAndFollowedExactly) {
  CoupledLine line(2, {{1, 0}});
  const auto law = line.gear(1, 2);
  line.run_master(20.0);
  line.cycles(2000);
  const auto id = line.couplings.engage(1, law, CatchUp::kPosition);
  line.cycles(3);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  EXPECT_EQ(line.coupled(), CouplingState::kCatchingUp);
  line.synchronise();
  double worst = 0.0;
  for (const double velocity : {30.0, -10.0, 5.0}) {
    line.run_master(velocity);
    for (int i = 0; i < 2500; ++i) {
      line.cycle();
      worst = std::max(worst, line.apart(law));
    }
  }
  EXPECT_LT(worst, kExact);
  EXPECT_EQ(line.couplings.report(1).losses, 0U);
  EXPECT_EQ(line.phase(id), RequestPhase::kReached);
  // The actual positions match, too: both drives have the same delay.
  EXPECT_NEAR(line.axes().axis_report(1).position, law.at(line.axes().axis_report(0).position).position, 0.01);
  line.expect_obedience();
}

// The slave is as fast as its master, which uses its full limits; then the ratio requires more than the slave can do.
TEST(Couplings, AMasterMayAskForAllOfTheLimitsOfItsSlaveAndNoMore) {
  CoupledLine line(2, {{1, 0}});
  const auto law = line.gear(1, 1);
  ASSERT_NE(line.couplings.engage(1, law, CatchUp::kPosition), 0U);
  line.cycles(100);
  double worst = 0.0;
  for (const double velocity : {50.0, -50.0, 0.0}) {
    line.run_master(velocity, 1000.0);
    for (int i = 0; i < 1200; ++i) {
      line.cycle();
      worst = std::max(worst, line.apart(law));
    }
  }
  EXPECT_LT(worst, kExact);
  EXPECT_EQ(line.couplings.report(1).losses, 0U);
  const auto steep = line.gear(3, 2);
  ASSERT_NE(line.couplings.engage(1, steep, CatchUp::kPosition), 0U);
  line.cycles(100);
  line.run_master(45.0, 900.0);
  line.cycles(1200);
  EXPECT_GE(line.couplings.report(1).losses, 1U);
  EXPECT_EQ(line.coupled(), CouplingState::kCatchingUp);
  line.run_master(20.0);
  line.synchronise();
  line.cycles(10);
  EXPECT_LT(line.apart(steep), kExact);
  line.expect_obedience();
}

TEST(Couplings, ASlaveIsReleasedIntoItsVelocityAndToRest) {
  CoupledLine line(2, {{1, 0}});
  const auto law = line.gear(-1, 1);
  const auto coupled = line.couplings.engage(1, law, CatchUp::kPosition);
  line.run_master(12.0);
  line.cycles(3000);
  const auto released = line.couplings.disengage(1);
  line.cycles(400);
  EXPECT_EQ(line.phase(coupled), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(released), RequestPhase::kReached);
  EXPECT_EQ(line.state(1), PlcopenState::kContinuousMotion);
  EXPECT_EQ(line.coupled(), CouplingState::kIdle);
  line.run_master(3.0);
  const double from = line.setpoint(1);
  line.cycles(800);
  EXPECT_NEAR(line.setpoint(1) - from, -12.0 * 0.1, 1e-6);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt), 1).phase, RequestPhase::kDone);
  // Coupled again, then halted while in synchronism.
  ASSERT_NE(line.couplings.engage(1, law, CatchUp::kVelocity), 0U);
  line.synchronise();
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt), 1).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  // Nothing is left to be released.
  const double stands = line.setpoint(1);
  EXPECT_EQ(line.couplings.disengage(1), 0U);
  line.cycles(400);
  EXPECT_EQ(line.setpoint(1), stands);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  line.expect_obedience();
}

TEST(Couplings, WhatASlaveCouldNotTakeIsForgotten) {
  CoupledLine line(2, {{1, 0}});
  const auto limits = trajectory::ProfileLimits::symmetric(5.0, 100.0, 5000.0);
  ASSERT_EQ(line.ask(power(false), 1).phase, RequestPhase::kDone);
  for (int i = 0; i < 20; ++i) {
    const auto id = line.couplings.engage(1, line.gear(-2, 1), CatchUp::kPosition);
    ASSERT_NE(id, 0U);
    EXPECT_EQ(line.finish(id).error, AxisError::kNotEnabled);
  }
  line.enable(1);
  // A request to follow without a coupling must not reuse the refused one.
  EXPECT_EQ(line.ask(request(AxisCommand::kFollow), 1).error, AxisError::kFollowing);
  line.cycles(10);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(line.couplings.shift_phase_to(1, 0.4, limits));
  const auto law = line.gear(1, 2);
  ASSERT_NE(line.couplings.engage(1, law, CatchUp::kPosition), 0U);
  line.run_master(10.0);
  line.cycles(2000);
  EXPECT_EQ(line.coupled(), CouplingState::kInSync);
  EXPECT_LT(line.apart(law), kExact);
  EXPECT_EQ(line.couplings.report(1).phase, 0.0);
  line.expect_obedience();
}

TEST(Couplings, ARefusedCouplingLeavesTheOneThatThereIs) {
  CoupledLine line(2, {{1, 0}});
  const auto law = line.gear(1, 2);
  ASSERT_NE(line.couplings.engage(1, law, CatchUp::kPosition), 0U);
  line.run_master(8.0);
  line.cycles(2000);
  ASSERT_EQ(line.coupled(), CouplingState::kInSync);
  ASSERT_NE(line.couplings.engage_at(1, line.gear(1, 1), {.master = line.setpoint(0) + 0.5, .distance = 2.0}), 0U);
  double worst = 0.0;
  for (int i = 0; i < 800; ++i) {
    line.cycle();
    worst = std::max(worst, line.apart(law));
  }
  EXPECT_LT(worst, kExact);
  EXPECT_EQ(line.couplings.report(1).refusal, CouplingRefusal::kTooLate);
  EXPECT_EQ(line.coupled(), CouplingState::kInSync);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  line.expect_obedience();
}

TEST(Couplings, SynchronismBeginsAtThePlaceOfTheMaster) {
  CoupledLine line(2, {{1, 0}});
  const double master = line.setpoint(0);
  const double slave = line.setpoint(1);
  const auto law = CouplingLaw::gear(trajectory::GearRatio{}, master + 4.0, slave + 1.0);
  line.run_master(8.0);
  ASSERT_NE(line.couplings.engage_at(1, law, {.master = master + 4.0, .distance = 2.0}), 0U);
  double waited = 0.0;
  double synchronous = 0.0;
  for (int i = 0; i < 8000 && synchronous <= 0.0; ++i) {
    line.cycle();
    const double at = line.setpoint(0) - master;
    if (line.coupled() == CouplingState::kWaiting) waited = at;
    if (line.coupled() == CouplingState::kInSync) synchronous = at;
  }
  EXPECT_NEAR(waited, 2.0, 2e-3);
  EXPECT_NEAR(synchronous, 4.0, 2e-3);
  line.cycles(500);
  EXPECT_LT(line.apart(law), kExact);
  line.expect_obedience();
}

TEST(Couplings, WhatCannotBeEndsTheRequestWithAReason) {
  CoupledLine line(2, {{1, 0}});
  const auto law = line.gear(1, 1);
  line.run_master(8.0);
  line.cycles(800);
  const auto late = line.couplings.engage_at(1, law, {.master = line.setpoint(0) + 0.5, .distance = 2.0});
  EXPECT_EQ(line.finish(late).phase, RequestPhase::kError);
  EXPECT_EQ(line.axes().report(late).error, AxisError::kFollowing);
  EXPECT_EQ(line.couplings.report(1).refusal, CouplingRefusal::kTooLate);
  line.cycles(100);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  EXPECT_EQ(line.couplings.engage(0, law, CatchUp::kPosition), 0U) << "the master is no slave";
  EXPECT_EQ(line.couplings.disengage(0), 0U);
  EXPECT_FALSE(line.couplings.shift_phase_to(0, 1.0, trajectory::ProfileLimits::symmetric(1.0, 1.0, 1.0)));
  line.expect_obedience();
}

TEST(Couplings, ACircleOrASecondMasterIsRefusedWithASentence) {
  SingleLine line(1);
  const std::string first = "'" + line.axes().axes()[0].config().name + "'";
  EXPECT_EQ(refusal_of(1, {{0, 0}}), "couplings: axis " + first + " cannot be its own master");
  EXPECT_EQ(refusal_of(1, {{0, 7}}), "couplings: an axis that does not exist");
  EXPECT_NE(refusal_of(3, {{0, 1}, {1, 2}, {2, 0}}).find("are coupled in a circle"), std::string::npos);
  EXPECT_NE(refusal_of(3, {{0, 1}, {2, 0}, {1, 0}}).find("are coupled in a circle"), std::string::npos);
  EXPECT_NE(refusal_of(3, {{0, 1}, {0, 2}}).find("has two masters"), std::string::npos);
  EXPECT_EQ(refusal_of(3, {{2, 1}, {1, 0}}), "");
}

// Listed in reverse order: a slave whose master is a slave itself is updated after it, in the same cycle.
TEST(Couplings, AChainMovesInTheSameCycle) {
  CoupledLine line(3, {{2, 1}, {1, 0}});
  const auto first = line.gear(1, 2, 0, 1);
  const auto second = line.gear(-3, 2, 1, 2);
  ASSERT_NE(line.couplings.engage(1, first, CatchUp::kPosition), 0U);
  ASSERT_NE(line.couplings.engage(2, second, CatchUp::kPosition), 0U);
  line.cycles(10);
  line.run_master(10.0);
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    line.cycle();
    worst = std::max({worst, line.apart(first, 0, 1), line.apart(second, 1, 2)});
  }
  EXPECT_LT(worst, kExact);
  line.expect_obedience();
}

TEST(Couplings, AMasterThatFailsBringsItsSlaveToRest) {
  CoupledLine line(2, {{1, 0}});
  const auto id = line.couplings.engage(1, line.gear(1, 1), CatchUp::kPosition);
  line.run_master(15.0);
  line.cycles(2000);
  ASSERT_EQ(line.coupled(), CouplingState::kInSync);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(id).phase, RequestPhase::kError);
  EXPECT_EQ(line.axes().report(id).error, AxisError::kFollowing);
  line.cycles(2000);
  EXPECT_EQ(line.state(0), PlcopenState::kErrorStop);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  EXPECT_EQ(line.coupled(), CouplingState::kIdle);
  line.judges[1].expect_obedience();
  // A master that does not move by setpoints cannot be coupled to.
  EXPECT_EQ(line.finish(line.couplings.engage(1, line.gear(1, 1), CatchUp::kPosition)).phase, RequestPhase::kError);
}

TEST(Couplings, APeriodicCamAndAPhase) {
  trajectory::CamTable table;
  for (int i = 0; i <= 16; ++i)
    table.points.push_back({kTurn * i / 16.0, 0.5 * (1.0 - std::cos(kTurn * (i % 16) / 16.0)), 0.0, 0.0, 0});
  const auto cam = trajectory::Cam::make(table, trajectory::CamMethod::kSpline, trajectory::CamKind::kPeriodic).value();
  CoupledLine line(2, {{1, 0}});
  const double master = line.setpoint(0);
  const double slave = line.setpoint(1);
  line.run_master(10.0);
  line.cycles(1000);
  ASSERT_NE(line.couplings.engage(1, CouplingLaw::cam(cam, master, slave), CatchUp::kPosition), 0U);
  line.synchronise();
  line.cycles(4000);
  EXPECT_LT(line.apart(CouplingLaw::cam(cam, master, slave)), kExact);
  const auto limits = trajectory::ProfileLimits::symmetric(5.0, 100.0, 5000.0);
  ASSERT_TRUE(line.couplings.shift_phase_to(1, 0.4, limits));
  line.cycles(2);
  EXPECT_FALSE(line.couplings.report(1).phase_reached);
  line.cycles(2000);
  EXPECT_TRUE(line.couplings.report(1).phase_reached);
  EXPECT_EQ(line.couplings.report(1).phase, 0.4);
  EXPECT_EQ(line.couplings.report(1).losses, 0U);
  EXPECT_LT(line.apart(CouplingLaw::cam(cam, master - 0.4, slave)), kExact);
  EXPECT_GT(line.apart(CouplingLaw::cam(cam, master, slave)), 0.01);
  line.expect_obedience();
}

// Frames are lost and periods missed at any time: no axis makes a step, and the slave returns to synchronism.
TEST(Couplings, LostFramesAndMissedPeriodsNeverMakeAxesLeap) {
  std::mt19937_64 random(20240607);
  const auto any = [&random](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  CoupledLine line(2, {{1, 0}});
  const auto law = line.gear(1, 2);
  ASSERT_NE(line.couplings.engage(1, law, CatchUp::kPosition), 0U);
  double told_wrong = 0.0;
  double apart_before = 0.0;
  bool told_before = false;
  for (int round = 0; round < 40; ++round) {
    line.run_master(any(-30, 30));
    line.cycles(2);
    for (int left = any(20, 400); left > 0; --left) {
      line.cycle();
      // The effect of the slave's limits on a step is known a cycle later.
      const bool told = line.coupled() == CouplingState::kInSync;
      if (told && told_before) told_wrong = std::max(told_wrong, apart_before);
      told_before = told;
      apart_before = line.apart(law);
    }
    if (any(0, 1) == 0) {
      line.stall(any(1, 6));
    } else {
      auto& way = any(0, 1) == 0 ? line.lose_out : line.lose_back;
      way = true;
      line.cycles(any(1, 6));
      way = false;
    }
  }
  EXPECT_LT(told_wrong, kExact) << "told to be in synchronism, and was not";
  line.run_master(10.0);
  line.cycles(2000);
  EXPECT_EQ(line.state(0), PlcopenState::kContinuousMotion);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  EXPECT_EQ(line.coupled(), CouplingState::kInSync);
  EXPECT_LT(line.apart(law), kExact);
  line.expect_obedience();
}

}  // namespace
}  // namespace driveline::bus_test
