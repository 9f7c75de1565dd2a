// Pitch error and backlash: the position of the load behind a screw with both, and the demands of the drives meanwhile.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "driveline/motion/axis/axis_compensation.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/plant/screw.hpp"
#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {
namespace {

using motion::CompensationSettings;
using motion::ProbeTrigger;
using motion::cia402::Mode;

constexpr slaves::ScrewParameters kScrew{
    .wave_rad = 4e-3, .wave_length_rad = 6.0, .stretch = 1e-3, .backlash_rad = 0.02};
/// Largest error of a drive at standstill; more than that is a wrong compensation.
constexpr double kAtRest = 2e-3;
/// The loops of the master in CST have no integral: dry friction leaves 0.03 Nm over 0.1 Nm s/rad and 20/s.
constexpr double kAtRestByTorque = 0.016;

double at_rest(Mode mode) {
  return mode == Mode::kCyclicTorque ? kAtRestByTorque : kAtRest;
}

/// When the loops of the master overshoot a little, the shaft returns, but within the backlash the load does not.
double shown_well(Mode mode) {
  return mode == Mode::kCyclicPosition ? 2e-4 : kAtRest;
}

/// As measured by a laser: the difference between shaft and load for each position of the load.
trajectory::CorrectionTable measured(double begin, double end) {
  const slaves::Screw screw(kScrew, 0.0);
  trajectory::CorrectionTable table;
  for (double load = begin; load < end; load += 0.25) {
    double shaft = load;
    for (int i = 0; i < 20; ++i) shaft -= screw.position_of(shaft) - load;
    table.points.push_back({load, shaft - load, shaft - load, 0});
  }
  return table;
}

std::shared_ptr<const CompensationSettings> compensation(bool when_homed = false) {
  CompensationSettings settings{
      trajectory::PositionCorrection::make(measured(-20.0, 40.0), kScrew.backlash_rad).value()};
  settings.take_up_velocity = 5.0;
  settings.take_up_acceleration = 100.0;
  settings.when_homed = when_homed;
  return std::make_shared<const CompensationSettings>(settings);
}

RunOptions screw_options(Mode mode = Mode::kCyclicPosition, bool compensated = true) {
  auto options = single_options();
  options.mode = mode;
  if (compensated) options.compensation = compensation();
  return options;
}

/// An axis that moves a load by a screw.
class ScrewLine : public SingleLine {
 public:
  explicit ScrewLine(const RunOptions& options = screw_options(),
                     const std::vector<slaves::msd::MachineSwitch>& switches = {}, double before = 0.0)
      : SingleLine(1, options, switches), screw_(kScrew, shaft() + before) {
    each_period = [this, before] {
      screw_.turn(shaft() + before);
      demanded_.push_back(drives.drive(0).dictionary().get(slaves::msd::kValue.position_demand) / kDemandIncrements);
    };
    enable();
  }
  [[nodiscard]] double shaft() { return drives.drive(0).position_rad(); }
  [[nodiscard]] double load() const { return screw_.load_rad(); }
  [[nodiscard]] double shown() { return axes().axis_report(0).position; }
  [[nodiscard]] const std::vector<double>& demanded() const { return demanded_; }
  /// Moves to `target` and waits until the axis is at rest.
  void go(double target, double velocity = 20.0) {
    auto asked = move(target, velocity);
    asked.acceleration_si = asked.deceleration_si = 400.0;
    ASSERT_EQ(finish(submit(asked), 40'000).phase, RequestPhase::kDone);
    cycles(2500);
  }

 private:
  slaves::Screw screw_;
  std::vector<double> demanded_;
};

class Compensated : public testing::TestWithParam<Mode> {};

TEST_P(Compensated, TheLoadIsWhereItIsTold) {
  ScrewLine line(screw_options(GetParam()));
  for (const double target : {1.0, 4.5, 2.0, 3.1, 3.05, 3.0, 3.06, 14.0, -3.0}) {
    SCOPED_TRACE(target);
    line.go(target);
    EXPECT_NEAR(line.load(), target, at_rest(GetParam()));
    EXPECT_NEAR(line.shown(), line.load(), shown_well(GetParam())) << "what is shown is the load, too";
  }
  line.expect_obedience();
}

TEST_P(Compensated, WithoutTheTableItIsNot) {
  ScrewLine line(screw_options(GetParam(), false));
  double farthest = 0.0;
  for (const double target : {1.0, 4.5, 2.0, 14.0, -3.0}) {
    line.go(target);
    farthest = std::max(farthest, std::abs(line.load() - target));
    EXPECT_NEAR(line.shaft(), target, at_rest(GetParam()));
  }
  EXPECT_GT(farthest, 0.02);
}

INSTANTIATE_TEST_SUITE_P(InEachMode, Compensated,
                         testing::Values(Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque),
                         [](const auto& row) { return std::string(to_text(row.param)); });

TEST(Compensation, TheLoadIsOnTheSetpointsAlsoWhileItMoves) {
  double with = 0.0;
  double without = 0.0;
  for (const bool compensated : {true, false}) {
    ScrewLine line(screw_options(Mode::kCyclicPosition, compensated));
    line.go(-1.0);
    line.submit(move(12.0, 8.0));
    line.cycles(2000);
    double& worst = compensated ? with : without;
    double last = line.load();
    for (int i = 0; i < 6000; ++i) {
      // The load of this cycle, moved on for the dead time of the drive: three cycles.
      const double setpoint_before = line.setpoint();
      line.cycle();
      const double velocity = (line.setpoint() - setpoint_before) / 125e-6;
      last = line.load();
      worst = std::max(worst, std::abs(last + 3.0 * 125e-6 * velocity - line.setpoint()));
    }
  }
  EXPECT_LT(with, 1.5e-3);
  EXPECT_GT(without, 6e-3);
}

TEST(Compensation, BacklashIsTakenUpInAMotionOfItsOwn) {
  ScrewLine line;
  line.go(3.0);
  const auto from = line.demanded().size();
  line.go(2.99);
  const auto& demanded = line.demanded();
  // The path of the drive is that of the load plus the backlash, and never reverses.
  EXPECT_NEAR(demanded[from] - demanded.back(), 0.01 + kScrew.backlash_rad, 2e-4);
  double fastest = 0.0;
  for (std::size_t i = from + 1; i < demanded.size(); ++i) {
    EXPECT_LE(demanded[i], demanded[i - 1] + 1e-9) << i;
    fastest = std::max(fastest, (demanded[i - 1] - demanded[i]) / 125e-6);
  }
  EXPECT_GT(fastest, 0.5);
  EXPECT_NEAR(line.load(), 2.99, kAtRest);
  line.expect_obedience();
}

// Repeated reversals while the backlash is taken up, lost frames and missed periods.
TEST(Compensation, NoOrderOfEventsBreaksALimit) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    ScrewLine line;
    const auto any = [&random](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
    for (int event = 0; event < 60; ++event) {
      switch (any(0, 4)) {
        case 0:
          line.submit(request(AxisCommand::kMoveVelocity, any(-45, 44)));
          break;
        case 1:
          line.submit(request(AxisCommand::kMoveRelative, 0.002 * any(-40, 40)));
          break;
        case 2:
          lose_outputs(line, any(1, 3));
          break;
        case 3:
          lose_inputs(line, any(1, 3));
          break;
        default:
          line.stall(any(1, 5));
          break;
      }
      line.cycles(any(1, 150));
      ASSERT_NE(line.state(), PlcopenState::kErrorStop);
    }
    ASSERT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
    line.cycles(2500);
    EXPECT_NEAR(line.shown(), line.load(), 5e-4);
    line.expect_obedience();
  }
}

TEST(Compensation, ChangesOfModeDoNotDisturbIt) {
  ScrewLine line;
  line.go(2.0);
  line.submit(request(AxisCommand::kMoveVelocity, -3.0));
  line.cycles(40);
  for (const auto mode : {Mode::kCyclicVelocity, Mode::kCyclicPosition, Mode::kCyclicTorque, Mode::kCyclicPosition}) {
    auto changed = request(AxisCommand::kSetMode);
    changed.mode = static_cast<std::int8_t>(mode);
    EXPECT_EQ(line.ask(changed).phase, RequestPhase::kDone);
    line.cycles(800);
    EXPECT_NEAR(line.shown(), line.load(), 1e-3);
  }
  line.expect_obedience();
}

TEST(Compensation, SwitchingOffAndOnInTheMiddleOfItMovesNothing) {
  ScrewLine line;
  line.go(2.0);
  line.submit(request(AxisCommand::kMoveVelocity, -0.2));
  line.cycles(60);
  ASSERT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  const double before = line.shaft();
  line.enable();
  line.cycles(400);
  EXPECT_NEAR(line.shaft(), before, 1e-3);
  line.go(1.0);
  EXPECT_NEAR(line.load(), 1.0, kAtRest);
  line.expect_obedience();
}

RunOptions homed_options() {
  auto options = screw_options();
  options.compensation = compensation(true);
  map_touch_probe(options);
  return options;
}

// The table refers to a position that the drive knows only after homing.
TEST(Compensation, BeginsWithHomingWhereThatIsAskedFor) {
  constexpr double kMark = 2.0;    // position of the shaft where the switch closes
  constexpr double kBefore = 7.0;  // the shaft has turned before it is switched on
  ScrewLine line(homed_options(), {{slaves::msd::Input::kIsd05, kMark, 3.5}}, kBefore);
  line.go(-1.0);
  EXPECT_NEAR(line.shaft(), -1.0, kAtRest) << "not before it";
  line.go(0.0);
  auto search = request(AxisCommand::kHomeByProbe, slaves::Screw(kScrew, 0.0).position_of(kMark + kBefore), 2.0);
  search.distance_si = 4.0;
  search.trigger = ProbeTrigger::kFirstRising;
  for (int again = 0; again < 2; ++again) {
    SCOPED_TRACE(again);
    ASSERT_EQ(line.finish(line.submit(search), 40'000).phase, RequestPhase::kDone);
    line.cycles(2500);
    EXPECT_NEAR(line.load(), search.target_si, kAtRest) << "it stands at its mark, the backlash taken up";
    for (const double target : {12.0, 10.0, 10.5, 4.0}) {
      line.go(target);
      EXPECT_NEAR(line.load(), target, kAtRest);
      EXPECT_NEAR(line.shown(), line.load(), 5e-4);
    }
    line.go(search.target_si - 1.0);
  }
  line.expect_obedience();
}

}  // namespace
}  // namespace driveline::bus_test
