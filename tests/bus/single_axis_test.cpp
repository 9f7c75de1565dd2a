// Axes commanded individually: states and requests named as in PLCopen, and the demands of the drives meanwhile.
#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "single_line.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Forth and back, at up to 24 rad/s and 380 rad/s^2, from any start.
class SwingFeed final : public motion::SetpointFeed {
 public:
  [[nodiscard]] std::size_t axis_count() const noexcept override { return 1; }
  void join(std::size_t /*axis*/, const trajectory::AxisSetpoint& from) noexcept override { middle_ = from.position; }
  void leave(std::size_t /*axis*/) noexcept override {}
  [[nodiscard]] bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept override {
    constexpr double kAmplitude = 1.5;
    constexpr double kOmega = 16.0;
    time_s_ += period_s;
    const double phase = kOmega * time_s_;
    at_ = {middle_ + kAmplitude * (1.0 - std::cos(phase)), kAmplitude * kOmega * std::sin(phase),
           kAmplitude * kOmega * kOmega * std::cos(phase)};
    setpoints[0] = at_;
    return true;
  }
  [[nodiscard]] const trajectory::AxisSetpoint& at() const noexcept { return at_; }

 private:
  double middle_ = 0.0;
  double time_s_ = 0.0;
  trajectory::AxisSetpoint at_{};
};

TEST(SingleAxis, IsEnabledMovedAndSwitchedOff) {
  SingleLine line;
  EXPECT_EQ(line.state(), PlcopenState::kDisabled);
  line.enable();
  const double from = line.setpoint();
  const auto id = line.submit(move(from + 3.0, 20.0));
  line.cycles(4);
  EXPECT_EQ(line.phase(id), RequestPhase::kActive);
  EXPECT_EQ(line.state(), PlcopenState::kDiscreteMotion);
  EXPECT_EQ(line.finish(id).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_NEAR(line.setpoint(), from + 3.0, 1e-12);
  line.cycles(400);
  EXPECT_NEAR(line.axes().axis_report(0).position, from + 3.0, 0.01);
  EXPECT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kDisabled);
  line.expect_obedience();
}

TEST(SingleAxis, WaitsForABrakeThatOpens) {
  constexpr float kOpensMs = 50.0F;  // P 213
  constexpr int kOpensCycles = 400;
  for (const bool waits : {true, false}) {
    auto options = single_options();
    set_object(options, 0x20D5, 0, std::bit_cast<std::uint32_t>(kOpensMs));
    options.follow_bit = waits;
    SingleLine line(1, options);
    line.submit(power(true));
    for (int i = 0; i < 8000 && line.axes().axes()[0].inputs().state != snapshot::AxisState::kOperationEnabled; ++i)
      line.cycle();
    int cycles = 0;
    for (; line.state() != PlcopenState::kStandstill && cycles < 10 * kOpensCycles; ++cycles) line.cycle();
    EXPECT_EQ(cycles >= kOpensCycles - 8, waits) << cycles;
    EXPECT_LT(cycles, kOpensCycles + 80);
    if (!waits) continue;
    const double from = line.setpoint();
    EXPECT_EQ(line.ask(move(from + 3.0, 20.0)).phase, RequestPhase::kDone);
    line.expect_obedience();
  }
}

TEST(SingleAxis, OneMovesWhileTheOthersStandOrAreOff) {
  SingleLine line(3);
  line.enable(0);
  line.enable(2);
  const double other = line.setpoint(2);
  const double off = line.axes().axis_report(1).position;
  EXPECT_EQ(line.ask(move(line.setpoint(0) + 1.0), 0).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(1), PlcopenState::kDisabled);
  EXPECT_EQ(line.state(2), PlcopenState::kStandstill);
  EXPECT_EQ(line.setpoint(2), other);
  EXPECT_NEAR(line.axes().axis_report(1).position, off, 1e-3);
}

