// MC_Home: homing by the drives as seen by the master, with every method of the simulated drives.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "driveline/slaves/msd/core/variant.hpp"
#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Input;
using slaves::msd::MachineSwitch;
using slaves::msd::Variant;

constexpr double kHomingTurn = 6.283185307179586;
constexpr double kHomingEndless = std::numeric_limits<double>::infinity();
constexpr double kHomingLimit = 4.3;     ///< revolutions: limit switches beyond, on either side
constexpr double kHomingEdge = 1.3;      ///< home switch of methods 3 to 6, from here outwards
constexpr double kHomingCamLeft = 0.6;   ///< cam of methods 7 to 14
constexpr double kHomingCamRight = 1.7;  ///< its other end
/// An offset away from the limit switches.
constexpr std::int32_t home_offset(int method) {
  return method == 2 || method == 18 ? -12345 : 12345;
}
constexpr double kSlowSearch = 0.2;  ///< rev/s

struct Homing {
  int method;
  double home;  ///< revolutions; index pulses are at whole ones
  double tolerance = 3e-6;
};

/// An edge is found within a control cycle of the slow search.
constexpr double kEdgeTolerance = 1.5 * kSlowSearch * 62.5e-6;

/// Home positions of the methods of CiA 402 on this machine.
const std::vector<Homing>& homings() {
  static const std::vector kHomings = {
      Homing{1, -4.0}, Homing{2, 4.0}, Homing{3, 1.0}, Homing{4, 2.0}, Homing{5, -1.0}, Homing{6, -2.0}, Homing{7, 0.0},
      Homing{8, 1.0}, Homing{9, 1.0}, Homing{10, 2.0}, Homing{11, 2.0}, Homing{12, 1.0}, Homing{13, 1.0},
      Homing{14, 0.0}, Homing{17, -kHomingLimit, kEdgeTolerance}, Homing{18, kHomingLimit, kEdgeTolerance},
      Homing{19, kHomingEdge, kEdgeTolerance}, Homing{20, kHomingEdge, kEdgeTolerance},
      Homing{21, -kHomingEdge, kEdgeTolerance}, Homing{22, -kHomingEdge, kEdgeTolerance},
      Homing{23, kHomingCamLeft, kEdgeTolerance}, Homing{24, kHomingCamLeft, kEdgeTolerance},
      Homing{25, kHomingCamRight, kEdgeTolerance}, Homing{26, kHomingCamRight, kEdgeTolerance},
      Homing{27, kHomingCamRight, kEdgeTolerance}, Homing{28, kHomingCamRight, kEdgeTolerance},
      Homing{29, kHomingCamLeft, kEdgeTolerance}, Homing{30, kHomingCamLeft, kEdgeTolerance}, Homing{33, 0.0},
      Homing{34, 1.0},
      // At the present position, within increments and position loop errors.
      Homing{35, 0.2, 1e-4}, Homing{37, 0.2, 1e-4}};
  return kHomings;
}

std::vector<MachineSwitch> switches_for(int method) {
  std::vector<MachineSwitch> switches{{Input::kIsd00, -kHomingEndless, -kHomingLimit * kHomingTurn},
                                      {Input::kIsd01, kHomingLimit * kHomingTurn, kHomingEndless}};
  const int number = method > 16 && method < 31 ? method - 16 : method;
  if (number == 3 || number == 4) {
    switches.push_back({Input::kIsd02, kHomingEdge * kHomingTurn, kHomingEndless});
  } else if (number == 5 || number == 6) {
    switches.push_back({Input::kIsd02, -kHomingEndless, -kHomingEdge * kHomingTurn});
  } else {
    switches.push_back({Input::kIsd02, kHomingCamLeft * kHomingTurn, kHomingCamRight * kHomingTurn});
  }
  return switches;
}

