// Requests to the axes of a line: who may ask, what is refused, what becomes of those who are not heard any more.
#include "driveline/runtime/axes/axis_door.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "driveline/runtime/line.hpp"
#include "failure_of.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::AxisCommand;
using ecat_master::AxisConfig;
using ecat_master::AxisRequest;
using ecat_master::PlcopenState;
using std::chrono::milliseconds;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

AxisRequest ask(AxisCommand command, double target = 0.0) {
  AxisRequest request;
  request.command = command;
  request.target = target;
  return request;
}

AxisCaller caller(std::string name, std::optional<std::chrono::nanoseconds> keep_alive = std::nullopt) {
  AxisCaller caller;
  caller.name = std::move(name);
  caller.keep_alive = keep_alive;
  return caller;
}

/// A door before two axes in degrees whose cycle does not run: what is asked of them waits.
class AxisDoorTest : public testing::Test {
 protected:
  AxisDoorTest() {
    std::vector<ecat_master::Axis> made;
    for (const auto& config : configs) {
      made.emplace_back(config, ecat_master::ProcessDataPlace{}, ecat_master::axis_pdo_configuration());
    }
    single.emplace(std::move(made), ecat_master::SingleAxes::Settings{});
  }
  static AxisConfig config(const std::string& name, std::size_t slave) {
    AxisConfig axis;
    axis.name = name;
    axis.slave = slave;
    axis.limits = {10.0, 100.0};
    axis.unit = trajectory::find_position_unit("deg");
    return axis;
  }
  /// The sentences since the last time.
  std::vector<std::string> told() {
    std::vector<std::string> sentences;
    for (auto& facts : door.take_events()) sentences.push_back(describe(Event{std::move(facts)}));
    return sentences;
  }
  /// One cycle of the axes, without a line.
  void cycle() {
    std::vector<std::byte> image(256);
    single->update(++cycles, image);
  }
  std::string refusal(const AxisCaller& who, std::size_t axis, const AxisRequest& request) {
    const auto submitted = door.submit(who, axis, request);
    return submitted ? "" : describe(events::event_axis(configs[axis]), submitted.error());
  }

  std::vector<AxisConfig> configs{config("x", 0), config("y", 1)};
  rt::VirtualClock clock;
  int stops = 0;
  std::int64_t cycles = 0;
  AxisDoor door{configs, clock, [this] { ++stops; }};
  std::optional<ecat_master::SingleAxes> single;
};

TEST_F(AxisDoorTest, IsClosedUntilTheLineIsInOperation) {
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kHalt)), "axis x: the line is not in operation");
  door.open(*single);
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kHalt)), "");
  door.close();
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kHalt)), "axis x: the line is not in operation");
  EXPECT_FALSE(door.status(0).report);
}

TEST_F(AxisDoorTest, FindsAxesByName) {
  EXPECT_EQ(door.find("y"), 1U);
  EXPECT_FALSE(door.find("z"));
}

TEST_F(AxisDoorTest, RefusesNumbersThatCannotBeInTheUnitOfTheAxis) {
  door.open(*single);
  const auto who = caller("hand");
  auto fast = ask(AxisCommand::kMoveAbsolute, 1.0);
  fast.velocity = 20.0;
  EXPECT_EQ(refusal(who, 0, fast), "axis x: velocity 1145.92 deg/s is not possible, 0 deg/s to 572.958 deg/s are");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveVelocity, -20.0)),
            "axis x: velocity -1145.92 deg/s is not possible, -572.958 deg/s to 572.958 deg/s are");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kSetOverride, 3.0)), "axis x: override 3 is not possible, 0 to 2 are");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, std::numeric_limits<double>::quiet_NaN())),
            "axis x: target is not a number that can be");
  auto backwards = ask(AxisCommand::kMoveAbsolute, 1.0);
  backwards.acceleration = -1.0;
  EXPECT_THAT(refusal(who, 0, backwards), HasSubstr("acceleration -57.2958 deg/s^2 is not possible"));
  EXPECT_EQ(door.authority().owner_of(0), "") << "what is refused takes no axis";
}

