// Interpolated position mode (6060h = 7) as a mode in which a drive follows the setpoints of the master.
#include <gmock/gmock.h>

#include <cstdint>
#include <string>

#include "driveline/slaves/msd/core/variant.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Variant;

RunOptions interpolated_options(Variant variant = Variant::kMsd) {
  auto options = single_options();
  options.variant = variant;
  options.pdos = motion::PdoConfiguration{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}},
                                           {0x1601, {{0x60FF, 0, 32}, {0x60C1, 1, 32}}},
                                           {0x1602, {{0x6071, 0, 16}, {0x60B1, 0, 32}, {0x60B2, 0, 16}}}},
                                          {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
                                           {0x1A01, {{0x606C, 0, 32}, {0x60F4, 0, 32}}},
                                           {0x1A02, {{0x6077, 0, 16}, {0x603F, 0, 16}}}}};
  return options;
}

AxisRequest into(std::int8_t mode) {
  auto made = request(AxisCommand::kSetMode);
  made.mode = mode;
  return made;
}

class InterpolatedLine : public SingleLine {
 public:
  explicit InterpolatedLine(const RunOptions& options = interpolated_options()) : SingleLine(1, options) { enable(); }
  [[nodiscard]] motion::AxisReport now() { return axes().axis_report(0); }
  /// Bit 12 of the status word: the drive interpolates (MSD manual Table 11.9).
  [[nodiscard]] bool interpolates() { return (axes().axes()[0].inputs().status_word & 0x1000U) != 0; }
};

class EveryInterpolation : public testing::TestWithParam<Variant> {};

TEST_P(EveryInterpolation, FollowsTheSetpointsFromCspAndBackAlsoWhileTheAxisMoves) {
  InterpolatedLine line(interpolated_options(GetParam()));
  EXPECT_EQ(line.ask(into(7)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.now().mode, 7);
  line.cycles(20);
  EXPECT_TRUE(line.interpolates());
  EXPECT_EQ(line.ask(move(5.0)).phase, RequestPhase::kDone);
  line.cycles(400);
  EXPECT_NEAR(line.now().position, 5.0, 0.01);
  line.submit(request(AxisCommand::kMoveVelocity, -20.0));
  for (const auto mode : {std::int8_t{8}, std::int8_t{7}, std::int8_t{8}, std::int8_t{7}}) {
    line.cycles(400);
    EXPECT_EQ(line.ask(into(mode)).phase, RequestPhase::kDone);
    line.cycles(100);
    EXPECT_EQ(line.now().mode, mode);
    EXPECT_NEAR(line.now().velocity, -20.0, 0.5);
  }
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  line.enable();
  EXPECT_EQ(line.now().mode, 7) << "it keeps the mode";
  EXPECT_EQ(line.ask(move(0.0)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EveryInterpolation, testing::Values(Variant::kMsd, Variant::kServoOne),
                         [](const auto& row) { return std::string(row.param == Variant::kMsd ? "Msd" : "ServoOne"); });

TEST(InterpolatedPosition, AnAxisMayBeginInIt) {
  auto options = interpolated_options();
  options.mode = motion::cia402::Mode::kInterpolatedPosition;
  InterpolatedLine line(options);
  EXPECT_EQ(line.now().mode, 7);
  EXPECT_EQ(line.ask(move(3.0)).phase, RequestPhase::kDone);
  line.cycles(400);
  EXPECT_NEAR(line.now().position, 3.0, 0.01);
  line.expect_obedience();
}

TEST(InterpolatedPosition, TheFollowingErrorIsThatOfItsSetpoints) {
  InterpolatedLine line;
  EXPECT_EQ(line.ask(into(7)).phase, RequestPhase::kDone);
  line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(1500);
  const auto& axis = line.axes().axes()[0];
  EXPECT_NEAR(axis.following_error(), axis.inputs().drive_following_error, 2e-3);
  EXPECT_LT(std::abs(axis.following_error()), 5e-3);
}

TEST(InterpolatedPosition, SingleLostFramesAreNoMatter) {
  InterpolatedLine line;
  EXPECT_EQ(line.ask(into(7)).phase, RequestPhase::kDone);
  const auto way = line.submit(move(8.0));
  for (int cycle = 0; cycle < 20'000 && !line.axes().report(way).over(); ++cycle) {
    line.lose_out = cycle % 37 == 1;
    line.lose_back = cycle % 41 == 1;
    line.cycle();
  }
  line.lose_out = line.lose_back = false;
  EXPECT_EQ(line.phase(way), RequestPhase::kDone);
  line.cycles(400);
  EXPECT_NEAR(line.now().position, 8.0, 0.01);
  for (const auto& judge : line.judges) judge.expect_obedience(1.25);
}

TEST(InterpolatedPosition, AFaultEndsItsMotionAndItKeepsTheMode) {
  InterpolatedLine line;
  EXPECT_EQ(line.ask(into(7)).phase, RequestPhase::kDone);
  const auto running = line.submit(request(AxisCommand::kMoveVelocity, 10.0));
  line.cycles(1000);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(running).error, AxisError::kFault);
  line.cycles(8000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable();
  EXPECT_EQ(line.now().mode, 7);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
}

TEST(InterpolatedPosition, HasNoWayButToCsp) {
  InterpolatedLine line;
  EXPECT_EQ(line.ask(into(9)).phase, RequestPhase::kDone);
  line.cycles(100);
  EXPECT_EQ(line.ask(into(7)).error, AxisError::kMode) << "from a loop of the master";
  EXPECT_EQ(line.ask(into(8)).phase, RequestPhase::kDone);
  line.cycles(400);
  EXPECT_EQ(line.ask(into(7)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(into(10)).error, AxisError::kMode);
  for (const auto command : {AxisCommand::kHome, AxisCommand::kTorque, AxisCommand::kDriveMoveAbsolute})
    EXPECT_EQ(line.ask(request(command)).error, AxisError::kMode) << to_text(command);
  EXPECT_EQ(line.now().mode, 7);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
}

TEST(InterpolatedPosition, IsRefusedWithoutItsObjectOrByADriveThatDoesNotHaveIt) {
  Enabled<SingleLine> without;
  EXPECT_EQ(without.ask(into(7)).error, AxisError::kMode) << "60C1h:01 is not mapped";
  auto options = interpolated_options();
  options.supported_modes = 0x03E7U & ~(1U << 6U);
  InterpolatedLine line(options);
  EXPECT_EQ(line.ask(into(7)).error, AxisError::kNoSuchMode);
}

}  // namespace
}  // namespace driveline::bus_test
