// Gantry pairs: a single axis for all callers, and the positions of both shafts.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/motion/single_axis/gantry.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {
namespace {

using motion::GantryReport;
using motion::GantrySettings;
using motion::ProbeTrigger;

constexpr std::size_t kLeader = 0;
constexpr std::size_t kFollower = 1;
/// Difference at power-on: the second drive is a quarter of a rad below the first.
constexpr double kApart = -0.25;
constexpr double kTrue = 2e-3;  // largest position error of a drive

GantrySettings pair_settings() {
  GantrySettings settings;
  settings.leader = kLeader;
  settings.follower = kFollower;
  settings.offset = kApart;
  settings.skew_warning = 0.02;
  settings.skew_limit = 0.05;
  settings.square_velocity = 0.5;
  settings.square_acceleration = 20.0;
  return settings;
}

RunOptions gantry_options() {
  auto options = single_options();
  map_touch_probe(options);
  return options;
}

/// Two axes under one beam.
class GantryLine : public SingleLine {
 public:
  explicit GantryLine(const GantrySettings& settings = pair_settings(), bool enabled = true)
      : SingleLine(2, gantry_options(), {{slaves::msd::Input::kIsd05, 2.0, 3.5}}) {
    axes().add_gantry(settings);
    each_period = [this] {
      const double between = shaft(kFollower) - shaft(kLeader);
      narrowest = std::min(narrowest, between);
      widest = std::max(widest, between);
    };
    cycles(2);
    if (enabled) join();
  }
  void join() {
    ASSERT_EQ(ask(power(true)).phase, RequestPhase::kDone);
    EXPECT_EQ(state(kLeader), PlcopenState::kStandstill);
    cycles(2);
    EXPECT_EQ(state(kFollower), PlcopenState::kSynchronizedMotion);
    forget();
  }
  void forget() { narrowest = widest = shaft(kFollower) - shaft(kLeader); }
  [[nodiscard]] double shaft(std::size_t axis) { return drives.drive(axis).position_rad(); }
  [[nodiscard]] GantryReport pair() { return axes().gantry_report(0); }
  /// Deviation of the shafts from this difference.
  [[nodiscard]] double astray(double difference = kApart) const {
    return std::max(std::abs(narrowest - difference), std::abs(widest - difference));
  }
  [[nodiscard]] auto demand(std::size_t axis) {
    return drives.drive(axis).dictionary().get(slaves::msd::kValue.position_demand);
  }
  [[nodiscard]] bool powered(std::size_t axis) {
    return (drives.drive(axis).dictionary().get(slaves::msd::kValue.status_word) & 0x6FU) == 0x27U;
  }

