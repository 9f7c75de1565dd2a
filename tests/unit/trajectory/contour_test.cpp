#include <gtest/gtest.h>

#include <atomic>
#include <numbers>
#include <thread>
#include <utility>

#include "contour_oracle.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "support/campaign.hpp"

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

ContourSettings settings_of(std::size_t axes, double velocity, double acceleration, double jerk) {
  ContourSettings settings;
  settings.axes = axes;
  settings.capacity = 256;
  for (std::size_t i = 0; i < axes; ++i) settings.limits[i] = {velocity, acceleration, jerk};
  return settings;
}

/// Sends an operator's commands at random times, and none at the end.
class Operator {
 public:
  Operator(test::Random& random, std::size_t cycles) : random_(random), cycles_(cycles) { next_ = wait(); }

  void act(ContourFollower& follower, std::size_t cycle) {
    if (cycle == cycles_) {
      follower.hold(false);
      follower.reverse(false);
      follower.set_override(1.0);
    }
    if (cycle >= cycles_ || cycle < next_) return;
    next_ = cycle + wait();
    switch (random_.index(0, 4)) {
      case 0:
        return follower.hold(true);
      case 1:
        return follower.hold(false);
      case 2:
        return follower.reverse(random_.index(0, 1) == 0);
      default:
        follower.hold(false);
        follower.set_override(random_.index(0, 3) == 0 ? 0.0 : random_.real(0.0, kMaxOverride));
    }
  }

 private:
  std::size_t wait() { return static_cast<std::size_t>(random_.magnitude(1.0, 4000.0)); }

  test::Random& random_;
  std::size_t cycles_;
  std::size_t next_ = 0;
};

int rounds(int usual) {
  const char* text = std::getenv("DRIVELINE_CONTOUR_ROUNDS");
  return text == nullptr ? driveline::test::share_of(usual) : std::atoi(text);
}

TEST(Contour, KeepsEveryLimitOnRandomPathsWhateverTheOperatorDoes) {
  test::Random random;
  std::array<double, 3> used{};
  const int count = rounds(1000);
  for (int round = 0; round < count; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const std::size_t axes = random.index(1, 6);
    const auto settings = test::random_settings(random, axes);
    const auto plan = test::random_moves(random, axes, random.index(1, 6), random.magnitude(0.01, 0.1));
    const std::size_t busy = random.index(0, 6000);
    if (!test::can_be_shaped(axes, plan)) continue;
    ContourRun run(settings, plan);
    ContourOracle oracle(settings, plan);
    Operator person(random, busy);
    std::size_t cycle = 0;
    ContourSetpoint last;
    const auto end = run.to_end(
        settings.period_s, kLongest,
        [&](const ContourSetpoint& setpoint) {
          oracle.take(setpoint);
          person.act(run.follower(), ++cycle);
          last = setpoint;
        },
        busy + 10);
    ASSERT_EQ(oracle.verdict(), "");
    ASSERT_TRUE(end.has_value());
    ASSERT_LT(distance(last.position, plan.moves.back().target), 2e-9);
    ASSERT_EQ(last.speed, 0.0);
    for (std::size_t i = 0; i < 3; ++i) used[i] = std::max(used[i], oracle.used()[i]);
  }
  // The limits must be used, or the test would show nothing.
  if (count >= 1000) {
    for (const double each : used) EXPECT_GT(each, 0.99);
  }
}

/// The oracle's verdict on a planner with limits that are too large.
std::string verdict_with(const ContourSettings& believed, const ContourSettings& real) {
  const MovePlan plan{{}, {line_to({0.5}, kFast, 0.0)}};
  ContourRun run(believed, plan);
  ContourOracle oracle(real, plan);
  run.to_end(real.period_s, kLongest, [&](const ContourSetpoint& setpoint) { oracle.take(setpoint); });
  return oracle.verdict();
}

TEST(Contour, ALimitOnePercentTooLargeIsFound) {
  const auto real = settings_of(1, 1.0, 10.0, 1000.0);
  EXPECT_EQ(verdict_with(real, real), "");
  auto faster = real;
  faster.limits[0].max_velocity *= 1.01;
  EXPECT_NE(verdict_with(faster, real).find("velocity of axis 0"), std::string::npos);
  auto harder = real;
  harder.limits[0].max_acceleration *= 1.01;
  EXPECT_NE(verdict_with(harder, real).find("acceleration of axis 0"), std::string::npos);
  auto jerkier = real;
  jerkier.limits[0].max_jerk = 1000.0 * 80.0 / 79.0;  // one cycle less for averaging
  EXPECT_NE(verdict_with(jerkier, real).find("jerk of axis 0"), std::string::npos);
}

