// Axes of a line that move together along paths, and the demands of the drives meanwhile.
#include "driveline/motion/group/axis_groups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "driveline/motion/single_axis/couplings.hpp"
#include "group_line.hpp"

namespace driveline::bus_test {
namespace {

constexpr double kExact = 1e-9;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(AxisGroups, MoveAlongAStraightLineTogether) {
  StandbyGroup line(3);
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  const auto from = line.place();
  const GroupVector to{3.0, -2.0, 1.0};
  const auto id = line.groups->move(0, line_to(to));
  double worst = 0.0;
  bool active = false;
  for (int i = 0; i < 8000 && !line.groups->report(id).over(); ++i) {
    line.cycle();
    worst = std::max(worst, from_line(line.place(), from, to));
    active = active || line.group_phase(id) == RequestPhase::kActive;
  }
  EXPECT_TRUE(active);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
  EXPECT_LT(worst, kExact);
  EXPECT_LT(apart(line.place(), to), kExact);
  EXPECT_EQ(line.group_state(), GroupState::kStandby);
  EXPECT_EQ(line.ask_group(GroupCommand::kDisable).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kDisabled);
  line.cycles(10);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  EXPECT_EQ(line.ask(move(0.5), 1).phase, RequestPhase::kDone);
  line.expect_obedience();
}

std::string refusal_of(const std::vector<AxisGroupSettings>& configs, std::size_t axes = 3) {
  SingleLine line(axes);
  try {
    const AxisGroups groups(line.axes(), configs, kSinglePeriod);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(AxisGroups, ThatCannotBeAreRefusedWithASentence) {
  EXPECT_EQ(refusal_of({{"a", {0, 1}}, {"b", {2, 1}}}), "group 'b': axis 'axis1' is in group 'a' already");
  EXPECT_EQ(refusal_of({{"a", {0, 0}}}), "group 'a': axis 'axis0' is listed twice");
  EXPECT_EQ(refusal_of({{"a", {0, 7}}}), "group 'a': there is no axis with number 7");
  EXPECT_EQ(refusal_of({{"a", {}}}), "group 'a': it has no axes");
  EXPECT_EQ(refusal_of({{"", {0}}}), "a group needs a name");
  EXPECT_EQ(refusal_of({{"a", {0}}, {"a", {1}}}), "group 'a': another group has this name");
  EXPECT_EQ(refusal_of({{"a", {0}, 100}}), "group 'a': the capacity must be a power of two from 256 to 1048576");
  EXPECT_EQ(refusal_of({{"a", {0}, 256, kNan}}), "group 'a': its jerk_time_s must be above 0");
  EXPECT_EQ(refusal_of({{"a", {0, 1}}, {"b", {2}}}), "");
}

TEST(AxisGroups, AreEnabledWithAxesInStandstillOnly) {
  GroupLine line(3);
  ASSERT_EQ(line.ask(power(false), 1).phase, RequestPhase::kDone);
  auto report = line.ask_group(GroupCommand::kEnable);
  EXPECT_EQ(report.phase, RequestPhase::kError);
  EXPECT_EQ(report.error, GroupError::kAxisNotEnabled);
  EXPECT_EQ(report.axis, 1U);
  line.enable(1);
  ASSERT_NE(line.submit(request(AxisCommand::kMoveVelocity, 2.0), 2), 0U);
  line.cycles(10);
  report = line.ask_group(GroupCommand::kEnable);
  EXPECT_EQ(report.error, GroupError::kAxisMoves);
  EXPECT_EQ(report.axis, 2U);
  EXPECT_EQ(line.state(0), PlcopenState::kStandstill) << "all axes, or none";
  ASSERT_EQ(line.ask(request(AxisCommand::kHalt), 2).phase, RequestPhase::kDone);
  line.drives.drive(0).raise(slaves::msd::Fault::kOvercurrent);
  line.cycles(100);
  EXPECT_EQ(line.ask_group(GroupCommand::kEnable).error, GroupError::kAxisErrorStop);
  EXPECT_EQ(line.group_state(), GroupState::kDisabled);
}

TEST(AxisGroups, RefuseWhatTheirStateDoesNotAllow) {
  GroupLine line(2);
  const auto error_of = [&line](GroupCommand command, double value = 0.0) {
    return line.ask_group(command, value).error;
  };
  const auto error_of_move = [&line] { return line.finish_of_group(line.groups->move(0, line_to({1.0}))).error; };
  EXPECT_EQ(error_of_move(), GroupError::kNotEnabled);
  for (const auto command :
       {GroupCommand::kStop, GroupCommand::kHalt, GroupCommand::kInterrupt, GroupCommand::kContinue,
        GroupCommand::kReleaseStop, GroupCommand::kReverse, GroupCommand::kForward})
    EXPECT_EQ(error_of(command), GroupError::kNotEnabled) << to_text(command);
  EXPECT_EQ(line.ask_group(GroupCommand::kDisable).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask_group(GroupCommand::kReset).phase, RequestPhase::kDone);
  line.take_axes();
  for (const auto command : {GroupCommand::kInterrupt, GroupCommand::kContinue, GroupCommand::kReleaseStop,
                             GroupCommand::kReverse, GroupCommand::kForward})
    EXPECT_EQ(error_of(command), GroupError::kNothingToDo) << to_text(command);
  EXPECT_EQ(error_of(GroupCommand::kSetOverride, kNan), GroupError::kNotFinite);
  EXPECT_EQ(error_of(GroupCommand::kSetOverride, std::numeric_limits<double>::infinity()), GroupError::kNotFinite);
  EXPECT_EQ(error_of(GroupCommand::kSetOverride, -0.1), GroupError::kOverLimit);
  EXPECT_EQ(error_of(GroupCommand::kSetOverride, 2.1), GroupError::kOverLimit);
  EXPECT_EQ(line.ask_group(GroupCommand::kStop).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kStopping);
  EXPECT_EQ(error_of_move(), GroupError::kStopping);
  EXPECT_EQ(error_of(GroupCommand::kHalt), GroupError::kStopping);
  EXPECT_EQ(error_of(GroupCommand::kDisable), GroupError::kStopping);
  // Submitted in the same cycle, executed in this order.
  const auto released = line.submit_to_group(GroupCommand::kReleaseStop);
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to({0.2, 0.1}))).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(released), RequestPhase::kDone);
  EXPECT_EQ(line.groups->submit(7, {}), 0U);
  EXPECT_EQ(line.groups->move(7, {}), 0U);
  EXPECT_EQ(line.groups->report(1'000'000).phase, RequestPhase::kUnknown);
  line.expect_obedience();
}

TEST(AxisGroups, RefuseMovesThatCannotBeWithASentence) {
  StandbyGroup line(2);
  const auto reason_of = [&line](const GroupMove& move) {
    const auto id = line.groups->move(0, move);
    EXPECT_EQ(line.finish_of_group(id).error, GroupError::kBadMove);
    return line.groups->refusal(id);
  };
  EXPECT_EQ(reason_of(line_to({1.0, kNan})), "the target of axis 2 is nan; positions lie within +-1e6 m or rad");
  EXPECT_EQ(reason_of(line_to({1.0, 1.0}, 0.0)), "the feed is 0; it must be above 0");
  EXPECT_EQ(reason_of(line_to({1.0, 1.0, 1.0})), "the target has a value for axis 3 of 2");
  auto tolerant = line_to({1.0, 1.0});
  tolerant.path.tolerance = -1.0;
  EXPECT_EQ(reason_of(tolerant), "the tolerance is -1; it must be 0 or more, and finite");
  GroupMove arc = line_to({1.0, 1.0});
  arc.path.kind = PathMove::Kind::kArc;
  arc.path.center = {5.0, 5.0};
  EXPECT_NE(reason_of(arc), "");
  auto wide = line_to({1.0, 1.0});
  wide.target = {1.0, 1.0, 1.0};
  EXPECT_EQ(reason_of(wide), "the target has 3 values for 2 axes");
  // The axes have not moved. In a path the moves before a bad one are executed, those after it are not.
  EXPECT_EQ(line.group_state(), GroupState::kStandby);
  const std::vector<GroupMove> moves{line_to({0.1, 0.1}), line_to({kNan, 0.0}), line_to({0.5, 0.5})};
  const auto first = line.groups->move_path(0, moves);
  EXPECT_EQ(line.finish_of_group(first).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(first + 1), RequestPhase::kError);
  EXPECT_EQ(line.groups->report(first + 2).error, GroupError::kBadMove);
  EXPECT_EQ(line.group_phase(first + 2), RequestPhase::kAborted);
  EXPECT_LT(apart(line.place(), {0.1, 0.1}), kExact);
  line.expect_obedience();
}

TEST(AxisGroups, TheirAxesRefuseRequestsOfTheirOwn) {
  StandbyGroup line(3, {{"pair", {0, 1}}});
  ASSERT_NE(line.groups->move(0, line_to({4.0, 4.0})), 0U);
  line.cycles(200);
  for (const auto command :
       {AxisCommand::kMoveAbsolute, AxisCommand::kMoveVelocity, AxisCommand::kMoveSuperimposed, AxisCommand::kFollow,
        AxisCommand::kTorque, AxisCommand::kSetPosition, AxisCommand::kHome, AxisCommand::kSetMode,
        AxisCommand::kHomeByProbe, AxisCommand::kDriveMoveAbsolute, AxisCommand::kSetOverride}) {
    const auto report = line.ask(request(command, 0.5), 1);
    EXPECT_EQ(report.phase, RequestPhase::kError) << to_text(command);
    EXPECT_EQ(report.error, AxisError::kInGroup) << to_text(command);
  }
  EXPECT_EQ(line.ask(power(true), 1).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kMoving);
  // An axis outside all groups is not affected.
  EXPECT_EQ(line.ask(move(0.3), 2).phase, RequestPhase::kDone);
  line.expect_obedience();
}

TEST(AxisGroups, AStopOfOneAxisStopsAllOnThePath) {
  StandbyGroup line(2);
  const auto from = line.place();
  const GroupVector to{8.0, 6.0};
  auto moved = line.groups->move(0, line_to(to));
  line.cycles(800);
  ASSERT_EQ(line.group_state(), GroupState::kMoving);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt), 1).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(moved), RequestPhase::kAborted);
  EXPECT_EQ(line.groups->report(moved).error, GroupError::kAxisAsked);
  EXPECT_EQ(line.groups->report(moved).axis, 1U);
  EXPECT_EQ(line.group_state(), GroupState::kStandby);
  EXPECT_LT(from_line(line.place(), from, to), kExact);
  EXPECT_GT(apart(line.place(), to), 1.0);
  // A stop of an axis locks the group until the stop is released.
  moved = line.groups->move(0, line_to(to));
  line.cycles(400);
  EXPECT_EQ(line.ask(request(AxisCommand::kStop), 0).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kStopping);
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to(to))).error, GroupError::kStopping);
  EXPECT_EQ(line.ask(request(AxisCommand::kHalt), 0).error, AxisError::kStopping);
  EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop), 0).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask(request(AxisCommand::kReleaseStop), 0).error, AxisError::kNothingToDo);
  EXPECT_EQ(line.group_state(), GroupState::kStandby);
  // Finally power is switched off: the group comes to rest and releases its axes.
  ASSERT_NE(line.groups->move(0, line_to(to)), 0U);
  line.cycles(400);
  const auto off = line.submit(power(false), 0);
  const auto off_too = line.submit(power(false), 1);
  EXPECT_EQ(line.finish(off).phase, RequestPhase::kDone);
  EXPECT_EQ(line.finish(off_too).phase, RequestPhase::kDone);
  EXPECT_LT(from_line(line.place(), from, to), 1e-3) << "held by nobody now";
  EXPECT_EQ(line.group_state(), GroupState::kDisabled);
  EXPECT_EQ(line.state(0), PlcopenState::kDisabled);
  EXPECT_EQ(line.state(1), PlcopenState::kDisabled);
  line.expect_obedience();
}

