// MC_TouchProbe, MC_AbortTrigger, and homing by the master with the touch probe of the drive.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "driveline/slaves/msd/core/variant.hpp"
#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {
namespace {

using motion::ProbeTrigger;
using slaves::msd::Input;
using slaves::msd::MachineSwitch;
using slaves::msd::Variant;

constexpr double kProbeTurn = 6.283185307179586;
constexpr double kProbeEndless = std::numeric_limits<double>::infinity();
/// Positions where the switch at touch probe 1 (ISD05) closes and opens, and that of touch probe 2 (ISD06) closes; rad.
constexpr double kCloses = 2.0;
constexpr double kOpens = 3.5;
constexpr double kSecondCloses = 2.6;

std::vector<MachineSwitch> probe_switches() {
  return {{Input::kIsd05, kCloses, kOpens}, {Input::kIsd06, kSecondCloses, kProbeEndless}};
}

RunOptions probe_options(Variant variant = Variant::kMsd) {
  auto options = single_options();
  options.variant = variant;
  map_touch_probe(options);
  options.pdos->inputs.push_back({0x1A03, {{0x60BB, 0, 32}, {0x60BC, 0, 32}}});
  set_object<std::uint16_t>(options, 0x206B, 0, 15);  // ISD06: PROBE
  return options;
}

AxisRequest probe(ProbeTrigger trigger, double first = 0.0, double last = 0.0) {
  auto made = request(AxisCommand::kTouchProbe);
  made.trigger = trigger;
  made.window_first_si = first;
  made.window_last_si = last;
  return made;
}

AxisRequest search(ProbeTrigger trigger, double distance, double velocity, double name = 0.0) {
  auto made = request(AxisCommand::kHomeByProbe, name, velocity);
  made.trigger = trigger;
  made.distance_si = distance;
  return made;
}

class ProbeLine : public SingleLine {
 public:
  explicit ProbeLine(const RunOptions& options = probe_options()) : SingleLine(1, options, probe_switches()) {
    enable();
  }
  [[nodiscard]] motion::AxisReport now() { return axes().axis_report(0); }
};

/// Motion within a control cycle of the drive, 62.5 us, plus an increment, at the velocity of the tests.
constexpr double tolerance(double velocity) {
  return velocity * 62.5e-6 + 1e-4;
}

class EveryTrigger : public testing::TestWithParam<std::tuple<ProbeTrigger, Variant>> {};

TEST_P(EveryTrigger, RecordsWhereTheAxisIs) {
  const auto& [trigger, variant] = GetParam();
  ProbeLine line(probe_options(variant));
  ASSERT_EQ(line.ask(request(AxisCommand::kSetPosition, line.setpoint() + 100.0)).phase, RequestPhase::kDone);
  const auto id = line.submit(probe(trigger));
  line.cycles(100);
  EXPECT_EQ(line.phase(id), RequestPhase::kActive);
  EXPECT_EQ(line.ask(move(108.0, 10.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  const double place = trigger == ProbeTrigger::kFirstRising    ? kCloses
                       : trigger == ProbeTrigger::kFirstFalling ? kOpens
                       : trigger == ProbeTrigger::kSecondRising ? kSecondCloses
                                                                : kProbeTurn;
  EXPECT_EQ(line.now().recorded_request, id);
  EXPECT_NEAR(line.now().recorded_position, 100.0 + place, tolerance(10.0));
  line.expect_obedience();
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EveryTrigger,
                         testing::Combine(testing::Values(ProbeTrigger::kFirstRising, ProbeTrigger::kFirstFalling,
                                                          ProbeTrigger::kSecondRising, ProbeTrigger::kZeroPulse),
                                          testing::Values(Variant::kMsd, Variant::kServoOne)),
                         [](const auto& row) {
                           return "Trigger" + std::to_string(static_cast<int>(std::get<0>(row.param))) +
                                  (std::get<1>(row.param) == Variant::kMsd ? "Msd" : "ServoOne");
                         });

TEST(TouchProbe, PlacesAreAsAReversedAxisCounts) {
  auto options = probe_options();
  options.reversed = true;
  ProbeLine line(options);
  const auto id = line.submit(probe(ProbeTrigger::kFirstRising, -2.5, -1.5));
  EXPECT_EQ(line.ask(move(-2.3, 10.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  EXPECT_NEAR(line.now().recorded_position, -kCloses, tolerance(10.0));
  EXPECT_EQ(line.ask(move(0.0, 10.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, -8.0, 10.0, 50.0)).phase, RequestPhase::kDone);
  line.cycles(1000);
  EXPECT_NEAR(line.drives.drive(0).position_rad(), kCloses, tolerance(10.0) + 0.02);
  EXPECT_NEAR(line.now().position, 50.0, 0.02);
  line.expect_obedience();
}

TEST(TouchProbe, OnlyTheWindowCounts) {
  ProbeLine line;
  // The encoder's zero pulse comes once per turn.
  const auto id = line.submit(probe(ProbeTrigger::kZeroPulse, 2.5 * kProbeTurn, 1.5 * kProbeTurn));
  EXPECT_EQ(line.ask(move(1.2 * kProbeTurn, 20.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(id), RequestPhase::kActive) << "the first turn is outside";
  EXPECT_EQ(line.ask(move(3.2 * kProbeTurn, 20.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  EXPECT_NEAR(line.now().recorded_position, 2.0 * kProbeTurn, tolerance(20.0));
}

TEST(TouchProbe, WhatWasLatchedBeforeIsNotTaken) {
  ProbeLine line;
  ASSERT_EQ(line.submit(probe(ProbeTrigger::kFirstRising)), 2U);
  EXPECT_EQ(line.ask(move(2.3, 10.0)).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.now().recorded_position, kCloses, tolerance(10.0));
  const auto second = line.submit(probe(ProbeTrigger::kFirstRising));
  line.cycles(400);
  EXPECT_EQ(line.phase(second), RequestPhase::kActive);
  EXPECT_EQ(line.ask(move(4.0, 10.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(second), RequestPhase::kActive) << "only an edge that falls";
  EXPECT_EQ(line.ask(move(2.3, 10.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(second), RequestPhase::kDone);
  EXPECT_NEAR(line.now().recorded_position, kOpens, tolerance(10.0)) << "backwards it closes there";
}

TEST(TouchProbe, IsAbortedByRequestAndReplacedByAnother) {
  ProbeLine line;
  EXPECT_EQ(line.ask(request(AxisCommand::kAbortTrigger)).error, AxisError::kNothingToDo);
  const auto first = line.submit(probe(ProbeTrigger::kFirstRising));
  const auto second = line.submit(probe(ProbeTrigger::kFirstFalling));
  line.cycles(50);
  EXPECT_EQ(line.phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(second), RequestPhase::kActive);
  EXPECT_EQ(line.ask(request(AxisCommand::kAbortTrigger)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(second), RequestPhase::kAborted);
  EXPECT_EQ(line.ask(move(4.0, 10.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.now().recorded_request, 0U);
}

TEST(TouchProbe, IsRefusedWithTheReason) {
  ProbeLine line;
  EXPECT_EQ(line.ask(probe(ProbeTrigger::kSecondFalling)).error, AxisError::kProbeObjects) << "60BDh is not mapped";
  EXPECT_EQ(line.ask(probe(static_cast<ProbeTrigger>(77))).error, AxisError::kProbeObjects);
  EXPECT_EQ(line.ask(probe(ProbeTrigger::kFirstRising, std::nan(""), 1.0)).error, AxisError::kNotFinite);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kSecondFalling, 1.0, 5.0)).error, AxisError::kProbeObjects);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 0.0, 5.0)).error, AxisError::kNothingToDo);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 5.0, 51.0)).error, AxisError::kOverLimit);
  Enabled<SingleLine> without;
  EXPECT_EQ(without.ask(probe(ProbeTrigger::kFirstRising)).error, AxisError::kProbeObjects);
}

TEST(TouchProbe, ADriveThatDoesNotSwitchItOnSaysSo) {
  auto options = probe_options();
  set_object<std::uint16_t>(options, 0x28ED, 0, 0);  // P 2285: no touch probe
  ProbeLine line(options);
  EXPECT_EQ(line.ask(probe(ProbeTrigger::kFirstRising)).error, AxisError::kProbe);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 5.0, 5.0)).error, AxisError::kProbe);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
}

TEST(TouchProbe, LostFramesAreNoMatterButALostDriveIs) {
  ProbeLine line;
  const auto id = line.submit(probe(ProbeTrigger::kFirstRising));
  const auto way = line.submit(move(4.0, 10.0));
  for (int cycle = 0; cycle < 8000 && !line.axes().report(way).over(); ++cycle) {
    line.lose_out = cycle % 5 == 1;
    line.lose_back = cycle % 7 == 1;
    line.cycle();
  }
  line.lose_out = line.lose_back = false;
  EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  EXPECT_NEAR(line.now().recorded_position, kCloses, 10.0 * 125e-6 + 1e-3);
  const auto next = line.submit(probe(ProbeTrigger::kFirstRising));
  line.cycles(10);
  lose_inputs(line, 20);
  EXPECT_EQ(line.axes().report(next).error, AxisError::kLost);
}

TEST(TouchProbe, AFaultOfTheDriveEndsIt) {
  ProbeLine line;
  const auto id = line.submit(probe(ProbeTrigger::kFirstRising));
  line.cycles(50);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(id).error, AxisError::kFault);
}

class EverySearch : public testing::TestWithParam<std::tuple<double, Variant>> {};

TEST_P(EverySearch, ComesToRestAtItsHome) {
  const auto& [velocity, variant] = GetParam();
  for (const auto mode : {std::int8_t{8}, std::int8_t{9}, std::int8_t{10}}) {
    SCOPED_TRACE(static_cast<int>(mode));
    ProbeLine line(probe_options(variant));
    auto change = request(AxisCommand::kSetMode);
    change.mode = mode;
    ASSERT_EQ(line.ask(change).phase, RequestPhase::kDone);
    line.cycles(100);
    for (auto& judge : line.judges) judge.forget();
    line.cycles(20);
    // In CST the axis is judged by its actual motion.
    const double soft = mode == 10 ? 600.0 : 0.0;
    auto asked = search(ProbeTrigger::kFirstRising, 8.0, velocity, 50.0);
    asked.acceleration_si = soft;
    const auto id = line.submit(asked);
    line.cycles(100);
    EXPECT_EQ(line.state(), PlcopenState::kHoming);
    EXPECT_EQ(line.finish(id, 60'000).phase, RequestPhase::kDone);
    EXPECT_EQ(line.state(), PlcopenState::kStandstill);
    EXPECT_NEAR(line.setpoint(), 50.0, 1e-9);
    line.cycles(2000);
    EXPECT_NEAR(line.now().position, 50.0, 0.02);
    EXPECT_NEAR(line.drives.drive(0).position_rad(), kCloses, tolerance(velocity) + 0.02);
    auto away = move(49.0);
    away.acceleration_si = soft;
    EXPECT_EQ(line.ask(away).phase, RequestPhase::kDone);
    EXPECT_NEAR(line.axes().setpoints()[0].position, kCloses - 1.0, tolerance(velocity));
    line.expect_obedience();
  }
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EverySearch,
                         testing::Combine(testing::Values(2.0, 20.0),
                                          testing::Values(Variant::kMsd, Variant::kServoOne)),
                         [](const auto& row) {
                           return std::string(std::get<0>(row.param) < 10.0 ? "Slow" : "Fast") +
                                  (std::get<1>(row.param) == Variant::kMsd ? "Msd" : "ServoOne");
                         });

TEST(HomingByProbe, BackwardsToTheZeroPulse) {
  ProbeLine line;
  EXPECT_EQ(line.ask(search(ProbeTrigger::kZeroPulse, -8.0, 10.0)).phase, RequestPhase::kDone);
  line.cycles(1000);
  EXPECT_NEAR(line.drives.drive(0).position_rad() / kProbeTurn,
              std::round(line.drives.drive(0).position_rad() / kProbeTurn), 2e-3);
  EXPECT_LT(line.drives.drive(0).position_rad(), 0.1);
  line.expect_obedience();
}

TEST(HomingByProbe, NoEdgeWithinTheDistanceIsAnErrorAtRest) {
  ProbeLine line;
  const double from = line.setpoint();
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 1.5, 10.0)).error, AxisError::kNoEdge);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_NEAR(line.setpoint(), from + 1.5, 1e-9) << "no further, and no other names";
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 3.0, 10.0)).phase, RequestPhase::kDone) << "again";
  line.expect_obedience();
}

TEST(HomingByProbe, BeginsAtAStandstillAndNothingElseBeginsMeanwhile) {
  ProbeLine line;
  line.submit(request(AxisCommand::kMoveVelocity, 1.0));
  line.cycles(100);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 3.0, 5.0)).error, AxisError::kNotAtRest);
  ASSERT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  const auto homing = line.submit(search(ProbeTrigger::kFirstRising, 5.0, 2.0));
  line.cycles(200);
  for (const auto command : {AxisCommand::kHome, AxisCommand::kHalt, AxisCommand::kMoveAbsolute, AxisCommand::kTorque,
                             AxisCommand::kSetMode, AxisCommand::kSetPosition, AxisCommand::kTouchProbe,
                             AxisCommand::kHomeByProbe, AxisCommand::kDriveMoveAbsolute})
    EXPECT_EQ(line.ask(request(command)).error, AxisError::kNotAtRest) << to_text(command);
  EXPECT_EQ(line.finish(homing, 60'000).phase, RequestPhase::kDone);
}

TEST(HomingByProbe, AStopOrSwitchingOffEndsItAtAnyMoment) {
  for (const int moment : {1, 3, 10, 400, 1700}) {
    for (const bool off : {false, true}) {
      SCOPED_TRACE(testing::Message() << moment << (off ? " off" : " stop"));
      ProbeLine line;
      const auto homing = line.submit(search(ProbeTrigger::kFirstRising, 5.0, 10.0));
      line.cycles(moment);
      EXPECT_EQ(line.ask(off ? power(false) : request(AxisCommand::kStop)).phase, RequestPhase::kDone);
      EXPECT_EQ(line.phase(homing), RequestPhase::kAborted);
      EXPECT_EQ(line.state(), off ? PlcopenState::kDisabled : PlcopenState::kStopping);
      line.expect_obedience();
    }
  }
}

TEST(HomingByProbe, AnOverrideHoldsIt) {
  ProbeLine line;
  const auto homing = line.submit(search(ProbeTrigger::kFirstRising, 5.0, 10.0));
  line.cycles(400);
  line.submit(request(AxisCommand::kSetOverride, 0.0));
  line.cycles(2000);
  EXPECT_EQ(line.phase(homing), RequestPhase::kActive);
  line.submit(request(AxisCommand::kSetOverride, 1.0));
  EXPECT_EQ(line.finish(homing).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(HomingByProbe, AFaultOrLostCommunicationEndsIt) {
  for (const bool fault : {true, false}) {
    ProbeLine line;
    const auto homing = line.submit(search(ProbeTrigger::kFirstRising, 5.0, 5.0));
    line.cycles(1000);
    if (fault) {
      line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
    } else {
      lose_inputs(line, 20);
    }
    EXPECT_EQ(line.finish(homing).error, fault ? AxisError::kFault : AxisError::kLost);
    line.cycles(20'000);
    EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
    line.enable();
    EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 0.5)).phase, RequestPhase::kDone);
  }
}

TEST(HomingByProbe, SingleLostFramesAreNoMatter) {
  ProbeLine line;
  const auto homing = line.submit(search(ProbeTrigger::kFirstRising, 5.0, 5.0));
  for (int cycle = 0; cycle < 60'000 && !line.axes().report(homing).over(); ++cycle) {
    line.lose_out = cycle % 5 == 1;
    line.lose_back = cycle % 7 == 1;
    line.cycle();
  }
  line.lose_out = line.lose_back = false;
  EXPECT_EQ(line.phase(homing), RequestPhase::kDone);
  EXPECT_NEAR(line.axes().setpoints()[0].position, kCloses, 5.0 * 125e-6 + 1e-3);
}

TEST(HomingByProbe, SoftwareLimitsAreKept) {
  auto options = probe_options();
  options.software_limits = trajectory::PositionRange{-1.0, 4.0};
  ProbeLine line(options);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 5.0, 5.0)).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(search(ProbeTrigger::kFirstRising, 3.0, 5.0)).phase, RequestPhase::kDone);
}

}  // namespace
}  // namespace driveline::bus_test