TEST(Contour, ALineFromRestToRestTakesTheShortestTime) {
  const auto settings = settings_of(1, 1.0, 10.0, 1000.0);
  const MovePlan plan{{}, {line_to({0.5}, kFast, 0.0)}};
  ContourRun run(settings, plan);
  const auto end = run.to_end(settings.period_s, kLongest, [](const ContourSetpoint&) {});
  // Distance by velocity, and the two ramps.
  EXPECT_NEAR(end.value(), 0.5 / 1.0 + 1.0 / 10.0 + 10.0 / 1000.0, 0.001);
}

// Durations from bench/path for these paths: motions within the limits of every axis, by a numeric optimum.
TEST(Contour, BendsAndFlatCornersTakeHardlyLongerThanANumericOptimum) {
  auto settings = settings_of(2, 1.0, 10.0, 1000.0);
  settings.capacity = 8192;
  const auto duration_of = [&](const MovePlan& plan) {
    ContourRun run(settings, plan);
    return run.to_end(settings.period_s, kLongest, [](const auto&) {}).value_or(kLongest);
  };
  MovePlan circles{{0.1}, {}};
  for (int k = 0; k < 3; ++k) circles.moves.push_back(arc_by({0.1}, 0.0, 0.0, 2.0 * std::numbers::pi, kFast, 0.0));
  EXPECT_LT(duration_of(circles), 1.05 * 1.949);
  MovePlan square{{}, {}};
  for (const auto& [x, y] : {std::pair{0.4, 0.0}, {0.4, 0.4}, {0.0, 0.4}, {0.0, 0.0}}) {
    square.moves.push_back(line_to({x, y}, kFast, 1e-3));
  }
  EXPECT_LT(duration_of(square), 1.05 * 1.984);
}

TEST(Contour, TheFeedIsWhatTheMoveSaysTimesTheOverride) {
  const auto settings = settings_of(2, 1.0, 10.0, 1000.0);
  const MovePlan plan{{}, {line_to({0.3, 0.4}, 0.2, 0.0)}};
  for (const double share : {0.5, 1.0, 2.0}) {
    ContourRun run(settings, plan);
    ASSERT_TRUE(run.follower().set_override(share));
    double fastest = 0.0;
    run.to_end(settings.period_s, kLongest,
               [&](const ContourSetpoint& setpoint) { fastest = std::max(fastest, setpoint.speed); });
    EXPECT_NEAR(fastest, 0.2 * share, 1e-8);
  }
}

TEST(Contour, AnArcOfManyKilometersIsPlannedToItsEnd) {
  // Its length in steps times its number of stretches exceeds 63 bits.
  const auto settings = settings_of(2, 1e6, 1e6, 1e8);
  const MovePlan plan{{}, {arc_by({}, 0.0, 1e5, 6.0, kFast, 0.0)}};
  ContourRun run(settings, plan);
  ContourSetpoint last;
  double largest = 0.0;
  const auto end = run.to_end(settings.period_s, kLongest, [&](const ContourSetpoint& setpoint) {
    for (std::size_t i = 0; i < settings.axes; ++i) largest = std::max(largest, std::abs(setpoint.acceleration[i]));
    last = setpoint;
  });
  ASSERT_TRUE(end.has_value());
  EXPECT_LT(distance(last.position, plan.moves.back().target), 1e-6);
  EXPECT_LT(largest, 1e6 * 1.001);
  EXPECT_GT(largest, 0.5e6);
}

TEST(Contour, AnOverrideOutOfRangeIsRefused) {
  const auto settings = settings_of(1, 1.0, 10.0, 1000.0);
  ContourTrack track(settings, {});
  ContourFollower follower(track);
  EXPECT_TRUE(follower.set_override(0.0));
  EXPECT_TRUE(follower.set_override(2.0));
  EXPECT_FALSE(follower.set_override(-0.1));
  EXPECT_FALSE(follower.set_override(2.1));
  EXPECT_FALSE(follower.set_override(std::nan("")));
}

TEST(Contour, GoesBackToTheBeginOfThePathAndAgainToItsEnd) {
  const auto settings = settings_of(3, 1.0, 10.0, 1000.0);
  const MovePlan plan{
      {},
      {line_to({0.1}, kFast, 1e-3), line_to({0.1, 0.1}, kFast, 0.0), arc_by({0.1, 0.1}, 0.05, 0.1, 2.0, kFast, 0.0)}};
  ContourRun run(settings, plan);
  ContourOracle oracle(settings, plan);
  ASSERT_TRUE(run.to_end(settings.period_s, kLongest, [&](const auto& setpoint) { oracle.take(setpoint); }));
  run.follower().reverse(true);
  GroupVector last{};
  const auto take = [&](const ContourSetpoint& setpoint) {
    oracle.take(setpoint);
    last = setpoint.position;
  };
  ASSERT_TRUE(run.to_end(settings.period_s, kLongest, take));
  EXPECT_LT(distance(last, plan.start), 1e-9);
  run.follower().reverse(false);
  ASSERT_TRUE(run.to_end(settings.period_s, kLongest, take));
  EXPECT_LT(distance(last, plan.moves.back().target), 1e-9);
  EXPECT_EQ(oracle.verdict(), "");
}