TEST_F(AxisDoorTest, RefusesPlacesBeyondTheSoftwareLimits) {
  configs[0].software_limits = trajectory::PositionRange{-1.0, 2.0};
  door.open(*single);
  const auto who = caller("hand");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, 2.5)),
            "axis x: position 143.239 deg is not possible, -57.2958 deg to 114.592 deg are (min_position, "
            "max_position)");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, 2.0)), "");
  EXPECT_EQ(refusal(who, 1, ask(AxisCommand::kMoveAbsolute, 2.5)), "") << "the other one has none";
}

TEST_F(AxisDoorTest, RefusesTorquesThatItCannotLead) {
  door.open(*single);
  const auto who = caller("hand");
  const auto* const without_gain =
      "axis x: torques need velocity_gain or inertia in its [[axis]], by which its velocity is kept";
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kTorque, 0.5)), without_gain);
  auto mode = ask(AxisCommand::kSetMode);
  mode.mode = 10;
  EXPECT_EQ(refusal(who, 0, mode), without_gain);
  configs[0].velocity_gain = 0.03;
  EXPECT_EQ(refusal(who, 0, mode), "");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kTorque, -100.0)),
            "axis x: torque -100 Nm is not possible, -78.6408 Nm to 78.6408 Nm are");
  auto fast = ask(AxisCommand::kTorque, 0.5);
  fast.velocity = 20.0;
  EXPECT_THAT(refusal(who, 0, fast), HasSubstr("velocity 1145.92 deg/s is not possible"));
  static_cast<void>(told());
  auto ramp = ask(AxisCommand::kTorque, 0.5);
  ramp.velocity = 1.0;
  ramp.acceleration = 2.0;
  EXPECT_EQ(refusal(who, 0, ramp), "");
  EXPECT_THAT(told(), ElementsAre("hand: axis x: torque 0.5 Nm, velocity 57.2958 deg/s, 2 Nm/s"));
}

TEST_F(AxisDoorTest, OneCommandsAndEverybodyMayStop) {
  door.open(*single);
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kMoveRelative, std::numbers::pi / 2)), "");
  EXPECT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kMoveRelative, 1.0)), "axis x: is commanded by hand");
  EXPECT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kHalt)), "");
  EXPECT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kStop)), "");
  EXPECT_EQ(door.status(0).owner, "hand") << "who stops an axis does not command it";
  EXPECT_THAT(told(), ElementsAre("hand: axis x: move_relative by 90 deg",
                                  "stream: axis x: move_relative by 57.2958 deg: refused: is commanded by hand",
                                  "stream: axis x: halt", "stream: axis x: stop"))
      << "each command is told, with who gave it";
}

TEST_F(AxisDoorTest, TakingOverIsToldToWhomItConcerns) {
  door.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  cycle();
  door.watch();
  auto hand = caller("hand");
  hand.take_over = true;
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kPower)), "");
  static_cast<void>(told());
  door.watch();
  EXPECT_EQ(door.status(0).owner, "stream") << "the axis has not looked at it yet";
  cycle();
  door.watch();
  EXPECT_THAT(told(), ElementsAre("axis x: hand has taken it over from stream"));
  EXPECT_EQ(door.status(0).owner, "hand");
}

TEST_F(AxisDoorTest, WhatTheAxisRefusesTakesNothingOver) {
  door.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kPower)), "");
  cycle();
  auto hand = caller("hand");
  hand.take_over = true;
  // It is not enabled yet.
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  cycle();
  door.watch();
  EXPECT_EQ(door.status(0).owner, "stream");
  door.leave("hand", true);
  door.watch();
  EXPECT_EQ(door.status(0).owner, "stream");
  for (const auto& change : door.authority().take_changes()) EXPECT_NE(change.owner, "hand");
}

TEST_F(AxisDoorTest, WhatIsOneTooManyTakesNothing) {
  door.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kPower)), "");
  for (int i = 0; i < 1000 && refusal(caller("stream"), 0, ask(AxisCommand::kPower)).empty(); ++i) continue;
  auto hand = caller("hand");
  hand.take_over = true;
  EXPECT_EQ(refusal(hand, 0, ask(AxisCommand::kPower)), "axis x: there are more requests than the cycle can take");
  EXPECT_EQ(refusal(hand, 1, ask(AxisCommand::kPower)), "axis y: there are more requests than the cycle can take");
  EXPECT_EQ(door.status(0).owner, "stream");
  EXPECT_EQ(door.status(1).owner, "");
}

