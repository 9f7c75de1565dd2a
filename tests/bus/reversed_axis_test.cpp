// Reversed axes: every value has the opposite sign in the drive, and the limits are those of the axis.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::cia402::Mode;

constexpr double kReversedTurn = 6.283185307179586;

RunOptions reversed_options(Mode mode = Mode::kCyclicPosition) {
  auto options = single_options();
  options.mode = mode;
  options.reversed = true;
  return options;
}

/// In CST the motion of the axis includes the response of the master's loop to friction.
AxisRequest gentle(AxisRequest asked) {
  asked.acceleration_si = asked.deceleration_si = 600.0;
  return asked;
}

class ReversedLine : public SingleLine {
 public:
  explicit ReversedLine(const RunOptions& options = reversed_options()) : SingleLine(1, options) { enable(); }
  [[nodiscard]] motion::AxisReport now() { return axes().axis_report(0); }
  [[nodiscard]] double shaft() { return drives.drive(0).position_rad(); }
  [[nodiscard]] double shaft_velocity() { return drives.drive(0).velocity_rad_s(); }
  template <typename Value>
  [[nodiscard]] auto object(Value value) {
    return drives.drive(0).dictionary().get(value);
  }
};

class ReversedAxis : public testing::TestWithParam<Mode> {};

TEST_P(ReversedAxis, GoesAgainstItsDriveWithinItsLimits) {
  ReversedLine line(reversed_options(GetParam()));
  EXPECT_NEAR(line.now().position, -line.shaft(), 1e-3);
  for (const double way : {3.0, -5.0}) {
    const double from = line.setpoint();
    EXPECT_EQ(line.ask(gentle(request(AxisCommand::kMoveRelative, way))).phase, RequestPhase::kDone);
    line.cycles(800);
    EXPECT_NEAR(line.now().position, from + way, 0.05);
    EXPECT_NEAR(line.shaft(), -line.now().position, 1e-3);
  }
  line.submit(gentle(request(AxisCommand::kMoveVelocity, 20.0)));
  line.cycles(2000);
  EXPECT_NEAR(line.now().velocity, 20.0, 0.5);
  EXPECT_NEAR(line.shaft_velocity(), -20.0, 0.5);
  EXPECT_EQ(line.ask(gentle(request(AxisCommand::kHalt))).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST_P(ReversedAxis, KeepsTheSoftwareLimitsAsItCounts) {
  auto options = reversed_options(GetParam());
  options.software_limits = trajectory::PositionRange{-1.0, 4.0};
  ReversedLine line(options);
  EXPECT_EQ(line.ask(gentle(request(AxisCommand::kMoveAbsolute, -1.5))).error, AxisError::kOutsideRange);
  EXPECT_EQ(line.ask(gentle(request(AxisCommand::kMoveAbsolute, 3.5))).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(gentle(request(AxisCommand::kMoveVelocity, -10.0))).error, AxisError::kOutsideRange);
  line.cycles(800);
  EXPECT_NEAR(line.now().position, -1.0, 0.05);
  EXPECT_NEAR(line.shaft(), 1.0, 0.05);
  line.expect_obedience();
}

/// 607Eh reverses positions and velocities, but not torques: 6077h has the opposite sign. An axis without known torques
/// still changes between CSP and CSV, and sends its drive no torque.
TEST(TurnedDrive, ChangesFromCspToCsvUnderALoadLikeAnyOther) {
  for (const bool added : {false, true}) {
    for (const auto polarity : {std::uint8_t{0x00}, std::uint8_t{0xC0}}) {
      SCOPED_TRACE(testing::Message() << int{polarity} << (added ? ", offsets added" : ""));
      auto options = single_options();
      options.knows_torques = false;
      options.adds_offsets = added;
      options.startup.push_back({0x607E, 0, {std::byte{polarity}}});
      // P 379: feed-forward from the bus, of velocity and torque.
      if (added) {
        for (const auto part : {std::uint8_t{1}, std::uint8_t{2}})
          options.startup.push_back({0x217B, part, {std::byte{1}, std::byte{0}}});
      }
      ReversedLine line(options);
      line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, 0.4);
      line.cycles(400);
      for (auto& judge : line.judges) judge.forget();
      line.cycles(20);
      line.submit(gentle(request(AxisCommand::kMoveVelocity, 15.0)));
      line.cycles(400);
      EXPECT_NEAR(line.shaft_velocity(), polarity == 0 ? 15.0 : -15.0, 0.5);
      double mode = 9.0;
      for (int change = 0; change < 4; ++change, mode = 17.0 - mode) {
        auto changed = request(AxisCommand::kSetMode);
        changed.mode = static_cast<std::int8_t>(mode);
        const auto id = line.submit(changed);
        for (int i = 0; i < 400; ++i) {
          line.cycle();
          ASSERT_EQ(line.object(slaves::msd::kValue.torque_offset), 0);
        }
        EXPECT_EQ(line.phase(id), RequestPhase::kDone);
        EXPECT_NEAR(line.now().velocity, 15.0, 0.5);
      }
      line.expect_obedience();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InEachMode, ReversedAxis,
                         testing::Values(Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque),
                         [](const auto& row) { return std::string(to_text(row.param)); });

TEST(ReversedDrive, OffsetsAndTorqueLimitsHaveTheSignOfTheAxis) {
  auto options = reversed_options();
  options.max_torque = 0.15;
  ReversedLine line(options);
  const auto moving = line.submit(move(20.0, 30.0));
  double least = 0.0;
  double most = 0.0;
  for (int i = 0; i < 8000 && !line.axes().report(moving).over(); ++i) {
    line.cycle();
    const double torque = line.object(slaves::msd::kValue.torque_offset);
    if (torque < least) {
      EXPECT_LE(line.object(slaves::msd::kValue.velocity_offset), 0) << "it speeds up";
    }
    least = std::min(least, torque);
    most = std::max(most, torque);
  }
  EXPECT_EQ(line.phase(moving), RequestPhase::kDone);
  const double permille = 0.15 / 2.4 * 1000.0;
  EXPECT_NEAR(least, -permille, 1.0) << "the limit, either way";
  EXPECT_NEAR(most, permille, 1.0);
  line.expect_obedience();
}

TEST(ReversedDrive, ATorqueHasTheDirectionOfTheAxis) {
  ReversedLine line;
  auto pull = request(AxisCommand::kTorque, 0.2, 10.0);
  pull.acceleration_si = 5.0;
  line.submit(pull);
  double fastest = 0.0;
  for (int i = 0; i < 4000; ++i) {
    line.cycle();
    fastest = std::min(fastest, line.shaft_velocity());
  }
  EXPECT_LT(fastest, -8.0);
  EXPECT_GT(fastest, -10.2) << "no faster than it may";
  EXPECT_NEAR(line.now().velocity, -line.shaft_velocity(), 0.1);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(ReversedDrive, AMeasuredTorqueHasTheSignOfTheAxis) {
  ReversedLine line;
  // The drive holds this load with the same torque in its positive direction.
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, 0.5);
  line.cycles(1600);
  EXPECT_GT(line.object(slaves::msd::kValue.torque_actual), 0);
  EXPECT_NEAR(line.now().torque, -0.5, 0.05);
}

TEST(ReversedDrive, ChangesItsModeWhileItMoves) {
  ReversedLine line;
  const auto running = line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(800);
  for (const auto mode : {std::int8_t{9}, std::int8_t{10}, std::int8_t{8}}) {
    auto change = request(AxisCommand::kSetMode);
    change.mode = mode;
    EXPECT_EQ(line.ask(change).phase, RequestPhase::kDone) << static_cast<int>(mode);
    line.cycles(400);
    EXPECT_NEAR(line.now().velocity, 20.0, 0.5);
    EXPECT_NEAR(line.shaft_velocity(), -20.0, 0.5);
  }
  EXPECT_EQ(line.phase(running), RequestPhase::kReached);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(ReversedDrive, HomingIsThatOfTheDrive) {
  auto options = reversed_options();
  // To the next index pulse in the negative direction of the drive.
  options.startup.push_back({0x6098, 0, {std::byte{33}}});
  ReversedLine line(options);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.5)).phase, RequestPhase::kDone);
  const auto homing = line.submit(request(AxisCommand::kHome));
  double fastest = 0.0;
  for (int i = 0; i < 60'000 && !line.axes().report(homing).over(); ++i) {
    line.cycle();
    fastest = std::max(fastest, line.now().velocity);
  }
  EXPECT_EQ(line.phase(homing), RequestPhase::kDone);
  EXPECT_GT(fastest, 0.5) << "the axis counts upwards meanwhile";
  line.cycles(800);
  EXPECT_NEAR(line.shaft(), -kReversedTurn, 0.2);
  EXPECT_NEAR(line.now().position, 0.0, 0.2);
  EXPECT_EQ(line.ask(move(1.0)).phase, RequestPhase::kDone);
  line.cycles(800);
  EXPECT_NEAR(line.shaft(), -kReversedTurn - 1.0, 0.05);
}

TEST(ReversedDrive, MovesByTheProfileGeneratorOfItsDrive) {
  ReversedLine line;
  EXPECT_EQ(line.finish(line.submit(request(AxisCommand::kDriveMoveAbsolute, 2.0)), 60'000).phase, RequestPhase::kDone);
  line.cycles(400);
  EXPECT_NEAR(line.now().position, 2.0, 0.05);
  EXPECT_NEAR(line.shaft(), -2.0, 0.05);
}

}  // namespace
}  // namespace driveline::bus_test