TEST(AxisGroups, AnAbortingMoveBeginsWhereThePathWasLeft) {
  StandbyGroup line(2);
  const auto from = line.place();
  const auto first = line.groups->move(0, line_to({8.0, 0.0}));
  auto waiting = line_to({8.0, 8.0});
  waiting.buffer = GroupBuffer::kBuffered;
  const auto second = line.groups->move(0, waiting);
  line.cycles(600);
  const auto third = line.groups->move(0, line_to({0.0, 1.0}));
  double left = 0.0;
  for (int i = 0; i < 8000 && line.group_phase(third) != RequestPhase::kActive; ++i) {
    line.cycle();
    left = std::max(left, from_line(line.place(), from, {8.0, 0.0}));
  }
  EXPECT_LT(left, 1e-6) << "what a move does in its first cycle is seen before it is told to be active";
  EXPECT_EQ(line.group_phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.group_phase(second), RequestPhase::kAborted);
  EXPECT_EQ(line.finish_of_group(third).phase, RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), {0.0, 1.0}), kExact);
  line.expect_obedience();
}

TEST(AxisGroups, BufferedMovesStopInBetweenAndBlendedOnesDoNot) {
  StandbyGroup line(2);
  const auto slowest_at_corner = [&line](GroupBuffer buffer, double shift) {
    EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to({shift, shift}))).phase, RequestPhase::kDone);
    auto first = line_to({shift + 3.0, shift});
    first.path.tolerance = 0.05;
    first.continues = true;
    auto second = line_to({shift + 3.0, shift + 3.0});
    second.buffer = buffer;
    const auto begun = line.groups->move(0, first);
    const auto id = line.groups->move(0, second);
    double slowest = 1e9;
    double nearest = 1e9;
    auto before = line.place();
    while (!line.groups->report(id).over()) {
      line.cycle();
      // The nearest position may be between two cycles.
      nearest = std::min(nearest, from_line({shift + 3.0, shift}, before, line.place()));
      before = line.place();
      const bool near = apart(line.place(), {shift + 3.0, shift}) < 0.5;
      if (near) slowest = std::min(slowest, line.groups->group_report(0).speed);
    }
    EXPECT_EQ(line.group_phase(begun), RequestPhase::kDone);
    EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
    return std::pair{slowest, nearest};
  };
  const auto [stopped, met] = slowest_at_corner(GroupBuffer::kBuffered, 0.0);
  EXPECT_LT(stopped, 1e-6);
  EXPECT_LT(met, kExact);
  const auto [blended, passed] = slowest_at_corner(GroupBuffer::kBlending, 1.0);
  EXPECT_GT(blended, 1.0);
  EXPECT_GT(passed, 0.01);
  EXPECT_LT(passed, 0.05 + 1e-6);
  line.expect_obedience();
}

