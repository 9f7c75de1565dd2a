#include "driveline/motion/control/position_watch.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace driveline::motion {
namespace {

using Kind = PositionFinding::Kind;
using std::chrono::microseconds;
using trajectory::AxisSetpoint;

/// At most 100 rad/s, a tolerance of 0.1 rad, 1000 increments per rad; cycles of 1 ms, in which it moves up to 0.1 rad.
AxisConfig watched_axis() {
  AxisConfig config;
  config.limits = {100.0, 1000.0};
  config.increments_per_unit = 1000.0;
  return config;
}

/// A watch that is called once per cycle.
struct WatchBench {
  explicit WatchBench(const AxisConfig& config = watched_axis()) : watch(config, microseconds{1000}) {}
  PositionWatch watch;
  std::int64_t cycle = 100;

  PositionFinding rest(double position) { return watch.judge(cycle++, position, {}, false); }
  PositionFinding drive(double position, const AxisSetpoint& setpoint) {
    return watch.judge(cycle++, position, setpoint, true);
  }
  /// Calls it until the position is steady.
  void settle(double position) {
    for (int i = 0; i < 20; ++i) static_cast<void>(rest(position));
  }
};

TEST(PositionWatch, AStepBeyondWhatTheAxisCanDoIsALeap) {
  WatchBench bench;
  bench.settle(1.0);
  EXPECT_FALSE(bench.drive(1.0, {1.0, 0.0, 0.0}));
  EXPECT_FALSE(bench.drive(1.49, {1.1, 100.0, 0.0})) << "twice the way of two cycles and the tolerance";
  const auto leap = bench.drive(1.49 - 2.0, {1.2, 100.0, 0.0});
  EXPECT_EQ(leap.kind, Kind::kLeap);
  EXPECT_DOUBLE_EQ(leap.from, 1.49);
  EXPECT_DOUBLE_EQ(leap.moved, -2.0);
  EXPECT_DOUBLE_EQ(leap.allowed, 0.5);
  EXPECT_DOUBLE_EQ(leap.within_s, 1e-3);
}

TEST(PositionWatch, TimeThatHasPassedIsTimeToMove) {
  WatchBench bench;
  bench.settle(0.0);
  EXPECT_FALSE(bench.drive(0.0, {}));
  bench.cycle += 9;
  EXPECT_FALSE(bench.drive(2.0, {0.0, 0.0, 0.0})) << "frames were lost for 9 ms";
  bench.cycle += 9;
  EXPECT_EQ(bench.drive(4.4, {}).kind, Kind::kLeap);
}

TEST(PositionWatch, TimeForWhichTheExchangeWasHeldUpIsTimeToMove) {
  WatchBench bench;
  bench.settle(0.0);
  EXPECT_FALSE(bench.drive(0.0, {}));
  EXPECT_FALSE(bench.watch.judge(bench.cycle++, 2.0, {}, true, std::chrono::milliseconds{10}));
  EXPECT_EQ(bench.watch.judge(bench.cycle++, 4.4, {}, true, std::chrono::milliseconds{10}).kind, Kind::kLeap);
  EXPECT_EQ(bench.watch.judge(bench.cycle++, 2.0, {}, true, microseconds{900}).kind, Kind::kLeap);
}

TEST(PositionWatch, APathFasterThanTheLimitIsFollowed) {
  WatchBench bench;
  bench.settle(0.0);
  EXPECT_FALSE(bench.drive(0.0, {0.0, 0.0, 0.0}));
  EXPECT_FALSE(bench.drive(1.0, {1.0, 1000.0, 0.0}));
  EXPECT_EQ(bench.drive(5.2, {2.0, 1000.0, 0.0}).kind, Kind::kLeap);
  WatchBench late;
  late.settle(0.0);
  EXPECT_FALSE(late.drive(0.0, {0.0, 0.0, 0.0}));
  EXPECT_FALSE(late.drive(1.0, {0.0, 1000.0, 0.0})) << "the speed of the path alone allows it";
}

TEST(PositionWatch, APositionThatStandsWhileTheAxisIsSentOnIsFrozen) {
  WatchBench bench;
  bench.settle(0.5);
  PositionFinding found;
  int cycles = 0;
  for (; !found && cycles < 200; ++cycles) found = bench.drive(0.5, {0.5 + 0.01 * cycles, 10.0, 0.0});
  EXPECT_EQ(found.kind, Kind::kFrozen);
  EXPECT_EQ(cycles, 51) << "after 50 ms, when the way is longer than the tolerance";
  EXPECT_DOUBLE_EQ(found.from, 0.5);
  EXPECT_NEAR(found.moved, 0.5, 1e-9);
  EXPECT_NEAR(found.within_s, 0.05, 1e-9);
}

TEST(PositionWatch, AnAxisThatIsNotSentAnywhereMayStand) {
  WatchBench bench;
  bench.settle(0.5);
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_FALSE(bench.drive(0.5, {0.5, 0.0, 0.0}));
    ASSERT_FALSE(bench.drive(0.5, {0.55, 0.0, 0.0})) << "less than it may be off";
  }
}

