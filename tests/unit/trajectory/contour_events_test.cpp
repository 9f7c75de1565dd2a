#include <gtest/gtest.h>

#include "contour_oracle.hpp"

namespace driveline::trajectory {
namespace {

using test::ContourOracle;
using test::ContourRun;
using test::line_to;
using test::MovePlan;

constexpr double kFast = 1e9;
constexpr double kEnd = std::numeric_limits<double>::infinity();
constexpr std::size_t kLongest = 2'000'000;

ContourSettings settings_of(std::size_t axes) {
  ContourSettings settings;
  settings.axes = axes;
  settings.capacity = 256;
  for (std::size_t i = 0; i < axes; ++i) settings.limits[i] = {1.0, 10.0, 1000.0};
  return settings;
}

PathMove with_outputs(PathMove move, std::vector<MoveOutput> outputs, double dwell_s = 0.0) {
  move.outputs = std::move(outputs);
  move.dwell_s = dwell_s;
  return move;
}

MoveOutput change(std::uint32_t output, double at) {
  return {{output, 1.0}, at};
}

/// Reports of the cycle, with their times.
struct Told {
  std::uint32_t output;
  std::size_t cycle;
  GroupVector before;
  GroupVector position;
};

/// All reports and setpoints of a run.
struct Story {
  std::vector<Told> told;
  std::vector<ContourSetpoint> setpoints;