// A move was announced but not submitted: the axes still reach the end of their path.
TEST(AxisGroups, AMoveThatWasAnnouncedAndDoesNotComeIsNotWaitedFor) {
  StandbyGroup line(2);
  auto first = line_to({0.5, 0.5});
  first.continues = true;
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, first)).phase, RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), {0.5, 0.5}), kExact);
}

TEST(AxisGroups, APathInPartsDoesNotStopBetweenThemHoweverLongTheAxesHaveStoodBefore) {
  StandbyGroup line(2);
  ASSERT_EQ(line.finish_of_group(line.groups->move(0, line_to({0.1, 0.0}))).phase, RequestPhase::kDone);
  line.cycles(1000);
  auto first = line_to({0.3, 0.0});
  first.continues = true;
  ASSERT_NE(line.groups->move(0, first), 0U);
  line.cycles(3);
  auto second = line_to({0.5, 0.0});
  second.buffer = GroupBuffer::kBlending;
  const auto id = line.groups->move(0, second);
  double slowest = 1.0;
  for (int i = 0; i < 16000 && !line.groups->report(id).over(); ++i) {
    const auto before = line.place()[0];
    line.cycle();
    if (before > 0.25 && before < 0.35) slowest = std::min(slowest, line.place()[0] - before);
  }
  EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), {0.5, 0.0}), kExact);
  EXPECT_GT(slowest, 1e-6) << "rad in a cycle";
}