  double narrowest = 0.0;
  double widest = 0.0;
};

TEST(Gantry, BothAxesAreToldTheSameInTheSameCycle) {
  GantryLine line;
  const auto from = line.demand(kLeader);
  const auto other = line.demand(kFollower);
  line.submit(move(6.0, 30.0));
  for (int i = 0; i < 6000; ++i) {
    line.cycle();
    ASSERT_NEAR(line.demand(kLeader) - from, line.demand(kFollower) - other, 3) << "increments, in cycle " << i;
  }
  EXPECT_NEAR(line.shaft(kLeader), 6.0, kTrue);
  EXPECT_NEAR(line.shaft(kFollower), 6.0 + kApart, kTrue);
  EXPECT_LT(line.astray(), 5e-3);
  EXPECT_LT(std::abs(line.pair().worst_skew), 5e-3);
  // Both axes report the same position.
  EXPECT_NEAR(line.axes().axis_report(kFollower).position, 6.0, kTrue);
  line.expect_obedience();
}

TEST(Gantry, AreEnabledAndSwitchedOffTogether) {
  GantryLine line(pair_settings(), false);
  line.submit(power(true));
  for (int i = 0; i < 400; ++i) {
    line.cycle();
    ASSERT_EQ(line.powered(kLeader), line.powered(kFollower)) << i;
  }
  EXPECT_TRUE(line.pair().formed);
  line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(1000);
  line.forget();
  ASSERT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  EXPECT_LT(line.astray(), 5e-3) << "they come to rest together";
  EXPECT_FALSE(line.powered(kLeader));
  EXPECT_FALSE(line.powered(kFollower));
  EXPECT_FALSE(line.pair().formed);
  // It may be enabled again while it comes to rest.
  line.join();
  line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(1000);
  line.submit(power(false));
  line.cycles(10);
  ASSERT_EQ(line.ask(power(true)).phase, RequestPhase::kDone);
  line.cycles(1000);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  ASSERT_EQ(line.ask(move(1.0, 20.0)).phase, RequestPhase::kDone);
  EXPECT_LT(line.astray(), 5e-3);
  line.expect_obedience();
}

TEST(Gantry, AMotionDoesNotBeginAfterALaterStopOfTheFollower) {
  GantryLine line;
  for (int i = 0; i < 40; ++i) line.submit(request(AxisCommand::kSetOverride, 1.0));
  const auto older = line.submit(move(6.0, 30.0));
  const auto halt = line.submit(request(AxisCommand::kHalt), kFollower);
  line.cycles(40);
  EXPECT_EQ(line.phase(older), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(halt), RequestPhase::kDone);
  EXPECT_EQ(line.state(kLeader), PlcopenState::kStandstill);
  line.expect_obedience();
}

TEST(Gantry, TheFollowerIsNotCommandedButMayBeStopped) {
  GantryLine line;
  for (const auto command :
       {AxisCommand::kPower, AxisCommand::kReset, AxisCommand::kMoveAbsolute, AxisCommand::kMoveVelocity,
        AxisCommand::kFollow, AxisCommand::kSetPosition, AxisCommand::kHome, AxisCommand::kTouchProbe})
    EXPECT_EQ(line.ask(request(command), kFollower).error, AxisError::kGantryFollower) << to_text(command);
  for (const auto command : {AxisCommand::kHome, AxisCommand::kSetMode, AxisCommand::kTorque,
                             AxisCommand::kDriveMoveAbsolute, AxisCommand::kDriveMoveVelocity})
    EXPECT_EQ(line.ask(request(command)).error, AxisError::kGantry) << to_text(command);
  line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(1000);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt), kFollower).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_LT(line.astray(), 5e-3);
  line.expect_obedience();
}

TEST(Gantry, AFaultOfOneStopsBothInFormation) {
  for (const auto failing : {kLeader, kFollower}) {
    SCOPED_TRACE(failing);
    GantryLine line;
    line.submit(request(AxisCommand::kMoveVelocity, 20.0));
    line.cycles(1500);
    line.forget();
    line.drives.drive(failing).raise(slaves::msd::Fault::kMotorTemperature);
    line.cycles(2000);
    EXPECT_EQ(line.state(kLeader), PlcopenState::kErrorStop);
    EXPECT_EQ(line.state(kFollower), PlcopenState::kErrorStop);
    EXPECT_EQ(line.axes().axis_report(failing).error, AxisError::kFault);
    EXPECT_EQ(line.axes().axis_report(1 - failing).error, AxisError::kGantryPartner);
    EXPECT_LT(std::abs(line.drives.drive(kLeader).velocity_rad_s()), 1e-3);
    EXPECT_LT(std::abs(line.drives.drive(kFollower).velocity_rad_s()), 1e-3);
    EXPECT_LT(line.astray(), 0.05) << "some cycles of 20 rad/s";
    EXPECT_EQ(line.ask(move(1.0)).error, AxisError::kErrorStop);
  }
}

