// Requests to the axes of a line: permitted callers, refusals, and callers that time out.
#include "driveline/runtime/axes/axis_requests.hpp"

#include <gmock/gmock.h>

#include <future>
#include <limits>
#include <numbers>
#include <optional>

#include "driveline/runtime/event.hpp"
#include "make_axis_request.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::AxisConfig;
using motion::AxisRequest;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// AxisRequests for two axes in degrees whose cycle does not run, so that requests wait.
class AxisRequestsTest : public testing::Test {
 protected:
  AxisRequestsTest() {
    std::vector<motion::Axis> made;
    for (const auto& config : configs) {
      made.emplace_back(config, motion::ImagePlace{}, motion::axis_pdo_configuration());
    }
    single.emplace(std::move(made), motion::SingleAxes::Settings{});
  }
  static AxisConfig config(const std::string& name, std::size_t slave) {
    AxisConfig axis;
    axis.name = name;
    axis.slave = slave;
    axis.limits = {10.0, 100.0};
    axis.unit = trajectory::find_position_unit("deg");
    return axis;
  }
  /// The events since the last call, as sentences.
  std::vector<std::string> told() {
    std::vector<std::string> sentences;
    for (auto& facts : axis_requests.take_events()) sentences.push_back(describe(Event{std::move(facts)}));
    return sentences;
  }
  /// One cycle of the axes, without a line.
  void cycle() {
    std::vector<std::byte> image(256);
    single->update(++cycles, image);
  }
  std::string refusal(const AxisCaller& who, std::size_t axis, const AxisRequest& request) {
    const auto submitted = axis_requests.submit(who, axis, request);
    return submitted ? "" : describe(events::event_axis(configs[axis]), submitted.error());
  }

  std::vector<AxisConfig> configs{config("x", 0), config("y", 1)};
  rt::VirtualClock clock;
  int stops = 0;
  std::int64_t cycles = 0;
  AxisRequests axis_requests{configs, clock, [this] { ++stops; }};
  std::optional<motion::SingleAxes> single;
};

TEST_F(AxisRequestsTest, IsClosedUntilTheLineIsInOperation) {
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kHalt)), "axis x: the line is not in operation");
  axis_requests.open(*single);
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kHalt)), "");
  axis_requests.close();
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kHalt)), "axis x: the line is not in operation");
  EXPECT_FALSE(axis_requests.status(0).report);
}

TEST_F(AxisRequestsTest, FindsAxesByName) {
  EXPECT_EQ(axis_requests.find("y"), 1U);
  EXPECT_FALSE(axis_requests.find("z"));
}

TEST_F(AxisRequestsTest, RefusesNumbersThatCannotBeInTheUnitOfTheAxis) {
  axis_requests.open(*single);
  const auto who = caller("hand");
  auto fast = ask(AxisCommand::kMoveAbsolute, 1.0);
  fast.velocity_si = 20.0;
  EXPECT_EQ(refusal(who, 0, fast), "axis x: velocity 1145.92 deg/s is outside 0 deg/s to 572.958 deg/s");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveVelocity, -20.0)),
            "axis x: velocity -1145.92 deg/s is outside -572.958 deg/s to 572.958 deg/s");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kSetOverride, 3.0)), "axis x: override 3 is outside 0 to 2");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, std::numeric_limits<double>::quiet_NaN())),
            "axis x: target is not a finite number");
  auto backwards = ask(AxisCommand::kMoveAbsolute, 1.0);
  backwards.acceleration_si = -1.0;
  EXPECT_THAT(refusal(who, 0, backwards), HasSubstr("acceleration -57.2958 deg/s^2 is outside"));
  EXPECT_EQ(axis_requests.authority().owner_of(0), "") << "what is refused takes no axis";
}