TEST(AxisGroups, RelativeMovesAndArcs) {
  StandbyGroup line(2);
  const auto from = line.place();
  auto by = line_to({1.0, 2.0});
  by.relative = true;
  ASSERT_EQ(line.finish_of_group(line.groups->move(0, by)).phase, RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), {from[0] + 1.0, from[1] + 2.0}), kExact);
  // Half a circle.
  const auto begin = line.place();
  GroupMove arc;
  arc.relative = true;
  arc.path.kind = PathMove::Kind::kArc;
  arc.path.center = {1.0, 0.0};
  arc.path.target = {2.0, 0.0};
  arc.path.feed = 10.0;
  const auto id = line.groups->move(0, arc);
  double worst = 0.0;
  while (!line.groups->report(id).over()) {
    line.cycle();
    worst = std::max(worst, std::abs(apart(line.place(), {begin[0] + 1.0, begin[1]}) - 1.0));
  }
  EXPECT_LT(worst, kExact);
  EXPECT_LT(apart(line.place(), {begin[0] + 2.0, begin[1]}), kExact);
  line.expect_obedience();
}

TEST(AxisGroups, AreInterruptedContinuedReversedAndHeldOnThePath) {
  StandbyGroup line(2);
  const auto from = line.place();
  const GroupVector to{10.0, 5.0};
  const auto id = line.groups->move(0, line_to(to, 40.0));
  line.cycles(1000);
  EXPECT_EQ(line.ask_group(GroupCommand::kInterrupt).phase, RequestPhase::kDone);
  EXPECT_TRUE(line.groups->group_report(0).interrupted);
  EXPECT_EQ(line.ask_group(GroupCommand::kInterrupt).error, GroupError::kNothingToDo);
  const auto held = line.place();
  line.cycles(500);
  EXPECT_EQ(apart(line.place(), held), 0.0);
  EXPECT_EQ(line.group_state(), GroupState::kMoving);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kActive);
  EXPECT_EQ(line.ask_group(GroupCommand::kReverse).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask_group(GroupCommand::kContinue).phase, RequestPhase::kDone);
  line.cycles(4000);
  EXPECT_LT(apart(line.place(), from), kExact) << "back at the begin";
  EXPECT_TRUE(line.groups->group_report(0).backwards);
  EXPECT_EQ(line.ask_group(GroupCommand::kForward).phase, RequestPhase::kDone);
  line.cycles(1000);
  EXPECT_EQ(line.ask_group(GroupCommand::kSetOverride, 0.0).phase, RequestPhase::kDone);
  line.cycles(2000);
  const auto stands = line.place();
  EXPECT_GT(apart(stands, to), 1.0);
  line.cycles(500);
  EXPECT_EQ(apart(line.place(), stands), 0.0);
  EXPECT_EQ(line.ask_group(GroupCommand::kSetOverride, 2.0).phase, RequestPhase::kDone);
  EXPECT_EQ(line.finish_of_group(id).phase, RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), to), kExact);
  line.expect_obedience();
}