// The drives have no fault: both are stopped by the same ramp.
TEST(Gantry, APositionThatCannotBeTrueStopsBothByTheSameRamp) {
  for (const auto failing : {kLeader, kFollower}) {
    SCOPED_TRACE(failing);
    GantryLine line;
    line.submit(request(AxisCommand::kMoveVelocity, 20.0));
    line.cycles(1500);
    const auto before = line.demand(kFollower) - line.demand(kLeader);
    line.forget();
    line.drives.drive(failing).set_machine_input(slaves::msd::MachineInput::kPositionError, 1e6);
    for (int i = 0; i < 600; ++i) {
      line.cycle();
      ASSERT_NEAR(line.demand(kFollower) - line.demand(kLeader), before, 3) << i;
    }
    EXPECT_EQ(line.axes().axis_report(failing).error, AxisError::kPosition);
    EXPECT_EQ(line.axes().axis_report(1 - failing).error, AxisError::kGantryPartner);
    EXPECT_LT(line.astray(), 5e-3);
    EXPECT_FALSE(line.powered(kLeader));
    EXPECT_FALSE(line.powered(kFollower));
    line.expect_obedience();
  }
}

TEST(Gantry, BeyondItsSkewLimitBothStopWithinTheirs) {
  for (const auto held : {kLeader, kFollower}) {
    SCOPED_TRACE(held);
    GantryLine line;
    line.submit(request(AxisCommand::kMoveVelocity, 10.0));
    line.cycles(1500);
    bool warned = false;
    // A load that the drive cannot move.
    line.drives.drive(held).set_machine_input(slaves::msd::MachineInput::kLoad, 20.0);
    for (int i = 0; i < 4000 && line.state() != PlcopenState::kErrorStop; ++i) {
      line.cycle();
      warned = warned || line.pair().warned;
    }
    EXPECT_TRUE(warned);
    line.drives.drive(held).set_machine_input(slaves::msd::MachineInput::kLoad, 0.0);
    EXPECT_EQ(line.axes().axis_report(kLeader).error, AxisError::kSkew);
    EXPECT_EQ(line.axes().axis_report(kFollower).error, AxisError::kSkew);
    EXPECT_GT(std::abs(line.pair().stopped_at), 0.05);
    EXPECT_LT(std::abs(line.pair().stopped_at), 0.06);
    EXPECT_EQ(line.pair().stopped_at < 0.0, held == kFollower);
    line.cycles(2000);
    EXPECT_FALSE(line.powered(kLeader));
    EXPECT_FALSE(line.powered(kFollower));
    line.judges[1 - held].expect_obedience();
  }
}

TEST(Gantry, OutOfSkewItIsNotEnabledUnlessItIsToBeSquared) {
  auto settings = pair_settings();
  settings.offset = kApart + 0.12;
  GantryLine refused(settings, false);
  EXPECT_EQ(refused.ask(power(true)).error, AxisError::kSkew);
  EXPECT_NEAR(refused.pair().stopped_at, -0.12, kTrue);
  EXPECT_FALSE(refused.powered(kLeader));
  settings.square_when_enabled = true;
  GantryLine line(settings);
  EXPECT_TRUE(line.pair().squaring);
  EXPECT_LT(line.astray(), 5e-3) << "it stands at first";
  double fastest = 0.0;
  double before = line.demand(kFollower);
  const double leader = line.demand(kLeader);
  for (int i = 0; i < 4000; ++i) {
    line.cycle();
    fastest = std::max(fastest, (line.demand(kFollower) - before) / kDemandIncrements / 125e-6);
    before = line.demand(kFollower);
    EXPECT_NEAR(line.demand(kLeader), leader, 2);
  }
  EXPECT_FALSE(line.pair().squaring);
  EXPECT_NEAR(line.shaft(kFollower) - line.shaft(kLeader), settings.offset, kTrue);
  EXPECT_LT(fastest, 0.55) << "0.5 in whole increments";
  EXPECT_GT(fastest, 0.4);
  EXPECT_LT(std::abs(line.pair().worst_skew), 0.01);
  line.expect_obedience();
}