TEST(SingleAxis, RequestsAreRefusedWithTheReason) {
  SingleLine line;
  const auto refused = [&line](const AxisRequest& asked) {
    const auto report = line.ask(asked);
    EXPECT_EQ(report.phase, RequestPhase::kError) << to_text(asked.command);
    return report.error;
  };
  EXPECT_EQ(refused(move(1.0)), AxisError::kNotEnabled);
  EXPECT_EQ(refused(request(AxisCommand::kHalt)), AxisError::kNotEnabled);
  line.enable();
  const double from = line.setpoint();
  EXPECT_EQ(refused(move(kNaN)), AxisError::kNotFinite);
  EXPECT_EQ(refused(move(1.0, -1.0)), AxisError::kNotFinite);
  EXPECT_EQ(refused(move(1.0, 51.0)), AxisError::kOverLimit);
  EXPECT_EQ(refused(request(AxisCommand::kMoveVelocity, 50.1)), AxisError::kOverLimit);
  auto hard = move(1.0);
  hard.acceleration_si = 1001.0;
  EXPECT_EQ(refused(hard), AxisError::kOverLimit);
  hard.acceleration_si = 0.0;
  hard.deceleration_si = 1001.0;
  EXPECT_EQ(refused(hard), AxisError::kOverLimit);
  EXPECT_EQ(refused(request(AxisCommand::kSetOverride, 2.1)), AxisError::kOverLimit);
  EXPECT_EQ(refused(request(AxisCommand::kSetOverride, -0.1)), AxisError::kOverLimit);
  EXPECT_EQ(refused(request(AxisCommand::kReleaseStop)), AxisError::kNothingToDo);
  EXPECT_EQ(refused(request(AxisCommand::kFollow)), AxisError::kNothingToDo);
  EXPECT_EQ(line.setpoint(), from);
  EXPECT_EQ(line.submit(move(1.0), 7), 0U) << "no such axis";
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
}

TEST(SingleAxis, ABufferedMotionIsTakenWhileItWaitsForItsTurn) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  const auto first = line.submit(move(from + 20.0, 30.0));
  line.cycles(400);
  const auto second = line.submit(move(from + 21.0, 20.0, BufferMode::kBuffered));
  EXPECT_FALSE(line.axes().taken(second));
  line.cycles(2);
  EXPECT_TRUE(line.axes().taken(second));
  EXPECT_EQ(line.phase(second), RequestPhase::kWaiting);
  EXPECT_EQ(line.phase(first), RequestPhase::kActive);
}

TEST(SingleAxis, ANewMotionReplacesTheOneUnderWayWithoutAStep) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  const auto first = line.submit(move(from + 20.0, 50.0));
  line.cycles(1500);
  const auto second = line.submit(move(from - 5.0, 30.0));
  line.cycles(2);
  EXPECT_EQ(line.phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.finish(second, 20000).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from - 5.0, 1e-12);
  line.expect_obedience();
}