TEST(AxisGroups, AfterAFailureAreResetAndEnabledAnew) {
  StandbyGroup line(3);
  const auto id = line.groups->move(0, line_to({9.0, 9.0, 9.0}));
  line.cycles(800);
  line.drives.drive(1).raise(slaves::msd::Fault::kOvercurrent);
  EXPECT_EQ(line.finish_of_group(id).phase, RequestPhase::kAborted);
  EXPECT_EQ(line.groups->report(id).error, GroupError::kAxisFailed);
  EXPECT_EQ(line.groups->report(id).axis, 1U);
  const auto report = line.groups->group_report(0);
  EXPECT_EQ(report.state, GroupState::kErrorStop);
  EXPECT_EQ(report.error, GroupError::kAxisFailed);
  EXPECT_EQ(report.failed_axis, 1U);
  EXPECT_EQ(report.axis_error, AxisError::kFault);
  EXPECT_NE(report.error_code, 0);
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to({1.0}))).error, GroupError::kErrorStop);
  EXPECT_EQ(line.ask_group(GroupCommand::kEnable).error, GroupError::kErrorStop);
  line.cycles(4000);
  EXPECT_EQ(line.state(0), PlcopenState::kStandstill) << "given back";
  EXPECT_EQ(line.ask_group(GroupCommand::kReset, 0.0).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kDisabled);
  EXPECT_EQ(line.groups->group_report(0).axis_error, AxisError::kNone);
  EXPECT_EQ(line.state(1), PlcopenState::kDisabled);
  line.enable(1);
  line.take_axes();
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to({0.0, 0.0, 0.0}))).phase, RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), {0.0, 0.0, 0.0}), kExact);
  line.judges[0].expect_obedience();
  line.judges[2].expect_obedience();
}

