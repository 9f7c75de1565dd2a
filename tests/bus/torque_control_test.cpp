// MC_TorqueControl and the software limits of axes that are commanded individually.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

AxisRequest torque(double target, double velocity = 0.0, double ramp = 0.0) {
  auto made = request(AxisCommand::kTorque, target, velocity);
  made.acceleration_si = ramp;
  return made;
}

TEST(TorqueControl, GivesTheTorqueThatIsAskedAndNoMore) {
  Enabled<SingleLine> line;
  // A load that keeps the axis from turning.
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, 0.5);
  line.cycles(800);
  const auto id = line.submit(torque(0.5, 0.0, 2.0));
  line.cycles(100);
  EXPECT_EQ(line.state(), PlcopenState::kContinuousMotion);
  line.cycles(2000);
  EXPECT_EQ(line.phase(id), RequestPhase::kReached) << "in torque";
  EXPECT_EQ(line.axes().axis_report(0).mode, 10);
  EXPECT_NEAR(line.axes().axis_report(0).torque, 0.5, 0.01);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(id), RequestPhase::kAborted);
  line.cycles(200);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_EQ(line.axes().axis_report(0).mode, 8) << "the mode from before";
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(TorqueControl, RampsItsTorque) {
  Enabled<SingleLine> line;
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, 0.4);
  line.cycles(800);
  const double from = line.axes().axis_report(0).torque;
  EXPECT_NEAR(from, 0.4, 0.05) << "it begins with the torque in force";
  const auto id = line.submit(torque(0.6, 0.0, 1.0));
  line.cycles(800);
  EXPECT_EQ(line.phase(id), RequestPhase::kActive);
  EXPECT_NEAR(line.axes().axis_report(0).torque, from + 0.1, 0.05);
  line.cycles(1600);
  EXPECT_EQ(line.phase(id), RequestPhase::kReached);
}

TEST(TorqueControl, IsNoFasterThanItMay) {
  for (const double direction : {1.0, -1.0}) {
    Enabled<SingleLine> line;
    line.submit(torque(0.2 * direction, 10.0, 5.0));
    double fastest = 0.0;
    for (int i = 0; i < 4000; ++i) {
      line.cycle();
      fastest = std::max(fastest, std::abs(line.drives.drive(0).velocity_rad_s()));
    }
    EXPECT_GT(fastest, 8.0);
    EXPECT_LT(fastest, 10.2);
    // The loops take over the moving axis.
    EXPECT_EQ(line.ask(request(AxisCommand::kMoveVelocity, 20.0 * direction), 0).phase, RequestPhase::kReached);
    EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
    line.expect_obedience();
  }
}

TEST(TorqueControl, AnotherTorqueReplacesIt) {
  Enabled<SingleLine> line;
  const auto first = line.submit(torque(0.15, 20.0));
  line.cycles(600);
  EXPECT_EQ(line.phase(first), RequestPhase::kReached);
  const auto second = line.submit(torque(-0.15, 20.0));
  line.cycles(2000);
  EXPECT_EQ(line.phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(second), RequestPhase::kReached);
  EXPECT_LT(line.axes().axis_report(0).velocity, -5.0);
  EXPECT_EQ(line.ask(power(false)).phase, RequestPhase::kDone) << "it comes to rest first";
  line.expect_obedience();
}

TEST(TorqueControl, OutOfAMotionAndIntoAnotherIsWithinTheLimits) {
  for (const double velocity : {5.0, 20.0, 40.0}) {
    for (const double load_nm : {0.0, 0.2, -0.2}) {
      for (const int moment : {100, 137, 400, 900}) {
        SCOPED_TRACE(testing::Message() << velocity << " rad/s, " << load_nm << " Nm, cycle " << moment);
        Enabled<SingleLine> line;
        line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, load_nm);
        line.submit(request(AxisCommand::kMoveVelocity, velocity));
        line.cycles(moment);
        const auto led = line.submit(torque(0.15, 30.0, 5.0));
        line.cycles(moment);
        EXPECT_THAT(line.phase(led), testing::AnyOf(RequestPhase::kActive, RequestPhase::kReached));
        EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, -10.0)).phase, RequestPhase::kDone);
        EXPECT_EQ(line.phase(led), RequestPhase::kAborted);
        line.cycles(400);
        EXPECT_EQ(line.axes().axis_report(0).mode, 8);
        line.expect_obedience();
      }
    }
  }
}

/// Highest torque that the master requests in per mille, while the axis moves at its limits in CST, and highest torque
/// demand of the drive.
std::pair<int, int> most_torque(std::optional<double> limit) {
  auto options = single_options();
  options.max_torque = limit;
  options.mode = motion::cia402::Mode::kCyclicTorque;
  Enabled<SingleLine> line(1, options);
  line.submit(move(4.0));
  std::pair<int, int> most{0, 0};
  const auto& values = line.drives.drive(0).dictionary();
  for (int i = 0; i < 4000; ++i) {
    line.cycle();
    const int asked = values.get(slaves::msd::kValue.target_torque) + values.get(slaves::msd::kValue.torque_offset);
    most.first = std::max(most.first, std::abs(asked));
    most.second = std::max(most.second, std::abs(int{values.get(slaves::msd::kValue.torque_demand)}));
  }
  EXPECT_NEAR(line.axes().axis_report(0).position, 4.0, 0.1) << "it gets there all the same";
  return most;
}