  void take(const ContourSetpoint& setpoint) {
    for (const auto& each : setpoint.changed_outputs()) {
      const auto before = setpoints.empty() ? setpoint.position : setpoints.back().position;
      told.push_back({each.output, setpoints.size(), before, setpoint.position});
    }
    setpoints.push_back(setpoint);
  }
  [[nodiscard]] std::vector<std::uint32_t> outputs() const {
    std::vector<std::uint32_t> all;
    for (const auto& each : told) all.push_back(each.output);
    return all;
  }
  /// Seconds at standstill at a position.
  [[nodiscard]] double rest_s(const GroupVector& place, double period_s) const {
    std::size_t count = 0;
    for (const auto& each : setpoints) count += test::distance(each.position, place) < 1e-9 ? 1 : 0;
    return static_cast<double>(count) * period_s;
  }
};

Story story_of(const ContourSettings& settings, const MovePlan& plan) {
  ContourRun run(settings, plan);
  ContourOracle oracle(settings, plan);
  Story story;
  EXPECT_TRUE(run.to_end(settings.period_s, kLongest, [&](const ContourSetpoint& setpoint) {
    oracle.take(setpoint);
    story.take(setpoint);
  }));
  EXPECT_EQ(oracle.verdict(), "");
  return story;
}

using Numbers = std::vector<std::uint32_t>;

TEST(ContourEvents, OutputsAreToldInTheCycleInWhichTheAxesPassTheirPlaces) {
  const auto settings = settings_of(1);
  const auto move = with_outputs(line_to({0.2}, kFast, 0.0),
                                 {change(1, 0.05), change(4, kEnd), change(3, -0.05), change(2, 0.1), change(0, 0.0)});
  const auto story = story_of(settings, {{}, {move}});
  ASSERT_EQ(story.outputs(), (Numbers{0, 1, 2, 3, 4}));
  constexpr std::array<double, 5> kPlaces{0.0, 0.05, 0.1, 0.15, 0.2};
  for (std::size_t k = 1; k < kPlaces.size(); ++k) {
    EXPECT_LT(story.told[k].before[0], kPlaces[k]);
    EXPECT_GE(story.told[k].position[0], kPlaces[k] - 1e-12);
  }
}

TEST(ContourEvents, TheEndOfAMoveIsTheMiddleOfItsRoundedCorner) {
  const auto settings = settings_of(2);
  const MovePlan plan{
      {},
      {with_outputs(line_to({0.1, 0.0}, 0.05, 2e-3), {change(0, kEnd)}),
       with_outputs(line_to({0.1, 0.1}, 0.05, 0.0), {change(1, 0.0), change(2, 1e-3), change(3, 0.05)})}};
  const auto story = story_of(settings, plan);
  ASSERT_EQ(story.outputs(), (Numbers{0, 1, 2, 3}));
  // In the middle the axes are at the same distance from both lines.
  EXPECT_NEAR(0.1 - story.told[0].position[0], story.told[0].position[1], 1e-5);
  EXPECT_EQ(story.told[0].cycle, story.told[1].cycle);
  EXPECT_GT(story.told[2].cycle, story.told[1].cycle);
  EXPECT_NEAR(story.told[3].position[1], 0.05, 1e-5);
}

TEST(ContourEvents, EachIsToldOnceWhateverTheOperatorDoes) {
  test::Random random;
  for (int round = 0; round < 100; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const auto settings = settings_of(2);
    MovePlan plan{{}, {}};
    Numbers expected;
    GroupVector at{};
    double rests_s = 0.0;
    for (int k = 0; k < 6; ++k) {
      at = {at[0] + random.real(0.01, 0.05), random.real(-0.05, 0.05)};
      const double length = test::distance(at, plan.moves.empty() ? GroupVector{} : plan.moves.back().target);
      const auto first = static_cast<std::uint32_t>(expected.size());
      const double dwell_s = random.index(0, 2) == 0 ? random.real(0.001, 0.05) : 0.0;
      rests_s += dwell_s;
      plan.moves.push_back(with_outputs(line_to(at, kFast, random.index(0, 1) == 0 ? 0.0 : 5e-4),
                                        {change(first, random.real(0.0, 0.5 * length)),
                                         change(first + 1, random.real(-0.5 * length, -1e-9)), change(first + 2, kEnd)},
                                        dwell_s));
      for (std::uint32_t i = 0; i < 3; ++i) expected.push_back(first + i);
    }
    ContourRun run(settings, plan);
    ContourOracle oracle(settings, plan);
    Story story;
    std::size_t cycle = 0;
    std::size_t next = random.index(1, 400);
    constexpr std::size_t kBusy = 4000;
    const auto end = run.to_end(
        settings.period_s, kLongest,
        [&](const ContourSetpoint& setpoint) {
          oracle.take(setpoint);
          story.take(setpoint);
          if (++cycle == kBusy) {
            run.follower().hold(false);
            run.follower().reverse(false);
          }
          if (cycle >= kBusy || cycle < next) return;
          next += random.index(1, 600);
          run.follower().hold(random.index(0, 3) == 0);
          run.follower().reverse(random.index(0, 2) == 0);
        },
        kBusy + 10);
    ASSERT_TRUE(end.has_value());
    ASSERT_EQ(oracle.verdict(), "");
    ASSERT_EQ(story.outputs(), expected);
    std::size_t dwelling = 0;
    for (const auto& each : story.setpoints) dwelling += each.dwells ? 1 : 0;
    ASSERT_GE(static_cast<double>(dwelling) * settings.period_s, rests_s - 10.0 * settings.period_s);
  }
}

TEST(ContourEvents, ADwellIsAsLongAsItSaysAndComesBetweenTheOutputsOfBothMoves) {
  const auto settings = settings_of(1);
  // In the middle of a straight line, and with a tolerance: the axes stop nevertheless.
  const MovePlan plan{{},
                      {with_outputs(line_to({0.1}, kFast, 1e-3), {change(0, kEnd)}, 0.25),
                       with_outputs(line_to({0.2}, kFast, 0.0), {change(1, 0.0)})}};
  const auto story = story_of(settings, plan);
  ASSERT_EQ(story.outputs(), (Numbers{0, 1}));
  const double between = static_cast<double>(story.told[1].cycle - story.told[0].cycle) * settings.period_s;
  EXPECT_NEAR(between, 0.25, 3.0 * settings.period_s);
  EXPECT_NEAR(story.told[0].position[0], 0.1, 1e-9);
  EXPECT_GE(story.rest_s({0.1}, settings.period_s), 0.25 - 1e-9);
  EXPECT_LE(story.rest_s({0.1}, settings.period_s), 0.25 + 0.01);
}

TEST(ContourEvents, ADwellDoesNotRunWhileTheAxesAreHeldAndIsNotRepeatedOnTheWayBack) {
  const auto settings = settings_of(1);
  const MovePlan plan{{}, {with_outputs(line_to({0.1}, kFast, 0.0), {}, 0.1), line_to({0.2}, kFast, 0.0)}};
  ContourRun run(settings, plan);
  std::size_t dwelling = 0;
  std::size_t held = 0;
  bool came_back = false;
  ASSERT_TRUE(run.to_end(settings.period_s, kLongest, [&](const ContourSetpoint& setpoint) {
    dwelling += setpoint.dwells ? 1 : 0;
    if (dwelling == 400) run.follower().hold(true);
    if (dwelling == 400 + 2000) run.follower().hold(false);
    held = dwelling;
    if (setpoint.position[0] > 0.15 && !came_back) {
      came_back = true;
      run.follower().reverse(true);
    }
    if (came_back && setpoint.position[0] < 0.05) run.follower().reverse(false);
  }));
  EXPECT_TRUE(came_back);
  EXPECT_NEAR(static_cast<double>(held), 800.0 + 2000.0, 5.0);
}

TEST(ContourEvents, MovesWithoutWayActWhereTheAxesAre) {
  const auto settings = settings_of(1);
  const MovePlan plan{{},
                      {with_outputs(line_to({}, kFast, 0.0), {change(0, kEnd)}, 0.1), line_to({0.1}, kFast, 1e-3),
                       with_outputs(line_to({0.1}, kFast, 1e-3), {change(1, kEnd)}),
                       with_outputs(line_to({0.1}, kFast, 1e-3), {change(2, 0.0)}, 0.05),
                       with_outputs(line_to({0.1}, kFast, 1e-3), {change(3, 0.0)}), line_to({0.2}, kFast, 0.0)}};
  const auto story = story_of(settings, plan);
  ASSERT_EQ(story.outputs(), (Numbers{0, 1, 2, 3}));
  EXPECT_GE(story.rest_s({}, settings.period_s), 0.1 - 1e-9);
  EXPECT_EQ(story.told[1].cycle, story.told[2].cycle);
  EXPECT_NEAR(static_cast<double>(story.told[3].cycle - story.told[2].cycle) * settings.period_s, 0.05, 1e-3);
}

TEST(ContourEvents, MoreOfThemThanThereIsRoomForArriveInTheirOrder) {
  const auto settings = settings_of(1);
  MovePlan plan{{}, {}};
  Numbers expected;
  for (std::uint32_t k = 0; k < 1500; ++k) {
    std::vector<MoveOutput> outputs;
    for (std::uint32_t i = 0; i < 5; ++i) {
      outputs.push_back(change(5 * k + i, kEnd));
      expected.push_back(5 * k + i);
    }
    plan.moves.push_back(with_outputs(line_to({1e-4 * (k + 1)}, kFast, 0.0), outputs));
  }
  EXPECT_EQ(story_of(settings, plan).outputs(), expected);
}

TEST(ContourEvents, WhatComesAfterAnEndActsThere) {
  const auto settings = settings_of(1);
  const MovePlan plan{{}, {line_to({0.1}, kFast, 0.0)}};
  ContourTrack track(settings, {});
  ContourPlanner planner(track);
  ContourFollower follower(track);
  ASSERT_TRUE(planner.add(plan.moves[0]));
  planner.finish();
  ASSERT_TRUE(planner.flush());
  while (!follower.step().at_end) {
  }
  ASSERT_TRUE(planner.add(with_outputs(line_to({0.1}, kFast, 0.0), {change(7, kEnd)}, 0.05)));
  ASSERT_TRUE(planner.add(line_to({0.2}, kFast, 0.0)));
  planner.finish();
  ASSERT_TRUE(planner.flush());
  Story story;
  do {
    story.take(follower.step());
  } while (!story.setpoints.back().at_end);
  ASSERT_EQ(story.outputs(), (Numbers{7}));
  EXPECT_GE(story.rest_s({0.1}, settings.period_s), 0.05 - 1e-9);
}

TEST(ContourEventsBadInput, DwellsAndOutputsThatCannotBeAreRefused) {
  PathShaper shaper(1, {});
  std::vector<ShapedPiece> out;
  const auto reason = [&](const PathMove& move) {
    const auto added = shaper.add(move, out);
    return added ? "" : added.error().reason;
  };
  const auto line = line_to({0.1}, kFast, 0.0);
  EXPECT_EQ(reason(with_outputs(line, {}, -1.0)), "the dwell is -1 s; it must be from 0 to 3600 s");
  EXPECT_EQ(reason(with_outputs(line, {}, std::nan(""))), "the dwell is nan s; it must be from 0 to 3600 s");
  EXPECT_EQ(reason(with_outputs(line, {change(0, 0.2)})),
            "an output would change 0.2 m after the start of a move that is 0.1 m long");
  EXPECT_EQ(reason(with_outputs(line, {change(0, -0.2)})),
            "an output would change 0.2 m before the end of a move that is 0.1 m long");
  EXPECT_EQ(reason(with_outputs(line, {{{0, std::nan("")}, 0.0}})), "an output and its place must be numbers");
  EXPECT_EQ(reason(with_outputs(line, std::vector<MoveOutput>(65, change(0, kEnd)))),
            "more than 64 outputs and dwells in one move");
  EXPECT_EQ(reason(with_outputs(line, std::vector<MoveOutput>(64, change(0, kEnd)))), "");
  EXPECT_EQ(reason(with_outputs(line, {change(0, kEnd)})), "more than 64 outputs and dwells in one move");
}

}  // namespace
}  // namespace driveline::trajectory