// Paths of any length in bounded memory, submitted as there is room.
TEST(AxisGroups, FollowAPathWithoutEnd) {
  StandbyGroup line(2, {{"plotter", {0, 1}, 256}});
  constexpr int kMoves = 2000;
  constexpr int kPart = 16;
  std::uint64_t last = 0;
  int handed = 0;
  const auto point = [](int n) { return GroupVector{0.02 * n, 0.3 * std::sin(0.05 * n)}; };
  for (int cycle = 0; cycle < 200'000 && (last == 0 || !line.groups->report(last).over()); ++cycle) {
    if (handed < kMoves && line.groups->room(0) >= kPart) {
      std::vector<GroupMove> part;
      for (int i = 0; i < kPart; ++i) {
        part.push_back(line_to(point(++handed), 40.0));
        part.back().path.tolerance = 0.002;
        part.back().continues = handed < kMoves;
        part.back().buffer = GroupBuffer::kBlending;
      }
      last = line.groups->move_path(0, part) + kPart - 1;
      ASSERT_GE(last, static_cast<std::uint64_t>(kPart));
    }
    line.cycle();
  }
  EXPECT_EQ(line.group_phase(last), RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), point(kMoves)), kExact);
  // A path with more moves than can wait is refused as a whole.
  const std::vector<GroupMove> many(AxisGroups::kMaxMoves + 1, line_to({1.0, 1.0}));
  EXPECT_EQ(line.groups->move_path(0, many), 0U);
  EXPECT_EQ(line.groups->room(0), AxisGroups::kMaxMoves);
  line.expect_obedience();
}

// kSetPosition shifts the positions, but the limits stay where they were.
TEST(AxisGroups, NoMoveLeavesTheSoftwareLimits) {
  auto options = single_options();
  options.software_limits = trajectory::PositionRange{-1.0, 1.0};
  GroupLine line(2, {}, options);
  ASSERT_EQ(line.ask(move(0.0), 0).phase, RequestPhase::kDone);
  ASSERT_EQ(line.ask(move(0.0), 1).phase, RequestPhase::kDone);
  ASSERT_EQ(line.ask(request(AxisCommand::kSetPosition, 10.0), 1).phase, RequestPhase::kDone);
  line.take_axes();
  const auto reason_of = [&line](const GroupMove& move) {
    const auto id = line.groups->move(0, move);
    line.finish_of_group(id);
    return line.groups->refusal(id);
  };
  EXPECT_EQ(reason_of(line_to({0.5, 11.1})), "axis 'axis1' would get to 11.1; its software limits are 9 and 11");
  EXPECT_EQ(reason_of(line_to({-1.1, 10.0})), "axis 'axis0' would get to -1.1; its software limits are -1 and 1");
  // Up to the limit, and back on an arc that would exceed it.
  EXPECT_EQ(reason_of(line_to({1.0, 11.0}, 50.0)), "");
  EXPECT_LT(apart(line.place(), {1.0, 11.0}), kExact);
  GroupMove arc = line_to({0.0, 11.0});
  arc.path.kind = PathMove::Kind::kArc;
  arc.path.center = {0.5, 11.0};
  EXPECT_EQ(reason_of(arc).find("axis 'axis1' would get to"), 0U) << "above its ends";
  arc.path.clockwise = true;
  EXPECT_EQ(reason_of(arc), "") << "below";
  EXPECT_LT(apart(line.place(), {0.0, 11.0}), kExact);
  EXPECT_EQ(line.group_state(), GroupState::kStandby);
  line.expect_obedience();
}