TEST(SingleAxis, ManyMotionsAtOnceArePlannedFourInACycle) {
  SingleLine line(6);
  for (std::size_t i = 0; i < 6; ++i) line.enable(i);
  const auto before = line.submit(move(line.setpoint(5) + 20.0, 50.0), 5);
  line.cycles(1000);
  std::vector<std::uint64_t> asked;
  for (std::size_t i = 0; i < 6; ++i) asked.push_back(line.submit(move(line.setpoint(i) - 3.0, 30.0), i));
  const auto active = [&] {
    return std::count_if(asked.begin(), asked.end(),
                         [&](std::uint64_t id) { return line.phase(id) == RequestPhase::kActive; });
  };
  line.cycle();
  EXPECT_EQ(active(), 4);
  EXPECT_EQ(line.phase(before), RequestPhase::kActive) << "its axis goes on meanwhile";
  line.cycle();
  EXPECT_EQ(active(), 6);
  EXPECT_EQ(line.phase(before), RequestPhase::kAborted);
  for (const auto id : asked) EXPECT_EQ(line.finish(id, 20000).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(SingleAxis, AStopFindsRoomBesideAFloodOfOtherRequests) {
  SingleLine line(2);
  line.enable(0);
  const auto jog = line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(1000);
  EXPECT_EQ(line.phase(jog), RequestPhase::kReached);
  int flood = 0;
  while (line.submit(request(AxisCommand::kSetOverride, 1.0), 1) != 0 && flood < 10'000) ++flood;
  EXPECT_LT(flood, 10'000);
  const auto stop = line.submit(request(AxisCommand::kStop));
  EXPECT_NE(stop, 0U);
  line.cycle();
  EXPECT_EQ(line.state(), PlcopenState::kStopping) << "whatever was asked for before it";
  EXPECT_EQ(line.finish(stop).phase, RequestPhase::kDone);
  line.expect_obedience();
}

/// The request of a conveyor lasts for days, and others come to its slot in the table of reports.
TEST(SingleAxis, AnAxisThatRunsOnTakesNoReportFromAnother) {
  SingleLine line(2);
  line.enable(0);
  line.enable(1);
  const auto conveyor = line.submit(request(AxisCommand::kMoveVelocity, 1.0));
  EXPECT_EQ(line.finish(conveyor, 400).phase, RequestPhase::kReached);
  for (auto last = conveyor; last + 1 < conveyor + motion::RequestTable::kRemembered;) {
    const auto id = line.submit(request(AxisCommand::kSetOverride, 1.0), 1);
    if (id == 0) {
      line.cycle();
    } else {
      last = id;
    }
  }
  line.cycles(200);
  const auto next = line.submit(move(line.setpoint(1) + 0.1), 1);
  line.cycle();
  EXPECT_EQ(line.phase(next), RequestPhase::kActive);
  EXPECT_EQ(line.phase(conveyor), RequestPhase::kReached);
  EXPECT_EQ(line.finish(next).phase, RequestPhase::kDone);
}

TEST(SingleAxis, BufferedMotionsFollowOneAnother) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  const auto first = line.submit(move(from + 1.0));
  const auto second = line.submit(move(from + 2.0, 10.0, BufferMode::kBuffered));
  const auto third = line.submit(move(from, 10.0, BufferMode::kBuffered));
  line.cycles(2);
  EXPECT_EQ(line.phase(first), RequestPhase::kActive);
  EXPECT_EQ(line.phase(second), RequestPhase::kWaiting);
  EXPECT_EQ(line.finish(first).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 1.0, 1e-3);
  EXPECT_EQ(line.finish(second).phase, RequestPhase::kDone);
  EXPECT_EQ(line.finish(third).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from, 1e-12);
  line.expect_obedience();
}

TEST(SingleAxis, NineWaitingMotionsAreTooMany) {
  Enabled<SingleLine> line;
  line.submit(move(line.setpoint() + 100.0));
  std::vector<std::uint64_t> waiting;
  for (int i = 0; i < 9; ++i) waiting.push_back(line.submit(move(i, 10.0, BufferMode::kBuffered)));
  line.cycles(2);
  line.cycles(2);
  EXPECT_EQ(line.phase(waiting[7]), RequestPhase::kWaiting);
  EXPECT_EQ(line.axes().report(waiting[8]).error, AxisError::kBufferFull);
  // An aborting motion removes all waiting ones.
  line.submit(request(AxisCommand::kHalt));
  line.cycles(2);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(line.phase(waiting[static_cast<std::size_t>(i)]), RequestPhase::kAborted);
}

/// The velocity at which the setpoint passes a position.
double velocity_at(SingleLine& line, double place, std::uint64_t last) {
  double before = line.setpoint();
  while (!line.axes().report(last).over()) {
    line.cycle();
    const double now = line.setpoint();
    if ((before < place) != (now < place)) return (now - before) / 125e-6;
    before = now;
  }
  ADD_FAILURE() << "it never got there";
  return 0.0;
}

TEST(SingleAxis, BlendedMotionsPassTheEndOfTheFirstAtAVelocity) {
  const auto passing = [](BufferMode mode, double first_velocity, double second_velocity) {
    Enabled<SingleLine> line;
    const double from = line.setpoint();
    line.submit(move(from + 10.0, first_velocity));
    const auto second = line.submit(move(from + 20.0, second_velocity, mode));
    const double velocity = velocity_at(line, from + 10.0, second);
    EXPECT_EQ(line.finish(second, 20000).phase, RequestPhase::kDone);
    EXPECT_NEAR(line.setpoint(), from + 20.0, 1e-12);
    line.expect_obedience();
    return velocity;
  };
  EXPECT_LT(passing(BufferMode::kBuffered, 30.0, 10.0), 0.2);
  EXPECT_NEAR(passing(BufferMode::kBlendingLow, 30.0, 10.0), 10.0, 0.2);
  EXPECT_NEAR(passing(BufferMode::kBlendingPrevious, 30.0, 10.0), 30.0, 0.2);
  EXPECT_NEAR(passing(BufferMode::kBlendingLow, 10.0, 30.0), 10.0, 0.2);
}

TEST(SingleAxis, ABlendedMotionThatTurnsRoundStopsInBetween) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  line.submit(move(from + 5.0, 30.0));
  const auto back = line.submit(move(from, 30.0, BufferMode::kBlendingPrevious));
  double highest = from;
  while (!line.axes().report(back).over()) {
    line.cycle();
    highest = std::max(highest, line.setpoint());
  }
  EXPECT_LE(highest, from + 5.0 + 1e-9);
  line.expect_obedience();
}

TEST(SingleAxis, ABlendedMotionIsNoFasterThanTheWayBehindItAllows) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  line.submit(move(from + 5.0, 30.0));
  const auto little = line.submit(move(from + 5.01, 30.0, BufferMode::kBlendingPrevious));
  double highest = from;
  while (!line.axes().report(little).over()) {
    line.cycle();
    highest = std::max(highest, line.setpoint());
  }
  EXPECT_LE(highest, from + 5.01 + 1e-9);
  line.expect_obedience();
}

TEST(SingleAxis, RunsAtAVelocityUntilItIsHalted) {
  Enabled<SingleLine> line;
  const auto running = line.submit(request(AxisCommand::kMoveVelocity, -20.0));
  line.cycles(2);
  EXPECT_EQ(line.state(), PlcopenState::kContinuousMotion);
  line.cycles(1000);
  EXPECT_EQ(line.phase(running), RequestPhase::kReached) << "in velocity";
  const double before = line.setpoint();
  line.cycles(80);
  EXPECT_NEAR(line.setpoint() - before, -20.0 * 80 * 125e-6, 1e-9);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(running), RequestPhase::kAborted);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  line.expect_obedience();
}