RunOptions homing_options(int method, Variant variant = Variant::kMsd) {
  auto options = single_options();
  options.variant = variant;
  const auto per_s = [](double revolutions) { return static_cast<std::uint32_t>(revolutions * 1048576.0); };
  set_object<std::uint16_t>(options, 0x2065, 0, 6);   // ISD00: negative limit switch
  set_object<std::uint16_t>(options, 0x2066, 0, 5);   // ISD01: positive limit switch
  set_object<std::uint16_t>(options, 0x2067, 0, 10);  // ISD02: reference switch
  set_object<std::int8_t>(options, 0x6098, 0, static_cast<std::int8_t>(method));
  set_object<std::int32_t>(options, 0x607C, 0, home_offset(method));
  set_object<std::uint32_t>(options, 0x6099, 1, per_s(4.0));
  set_object<std::uint32_t>(options, 0x6099, 2, per_s(kSlowSearch));
  set_object<std::uint32_t>(options, 0x609A, 0, per_s(100.0));
  return options;
}

class HomingLine : public SingleLine {
 public:
  explicit HomingLine(int method = 24, Variant variant = Variant::kMsd)
      : HomingLine(homing_options(method, variant), method) {}
  HomingLine(const RunOptions& options, int method) : SingleLine(1, options, switches_for(method), 0.2 * kHomingTurn) {}