TEST_F(AxisRequestsTest, RefusesMotionsThatLastTooLongWithTheBound) {
  axis_requests.open(*single);
  const auto who = caller("hand");
  const std::string too_long =
      "axis x: the motion would take longer than 100000 s, the longest that is possible; by then ";
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, 2e6)), too_long + "it covers at most 5.72958e+07 deg");
  auto slow = ask(AxisCommand::kMoveAbsolute, -3.0);
  slow.velocity_si = 1e-5;
  EXPECT_EQ(refusal(who, 0, slow), too_long + "it covers at most 57.2958 deg");
  auto soft = ask(AxisCommand::kMoveAbsolute, 3.0);
  soft.acceleration_si = 1e-300;
  soft.deceleration_si = 3e-300;
  // 0.5 t^2 / (1 / a + 1 / d)
  EXPECT_EQ(refusal(who, 0, soft), too_long + "it covers at most 2.14859e-289 deg");
  auto jog = ask(AxisCommand::kMoveVelocity, 4.0);
  jog.acceleration_si = 1e-6;
  EXPECT_EQ(refusal(who, 0, jog), too_long + "it reaches at most 5.72958 deg/s");
  jog.acceleration_si = 2.0;
  jog.jerk_si = 1e-12;
  EXPECT_EQ(refusal(who, 0, jog), too_long + "it reaches at most 0.143239 deg/s");
  EXPECT_EQ(axis_requests.authority().owner_of(0), "") << "what is refused takes no axis";
}

TEST_F(AxisRequestsTest, RefusesPositionsThatCannotBeCounted) {
  configs[0].increments_per_unit = 3000.0;
  axis_requests.open(*single);
  const auto who = caller("hand");
  const std::string bounds = " deg is outside -8.39965e+10 deg to 8.39965e+10 deg";
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kSetPosition, 1e300)), "axis x: position 5.72958e+301" + bounds);
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kDriveMoveRelative, -2e9)), "axis x: position -1.14592e+11" + bounds);
  auto probe = ask(AxisCommand::kTouchProbe);
  probe.window_last_si = 2e9;
  EXPECT_EQ(refusal(who, 0, probe), "axis x: window 1.14592e+11" + bounds);
}

TEST_F(AxisRequestsTest, RefusesPlacesBeyondTheSoftwareLimits) {
  configs[0].software_limits = trajectory::PositionRange{-1.0, 2.0};
  axis_requests.open(*single);
  const auto who = caller("hand");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, 2.5)),
            "axis x: position 143.239 deg is outside -57.2958 deg to 114.592 deg (min_position, "
            "max_position)");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kMoveAbsolute, 2.0)), "");
  EXPECT_EQ(refusal(who, 1, ask(AxisCommand::kMoveAbsolute, 2.5)), "") << "the other one has none";
}

TEST_F(AxisRequestsTest, AnAxisThatMustBeResetNamesTheCommand) {
  AxisRefusal refusal;
  refusal.why = AxisRefusal::Why::kByAxis;
  refusal.error = motion::AxisError::kErrorStop;
  EXPECT_EQ(describe(events::event_axis(configs[1]), refusal),
            "axis y: the axis is in ErrorStop and must be reset first; `driveline axis y reset` resets it");
  GroupRefusal of_group;
  of_group.why = GroupRefusal::Why::kByGroup;
  of_group.error = motion::GroupError::kErrorStop;
  events::EventGroup group;
  group.name = "table";
  EXPECT_EQ(describe(group, of_group),
            "group table: the group is in GroupErrorStop and must be reset first; `driveline group table reset` resets "
            "it");
}

