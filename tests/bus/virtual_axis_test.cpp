// Axes without a drive: the same states and requests as others, also as masters of gears.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "driveline/motion/single_axis/couplings.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::Couplings;
using trajectory::CatchUp;
using trajectory::CouplingLaw;
using trajectory::CouplingState;

constexpr std::size_t kVirtual = 1;
constexpr double kPeriod = 125e-6;
constexpr trajectory::AxisLimits kLimits{20.0, 400.0};
constexpr double kMaxJerk = 20000.0;

RunOptions with_virtual_axis() {
  auto options = single_options();
  auto& axis = options.virtual_axes.emplace_back();
  axis.name = "material";
  axis.slave = motion::AxisConfig::kNoSlave;
  axis.limits = kLimits;
  axis.max_jerk = kMaxJerk;
  axis.period = kSinglePeriod;
  return options;
}

/// A drive, and an axis without one.
class VirtualLine : public SingleLine {
 public:
  VirtualLine() : SingleLine(1, with_virtual_axis()) {}

  /// Runs a cycle and records the setpoint of the virtual axis.
  void watched_cycle() {
    cycle();
    places.push_back(setpoint(kVirtual));
  }
  void watched_cycles(int count) {
    for (int i = 0; i < count; ++i) watched_cycle();
  }
  /// Checks the limits by differences of the positions alone.
  void expect_limits() const {
    double velocity = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
    for (std::size_t i = 3; i < places.size(); ++i) {
      const double first = places[i] - places[i - 1];
      const double second = first - (places[i - 1] - places[i - 2]);
      const double third = second - ((places[i - 1] - places[i - 2]) - (places[i - 2] - places[i - 3]));
      velocity = std::max(velocity, std::abs(first) / kPeriod);
      acceleration = std::max(acceleration, std::abs(second) / (kPeriod * kPeriod));
      jerk = std::max(jerk, std::abs(third) / (kPeriod * kPeriod * kPeriod));
    }
    EXPECT_LE(velocity, kLimits.max_velocity * 1.0001);
    EXPECT_LE(acceleration, kLimits.max_acceleration * 1.001);
    EXPECT_LE(jerk, kMaxJerk * 1.01);
  }

  std::vector<double> places;
};

TEST(VirtualAxis, HasTheStatesAndRequestsOfAnAxisWithADrive) {
  VirtualLine line;
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kDisabled);
  EXPECT_EQ(line.ask(move(1.0), kVirtual).error, AxisError::kNotEnabled);
  line.enable(kVirtual);
  line.watched_cycles(4);
  const auto moving = line.submit(move(3.0), kVirtual);
  line.watched_cycles(200);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kDiscreteMotion);
  line.watched_cycles(3000);
  EXPECT_EQ(line.phase(moving), RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(kVirtual), 3.0, 1e-12);
  EXPECT_NEAR(line.axes().axis_report(kVirtual).position, 3.0, 1e-12);
  const auto running = line.submit(request(AxisCommand::kMoveVelocity, 20.0), kVirtual);
  line.watched_cycles(2000);
  EXPECT_EQ(line.phase(running), RequestPhase::kReached);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kContinuousMotion);
  EXPECT_NEAR(line.axes().axis_report(kVirtual).velocity, 20.0, 1e-9);
  const auto slower = line.submit(request(AxisCommand::kSetOverride, 0.25), kVirtual);
  line.watched_cycles(2000);
  EXPECT_EQ(line.phase(slower), RequestPhase::kDone);
  EXPECT_NEAR(line.axes().axis_report(kVirtual).velocity, 5.0, 1e-9);
  ASSERT_NE(line.submit(request(AxisCommand::kStop), kVirtual), 0U);
  line.watched_cycles(2000);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kStopping);
  EXPECT_EQ(line.ask(move(0.0), kVirtual).error, AxisError::kStopping);
  EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop), kVirtual).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kStandstill);
  EXPECT_EQ(line.ask(power(false), kVirtual).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kDisabled);
  line.expect_limits();
}

TEST(VirtualAxis, RefusesWhatNeedsADriveOrIsBeyondItsLimits) {
  VirtualLine line;
  line.enable(kVirtual);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveVelocity, 20.1), kVirtual).error, AxisError::kOverLimit);
  EXPECT_EQ(line.ask(move(1.0, 21.0), kVirtual).error, AxisError::kOverLimit);
  EXPECT_EQ(line.ask(request(AxisCommand::kHome), kVirtual).phase, RequestPhase::kError);
  EXPECT_EQ(line.ask(request(AxisCommand::kTorque, 0.1), kVirtual).error, AxisError::kNoSuchMode);
  EXPECT_EQ(line.ask(request(AxisCommand::kDriveMoveAbsolute, 1.0), kVirtual).phase, RequestPhase::kError);
  EXPECT_EQ(line.ask(request(AxisCommand::kTouchProbe), kVirtual).phase, RequestPhase::kError);
  auto velocity_mode = request(AxisCommand::kSetMode);
  velocity_mode.mode = 9;
  EXPECT_EQ(line.ask(velocity_mode, kVirtual).error, AxisError::kNoSuchMode);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kStandstill);
}

TEST(VirtualAxis, LeadsADriveAndDoesNotMissTheFramesThatAreLost) {
  VirtualLine line;
  Couplings couplings(line.axes(), std::vector<Couplings::Pair>{{0, kVirtual}}, kSinglePeriod);
  line.enable(kVirtual);
  line.enable(0);
  const auto law =
      CouplingLaw::gear(trajectory::GearRatio::make(2, 1).value(), line.setpoint(kVirtual), line.setpoint());
  ASSERT_NE(couplings.engage(0, law, CatchUp::kPosition), 0U);
  line.cycles(10);
  ASSERT_NE(line.submit(request(AxisCommand::kMoveVelocity, 15.0), kVirtual), 0U);
  line.watched_cycles(1000);
  for (const int lost : {1, 3, 7}) {
    line.lose_back = true;
    line.watched_cycles(lost);
    line.lose_back = false;
    line.watched_cycles(800);
    EXPECT_EQ(couplings.report(0).state, CouplingState::kInSync);
    EXPECT_NEAR(line.setpoint(), law.at(line.setpoint(kVirtual)).position, 1e-9);
  }
  EXPECT_NEAR(line.axes().axis_report(kVirtual).velocity, 15.0, 1e-9);
  line.expect_limits();
  line.expect_obedience();
}

TEST(VirtualAxis, GoesOnWithTheOthersBehindMissedPeriods) {
  VirtualLine line;
  line.enable(kVirtual);
  ASSERT_NE(line.submit(request(AxisCommand::kMoveVelocity, 10.0), kVirtual), 0U);
  line.cycles(1000);
  const double before = line.setpoint(kVirtual);
  line.stall(4);
  EXPECT_NEAR(line.setpoint(kVirtual), before + 10.0 * kPeriod * 5.0, 10.0 * kPeriod * 0.01);
  line.cycles(100);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kContinuousMotion);
  // Longer than axes with drives can bridge.
  line.stall(20);
  line.cycles(10);
  EXPECT_EQ(line.state(kVirtual), PlcopenState::kErrorStop);
  EXPECT_EQ(line.axes().axis_report(kVirtual).error, AxisError::kMasterAway);
  line.cycles(200);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset), kVirtual).phase, RequestPhase::kDone);
  line.enable(kVirtual);
}

}  // namespace
}  // namespace driveline::bus_test