TEST(SingleAxis, AStopIsLockedUntilItIsReleased) {
  Enabled<SingleLine> line;
  line.submit(request(AxisCommand::kMoveVelocity, 30.0));
  line.cycles(1000);
  const auto stop = line.submit(request(AxisCommand::kStop));
  line.cycles(2);
  EXPECT_EQ(line.state(), PlcopenState::kStopping);
  EXPECT_EQ(line.finish(stop).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kStopping) << "the request still stands";
  EXPECT_EQ(line.ask(move(0.0)).error, AxisError::kStopping);
  EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  EXPECT_EQ(line.ask(move(line.setpoint() + 1.0)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(SingleAxis, AnOverrideSlowsDownAndHolds) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  const auto way = line.submit(move(from + 10.0, 20.0));
  line.cycles(500);
  line.submit(request(AxisCommand::kSetOverride, 0.5));
  line.cycles(800);
  double before = line.setpoint();
  line.cycle();
  EXPECT_NEAR((line.setpoint() - before) / 125e-6, 10.0, 1e-3);
  line.submit(request(AxisCommand::kSetOverride, 0.0));
  line.cycles(800);
  before = line.setpoint();
  line.cycles(100);
  EXPECT_EQ(line.setpoint(), before);
  EXPECT_EQ(line.phase(way), RequestPhase::kActive) << "held, not done";
  line.submit(request(AxisCommand::kSetOverride, 1.0));
  EXPECT_EQ(line.finish(way, 20000).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 10.0, 1e-12);
  line.expect_obedience();
}

TEST(SingleAxis, RelativeAdditiveAndSuperimposedMotionsAddUp) {
  Enabled<SingleLine> line;
  const double from = line.setpoint();
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 2.0)).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 2.0, 1e-12);
  // Relative to the target, not to the present position.
  line.submit(move(from + 10.0, 20.0));
  line.cycles(400);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveAdditive, 1.0)).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 11.0, 1e-12);
  const auto base = line.submit(move(from + 20.0, 20.0));
  line.cycles(400);
  const auto on_top = line.submit(request(AxisCommand::kMoveSuperimposed, 0.5, 5.0));
  EXPECT_EQ(line.finish(base).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(on_top), RequestPhase::kDone);
  EXPECT_NEAR(line.setpoint(), from + 20.5, 1e-12);
  line.expect_obedience();
}