TEST_F(AxisRequestsTest, RefusesTorquesThatItCannotLead) {
  axis_requests.open(*single);
  const auto who = caller("hand");
  const auto* const without_gain =
      "axis x: torque control needs velocity_gain or inertia in the [[axis]] to limit the velocity";
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kTorque, 0.5)), without_gain);
  auto mode = ask(AxisCommand::kSetMode);
  mode.mode = 10;
  EXPECT_EQ(refusal(who, 0, mode), without_gain);
  configs[0].velocity_gain = 0.03;
  EXPECT_EQ(refusal(who, 0, mode), "");
  EXPECT_EQ(refusal(who, 0, ask(AxisCommand::kTorque, -100.0)),
            "axis x: torque -100 Nm is outside -78.6408 Nm to 78.6408 Nm");
  auto fast = ask(AxisCommand::kTorque, 0.5);
  fast.velocity_si = 20.0;
  EXPECT_THAT(refusal(who, 0, fast), HasSubstr("velocity 1145.92 deg/s is outside"));
  static_cast<void>(told());
  auto ramp = ask(AxisCommand::kTorque, 0.5);
  ramp.velocity_si = 1.0;
  ramp.acceleration_si = 2.0;
  EXPECT_EQ(refusal(who, 0, ramp), "");
  EXPECT_THAT(told(), ElementsAre("hand: axis x: torque 0.5 Nm, velocity 57.2958 deg/s, 2 Nm/s"));
}

TEST_F(AxisRequestsTest, OneCommandsAndEverybodyMayStop) {
  axis_requests.open(*single);
  EXPECT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kMoveRelative, std::numbers::pi / 2)), "");
  EXPECT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kMoveRelative, 1.0)), "axis x: is commanded by hand");
  EXPECT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kHalt)), "");
  EXPECT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kStop)), "");
  EXPECT_EQ(axis_requests.status(0).owner, "hand") << "who stops an axis does not command it";
  EXPECT_THAT(told(), ElementsAre("hand: axis x: move_relative by 90 deg",
                                  "stream: axis x: move_relative by 57.2958 deg: refused: is commanded by hand",
                                  "stream: axis x: halt", "stream: axis x: stop"))
      << "each command is told, with who gave it";
}

TEST_F(AxisRequestsTest, TakingOverIsToldToWhomItConcerns) {
  axis_requests.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  cycle();
  axis_requests.watch();
  auto hand = caller("hand");
  hand.take_over = true;
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kPower)), "");
  static_cast<void>(told());
  axis_requests.watch();
  EXPECT_EQ(axis_requests.status(0).owner, "stream") << "the axis has not looked at it yet";
  cycle();
  axis_requests.watch();
  EXPECT_THAT(told(), ElementsAre("axis x: hand has taken it over from stream"));
  EXPECT_EQ(axis_requests.status(0).owner, "hand");
}

TEST_F(AxisRequestsTest, WhatTheAxisRefusesTakesNothingOver) {
  axis_requests.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kPower)), "");
  cycle();
  auto hand = caller("hand");
  hand.take_over = true;
  // The axis is not enabled yet.
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  cycle();
  axis_requests.watch();
  EXPECT_EQ(axis_requests.status(0).owner, "stream");
  axis_requests.leave("hand", true);
  axis_requests.watch();
  EXPECT_EQ(axis_requests.status(0).owner, "stream");
  for (const auto& change : axis_requests.authority().take_changes()) EXPECT_NE(change.owner, "hand");
}

TEST_F(AxisRequestsTest, WhatIsOneTooManyTakesNothing) {
  axis_requests.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kPower)), "");
  for (int i = 0; i < 1000 && refusal(caller("stream"), 0, ask(AxisCommand::kPower)).empty(); ++i) continue;
  auto hand = caller("hand");
  hand.take_over = true;
  EXPECT_EQ(refusal(hand, 0, ask(AxisCommand::kPower)),
            "axis x: too many requests: the request queue of the cycle is full");
  EXPECT_EQ(refusal(hand, 1, ask(AxisCommand::kPower)),
            "axis y: too many requests: the request queue of the cycle is full");
  EXPECT_EQ(axis_requests.status(0).owner, "stream");
  EXPECT_EQ(axis_requests.status(1).owner, "");
}