// The group is updated before the couplings, so its setpoints are those of the same cycle.
TEST(AxisGroups, AnAxisOfAGroupIsTheMasterOfAGear) {
  GroupLine line(3, {{"pair", {0, 1}}});
  motion::Couplings couplings(line.axes(), std::vector<motion::Couplings::Pair>{{2, 0}}, kSinglePeriod);
  line.take_axes();
  const auto ratio = trajectory::GearRatio::make(1, 2).value();
  const auto law = trajectory::CouplingLaw::gear(ratio, line.setpoint(0), line.setpoint(2));
  ASSERT_NE(couplings.engage(2, law, trajectory::CatchUp::kPosition), 0U);
  line.cycles(100);
  const auto id = line.groups->move(0, line_to({5.0, -3.0}));
  double worst = 0.0;
  while (!line.groups->report(id).over()) {
    line.cycle();
    worst = std::max(worst, std::abs(line.setpoint(2) - law.at(line.setpoint(0)).position));
  }
  EXPECT_LT(worst, kExact);
  EXPECT_EQ(couplings.report(2).losses, 0U);
  // An axis that can be led by a coupling cannot join a group.
  try {
    const AxisGroups more(line.axes(), {{"slaves", {2}}}, kSinglePeriod);
    FAIL() << "it has a feed";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "group 'slaves': axis 'axis2' follows a gear, a cam or a stream already");
  }
  line.expect_obedience();
}