TEST(PositionWatch, SlowAxesAreGivenTheirTime) {
  WatchBench bench;
  bench.settle(0.0);
  // An encoder of 100 increments per rad: a new value in every tenth cycle at 1 rad/s.
  for (int i = 0; i < 10'000; ++i) {
    const double way = 1e-3 * i;
    ASSERT_FALSE(bench.drive(std::floor(way * 100.0) / 100.0, {way, 1.0, 0.0})) << i;
  }
}

TEST(PositionWatch, AnEncoderThatIsCoarserThanTheToleranceIsNotFrozen) {
  auto config = watched_axis();
  config.increments_per_unit = 2.0;
  WatchBench bench(config);
  bench.settle(0.0);
  for (int i = 0; i < 20'000; ++i) {
    const double way = 1e-3 * i;
    ASSERT_FALSE(bench.drive(std::floor(way * 2.0) / 2.0, {way, 1.0, 0.0})) << i;
  }
}

TEST(PositionWatch, ADriveThatMeasuresLessOftenThanItIsAskedIsBelieved) {
  WatchBench bench;
  bench.settle(0.0);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_FALSE(bench.drive(0.1 * (i / 20 * 20), {0.1 * i, 100.0, 0.0})) << "2 rad every 20 ms";
  }
}

TEST(PositionWatch, StepsOfAnAxisThatIsNotDrivenAreNewBeginnings) {
  WatchBench bench;
  bench.settle(1.0);
  EXPECT_TRUE(bench.watch.steady());
  EXPECT_FALSE(bench.rest(-50.0)) << "homing, a new zero, other factors";
  EXPECT_FALSE(bench.watch.steady());
  EXPECT_EQ(bench.watch.held(), 1.0) << "it may not be true";
  EXPECT_EQ(bench.watch.unsteady().kind, Kind::kLeap);
  EXPECT_DOUBLE_EQ(bench.watch.unsteady().moved, -51.0);
  for (std::uint32_t i = 0; i < PositionWatch::kSteadyExchanges; ++i) {
    EXPECT_FALSE(bench.watch.steady()) << i;
    EXPECT_FALSE(bench.rest(-50.0));
  }
  EXPECT_TRUE(bench.watch.steady());
  EXPECT_EQ(bench.watch.held(), -50.0);
  EXPECT_FALSE(bench.watch.unsteady());
  EXPECT_FALSE(bench.drive(-50.0, {-50.0, 0.0, 0.0}));
}

TEST(PositionWatch, ANewPlaceAtTheMomentOfEnablingIsHeldAtOnce) {
  WatchBench bench;
  bench.settle(1.0);
  const auto found = bench.drive(10.0, {1.0, 0.0, 0.0});
  EXPECT_EQ(found.kind, Kind::kNewPlace);
  EXPECT_FALSE(found) << "nothing is wrong";
  EXPECT_EQ(bench.watch.held(), 10.0);
  EXPECT_EQ(bench.drive(10.0, {10.0, 0.0, 0.0}).kind, Kind::kNone);
  EXPECT_EQ(bench.drive(1.0, {10.0, 0.0, 0.0}).kind, Kind::kLeap) << "but not back again";
}

TEST(PositionWatch, APlaceThatKeepsLeapingIsNeverSteady) {
  WatchBench bench;
  for (int i = 0; i < 1000; ++i) {
    static_cast<void>(bench.rest(i % 4 == 0 ? 5.0 : 0.0));
    ASSERT_FALSE(bench.watch.steady());
  }
}

TEST(PositionWatch, AnAxisThatCoastsIsHeldWhereItIs) {
  WatchBench bench;
  for (int i = 0; i < 100; ++i) static_cast<void>(bench.rest(0.01 * i));
  EXPECT_TRUE(bench.watch.steady());
  EXPECT_DOUBLE_EQ(bench.watch.held(), 0.99);
}

TEST(PositionWatch, OfAnAxisThatWasAwayBeginsAnew) {
  WatchBench bench;
  bench.settle(1.0);
  EXPECT_FALSE(bench.drive(1.0, {1.0, 0.0, 0.0}));
  bench.watch.forget();
  EXPECT_FALSE(bench.watch.steady());
  EXPECT_FALSE(bench.rest(99.0));
  EXPECT_EQ(bench.watch.held(), 99.0);
}

TEST(PositionWatch, WithAToleranceOfZeroBelievesEverything) {
  auto config = watched_axis();
  config.position_tolerance = 0.0;
  WatchBench bench(config);
  bench.settle(1.0);
  EXPECT_FALSE(bench.drive(1000.0, {1.0, 0.0, 0.0}));
  for (int i = 0; i < 1000; ++i) ASSERT_FALSE(bench.drive(1000.0, {0.1 * i, 100.0, 0.0}));
  EXPECT_TRUE(bench.watch.steady());
}

}  // namespace
}  // namespace driveline::motion