TEST(Contour, APathWithoutEndNeedsNoMoreMemory) {
  const auto settings = settings_of(2, 1.0, 10.0, 1000.0);
  ContourTrack track(settings, {});
  ContourPlanner planner(track);
  ContourFollower follower(track);
  const double turn = 0.02;
  double angle = 0.0;
  std::uint64_t moves = 0;
  MovePlan around{{}, {}};
  for (int cycle = 0; cycle < 400'000; ++cycle) {
    // 256 slots, but a path of many thousand pieces.
    while (planner.flush() && moves < 40'000) {
      angle += turn;
      ASSERT_TRUE(planner.add(line_to({0.05 * std::sin(angle), 0.05 - 0.05 * std::cos(angle)}, 0.2, 1e-5)));
      ++moves;
    }
    const auto setpoint = follower.step();
    const double radius = std::hypot(setpoint.position[0], setpoint.position[1] - 0.05);
    ASSERT_NEAR(radius, 0.05, 2e-5);
  }
  EXPECT_GT(moves, 5'000U);
}

/// Follows the moves to their end, within all limits.
void expect_end(const ContourSettings& settings, const MovePlan& plan) {
  ContourRun run(settings, plan);
  ContourOracle oracle(settings, plan);
  ContourSetpoint last;
  const auto end = run.to_end(settings.period_s, 400'000, [&](const ContourSetpoint& setpoint) {
    oracle.take(setpoint);
    last = setpoint;
  });
  EXPECT_TRUE(end.has_value());
  EXPECT_EQ(oracle.verdict(), "");
  EXPECT_LT(distance(last.position, plan.moves.back().target), 2e-9);
}

/// 1000 lines, with room for 256.
MovePlan straight_of(double step) {
  MovePlan plan{{}, {}};
  for (int k = 1; k <= 1000; ++k) plan.moves.push_back(line_to({step * k}, kFast, 0.0));
  return plan;
}

// All of them have the same limits.
TEST(Contour, AStraightOfMoreLinesThanThereIsRoomForEndsAtItsEnd) {
  expect_end(settings_of(1, 1.0, 10.0, 1000.0), straight_of(0x1p-6));
}

// The averaging spans more lines than there is room for.
TEST(Contour, MoreShortLinesThanThereIsRoomForWithinTheAveragingEndAtTheirEnd) {
  expect_end(settings_of(1, 1.0, 10.0, 1000.0), straight_of(0x1p-16));
  expect_end(settings_of(1, 1000.0, 10.0, 1000.0), straight_of(0x1p-9));
}

TEST(Contour, ShortLinesOfAxesWithoutAVelocityLimitKeepTheOtherLimits) {
  test::Random random;
  for (int round = 0; round < 10; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    MovePlan plan{{}, {}};
    const double step = random.magnitude(2e-5, 2e-3);
    GroupVector at{};
    for (int k = 1; k <= 600; ++k) {
      // Straights with a bend now and then: those are slow.
      at[0] += step;
      if (k % 150 > 100) at[1] += random.real(-1.0, 1.0) * step;
      plan.moves.push_back(line_to(at, kFast, 0.05 * step));
    }
    expect_end(settings_of(2, 1e6, 10.0, 1000.0), plan);
  }
}