/// As many requests and moves as the queues take, while the axes move.
TEST(AxisGroups, AStopIsTakenInTheNextCycleWhateverWaits) {
  for (const bool of_axis : {false, true}) {
    StandbyGroup line(2);
    const auto first = line.groups->move(0, line_to({8.0, 6.0}));
    line.cycles(400);
    std::vector<std::uint64_t> moves;
    while (line.groups->room(0) > 0)
      moves.push_back(line.groups->move(0, line_to({0.01 * static_cast<double>(moves.size())})));
    EXPECT_EQ(moves.size(), AxisGroups::kMaxMoves);
    for (int i = 0; i < 10'000; ++i) static_cast<void>(line.submit_to_group(GroupCommand::kSetOverride, 1.0));
    ASSERT_EQ(line.submit_to_group(GroupCommand::kSetOverride, 1.0), 0U) << "the queue is full";
    const auto of_group = of_axis ? 0 : line.submit_to_group(GroupCommand::kStop);
    if (of_axis) line.submit(request(AxisCommand::kStop), 1);
    line.SingleLine::cycle();
    ASSERT_EQ(line.group_state(), GroupState::kStopping);
    line.cycles(1000);
    if (!of_axis) {
      EXPECT_EQ(line.group_phase(of_group), RequestPhase::kDone);
    }
    EXPECT_EQ(line.group_phase(first), RequestPhase::kAborted);
    for (const auto id : moves) EXPECT_EQ(line.group_phase(id), RequestPhase::kAborted);
    EXPECT_EQ(line.group_state(), GroupState::kStopping);
    line.expect_obedience();
  }
}

TEST(AxisGroups, WhatWouldResumeTheMotionDoesNotDoSoAfterALaterStop) {
  StandbyGroup line(2);
  ASSERT_NE(line.groups->move(0, line_to({8.0, 6.0})), 0U);
  line.cycles(400);
  ASSERT_EQ(line.ask_group(GroupCommand::kInterrupt).phase, RequestPhase::kDone);
  const auto flood = [&line] {
    for (int i = 0; i < 200; ++i) static_cast<void>(line.submit_to_group(GroupCommand::kSetOverride, 1.0));
  };
  flood();
  const auto resumed = line.submit_to_group(GroupCommand::kContinue);
  const auto held = line.submit_to_group(GroupCommand::kInterrupt);
  line.cycles(100);
  EXPECT_EQ(line.groups->report(held).error, GroupError::kNothingToDo) << "it is held already";
  EXPECT_EQ(line.group_phase(resumed), RequestPhase::kAborted);
  EXPECT_TRUE(line.groups->group_report(0).interrupted);
  EXPECT_EQ(line.ask_group(GroupCommand::kStop).phase, RequestPhase::kDone);
  flood();
  const auto released = line.submit_to_group(GroupCommand::kReleaseStop);
  const auto stopped = line.submit_to_group(GroupCommand::kStop);
  line.cycles(100);
  EXPECT_EQ(line.group_phase(released), RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(stopped), RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kStopping);
  EXPECT_EQ(line.ask_group(GroupCommand::kReleaseStop).phase, RequestPhase::kDone);
  EXPECT_EQ(line.ask_group(GroupCommand::kDisable).phase, RequestPhase::kDone);
  flood();
  const auto enabled = line.submit_to_group(GroupCommand::kEnable);
  const auto disabled = line.submit_to_group(GroupCommand::kDisable);
  line.cycles(100);
  EXPECT_EQ(line.group_phase(enabled), RequestPhase::kAborted);
  EXPECT_EQ(line.group_phase(disabled), RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kDisabled);
  line.expect_obedience();
}

TEST(AxisGroups, AMoveThatFollowsAStopOrAHaltIsPlannedAfterIt) {
  StandbyGroup line(2);
  const auto first = line.groups->move(0, line_to({8.0, 6.0}));
  line.cycles(400);
  const auto halted = line.submit_to_group(GroupCommand::kHalt);
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to({1.0, 1.0}))).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.group_phase(halted), RequestPhase::kDone);
  EXPECT_LT(apart(line.place(), {1.0, 1.0}), kExact);
  const auto stopped = line.submit_to_group(GroupCommand::kStop);
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to({2.0, 2.0}))).error, GroupError::kStopping);
  EXPECT_EQ(line.group_phase(stopped), RequestPhase::kDone);
  line.expect_obedience();
}

TEST(AxisGroups, ArePlannedByAThreadOfTheirOwn) {
  StandbyGroup line(2);
  line.groups->start_planning();
  for (const double to : {1.0, -1.0, 2.0}) {
    const auto id = line.groups->move(0, line_to({to, -to}));
    while (!line.groups->report(id).over()) line.SingleLine::cycle();
    EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
    EXPECT_LT(apart(line.place(), {to, -to}), kExact);
  }
  line.groups->stop_planning();
  line.expect_obedience();
}

/// Cycle, planning and client are threads of their own.
TEST(AxisGroups, AreStoppedWhileAThreadPlans) {
  StandbyGroup line(2);
  line.groups->start_planning();
  for (int turn = 0; turn < 10; ++turn) {
    std::vector<std::uint64_t> moves;
    for (int i = 0; i < 20; ++i) {
      auto move = line_to({0.1 * i, 0.05 * turn});
      move.buffer = GroupBuffer::kBuffered;
      moves.push_back(line.groups->move(0, move));
    }
    line.SingleLine::cycles(100);
    std::uint64_t halted = 0;
    std::thread client([&line, &halted] { halted = line.submit_to_group(GroupCommand::kHalt); });
    line.SingleLine::cycles(20);
    client.join();
    moves.push_back(halted);
    for (const auto id : moves) {
      while (!line.groups->report(id).over()) line.SingleLine::cycle();
    }
    EXPECT_EQ(line.group_phase(halted), RequestPhase::kDone);
    EXPECT_EQ(line.group_state(), GroupState::kStandby);
  }
  line.groups->stop_planning();
  line.expect_obedience();
}

}  // namespace
}  // namespace driveline::bus_test