TEST(SingleAxis, APositionThatIsSetChangesTheNamesOfPlacesAndNothingElse) {
  Enabled<SingleLine> line;
  const auto before = line.axes().setpoints()[0].position;
  EXPECT_EQ(line.ask(request(AxisCommand::kSetPosition, 100.0)).phase, RequestPhase::kDone);
  line.cycle();
  EXPECT_NEAR(line.setpoint(), 100.0, 1e-12);
  EXPECT_EQ(line.axes().setpoints()[0].position, before);
  EXPECT_EQ(line.ask(move(101.0)).phase, RequestPhase::kDone);
  EXPECT_NEAR(line.axes().setpoints()[0].position, before + 1.0, 1e-12);
}

TEST(SingleAxis, AFaultOfOneDriveStopsItAndNoOther) {
  SingleLine line(2);
  line.enable(0);
  line.enable(1);
  const auto first = line.submit(request(AxisCommand::kMoveVelocity, 10.0), 0);
  line.submit(request(AxisCommand::kMoveVelocity, 10.0), 1);
  line.cycles(1000);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  line.cycles(100);
  EXPECT_EQ(line.state(0), PlcopenState::kErrorStop);
  EXPECT_EQ(line.axes().axis_report(0).error, AxisError::kFault);
  EXPECT_EQ(line.axes().report(first).error, AxisError::kFault);
  EXPECT_EQ(line.state(1), PlcopenState::kContinuousMotion);
  EXPECT_EQ(line.ask(power(true), 0).error, AxisError::kErrorStop);
  EXPECT_EQ(line.ask(request(AxisCommand::kReset), 0).phase, RequestPhase::kDone);
  EXPECT_EQ(line.state(0), PlcopenState::kDisabled);
  line.enable(0);
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0), 0).phase, RequestPhase::kDone);
}