TEST_F(AxisRequestsTest, ATouchProbeNeedsNoLeaseAndIsOneAtATime) {
  axis_requests.open(*single);
  ASSERT_EQ(refusal(caller("stream"), 0, ask(AxisCommand::kPower)), "");
  const auto probe = ask(AxisCommand::kTouchProbe);
  EXPECT_EQ(refusal(caller("hand"), 0, probe), "");
  EXPECT_EQ(axis_requests.status(0).owner, "stream") << "it moves nothing";
  EXPECT_EQ(refusal(caller("other"), 0, probe), "axis x: its touch probe is used by hand");
  EXPECT_EQ(refusal(caller("other"), 1, probe), "") << "that of another axis is free";
  EXPECT_EQ(refusal(caller("hand"), 0, probe), "") << "his own";
  auto taking = caller("other");
  taking.take_over = true;
  EXPECT_EQ(refusal(taking, 0, probe), "");
  EXPECT_EQ(axis_requests.status(0).owner, "stream");
  EXPECT_EQ(refusal(caller("third"), 0, ask(AxisCommand::kAbortTrigger)), "") << "to anybody";
  axis_requests.close();
  axis_requests.occupy("path");
  EXPECT_THAT(refusal(taking, 0, probe), HasSubstr("is moved by the path of this run"));
}

TEST_F(AxisRequestsTest, RequestsOfProbesAndDrivesHaveSentences) {
  configs[0].software_limits = trajectory::PositionRange{-1.0, 2.0};
  axis_requests.open(*single);
  auto probe = ask(AxisCommand::kTouchProbe);
  probe.trigger = motion::ProbeTrigger::kSecondFalling;
  probe.window_last_si = 1.0;
  auto homing = ask(AxisCommand::kHomeByProbe, 0.5);
  homing.trigger = motion::ProbeTrigger::kZeroPulse;
  homing.distance_si = -0.5;
  homing.velocity_si = 1.0;
  for (const auto& request :
       {probe, homing, ask(AxisCommand::kDriveMoveAbsolute, 1.0), ask(AxisCommand::kDriveMoveVelocity, -1.0),
        ask(AxisCommand::kDriveRun, 1.0), ask(AxisCommand::kAbortTrigger)})
    EXPECT_EQ(refusal(caller("hand"), 0, request), "");
  EXPECT_THAT(told(), ElementsAre("hand: axis x: touch_probe 2, falling edge, from 0 deg to 57.2958 deg",
                                  "hand: axis x: home_by_probe zero pulse, as far as -28.6479 deg, at 28.6479 deg, "
                                  "velocity 57.2958 deg/s",
                                  "hand: axis x: drive_move_absolute to 57.2958 deg",
                                  "hand: axis x: drive_move_velocity -57.2958 deg/s",
                                  "hand: axis x: drive_run 57.2958 deg/s", "hand: axis x: abort_trigger"));
  homing.distance_si = -1.5;
  EXPECT_THAT(refusal(caller("hand"), 0, homing), HasSubstr("position -85.9437 deg is outside -57.2958 deg to"));
  EXPECT_THAT(refusal(caller("hand"), 0, ask(AxisCommand::kDriveMoveAbsolute, 2.5)),
              HasSubstr("position 143.239 deg is outside"));
  for (const auto command : {AxisCommand::kDriveMoveVelocity, AxisCommand::kDriveRun}) {
    EXPECT_THAT(refusal(caller("hand"), 0, ask(command, 11.0)), HasSubstr("velocity 630.254 deg/s is outside"));
  }
  probe.window_first_si = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(caller("hand"), 0, probe), "axis x: window is not a finite number");
}

TEST_F(AxisRequestsTest, WhoIsNotHeardAnyMoreLosesHisAxes) {
  axis_requests.open(*single);
  const auto hand = caller("hand", milliseconds{500});
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kMoveVelocity, 1.0)), "");
  static_cast<void>(told());
  clock.advance(milliseconds{400});
  axis_requests.keep_alive(hand);
  clock.advance(milliseconds{400});
  axis_requests.watch();
  EXPECT_THAT(told(), IsEmpty());
  clock.advance(milliseconds{100});
  axis_requests.watch();
  EXPECT_THAT(told(), ElementsAre("axis x: hand no longer renews its lease: the axis stops"));
  EXPECT_EQ(axis_requests.status(0).owner, "");
}