TEST(Contour, WithoutMoreMovesTheAxesComeToRestOnThePathAndGoOnLater) {
  const auto settings = settings_of(1, 1.0, 10.0, 1000.0);
  const MovePlan plan{{}, {line_to({0.2}, kFast, 0.0), line_to({0.3}, kFast, 0.0), line_to({1.0}, kFast, 0.0)}};
  ContourTrack track(settings, {});
  ContourPlanner planner(track);
  ContourFollower follower(track);
  ContourOracle oracle(settings, plan);
  ASSERT_TRUE(planner.add(plan.moves[0]));
  ASSERT_TRUE(planner.add(plan.moves[1]));
  planner.flush();
  const auto follow = [&] {
    ContourSetpoint setpoint;
    for (int cycle = 0; cycle < 20'000; ++cycle) oracle.take(setpoint = follower.step());
    return setpoint;
  };
  auto rest = follow();
  EXPECT_TRUE(rest.at_end);
  EXPECT_LE(rest.position[0], 0.2 + 1e-9);
  ASSERT_TRUE(planner.add(plan.moves[2]));
  planner.finish();
  planner.flush();
  rest = follow();
  EXPECT_NEAR(rest.position[0], 1.0, 1e-9);
  EXPECT_EQ(oracle.verdict(), "");
}

// The two threads as in a program. Their order depends on the machine; the limits hold in any case.
TEST(Contour, IsPlannedByOneThreadWhileAnotherFollows) {
  test::Random random;
  const auto settings = settings_of(2, 1.0, 10.0, 1000.0);
  MovePlan plan{{}, {}};
  for (int k = 1; k <= 400; ++k) {
    plan.moves.push_back(line_to({0.001 * k, random.real(0.0, 0.002)}, kFast, 5e-5));
  }
  ContourTrack track(settings, {});
  std::atomic<bool> planned{false};
  std::thread beside([&] {
    ContourPlanner planner(track);
    for (const auto& move : plan.moves) {
      while (!planner.flush()) std::this_thread::yield();
      ASSERT_TRUE(planner.add(move));
    }
    planner.finish();
    while (!planner.flush()) std::this_thread::yield();
    planned = true;
  });
  ContourFollower follower(track);
  ContourOracle oracle(settings, plan);
  ContourSetpoint setpoint;
  for (bool last_look = false; !last_look || !setpoint.at_end;) {
    last_look = planned;
    setpoint = follower.step();
    oracle.take(setpoint);
  }
  beside.join();
  EXPECT_EQ(oracle.verdict(), "");
  EXPECT_LT(distance(setpoint.position, plan.moves.back().target), 1e-9);
}

TEST(Contour, TheCycleUsesNeitherHeapNorLocks) {
  if (!rt::RtGuard::available()) {
    GTEST_SKIP() << "a sanitizer owns malloc in this build";
  }
  const auto settings = settings_of(2, 1.0, 10.0, 1000.0);
  const MovePlan plan{
      {},
      {line_to({0.1}, kFast, 1e-3), line_to({0.1, 0.1}, kFast, 0.0), arc_by({0.1, 0.1}, 0.05, 0.1, 2.0, kFast, 0.0)}};
  ContourRun run(settings, plan);
  run.plan();
  auto& follower = run.follower();
  rt::RtGuard::enter();
  for (int cycle = 0; cycle < 10'000; ++cycle) {
    follower.hold(cycle % 1000 < 200);
    follower.reverse(cycle % 3000 > 2000);
    follower.set_override(cycle % 700 < 350 ? 0.7 : 1.3);
    follower.step();
  }
  const auto counts = rt::RtGuard::leave();
  EXPECT_EQ(counts.total(), 0U);
}

TEST(ContourSettings, AreCheckedWithASentence) {
  auto settings = settings_of(2, 1.0, 10.0, 1000.0);
  EXPECT_EQ(check_settings(settings), "");
  settings.limits[1].max_jerk = 0.0;
  EXPECT_EQ(check_settings(settings), "axis 2 needs a positive and finite velocity, acceleration and jerk limit");
  settings.limits[1].max_jerk = std::nan("");
  EXPECT_EQ(check_settings(settings), "axis 2 needs a positive and finite velocity, acceleration and jerk limit");
  settings.limits[1].max_jerk = 1e-3;
  EXPECT_EQ(check_settings(settings), "axis 2 takes more than 65536 cycles to reach its acceleration limit");
  settings = settings_of(2, 1.0, 10.0, 1000.0);
  settings.limits[1].max_velocity = 1e6;
  EXPECT_EQ(check_settings(settings), "");
  settings.limits[1].max_velocity = 1e9;
  EXPECT_EQ(check_settings(settings), "the velocity limit of axis 2 is above 1e6 m/s or rad/s");
  // 2 * 1e4 m/s * 2000^2 * 125 us is 1e7, more than 2^23; a fifth of it is less.
  settings = settings_of(1, 1e4, 10.0, 40.0);
  EXPECT_EQ(check_settings(settings),
            "the axes are too fast for an averaging over 2000 cycles; lower velocity limits or higher jerk limits are "
            "needed");
  settings.limits[0].max_velocity = 2e3;
  EXPECT_EQ(check_settings(settings), "");
  settings = settings_of(2, 1.0, 10.0, 1000.0);
  settings.axes = 0;
  EXPECT_EQ(check_settings(settings), "a group has 1 to 8 axes");
  settings = settings_of(2, 1.0, 10.0, 1000.0);
  settings.capacity = 1000;
  EXPECT_EQ(check_settings(settings), "the capacity must be a power of two from 256 to 1048576");
  settings = settings_of(2, 1.0, 10.0, 1000.0);
  settings.period_s = std::nan("");
  EXPECT_EQ(check_settings(settings), "the period of the cycle must be from 10 us to 0.1 s");
  EXPECT_THROW(ContourTrack(settings, {}), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::trajectory