TEST(TorqueLimit, WhatTheMasterAsksForStaysWithinIt) {
  const auto [asked, demanded] = most_torque(std::nullopt);
  EXPECT_GT(asked, 140);
  EXPECT_GT(demanded, 140);
  // 0.24 of 2.4 Nm.
  const auto [limited, held] = most_torque(0.24);
  EXPECT_EQ(limited, 100);
  EXPECT_LE(held, 100);
  EXPECT_GT(held, 95);
}

TEST(TorqueLimit, ThatLeavesNothingIsRefused) {
  for (const double limit : {0.0, -1.0, std::nan("")}) {
    auto options = single_options();
    options.max_torque = limit;
    EXPECT_THROW(SingleLine(1, options), std::invalid_argument);
    options.single_axes = false;
    EXPECT_THROW(SingleLine(1, options), std::invalid_argument);
  }
}

TEST(TorqueLimit, ATorqueBeyondItIsRefused) {
  auto options = single_options();
  options.max_torque = 0.24;
  Enabled<SingleLine> line(1, options);
  EXPECT_EQ(line.ask(torque(0.25)).error, AxisError::kOverLimit);
  EXPECT_EQ(line.ask(torque(-0.25)).error, AxisError::kOverLimit);
  const auto most = line.submit(torque(0.24, 5.0));
  line.cycles(400);
  EXPECT_THAT(line.phase(most), testing::AnyOf(RequestPhase::kActive, RequestPhase::kReached));
}

TEST(TorqueControl, IsRefusedWithTheReason) {
  SingleLine line;
  EXPECT_EQ(line.ask(torque(0.1)).error, AxisError::kNotEnabled);
  line.enable();
  EXPECT_EQ(line.ask(torque(std::nan(""))).error, AxisError::kNotFinite);
  EXPECT_EQ(line.ask(torque(0.1, 51.0)).error, AxisError::kOverLimit);
  EXPECT_EQ(line.ask(torque(100.0)).error, AxisError::kOverLimit);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
}

TEST(TorqueControl, AFaultEndsItAndTheAxisBeginsInItsMode) {
  Enabled<SingleLine> line;
  const auto id = line.submit(torque(0.1, 10.0));
  line.cycles(800);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(id).error, AxisError::kFault);
  line.cycles(8000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable();
  EXPECT_EQ(line.axes().axis_report(0).mode, 8);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
}

RunOptions limited() {
  auto options = single_options();
  options.software_limits = trajectory::PositionRange{-5.0, 5.0};
  return options;
}

TEST(SoftwareLimits, TargetsBeyondThemAreRefused) {
  Enabled<SingleLine> line(1, limited());
  EXPECT_EQ(line.ask(move(5.1)).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(move(-5.1)).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 6.0)).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveAdditive, -6.0)).error, AxisError::kOutsideRange);
  const auto way = line.submit(move(4.0, 10.0));
  line.cycles(100);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveSuperimposed, 2.0, 1.0)).error, AxisError::kOutsideRange);
  auto behind = move(5.5);
  behind.buffer = BufferMode::kBlendingPrevious;
  const auto waiting = line.submit(behind);
  EXPECT_EQ(line.finish(way).phase, RequestPhase::kDone);
  EXPECT_EQ(line.finish(waiting).error, AxisError::kOutsideRange);
  line.cycles(200);
  EXPECT_NEAR(line.setpoint(), 4.0, 1e-3);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  // The limits refer to the drive's positions, whatever the positions in requests are.
  EXPECT_EQ(line.ask(request(AxisCommand::kSetPosition, 100.0)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(move(100.9)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(move(101.1)).error, AxisError::kOutsideRange);
  line.expect_obedience();
}

TEST(SoftwareLimits, AWayThatLeavesThemIsRefusedAndTheOldOneGoesOn) {
  Enabled<SingleLine> line(1, limited());
  const auto way = line.submit(move(4.9, 50.0));
  line.cycles(600);
  ASSERT_GT(line.axes().axis_report(0).velocity, 30.0);
  auto soft = move(4.9, 50.0);
  soft.deceleration_si = 200.0;
  EXPECT_EQ(line.ask(soft).error, AxisError::kOutsideRange) << "it could not stop before 5";
  EXPECT_EQ(line.finish(way).phase, RequestPhase::kDone);
}

TEST(SoftwareLimits, AVelocityEndsAtThem) {
  for (const double direction : {1.0, -1.0}) {
    Enabled<SingleLine> line(1, limited());
    const auto id = line.submit(request(AxisCommand::kMoveVelocity, 20.0 * direction));
    line.cycles(400);
    EXPECT_EQ(line.phase(id), RequestPhase::kReached) << "in velocity";
    EXPECT_EQ(line.finish(id).error, AxisError::kOutsideRange);
    EXPECT_NEAR(line.setpoint(), 5.0 * direction, 1e-9);
    EXPECT_EQ(line.state(), PlcopenState::kStandstill);
    EXPECT_EQ(line.ask(request(AxisCommand::kMoveVelocity, direction)).error, AxisError::kOutsideRange);
    EXPECT_EQ(line.ask(move(0.0)).phase, RequestPhase::kDone) << "there is a way back";
    line.expect_obedience();
  }
}

TEST(SoftwareLimits, ATorqueThatLeadsTheAxisToThemStopsIt) {
  Enabled<SingleLine> line(1, limited());
  EXPECT_EQ(line.ask(torque(0.15, 20.0)).error, AxisError::kOutsideRange);
  line.cycles(2000);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  EXPECT_LT(line.axes().axis_report(0).position, 5.05);
}

}  // namespace
}  // namespace driveline::bus_test