TEST_F(AxisRequestsTest, WhoLeavesHisRequestsKeepsTheAxisUntilTheyAreOver) {
  axis_requests.open(*single);
  const auto hand = caller("hand", milliseconds{500});
  ASSERT_EQ(refusal(hand, 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  axis_requests.leave("hand", false);
  clock.advance(milliseconds{5000});
  axis_requests.watch();
  EXPECT_EQ(axis_requests.status(0).owner, "hand");
  EXPECT_THAT(refusal(caller("other"), 0, ask(AxisCommand::kMoveRelative, 1.0)), HasSubstr("commanded by hand"));
}

TEST_F(AxisRequestsTest, ARequestIsAcceptedWhenTheAxisHasTakenIt) {
  axis_requests.open(*single);
  const auto slower = axis_requests.submit(caller("hand"), 1, ask(AxisCommand::kSetOverride, 0.5));
  const auto moved = axis_requests.submit(caller("hand"), 1, ask(AxisCommand::kMoveRelative, 1.5));
  ASSERT_TRUE(slower && moved);
  EXPECT_FALSE(axis_requests.progress(1, *slower).accepted) << "no cycle has taken it";
  EXPECT_FALSE(axis_requests.progress(1, *moved).accepted);
  cycle();
  EXPECT_TRUE(axis_requests.progress(1, *slower).accepted);
  const auto refused = axis_requests.progress(1, *moved);
  EXPECT_FALSE(refused.accepted);
  ASSERT_TRUE(refused.refusal);
  EXPECT_EQ(describe(events::event_axis(configs[1]), *refused.refusal),
            "axis y: the axis is not enabled; enable it first");
}

TEST_F(AxisRequestsTest, WhoGoesGivesHisAxesBack) {
  axis_requests.open(*single);
  ASSERT_EQ(refusal(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)), "");
  ASSERT_EQ(refusal(caller("hand"), 1, ask(AxisCommand::kPower)), "");
  axis_requests.release("hand", 0);
  EXPECT_EQ(axis_requests.status(0).owner, "");
  axis_requests.leave("hand", true);
  EXPECT_EQ(axis_requests.status(1).owner, "");
}

TEST_F(AxisRequestsTest, WhoGoesTakesAlongTheMotionsThatAreStillQueued) {
  axis_requests.open(*single);
  const auto moved = must(axis_requests.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)));
  axis_requests.leave("hand", true);
  cycle();
  EXPECT_EQ(single->report(*moved).phase, motion::RequestPhase::kAborted);
}

TEST_F(AxisRequestsTest, AThreadWaitsForTheEndOfARequest) {
  axis_requests.open(*single);
  const auto moved = must(axis_requests.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)));
  EXPECT_NE(*moved, 0U);
  EXPECT_EQ(axis_requests.wait(0, *moved, {}).report.phase, motion::RequestPhase::kWaiting) << "the time is over";
  auto waits = std::async(std::launch::async, [&] { return axis_requests.wait(0, *moved, std::chrono::hours{1}); });
  while (waits.wait_for(milliseconds{1}) != std::future_status::ready) {
    cycle();  // in which the axis refuses the request: it is not enabled
    axis_requests.watch();
  }
  const auto progress = waits.get();
  EXPECT_EQ(progress.report.phase, motion::RequestPhase::kError);
  ASSERT_TRUE(progress.refusal);
  EXPECT_EQ(progress.refusal->error, motion::AxisError::kNotEnabled);
}

TEST_F(AxisRequestsTest, AThreadThatWaitsGoesOnWhenTheLineGoesOutOfOperation) {
  axis_requests.open(*single);
  const auto moved = must(axis_requests.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)));
  auto waits = std::async(std::launch::async, [&] { return axis_requests.wait(0, *moved, std::chrono::hours{1}); });
  axis_requests.close();
  const auto progress = waits.get();
  EXPECT_EQ(progress.report.phase, motion::RequestPhase::kAborted);
  ASSERT_TRUE(progress.refusal);
  EXPECT_EQ(progress.refusal->why, AxisRefusal::Why::kNotRunning);
}