TEST(SingleAxis, ChangesItsModeWhileItMoves) {
  Enabled<SingleLine> line;
  const auto running = line.submit(request(AxisCommand::kMoveVelocity, 20.0));
  line.cycles(800);
  for (const auto mode : {std::int8_t{9}, std::int8_t{10}, std::int8_t{8}}) {
    auto change = request(AxisCommand::kSetMode);
    change.mode = mode;
    EXPECT_EQ(line.ask(change).phase, RequestPhase::kDone) << static_cast<int>(mode);
    EXPECT_EQ(line.axes().axis_report(0).mode, mode);
    line.cycles(400);
    EXPECT_NEAR(line.axes().axis_report(0).velocity, 20.0, 0.5);
  }
  auto wrong = request(AxisCommand::kSetMode);
  wrong.mode = 6;
  EXPECT_EQ(line.ask(wrong).error, AxisError::kMode) << "homing is no cyclic mode";
  EXPECT_EQ(line.phase(running), RequestPhase::kReached) << "all the time";
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(SingleAxis, IsSwitchedOffAtRestOnly) {
  Enabled<SingleLine> line;
  line.submit(request(AxisCommand::kMoveVelocity, 40.0));
  line.cycles(1000);
  EXPECT_EQ(line.ask(power(false)).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(SingleAxis, PowerThatIsAskedForAgainOnTheWayToRestHalts) {
  Enabled<SingleLine> line;
  line.submit(request(AxisCommand::kMoveVelocity, 40.0));
  line.cycles(1000);
  const auto off = line.submit(power(false));
  line.cycles(40);
  EXPECT_EQ(line.ask(power(true)).phase, RequestPhase::kDone);
  EXPECT_EQ(line.phase(off), RequestPhase::kAborted);
  line.cycles(800);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
  line.expect_obedience();
  EXPECT_EQ(line.ask(request(AxisCommand::kMoveRelative, 1.0)).phase, RequestPhase::kDone);
}

TEST(SingleAxis, TooLongAnAbsenceOfTheMasterStopsIt) {
  Enabled<SingleLine> line;
  line.submit(request(AxisCommand::kMoveVelocity, 10.0));
  line.cycles(1000);
  line.stall(5);
  EXPECT_EQ(line.state(), PlcopenState::kContinuousMotion);
  line.stall(9);
  EXPECT_EQ(line.state(), PlcopenState::kErrorStop);
  EXPECT_EQ(line.axes().axis_report(0).error, AxisError::kMasterAway);
}

/// The outputs that switch the axis on may have been computed before the master was away.
TEST(SingleAxis, ThatCoastsIsToldWhereItIsThoughTheMasterWasAway) {
  constexpr double kStale = 4.0;  // periods of motion; the master was away for seven
  int switched_on = 0;
  for (int moment = 0; moment < 60; ++moment) {
    SCOPED_TRACE(moment);
    SingleLine line;
    auto& drive = line.drives.drive(0);
    line.enable();
    line.submit(request(AxisCommand::kMoveVelocity, 35.0));
    line.cycles(1000);
    drive.raise(slaves::msd::Fault::kOvercurrent);
    for (int i = 0; i < 4000 && line.state() != PlcopenState::kErrorStop; ++i) line.cycle();
    ASSERT_EQ(line.ask(request(AxisCommand::kReset)).phase, RequestPhase::kDone);
    ASSERT_GT(drive.velocity_rad_s(), 15.0) << "it coasts";
    line.submit(power(true));
    line.cycles(moment);
    const bool before = !drive.power_on();
    line.stall(7);
    for (int i = 0; i < 2000 && !drive.power_on(); ++i) line.cycle();
    if (!before) break;
    ASSERT_TRUE(drive.power_on());
    ++switched_on;
    const auto& values = drive.dictionary();
    const auto beside =
        values.get(slaves::msd::kValue.target_position) - values.get(slaves::msd::kValue.position_actual);
    EXPECT_LE(std::abs(beside) / kDemandIncrements, drive.velocity_rad_s() * kStale * 125e-6);
  }
  EXPECT_GT(switched_on, 2);
}

/// The master closes its loops, with a delay.
TEST(SingleAxis, FollowingInCstReturnsGentlyBehindAGap) {
  SwingFeed feed;
  auto options = single_options();
  options.mode = motion::cia402::Mode::kCyclicTorque;
  options.feed = &feed;
  Enabled<SingleLine> line(1, options);
  const auto followed = line.submit(request(AxisCommand::kFollow));
  line.cycles(2000);
  ASSERT_EQ(line.phase(followed), RequestPhase::kReached);
  for (const bool lost : {false, true}) {
    SCOPED_TRACE(lost ? "frames lost" : "periods missed");
    if (lost) {
      line.lose_back = line.lose_out = true;
      line.cycles(6);
      line.lose_back = line.lose_out = false;
    } else {
      line.stall(6);
    }
    // The first step starts at the position that the drive has reached on its own.
    line.cycle();
    double before[] = {line.setpoint(), feed.at().position};
    line.cycle();
    double velocity = line.setpoint() - before[0];
    double led = feed.at().position - before[1];
    EXPECT_NE(line.setpoint(), feed.at().position) << "the gap has led it away";
    int cycles = 0;
    for (; cycles < 4000 && std::abs(line.setpoint() - feed.at().position) > 0.0; ++cycles) {
      before[0] = line.setpoint();
      before[1] = feed.at().position;
      line.cycle();
      const double change = line.setpoint() - before[0] - std::exchange(velocity, line.setpoint() - before[0]);
      const double asked = feed.at().position - before[1] - std::exchange(led, feed.at().position - before[1]);
      ASSERT_LE(std::abs(change - asked), 150.0 * 125e-6 * 125e-6) << cycles;
    }
    EXPECT_LT(cycles, 4000) << "it comes back";
    line.cycles(500);
  }
}

}  // namespace
}  // namespace driveline::bus_test