TEST_F(AxisDoorTest, ATouchProbeNeedsNoLeaseAndIsOneAtATime) {
  door.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kPower)), "");
  const auto probe = ask(AxisCommand::kTouchProbe);
  EXPECT_EQ(refusal(caller("hand"), 0, probe), "");
  EXPECT_EQ(door.status(0).owner, "stream") << "it moves nothing";
  EXPECT_EQ(refusal(caller("other"), 0, probe), "axis x: its touch probe is used by hand");
  EXPECT_EQ(refusal(caller("other"), 1, probe), "") << "that of another axis is free";
  EXPECT_EQ(refusal(caller("hand"), 0, probe), "") << "his own";
  auto taking = caller("other");
  taking.take_over = true;
  EXPECT_EQ(refusal(taking, 0, probe), "");
  EXPECT_EQ(door.status(0).owner, "stream");
  EXPECT_EQ(refusal(caller("third"), 0, ask(AxisCommand::kAbortTrigger)), "") << "to anybody";
  door.close();
  door.occupy("path");
  EXPECT_THAT(refusal(taking, 0, probe), HasSubstr("is moved by the path of this run"));
}

TEST_F(AxisDoorTest, RequestsOfProbesAndDrivesHaveSentences) {
  configs[0].software_limits = trajectory::PositionRange{-1.0, 2.0};
  door.open(*single);
  auto probe = ask(AxisCommand::kTouchProbe);
  probe.trigger = ecat_master::ProbeTrigger::kSecondFalling;
  probe.window_last = 1.0;
  auto homing = ask(AxisCommand::kHomeByProbe, 0.5);
  homing.trigger = ecat_master::ProbeTrigger::kZeroPulse;
  homing.distance = -0.5;
  homing.velocity = 1.0;
  for (const auto& request : {probe, homing, ask(AxisCommand::kDriveMoveAbsolute, 1.0),
                              ask(AxisCommand::kDriveMoveVelocity, -1.0), ask(AxisCommand::kAbortTrigger)})
    EXPECT_EQ(refusal(caller("hand"), 0, request), "");
  EXPECT_THAT(told(), ElementsAre("hand: axis x: touch_probe 2, falling edge, from 0 deg to 57.2958 deg",
                                  "hand: axis x: home_by_probe zero pulse, as far as -28.6479 deg, at 28.6479 deg, "
                                  "velocity 57.2958 deg/s",
                                  "hand: axis x: drive_move_absolute to 57.2958 deg",
                                  "hand: axis x: drive_move_velocity -57.2958 deg/s", "hand: axis x: abort_trigger"));
  homing.distance = -1.5;
  EXPECT_THAT(refusal(caller("hand"), 0, homing), HasSubstr("position -85.9437 deg is not possible, -57.2958 deg to"));
  EXPECT_THAT(refusal(caller("hand"), 0, ask(AxisCommand::kDriveMoveAbsolute, 2.5)),
              HasSubstr("position 143.239 deg is not possible"));
  EXPECT_THAT(refusal(caller("hand"), 0, ask(AxisCommand::kDriveMoveVelocity, 11.0)),
              HasSubstr("velocity 630.254 deg/s is not possible"));
  probe.window_first = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(caller("hand"), 0, probe), "axis x: window is not a number that can be");
}

TEST_F(AxisDoorTest, WhoIsNotHeardAnyMoreLosesHisAxes) {
  door.open(*single);
  const auto hand = caller("hand", milliseconds{500});
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kMoveVelocity, 1.0)), "");
  static_cast<void>(told());
  clock.advance(milliseconds{400});
  door.keep_alive(hand);
  clock.advance(milliseconds{400});
  door.watch();
  EXPECT_THAT(told(), IsEmpty());
  clock.advance(milliseconds{100});
  door.watch();
  EXPECT_THAT(told(), ElementsAre("axis x: hand is not heard any more: the axis stops"));
  EXPECT_EQ(door.status(0).owner, "");
}

