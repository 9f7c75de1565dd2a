#include <gtest/gtest.h>

#include "contour_oracle.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "driveline/trajectory/delta_kinematics.hpp"
#include "driveline/trajectory/scara_kinematics.hpp"

namespace driveline::trajectory {
namespace {

using test::arc_by;
using test::ContourOracle;
using test::ContourRun;
using test::distance;
using test::line_to;
using test::MovePlan;

constexpr double kFast = 1e9;
constexpr std::size_t kLongest = 2'000'000;

const ScaraKinematics& scara() {
  static const ScaraKinematics kMachine({0.35, 0.25, true});
  return kMachine;
}

const RotaryDeltaKinematics& delta() {
  static const RotaryDeltaKinematics kMachine({0.2, 0.045, 0.25, 0.6});
  return kMachine;
}

ContourSettings delta_settings() {
  ContourSettings settings;
  settings.axes = 3;
  settings.capacity = 2048;
  settings.kinematics = &delta();
  settings.tool = {5.0, 50.0, 4000.0};
  for (std::size_t i = 0; i < 3; ++i) settings.limits[i] = {15.0, 300.0, 30'000.0};
  return settings;
}

ContourSettings scara_settings() {
  ContourSettings settings;
  settings.axes = 4;
  settings.capacity = 2048;
  settings.kinematics = &scara();
  settings.tool.max_velocity = 3.0;
  settings.limits[0] = {6.0, 60.0, 5000.0};
  settings.limits[1] = {8.0, 80.0, 6000.0};
  settings.limits[2] = {1.0, 10.0, 1000.0};
  settings.limits[3] = {10.0, 100.0, 9000.0};
  return settings;
}

/// Random lines and arcs around a position, without those that the planner refuses.
MovePlan possible_moves(test::Random& random, const ContourSettings& settings, const GroupVector& about, double size,
                        std::size_t count) {
  MovePlan plan = test::random_moves(random, settings.axes, count, size);
  const auto shift = [&](GroupVector& place) {
    for (std::size_t i = 0; i < kMaxGroupAxes; ++i) place[i] += about[i];
  };
  shift(plan.start);
  for (auto& move : plan.moves) {
    shift(move.target);
    shift(move.center);
  }
  const PathCheck check(settings);
  PathShaper shaper(settings.axes, plan.start, &check);
  std::vector<ShapedPiece> out;
  MovePlan possible{plan.start, {}};
  for (const auto& move : plan.moves) {
    if (!shaper.add(move, out)) break;
    possible.moves.push_back(move);
  }
  return possible;
}

void expect_limits_on_random_paths(const ContourSettings& settings, const GroupVector& about, double size) {
  test::Random random;
  std::array<double, 3> used{};
  constexpr int kRounds = 60;
  for (int round = 0; round < kRounds; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const auto plan = possible_moves(random, settings, about, size, random.index(1, 6));
    if (plan.moves.empty()) continue;
    ContourRun run(settings, plan);
    ContourOracle oracle(settings, plan);
    ContourSetpoint last;
    std::size_t cycle = 0;
    const auto busy = random.index(1, 2000);
    const auto end = run.to_end(
        settings.period_s, kLongest,
        [&](const ContourSetpoint& setpoint) {
          oracle.take(setpoint);
          last = setpoint;
          ++cycle;
          if (cycle == busy) run.follower().hold(true);
          if (cycle == busy + 300) run.follower().reverse(true);
          if (cycle == busy + 500) run.follower().hold(false);
          if (cycle == busy + 700) run.follower().reverse(false);
          if (cycle == busy + 900) run.follower().set_override(1.7);
        },
        busy + 1000);
    ASSERT_EQ(oracle.verdict(), "");
    ASSERT_TRUE(end.has_value());
    GroupVector tool = last.position;
    ASSERT_TRUE(settings.kinematics->forward(last.position, tool));
    ASSERT_LT(distance(tool, plan.moves.back().target), 2e-9);
    ASSERT_LT(distance(tool, last.tool), 1e-12);
    for (std::size_t i = 0; i < 3; ++i) used[i] = std::max(used[i], oracle.used()[i]);
  }
  // The limits of acceleration and jerk must be used, or the test would show nothing.
  EXPECT_GT(used[1], 0.9);
  EXPECT_GT(used[2], 0.7);
}

TEST(ContourKinematics, ADeltaKeepsTheLimitsOfItsJointsAndItsTool) {
  expect_limits_on_random_paths(delta_settings(), {0.0, 0.0, -0.55}, 0.12);
}

TEST(ContourKinematics, AScaraKeepsTheLimitsOfItsJoints) {
  expect_limits_on_random_paths(scara_settings(), {0.38, 0.05, -0.1, 0.0}, 0.12);
}

TEST(ContourKinematics, ALineByTheInnerEdgeOfTheReachIsAsSlowAsTheElbowNeedsThere) {
  // If the arm is almost folded, a small step of the tool is a large one of the elbow.
  auto settings = scara_settings();
  const MovePlan plan{{0.12, -0.3, 0.0, 0.0}, {line_to({0.12, 0.3, 0.0, 0.0}, kFast, 0.0)}};
  ContourRun run(settings, plan);
  ContourOracle oracle(settings, plan);
  ASSERT_TRUE(run.to_end(settings.period_s, kLongest, [&](const ContourSetpoint& setpoint) { oracle.take(setpoint); }));
  EXPECT_EQ(oracle.verdict(), "");
  EXPECT_GT(oracle.used()[1], 0.6);
}

TEST(ContourKinematics, AJointLimitOnePercentTooLargeIsFound) {
  const auto real = delta_settings();
  auto believed = real;
  for (auto& limits : believed.limits) limits.max_velocity *= 1.02;
  const MovePlan plan{{-0.2, 0.0, -0.5}, {line_to({0.2, 0.0, -0.5}, kFast, 0.0)}};
  auto slow_real = real;
  auto slow_believed = believed;
  for (std::size_t i = 0; i < 3; ++i) {
    slow_real.limits[i].max_velocity = 2.0;
    slow_believed.limits[i].max_velocity = 2.04;
  }
  const auto verdict = [&](const ContourSettings& planned) {
    ContourRun run(planned, plan);
    ContourOracle oracle(slow_real, plan);
    run.to_end(real.period_s, kLongest, [&](const ContourSetpoint& setpoint) { oracle.take(setpoint); });
    return oracle.verdict();
  };
  EXPECT_EQ(verdict(slow_real), "");
  EXPECT_NE(verdict(slow_believed).find("velocity of axis"), std::string::npos);
}

/// Why a move is refused; empty: it is accepted.
std::string refusal(const ContourSettings& settings, const GroupVector& start, const std::vector<PathMove>& moves) {
  ContourTrack track(settings, start);
  ContourPlanner planner(track);
  for (const auto& move : moves) {
    const auto target = planner.target();
    if (const auto added = planner.add(move); !added) {
      EXPECT_EQ(distance(planner.target(), target), 0.0);
      return added.error().reason;
    }
  }
  return "";
}

TEST(ContourKinematicsBadInput, UnreachablePlacesAreRefusedBeforeAnythingMoves) {
  const auto settings = scara_settings();
  EXPECT_EQ(refusal(settings, {0.4}, {line_to({0.5, 0.4}, kFast, 0.0)}).find("the machine cannot reach ("), 0U);
  // Both ends can be reached, but not the positions in between.
  const auto inner = refusal(settings, {0.0, 0.4}, {line_to({0.01, -0.4}, kFast, 0.0)});
  EXPECT_EQ(inner.find("the machine cannot reach ("), 0U) << inner;
  EXPECT_EQ(refusal(delta_settings(), {0.0, 0.0, -0.5}, {line_to({0.0, 0.0, -0.9}, kFast, 0.0)}).find("the "), 0U);
  // The whole circle is checked, not only its ends.
  EXPECT_NE(refusal(settings, {0.4}, {arc_by({0.4}, 0.52, 0.0, 2.0 * std::numbers::pi, kFast, 0.0)}), "");
  EXPECT_EQ(refusal(settings, {0.4}, {arc_by({0.4}, 0.45, 0.0, 2.0 * std::numbers::pi, kFast, 0.0)}), "");
}

TEST(ContourKinematicsBadInput, ASingularPlaceBetweenTwoGoodOnesIsRefused) {
  const auto settings = scara_settings();
  const auto reason = refusal(settings, {0.1001, -0.3}, {line_to({0.1001, 0.31}, kFast, 0.0)});
  EXPECT_NE(reason.find("singular position of the machine at (0.1001, "), std::string::npos) << reason;
  EXPECT_NE(reason.find("the arms would be stretched or folded there"), std::string::npos) << reason;
}

TEST(ContourKinematicsBadInput, AShoulderThatWouldLeapBehindTheMachineIsRefused) {
  const auto settings = scara_settings();
  const auto reason = refusal(settings, {-0.3, 0.3}, {line_to({-0.3, -0.3}, kFast, 0.0)});
  EXPECT_EQ(reason.find("axis 1 would have to leap from "), 0U) << reason;
}

TEST(ContourKinematicsBadInput, AMachineThatCannotBeAtItsBeginIsRefused) {
  EXPECT_THROW(ContourTrack(scara_settings(), {0.9}), std::invalid_argument);
  auto settings = scara_settings();
  settings.tool.max_velocity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(check_settings(settings), "a machine with kinematics needs a velocity limit of its tool");
  settings = scara_settings();
  settings.axes = 3;
  EXPECT_EQ(check_settings(settings), "the machine has 4 joints, the group 3 axes");
  settings = scara_settings();
  settings.tool.max_jerk = 0.0;
  EXPECT_EQ(check_settings(settings), "the limits of the tool must be above 0");
}

ContourSettings limited(double low, double high) {
  ContourSettings settings;
  settings.axes = 2;
  settings.capacity = 256;
  for (std::size_t i = 0; i < 2; ++i) settings.limits[i] = {1.0, 10.0, 1000.0, low, high};
  return settings;
}

TEST(ContourSoftwareLimits, ExtremesOfArcsAndCurvesCount) {
  const auto settings = limited(-0.1, 0.1);
  EXPECT_EQ(refusal(settings, {}, {line_to({0.1, -0.1}, kFast, 0.0)}), "");
  EXPECT_EQ(refusal(settings, {}, {line_to({0.1001}, kFast, 0.0)}),
            "axis 1 would be at 0.1001, beyond its highest position of 0.1 m or rad");
  EXPECT_EQ(refusal(settings, {}, {line_to({0.0, -0.1001}, kFast, 0.0)}),
            "axis 2 would be at -0.1001, beyond its lowest position of -0.1 m or rad");
  // A whole circle that touches the limit, and another one a micrometre too large: both start and end in the middle.
  const auto circle = [](double radius) { return arc_by({}, radius, 0.0, 2.0 * std::numbers::pi, kFast, 0.0); };
  EXPECT_EQ(refusal(settings, {}, {circle(0.05)}), "");
  EXPECT_EQ(refusal(settings, {}, {circle(0.0500005)}),
            "axis 1 would be at 0.100001, beyond its highest position of 0.1 m or rad");
  // An arc whose ends are inside, but not its middle.
  const auto arc = arc_by({0.05, 0.05}, 0.02, 0.02, 2.5, kFast, 0.0);
  // Its top is between the checked positions.
  const double top = 0.02 + std::hypot(0.03, 0.03);
  EXPECT_EQ(refusal(limited(-0.1, top - 1e-6), {0.05, 0.05}, {arc}).find("axis 2 would be at 0.06242"), 0U);
  EXPECT_EQ(refusal(limited(-0.1, top), {0.05, 0.05}, {arc}), "");
  // A spline overshoots its points.
  PathMove spline = line_to({}, kFast, 0.0);
  spline.kind = PathMove::Kind::kSpline;
  spline.points = {{0.03, 0.09}, {0.06, 0.09}, {0.09, 0.0}};
  EXPECT_EQ(refusal(limited(-0.1, 0.0901), {}, {spline}).find("axis 2 would be at 0."), 0U);
}

TEST(ContourSoftwareLimits, JointsHaveThemToo) {
  auto settings = scara_settings();
  settings.limits[0].min_position = -1.0;
  settings.limits[0].max_position = 1.0;
  EXPECT_EQ(refusal(settings, {0.4, 0.1}, {line_to({0.4, 0.3}, kFast, 0.0)}), "");
  const auto reason =
      refusal(settings, {0.4, 0.1}, {line_to({0.1, 0.45}, kFast, 0.0), line_to({-0.3, 0.3}, kFast, 0.0)});
  EXPECT_NE(reason.find("axis 1 would be at "), std::string::npos) << reason;
}

TEST(ContourSoftwareLimits, RangesThatAreNoneAreRefused) {
  EXPECT_EQ(check_settings(limited(0.1, 0.1)), "the lowest position of axis 1 must be below its highest one");
  EXPECT_EQ(check_settings(limited(std::nan(""), 0.1)), "the lowest position of axis 1 must be below its highest one");
  EXPECT_THROW(ContourTrack(limited(-0.1, 0.1), {0.2}), std::invalid_argument);
}

TEST(ContourKinematics, TheCycleUsesNeitherHeapNorLocks) {
  if (!rt::RtGuard::available()) {
    GTEST_SKIP() << "a sanitizer owns malloc in this build";
  }
  const auto settings = delta_settings();
  const MovePlan plan{{-0.2, 0.0, -0.5}, {line_to({0.2, 0.0, -0.5}, 0.2, 0.0)}};
  ContourRun run(settings, plan);
  run.plan();
  auto& follower = run.follower();
  rt::RtGuard::enter();
  for (int cycle = 0; cycle < 5'000; ++cycle) follower.step();
  const auto counts = rt::RtGuard::leave();
  EXPECT_EQ(counts.total(), 0U);
}

}  // namespace
}  // namespace driveline::trajectory