// The switch is at the same position of both shafts: it is the reference of either axis.
TEST(Gantry, HomesTogetherAndIsSquareThen) {
  auto settings = pair_settings();
  settings.when_homed = true;
  settings.offset = 0.03;
  settings.skew_limit = 0.02;
  settings.skew_warning = 0.02;
  GantryLine line(settings);
  auto search = request(AxisCommand::kHomeByProbe, 100.0, 3.0);
  search.trigger = ProbeTrigger::kFirstRising;
  search.distance_si = 4.0;
  const auto id = line.submit(search);
  line.cycles(2000);
  EXPECT_EQ(line.ask(move(0.0)).error, AxisError::kNotAtRest) << "nothing begins meanwhile";
  ASSERT_EQ(line.finish(id, 60'000).phase, RequestPhase::kDone);
  line.cycles(2000);
  EXPECT_NEAR(line.shaft(kLeader), 2.0, 3e-3) << "the leader stands at its mark";
  EXPECT_NEAR(line.shaft(kFollower), 2.0 + settings.offset, 3e-3);
  EXPECT_NEAR(line.axes().axis_report(kLeader).position, 100.0, 3e-3);
  EXPECT_NEAR(line.axes().axis_report(kFollower).position, 100.0, 3e-3);
  EXPECT_LT(std::abs(line.pair().worst_skew), 0.01);
  line.forget();
  ASSERT_EQ(line.finish(line.submit(move(105.0, 20.0))).phase, RequestPhase::kDone);
  line.cycles(1000);
  EXPECT_NEAR(line.shaft(kLeader), 7.0, 4e-3);
  EXPECT_LT(line.astray(settings.offset), 5e-3);
  // A second homing changes nothing.
  ASSERT_EQ(line.finish(line.submit(move(98.0, 20.0)), 20'000).phase, RequestPhase::kDone);
  ASSERT_EQ(line.finish(line.submit(search), 60'000).phase, RequestPhase::kDone);
  line.cycles(1000);
  EXPECT_LT(line.astray(settings.offset), 6e-3);
  line.expect_obedience();
}

TEST(Gantry, WithoutAMarkHomingEndsAtRest) {
  GantryLine line;
  line.cycles(1000);
  auto search = request(AxisCommand::kHomeByProbe, 0.0, 5.0);
  search.trigger = ProbeTrigger::kFirstRising;
  search.distance_si = -1.0;
  EXPECT_EQ(line.ask(search).error, AxisError::kNoEdge);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  search.distance_si = 4.0;
  const auto id = line.submit(search);
  line.cycles(1000);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
  search.distance_si = 0.0;
  EXPECT_EQ(line.ask(search).error, AxisError::kNothingToDo);
  EXPECT_EQ(line.ask(move(1.0, 10.0)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(Gantry, ResetsBothAndGoesOn) {
  GantryLine line;
  line.drives.drive(kFollower).raise(slaves::msd::Fault::kMotorTemperature);
  line.cycles(2000);
  ASSERT_EQ(line.state(), PlcopenState::kErrorStop);
  ASSERT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(kLeader), PlcopenState::kDisabled);
  EXPECT_EQ(line.state(kFollower), PlcopenState::kDisabled);
  line.join();
  EXPECT_EQ(line.ask(move(1.0, 10.0)).phase, RequestPhase::kDone);
}

TEST(Gantry, LostFramesAndMissedPeriodsDoNotPartThem) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    GantryLine line;
    const auto any = [&random](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
    for (int event = 0; event < 40; ++event) {
      switch (any(0, 3)) {
        case 0:
          line.submit(request(AxisCommand::kMoveVelocity, any(-40, 40)));
          break;
        case 1:
          lose_outputs(line, any(1, 3));
          break;
        case 2:
          lose_inputs(line, any(1, 3));
          break;
        default:
          line.stall(any(1, 5));
          break;
      }
      line.cycles(any(20, 200));
      ASSERT_EQ(line.state(kFollower), PlcopenState::kSynchronizedMotion);
    }
    EXPECT_LT(line.astray(), 0.01);
    line.expect_obedience();
  }
}

TEST(Gantry, AreOfTwoAxesThatThereAre) {
  SingleLine line(3);
  auto settings = pair_settings();
  settings.follower = 0;
  EXPECT_THROW(line.axes().add_gantry(settings), std::invalid_argument);
  settings.follower = 3;
  EXPECT_THROW(line.axes().add_gantry(settings), std::invalid_argument);
  settings.follower = 1;
  line.axes().add_gantry(settings);
  settings.leader = 2;
  EXPECT_THROW(line.axes().add_gantry(settings), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::bus_test