TEST_F(AxisDoorTest, WhoLeavesHisRequestsKeepsTheAxisUntilTheyAreOver) {
  door.open(*single);
  const auto hand = caller("hand", milliseconds{500});
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  door.leave("hand", false);
  clock.advance(milliseconds{5000});
  door.watch();
  EXPECT_EQ(door.status(0).owner, "hand");
  EXPECT_THAT(refusal(caller("other"), 0, ask(AxisCommand::kMoveRelative, 1.0)), HasSubstr("commanded by hand"));
}

TEST_F(AxisDoorTest, WhoGoesGivesHisAxesBack) {
  door.open(*single);
  ASSERT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  ASSERT_EQ(refusal(caller("hand"), 1, ask(AxisCommand::kPower)), "");
  door.release("hand", 0);
  EXPECT_EQ(door.status(0).owner, "");
  door.leave("hand", true);
  EXPECT_EQ(door.status(1).owner, "");
}

TEST_F(AxisDoorTest, AxesThatAPathMovesAreNotToBeHadButStop) {
  door.occupy("path");
  auto hand = caller("hand");
  hand.take_over = true;
  EXPECT_EQ(refusal(hand, 1, ask(AxisCommand::kMoveRelative, 1.0)),
            "axis y: is moved by the path of this run, together with the others; a stop is all that can be asked");
  EXPECT_EQ(stops, 0);
  const auto stopped = door.submit(hand, 1, ask(AxisCommand::kHalt));
  ASSERT_TRUE(stopped);
  EXPECT_EQ(stops, 1);
  EXPECT_TRUE(door.progress(1, *stopped).report.over());
}

/// Watches a line, and does something at each look until it says that it is done.
class Hand final : public Observer {
 public:
  void event(const Event& event) override { told.push_back(describe(event)); }
  void look() override {
    if (on_look) on_look();
  }
  std::vector<std::string> told;
  std::function<void()> on_look;
};

class LineByHand : public test::TemporaryDirectory {
 protected:
  void open(const std::string& more = "", const std::string& keys = "") {
    std::string text = "[line]\ncycle_us = 1000\n";
    for (const auto* name : {"x", "y"}) text += std::string("[[slave]]\nname = \"") + name + "\"\n";
    for (const auto* name : {"x", "y"}) {
      text += std::string("[[axis]]\nname = \"") + name +
              "\"\nunit = \"deg\"\nmax_velocity = 720\nmax_acceleration = 7200\n" + keys;
    }
    const auto config = parse_line_config(text + more, directory / "line.toml");
    ASSERT_TRUE(config) << describe(config.error());
    Line::Options options;
    options.virtual_time = true;
    options.adjust = [this](LineConfig& read) -> Result<void> {
      read.output.directory = directory / "out";
      return {};
    };
    auto opened = Line::from_config(*config, options);
    ASSERT_TRUE(opened) << describe(opened.error());
    line = std::move(*opened);
    line->observe(hand);
  }
  [[nodiscard]] PlcopenState state(std::size_t axis) { return line->axes().status(axis).report->state; }
  [[nodiscard]] bool over(std::size_t axis, std::uint64_t request) {
    return line->axes().progress(axis, request).report.over();
  }
  RunReport run(bool enable = true) {
    Line::RunSettings settings;
    settings.duration_s = 10.0;
    settings.enable = enable;
    auto report = line->run(settings);
    EXPECT_TRUE(report) << describe(report.error());
    return report ? std::move(*report) : RunReport{};
  }

  std::unique_ptr<Line> line;
  Hand hand;
};