TEST_F(AxisRequestsTest, CallsBackOnceWhenARequestHasSettled) {
  axis_requests.open(*single);
  const auto who = caller("hand");
  const auto moved = must(axis_requests.submit(who, 0, ask(AxisCommand::kMoveRelative, 1.0)));
  std::vector<motion::RequestPhase> phases;
  axis_requests.when_settled(0, *moved, [&](const AxisProgress& progress) {
    phases.push_back(progress.report.phase);
    EXPECT_TRUE(axis_requests.submit(who, 0, ask(AxisCommand::kHalt))) << "without the lock";
  });
  axis_requests.watch();
  EXPECT_THAT(phases, IsEmpty()) << "the request waits for the cycle";
  cycle();
  axis_requests.watch();
  axis_requests.watch();
  EXPECT_THAT(phases, ElementsAre(motion::RequestPhase::kError));
}

TEST_F(AxisRequestsTest, CallsBackWhenTheLineGoesOutOfOperation) {
  axis_requests.open(*single);
  const auto first = must(axis_requests.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)));
  cycle();
  const auto second = must(axis_requests.submit(caller("hand"), 1, ask(AxisCommand::kMoveRelative, 1.0)));
  std::vector<motion::RequestPhase> phases;
  const auto note = [&](const AxisProgress& progress) { phases.push_back(progress.report.phase); };
  axis_requests.when_settled(1, *second, note);
  axis_requests.when_settled(0, *first, note);
  axis_requests.close();
  axis_requests.close();
  EXPECT_THAT(phases, ElementsAre(motion::RequestPhase::kError, motion::RequestPhase::kAborted))
      << "first those that were over";
}

TEST_F(AxisRequestsTest, AxesThatAPathMovesAreNotToBeHadButStop) {
  axis_requests.occupy("path");
  auto hand = caller("hand");
  hand.take_over = true;
  EXPECT_EQ(refusal(hand, 1, ask(AxisCommand::kMoveRelative, 1.0)),
            "axis y: is moved by the path of this run, together with the other axes; only a stop can be requested");
  EXPECT_EQ(stops, 0);
  const auto stopped = must(axis_requests.submit(hand, 1, ask(AxisCommand::kHalt)));
  EXPECT_EQ(stops, 1);
  EXPECT_EQ(*stopped, AxisRequests::kRunEnded);
  EXPECT_EQ(axis_requests.progress(1, *stopped).report.phase, motion::RequestPhase::kDone);
  EXPECT_EQ(axis_requests.wait(1, *stopped, std::chrono::nanoseconds::max()).report.phase, motion::RequestPhase::kDone);
}

/// Clients choose their names themselves.
TEST_F(AxisRequestsTest, ANamesakeOfWhatMovesAllAxesGetsNone) {
  axis_requests.occupy("path");
  auto namesake = caller("path", milliseconds{500});
  for (const auto command : {AxisCommand::kMoveRelative, AxisCommand::kPower, AxisCommand::kReleaseStop}) {
    EXPECT_THAT(refusal(namesake, 0, ask(command, 1.0)), HasSubstr("is moved by the path of this run"));
  }
  const auto lease = axis_requests.acquire(namesake, 0);
  ASSERT_FALSE(lease);
  EXPECT_EQ(lease.error().why, AxisRefusal::Why::kMovedTogether);
  axis_requests.give_back("path", 0);
  axis_requests.release("path", 0);
  axis_requests.leave("path", true);
  clock.advance(milliseconds{1000});
  axis_requests.watch();
  EXPECT_EQ(axis_requests.status(0).owner, "path");
  auto hand = caller("hand");
  hand.take_over = true;
  EXPECT_THAT(refusal(hand, 0, ask(AxisCommand::kMoveRelative, 1.0)), HasSubstr("is moved by the path of this run"));
}

}  // namespace
}  // namespace driveline::runtime