  [[nodiscard]] double revolutions() { return drives.drive(0).position_rad() / kHomingTurn; }
  [[nodiscard]] motion::AxisReport now() { return axes().axis_report(0); }
  RequestReport home() { return finish(submit(request(AxisCommand::kHome)), 400'000); }
  /// Starts homing and waits until the axis moves.
  std::uint64_t home_under_way() {
    const auto id = submit(request(AxisCommand::kHome));
    cycles(1000);
    EXPECT_EQ(phase(id), RequestPhase::kActive);
    EXPECT_EQ(state(), PlcopenState::kHoming);
    EXPECT_GT(std::abs(now().velocity), 1.0);
    return id;
  }
  /// Expects that the axis is usable.
  void expect_use() {
    cycles(100);
    EXPECT_EQ(now().mode, 8);
    EXPECT_EQ(ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
  }
};

class EveryHoming : public testing::TestWithParam<std::tuple<Homing, Variant>> {};

TEST_P(EveryHoming, MakesItsZeroThatOfTheAxis) {
  const auto& [homing, variant] = GetParam();
  Enabled<HomingLine> line(homing.method, variant);
  EXPECT_EQ(line.ask(request(AxisCommand::kSetPosition, 77.0)).phase, RequestPhase::kDone);
  const auto done = line.home();
  ASSERT_EQ(done.phase, RequestPhase::kDone) << to_text(done.error);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_EQ(line.now().mode, 8);
  EXPECT_EQ(line.drives.drive(0).fault(), std::nullopt);
  // Zero is home plus offset, and earlier positions are forgotten.
  const double zero = homing.home + home_offset(homing.method) / 1048576.0;
  EXPECT_NEAR(line.now().position / kHomingTurn, line.revolutions() - zero, homing.tolerance + 2e-5);
  EXPECT_NEAR(line.setpoint(), line.now().position, 1e-3);
  line.cycles(100);
  EXPECT_NEAR(line.now().velocity, 0.0, 0.3) << "nothing has moved it";
  EXPECT_EQ(line.ask(move(0.0)).phase, RequestPhase::kDone);
  line.cycles(2000);
  EXPECT_NEAR(line.revolutions(), zero, homing.tolerance + 2e-5);
  line.expect_obedience();
}

INSTANTIATE_TEST_SUITE_P(OfDrives, EveryHoming,
                         testing::Combine(testing::ValuesIn(homings()),
                                          testing::Values(Variant::kMsd, Variant::kServoOne)),
                         [](const auto& row) {
                           return "Method" + std::to_string(std::get<0>(row.param).method) +
                                  (std::get<1>(row.param) == Variant::kMsd ? "Msd" : "ServoOne");
                         });

TEST(DriveHoming, TheResultOfTheOneBeforeIsNotTaken) {
  Enabled<HomingLine> line(8);
  ASSERT_EQ(line.home().phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(move(-6.0)).phase, RequestPhase::kDone);
  const double before = line.revolutions();
  ASSERT_EQ(line.home().phase, RequestPhase::kDone);
  EXPECT_GT(line.revolutions(), before + 0.5) << "it has gone to the switch again";
  line.expect_obedience();
}

TEST(DriveHoming, InEveryCyclicModeComesBackToIt) {
  for (const auto mode : {std::int8_t{9}, std::int8_t{10}}) {
    Enabled<HomingLine> line(24);
    auto change = request(AxisCommand::kSetMode);
    change.mode = mode;
    ASSERT_EQ(line.ask(change).phase, RequestPhase::kDone);
    line.cycles(100);
    ASSERT_EQ(line.home().phase, RequestPhase::kDone);
    EXPECT_EQ(line.now().mode, mode);
    auto soft = move(0.0);
    soft.acceleration_si = 600.0;
    EXPECT_EQ(line.ask(soft).phase, RequestPhase::kDone);
    line.cycles(2000);
    EXPECT_NEAR(line.revolutions(), kHomingCamLeft + home_offset(24) / 1048576.0, 0.01);
    line.expect_obedience();
  }
}

TEST(DriveHoming, BeginsAtAStandstillAndNothingElseBeginsMeanwhile) {
  HomingLine line(24);
  EXPECT_EQ(line.ask(request(AxisCommand::kHome)).error, AxisError::kNotEnabled);
  line.enable();
  line.submit(request(AxisCommand::kMoveVelocity, 1.0));
  line.cycles(100);
  EXPECT_EQ(line.ask(request(AxisCommand::kHome)).error, AxisError::kNotAtRest);
  ASSERT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  const auto homing = line.home_under_way();
  for (const auto command : {AxisCommand::kHome, AxisCommand::kHalt, AxisCommand::kMoveAbsolute, AxisCommand::kTorque,
                             AxisCommand::kSetMode, AxisCommand::kSetPosition})
    EXPECT_EQ(line.ask(request(command)).error, AxisError::kNotAtRest) << to_text(command);
  EXPECT_EQ(line.finish(homing, 400'000).phase, RequestPhase::kDone);
  line.expect_use();
}

TEST(DriveHoming, AStopInterruptsIt) {
  Enabled<HomingLine> line(17);
  const auto homing = line.home_under_way();
  const auto stop = line.submit(request(AxisCommand::kStop));
  line.cycles(2);
  EXPECT_EQ(line.phase(homing), RequestPhase::kAborted);
  EXPECT_EQ(line.state(), PlcopenState::kStopping);
  EXPECT_EQ(line.finish(stop).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.now().velocity, 0.0, 0.3);
  EXPECT_EQ(line.state(), PlcopenState::kStopping) << "until it is released";
  EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  line.expect_use();
  EXPECT_EQ(line.home().phase, RequestPhase::kDone) << "again";
  line.expect_obedience();
}

/// At every point of the sequence, also during the changes of mode.
TEST(DriveHoming, AStopAtAnyMomentLeavesTheAxisAtRest) {
  for (const int moment : {0, 1, 2, 5, 9, 10, 12, 14, 20, 40}) {
    SCOPED_TRACE(moment);
    Enabled<HomingLine> line(35);
    line.submit(request(AxisCommand::kHome));
    line.cycles(moment);
    EXPECT_EQ(line.ask(request(AxisCommand::kStop)).phase, RequestPhase::kDone);
    EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop)).phase, RequestPhase::kDone);
    line.expect_use();
    line.expect_obedience();
  }
}

TEST(DriveHoming, SwitchedOffMeanwhileItComesToRestFirst) {
  Enabled<HomingLine> line(17);
  const auto homing = line.home_under_way();
  EXPECT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(homing), RequestPhase::kAborted);
  EXPECT_EQ(line.state(), PlcopenState::kDisabled);
  line.expect_obedience();
  line.enable();
  line.expect_use();
}

/// After a failure the axis is reset, enabled in its cyclic mode, and homed again.
void expect_recovery(HomingLine& line) {
  line.cycles(20'000);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
  line.enable();
  line.expect_use();
}

TEST(DriveHoming, AFaultOfTheDriveEndsIt) {
  Enabled<HomingLine> line(17);
  const auto homing = line.home_under_way();
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish(homing).error, AxisError::kFault);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  expect_recovery(line);
  EXPECT_EQ(line.home().phase, RequestPhase::kDone);
}

TEST(DriveHoming, ADriveThatFindsNoHomeSaysSo) {
  auto options = homing_options(19);
  set_object<std::uint16_t>(options, 0x2067, 0, 0);  // the reference switch is not connected
  Enabled<HomingLine> line(options, 19);
  const auto failed = line.home();
  EXPECT_EQ(failed.phase, RequestPhase::kError);
  EXPECT_EQ(failed.error, AxisError::kHoming);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  EXPECT_EQ(line.now().error_code, 0x8600);
}

TEST(DriveHoming, ADriveThatDoesNotFindItInTimeIsStopped) {
  auto options = homing_options(17);
  options.homing_timeout = milliseconds{200};
  Enabled<HomingLine> line(options, 17);
  EXPECT_EQ(line.home().error, AxisError::kHomingTimeout);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  expect_recovery(line);
}

TEST(DriveHoming, SingleLostFramesAreNoMatter) {
  Enabled<HomingLine> line(24);
  const auto homing = line.submit(request(AxisCommand::kHome));
  for (int cycle = 0; cycle < 400'000 && !line.axes().report(homing).over(); ++cycle) {
    line.lose_out = cycle % 5 == 1;
    line.lose_back = cycle % 7 == 1;
    line.cycle();
  }
  line.lose_out = line.lose_back = false;
  EXPECT_EQ(line.phase(homing), RequestPhase::kDone);
  const double zero = kHomingCamLeft + home_offset(24) / 1048576.0;
  EXPECT_NEAR(line.now().position / kHomingTurn, line.revolutions() - zero, kEdgeTolerance + 2e-5);
  line.expect_use();
}

TEST(DriveHoming, LostCommunicationEndsIt) {
  Enabled<HomingLine> line(17);
  const auto homing = line.home_under_way();
  lose_inputs(line, 20);
  EXPECT_EQ(line.axes().report(homing).error, AxisError::kLost);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  expect_recovery(line);
}

TEST(DriveHoming, AnAbsenceOfTheMasterEndsIt) {
  Enabled<HomingLine> line(17);
  const auto homing = line.home_under_way();
  line.stall(5);
  EXPECT_EQ(line.phase(homing), RequestPhase::kActive);
  line.stall(9);
  EXPECT_EQ(line.axes().report(homing).error, AxisError::kMasterAway);
  expect_recovery(line);
}

TEST(DriveHoming, AModeThatTheDriveDoesNotHaveIsRefused) {
  auto options = homing_options(24);
  options.supported_modes = 0x03E7U & ~(1U << 5U) & ~(1U << 9U);  // no hm, no cst
  Enabled<HomingLine> line(options, 24);
  EXPECT_EQ(line.ask(request(AxisCommand::kHome)).error, AxisError::kNoSuchMode);
  EXPECT_EQ(line.ask(request(AxisCommand::kTorque)).error, AxisError::kNoSuchMode);
  auto change = request(AxisCommand::kSetMode);
  change.mode = 10;
  EXPECT_EQ(line.ask(change).error, AxisError::kNoSuchMode);
  change.mode = 9;
  EXPECT_EQ(line.ask(change).phase, RequestPhase::kDone);
}

}  // namespace
}  // namespace driveline::bus_test