TEST_F(LineByHand, MovesOneAxisWhileTheOtherHoldsItsPlace) {
  open();
  std::uint64_t request = 0;
  double from = 0.0;
  double to = 0.0;
  double other = 0.0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (request == 0 && state(0) == PlcopenState::kStandstill && axes.status(0).owner.empty()) {
      from = axes.status(0).report->position;
      other = axes.status(1).report->position;
      request = axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.5)).value();
    }
    if (request == 0 || !over(0, request)) return;
    to = axes.status(0).report->position;
    other -= axes.status(1).report->position;
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(report.duration_s, 5.0);
  EXPECT_NEAR(to - from, 1.5, 0.01);
  EXPECT_NEAR(other, 0.0, 0.01);
  EXPECT_THAT(hand.told, Contains("hand: axis x: move_relative by 85.9437 deg"));
  EXPECT_THAT(hand.told, Contains("there is no [path]: the axes are enabled and hold the place where they stand"));
  EXPECT_EQ(hand.told.back(), "all in INIT");
}

TEST_F(LineByHand, AxesStayOffUntilTheyAreAskedFor) {
  open();
  int looks = 0;
  std::uint64_t request = 0;
  hand.on_look = [&] {
    ++looks;
    if (looks == 50) {
      EXPECT_EQ(state(0), PlcopenState::kDisabled);
      request = line->axes().submit(caller("hand"), 0, ask(AxisCommand::kPower)).value();
    }
    if (request == 0 || !over(0, request)) return;
    EXPECT_EQ(state(0), PlcopenState::kStandstill);
    EXPECT_EQ(state(1), PlcopenState::kDisabled);
    line->request_stop();
  };
  const auto report = run(false);
  EXPECT_EQ(failure_of(report), "") << "nobody wanted the other one";
  EXPECT_GT(looks, 50);
}

TEST_F(LineByHand, WhoDiesWhileAnAxisMovesStopsIt) {
  open();
  int moving = 0;
  bool left = false;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (moving == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
    if (moving++ == 0) static_cast<void>(axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveVelocity, 3.0)));
    if (moving == 20) {
      EXPECT_EQ(state(0), PlcopenState::kContinuousMotion);
      axes.leave("hand", true);
      left = true;
    }
    if (!left || state(0) != PlcopenState::kStandstill) return;
    EXPECT_NEAR(axes.status(0).report->velocity, 0.0, 0.2);
    EXPECT_EQ(axes.status(0).owner, "");
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_TRUE(left);
  EXPECT_LT(report.duration_s, 5.0) << "it has come to rest";
}

TEST_F(LineByHand, ARefusedTakeOverLeavesTheAxisAndItsMotionToItsOwner) {
  for (const int stays : {0, 1, 5}) {
    SCOPED_TRACE(stays);
    open();
    auto taker = caller("taker", milliseconds{500});
    taker.take_over = true;
    int moving = 0;
    std::uint64_t jog = 0;
    hand.on_look = [&] {
      auto& axes = line->axes();
      if (moving == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
      if (moving++ == 0) jog = axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveVelocity, 3.0)).value();
      // It homes at a standstill only, which the axis knows.
      if (moving == 20) static_cast<void>(axes.submit(taker, 0, ask(AxisCommand::kHome)).value());
      if (moving == 20 + stays) axes.leave("taker", true);
      if (moving < 60) return;
      EXPECT_EQ(state(0), PlcopenState::kContinuousMotion);
      EXPECT_EQ(axes.progress(0, jog).report.phase, ecat_master::RequestPhase::kReached);
      EXPECT_EQ(axes.status(0).owner, "hand");
      line->request_stop();
    };
    EXPECT_EQ(failure_of(run()), "");
    EXPECT_GE(moving, 60);
  }
}

TEST_F(LineByHand, WhoTakesOverAndGoesAtOnceLeavesTheAxisAtRest) {
  for (const int stays : {0, 1, 5}) {
    SCOPED_TRACE(stays);
    open();
    auto taker = caller("taker", milliseconds{500});
    taker.take_over = true;
    int moving = 0;
    hand.on_look = [&] {
      auto& axes = line->axes();
      if (moving == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
      if (moving++ == 0) static_cast<void>(axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveVelocity, 3.0)));
      if (moving == 20) static_cast<void>(axes.submit(taker, 0, ask(AxisCommand::kMoveVelocity, -3.0)).value());
      if (moving == 20 + stays) axes.leave("taker", true);
      if (moving < 200) return;
      EXPECT_EQ(state(0), PlcopenState::kStandstill);
      EXPECT_NE(axes.status(0).owner, "taker");
      line->request_stop();
    };
    EXPECT_EQ(failure_of(run()), "");
    EXPECT_GE(moving, 200);
  }
}

TEST_F(LineByHand, RequestThatTheAxisRefusesIsToldWithWhatToDo) {
  open();
  int looks = 0;
  hand.on_look = [&] {
    ++looks;
    if (looks == 10) static_cast<void>(line->axes().submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)));
    if (looks == 20) line->request_stop();
  };
  const auto report = run(false);
  EXPECT_THAT(hand.told,
              Contains("hand: axis x: move_relative by 57.2958 deg: failed: the axis is not enabled; enable it "
                       "first"));
  EXPECT_EQ(failure_of(report), "") << "the line is well";
}

TEST_F(LineByHand, AnAxisHomesByItsDrive) {
  // Method 33: in negative direction to the next index pulse.
  open("[[slave.sdo]]\nindex = 0x6098\ntype = \"int8\"\nvalue = 33\n");
  std::uint64_t moved = 0;
  std::uint64_t homed = 0;
  bool homing = false;
  double place = 1e9;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (moved == 0 && state(1) == PlcopenState::kStandstill && axes.status(1).owner.empty())
      moved = axes.submit(caller("hand"), 1, ask(AxisCommand::kMoveRelative, 1.5)).value();
    if (moved != 0 && homed == 0 && over(1, moved))
      homed = axes.submit(caller("hand"), 1, ask(AxisCommand::kHome)).value();
    if (homed == 0) return;
    homing = homing || state(1) == PlcopenState::kHoming;
    if (!over(1, homed)) return;
    EXPECT_EQ(axes.progress(1, homed).report.phase, ecat_master::RequestPhase::kDone);
    place = axes.status(1).report->position;
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_TRUE(homing);
  EXPECT_NEAR(place, 0.0, 0.2) << "it comes to rest a little behind the pulse";
  EXPECT_THAT(hand.told, Contains("hand: axis y: home"));
}

TEST_F(LineByHand, AnAxisIsLedByATorqueNoFasterThanItMay) {
  open("", "inertia = 3e-4\n");
  std::uint64_t pulled = 0;
  std::uint64_t halted = 0;
  int looks = 0;
  double fastest = 0.0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (pulled == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
    auto request = ask(AxisCommand::kTorque, 0.5);
    request.velocity = 3.0;
    if (pulled == 0) pulled = axes.submit(caller("hand"), 0, request).value();
    fastest = std::max(fastest, axes.status(0).report->velocity);
    if (++looks == 50) {
      EXPECT_EQ(state(0), PlcopenState::kContinuousMotion);
      EXPECT_EQ(axes.progress(0, pulled).report.phase, ecat_master::RequestPhase::kReached);
      EXPECT_EQ(axes.status(0).report->mode, 10);
      halted = axes.submit(caller("hand"), 0, ask(AxisCommand::kHalt)).value();
    }
    if (halted == 0 || !over(0, halted) || axes.status(0).report->mode != 8) return;
    EXPECT_EQ(state(0), PlcopenState::kStandstill);
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(report.duration_s, 5.0);
  EXPECT_GT(fastest, 1.0);
  EXPECT_LT(fastest, 3.1);
}

TEST_F(LineByHand, NoRequestLeavesTheSoftwareLimits) {
  open("", "min_position = -90\nmax_position = 90\n");
  const auto turn = std::numbers::pi;
  struct Step {
    AxisRequest request;
    std::string refusal{};  ///< at once
  };
  const std::vector<Step> steps{
      {ask(AxisCommand::kMoveAbsolute, 3.0 * turn),
       "axis x: position 540 deg is not possible, -90 deg to 90 deg are (min_position, max_position)"},
      {ask(AxisCommand::kMoveAbsolute, 0.25 * turn)},
      {ask(AxisCommand::kMoveRelative, 0.5 * turn),
       "axis x: position 135 deg is not possible, -90 deg to 90 deg are (min_position, max_position)"},
      {ask(AxisCommand::kMoveVelocity, 2.0)},
      {ask(AxisCommand::kSetPosition, 0.0)},
      {ask(AxisCommand::kMoveAbsolute, 0.1),
       "axis x: position 5.72958 deg is not possible, -180 deg to 0 deg are (min_position, max_position)"},
  };
  std::size_t next = 0;
  std::uint64_t request = 0;
  double highest = 0.0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (axes.status(0).report) highest = std::max(highest, std::abs(axes.status(0).report->velocity));
    const bool ready =
        request != 0 ? over(0, request) : state(0) == PlcopenState::kStandstill && axes.status(0).owner.empty();
    if (!ready) return;
    while (next < steps.size()) {
      const auto& step = steps[next++];
      const auto taken = axes.submit(caller("hand"), 0, step.request);
      EXPECT_EQ(taken ? "" : describe(events::event_axis(line->config().axes[0]), taken.error()), step.refusal);
      if (!taken) continue;
      request = *taken;
      return;
    }
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_EQ(next, steps.size());
  EXPECT_THAT(hand.told,
              Contains("hand: axis x: move_velocity 114.592 deg/s: failed: it would leave its software limits, "
                       "-90 deg to 90 deg are possible"))
      << "it has come to rest there";
  EXPECT_GT(highest, 1.0);
}

TEST_F(LineByHand, ARelativePathThatLeavesTheSoftwareLimitsIsRefusedWhereItBegins) {
  write(directory / "path.csv", "time[s],x[deg],y[deg]\n0,0,0\n1,30,30\n2,0,0\n");
  open("[path]\nfile = \"path.csv\"\nrelative = true\n", "min_position = -20\nmax_position = 20\n");
  double highest = 0.0;
  hand.on_look = [] {};
  const auto report = run();
  for (const auto& axis : report.axes) highest = std::max(highest, axis.following_error_max);
  EXPECT_EQ(failure_of(report),
            "axis x: would go to 30 deg; its software limits are -20 deg and 20 deg (min_position, max_position); all "
            "axes stopped within them");
  EXPECT_LT(report.duration_s, 2.0);
  EXPECT_LT(highest, 100.0) << "nothing has moved";
}

TEST_F(LineByHand, AxisThatFailsLeavesTheOthersAloneAndTheReportTells) {
  open("[recovery]\naxes = \"continue\"\n[[fault]]\nat_ms = 3000\nkind = \"power-off\"\nslave = \"y\"\nfor_ms = 500\n");
  int failed = 0;
  hand.on_look = [&] {
    if (state(1) != PlcopenState::kErrorStop) return;
    ++failed;
    EXPECT_EQ(state(0), PlcopenState::kStandstill);
  };
  const auto report = run();
  EXPECT_GT(failed, 0);
  EXPECT_GE(report.duration_s, 10.0) << "the run goes on";
  EXPECT_THAT(hand.told, Contains("axis y: ErrorStop: the drive is not there, or has left Operation enabled; it stops, "
                                  "the others go on"));
  EXPECT_EQ(failure_of(report),
            "axis y: was in ErrorStop at the end: the drive is not there, or has left Operation enabled");
  EXPECT_THAT(hand.told, Contains("all in INIT"));
}

TEST_F(LineByHand, NobodyMovesTheAxesOfAPath) {
  write(directory / "path.csv", "time[s],x[deg],y[deg]\n0,0,0\n1,30,30\n2,0,0\n");
  open("[path]\nfile = \"path.csv\"\nrelative = true\n");
  std::vector<std::string> refusals;
  int looks = 0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    // The first look is before anything moves.
    if (axes.status(0).owner.empty()) return;
    EXPECT_EQ(axes.status(0).owner, "path");
    const auto taken = axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0));
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().owner, "path");
    if (++looks == 30) static_cast<void>(axes.submit(caller("hand"), 0, ask(AxisCommand::kStop)));
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_EQ(looks, 30) << "a stop ends the run in order";
  EXPECT_THAT(hand.told, Contains("stop requested: taking the line down"));
}

}  // namespace
}  // namespace driveline::runtime
