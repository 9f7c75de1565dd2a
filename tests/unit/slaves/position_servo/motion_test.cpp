// The queue of moves and the demand: positions and velocities are calculated by hand from the numbers of each move.
#include "driveline/slaves/position_servo/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::slaves::position_servo::motion_test {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kPeriodMs = 2;
constexpr double kStart = -300.0;  ///< where the axis stands at the start of each test

/// An enabled axis at kStart, and the time since then.
struct Bench {
  Motion motion;
  std::int64_t now_ms = 0;

  Bench() {
    motion.reset(kStart);
    motion.set_fault_deceleration(400);  // 4000 counts/s^2
    motion.enable(true);
  }
  void run_until(std::int64_t ms) {
    for (; now_ms < ms; now_ms += kPeriodMs) motion.step(milliseconds{kPeriodMs});
  }
  [[nodiscard]] double position() const { return motion.demand().position; }
  [[nodiscard]] double velocity() const { return motion.demand().velocity; }
};

/// 1000 counts/s, 10000 counts/s^2 up, 5000 counts/s^2 down.
constexpr Move discrete(MoveType type, bool relative, std::int32_t target) {
  return {.type = type,
          .relative = relative,
          .target = target,
          .velocity = 10'000,
          .acceleration = 1000,
          .deceleration = 500};
}

constexpr Move segment(std::int32_t target, std::int32_t velocity, MoveType type = MoveType::kSegment) {
  return {.type = type, .target = target, .velocity = velocity};
}

constexpr Move relative_segment(std::int32_t distance, std::int32_t velocity) {
  return {.type = MoveType::kSegment, .relative = true, .target = distance, .velocity = velocity};
}

struct Sample {
  std::int64_t ms = 0;
  double position = 0.0;
  double velocity = 0.0;
};

struct Course {
  std::string name;
  std::vector<Move> moves;
  std::vector<Sample> samples;
};

class MotionCourse : public testing::TestWithParam<Course> {};

TEST_P(MotionCourse, IsThatOfItsNumbers) {
  Bench bench;
  for (const Move& move : GetParam().moves) ASSERT_EQ(bench.motion.add(move), MotionFault::kNone);
  for (const Sample& sample : GetParam().samples) {
    bench.run_until(sample.ms);
    EXPECT_NEAR(bench.position(), sample.position, 1e-6) << sample.ms;
    EXPECT_NEAR(bench.velocity(), sample.velocity, 1e-6) << sample.ms;
  }
  bench.run_until(bench.now_ms + kPeriodMs);
  EXPECT_TRUE(bench.motion.done());
  EXPECT_EQ(bench.position(), GetParam().samples.back().position);
  EXPECT_EQ(bench.velocity(), 0.0);
  EXPECT_EQ(bench.motion.fault(), MotionFault::kNone);
}

INSTANTIATE_TEST_SUITE_P(
    Courses, MotionCourse,
    testing::Values(
        // 100 ms and 50 counts up, 200 ms and 100 counts down, 850 counts between.
        Course{"Absolute",
               {discrete(MoveType::kTrapezoid, false, 700)},
               {{50, -287.5, 500}, {100, -250, 1000}, {500, 150, 1000}, {1050, 675, 500}, {1150, 700, 0}}},
        Course{"Relative",
               {discrete(MoveType::kTrapezoid, true, -1000)},
               {{50, -312.5, -500}, {500, -750, -1000}, {1050, -1275, -500}, {1150, -1300, 0}}},
        // Jerk 100000 counts/s^3: 200 ms and 100 counts at either end; the deceleration is not used.
        Course{"SCurve",
               {discrete(MoveType::kSCurve, false, 700)},
               {{50, -300 + 12.5 / 6, 125},
                {100, -300 + 100.0 / 6, 500},
                {200, -200, 1000},
                {1000, 600, 1000},
                {1100, 700 - 100.0 / 6, 500},
                {1200, 700, 0}}},
        // The second move begins when the first has ended, and counts from there.
        Course{"TwoRelative",
               {discrete(MoveType::kTrapezoid, true, 1000), discrete(MoveType::kTrapezoid, true, -1000)},
               {{1150, 700, 0}, {1200, 687.5, -500}, {2300, -300, 0}}},
        // 100 counts in 200 ms with 5000 counts/s^2, 1000 counts in 1 s, 100 counts in 200 ms.
        Course{"Segments",
               {segment(-200, 10'000), segment(800, 10'000), segment(900, 0)},
               {{100, -275, 500}, {200, -200, 1000}, {700, 300, 1000}, {1300, 875, 500}, {1400, 900, 0}}},
        Course{"RelativeSegments",
               {relative_segment(-100, 10'000), relative_segment(-1000, 10'000), relative_segment(-100, 0)},
               {{100, -325, -500}, {700, -900, -1000}, {1300, -1475, -500}, {1400, -1500, 0}}},
        // Between 1000 and 3000 counts/s: 200 counts in 100 ms; the acceleration changes at once, the speed does not.
        Course{"ThreeSpeeds",
               {segment(-200, 10'000), segment(0, 30'000), segment(150, 0)},
               {{200, -200, 1000}, {250, -125, 2000}, {300, 0, 3000}, {350, 112.5, 1500}, {400, 150, 0}}},
        // Jerk 4 dv / T^2 = 100000 counts/s^3 in either half.
        Course{"SCurveSegments",
               {segment(-200, 10'000, MoveType::kSegmentSCurve), segment(-100, 0, MoveType::kSegmentSCurve)},
               {{50, -300 + 12.5 / 6, 125},
                {100, -300 + 100.0 / 6, 500},
                {150, -250 + 12.5 / 6, 875},
                {200, -200, 1000},
                {250, -150 - 12.5 / 6, 875},
                {300, -100 - 100.0 / 6, 500},
                {400, -100, 0}}}),
    [](const auto& row) { return row.param.name; });

/// A period that does not divide the segments loses no time at their borders: 3 x 70 ms = 10 ms into the second.
TEST(MotionSegments, BordersWithinAPeriodLoseNoTime) {
  Bench bench;
  for (const Move& move : {segment(-200, 10'000), segment(800, 10'000), segment(900, 0)}) bench.motion.add(move);
  for (int i = 0; i < 3; ++i) bench.motion.step(milliseconds{70});
  EXPECT_NEAR(bench.position(), -190.0, 1e-6);
  for (int i = 0; i < 15; ++i) bench.motion.step(milliseconds{70});
  EXPECT_NEAR(bench.position(), 900.0 - 5000.0 * 0.14 * 0.14 / 2.0, 1e-6);
}

TEST(MotionQueue, HoldsThirtyTwoMovesAndTheNextIsAFault) {
  Bench bench;
  bench.motion.suspend(true);
  for (std::size_t i = 0; i < 32; ++i) {
    EXPECT_FALSE(bench.motion.queue().full()) << i;
    ASSERT_EQ(bench.motion.add(discrete(MoveType::kTrapezoid, true, 7)), MotionFault::kNone) << i;
  }
  EXPECT_TRUE(bench.motion.queue().full());
  EXPECT_EQ(bench.motion.add(discrete(MoveType::kTrapezoid, true, 7)), MotionFault::kQueueOverflow);
  EXPECT_TRUE(bench.motion.queue().empty());
  EXPECT_EQ(bench.motion.add(discrete(MoveType::kTrapezoid, true, 7)), MotionFault::kQueueOverflow);
  bench.motion.clear_fault();
  EXPECT_EQ(bench.motion.add(discrete(MoveType::kTrapezoid, true, 7)), MotionFault::kNone);
  EXPECT_EQ(bench.motion.queue().size(), 1U);
}

/// The ring of the queue is passed several times, and the moves keep their order.
TEST(MotionQueue, KeepsTheOrderOfMovesBeyondItsLength) {
  Bench bench;
  int expected = 0;
  for (int i = 0; i < 100; ++i) {
    expected += 3 * i - 100;
    ASSERT_EQ(bench.motion.add(discrete(MoveType::kTrapezoid, false, expected)), MotionFault::kNone);
    if (i % 2 != 0) {
      while (!bench.motion.done()) bench.motion.step(milliseconds{50});
      EXPECT_EQ(bench.position(), expected);
    }
  }
}

TEST(MotionQueue, SuspendedMovesWaitUntilTheSuspensionEnds) {
  Bench bench;
  bench.motion.suspend(true);
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 700));
  bench.run_until(100);
  EXPECT_EQ(bench.position(), kStart);
  EXPECT_TRUE(bench.motion.suspended());
  EXPECT_FALSE(bench.motion.done());
  bench.motion.suspend(false);
  bench.run_until(150);
  EXPECT_NEAR(bench.position(), -287.5, 1e-6);
}

/// A running chain of segments goes on with the segments that wait; the discrete move behind it does not begin.
TEST(MotionQueue, SuspensionHoldsBackOnlyStartsFromStandstill) {
  Bench bench;
  for (const Move& move : {segment(-200, 10'000), segment(-100, 0), discrete(MoveType::kTrapezoid, false, 700)}) {
    bench.motion.add(move);
  }
  bench.run_until(100);
  bench.motion.suspend(true);
  bench.run_until(1000);
  EXPECT_EQ(bench.position(), -100.0);
  EXPECT_FALSE(bench.motion.moving());
  EXPECT_EQ(bench.motion.queue().size(), 1U);
}

TEST(MotionQueue, FlushKeepsTheMoveThatRuns) {
  Bench bench;
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 700));
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 900));
  bench.run_until(100);
  bench.motion.flush();
  bench.run_until(3000);
  EXPECT_EQ(bench.position(), 700.0);
}

/// 4000 counts/s^2 from 1000 counts/s: 250 ms, 125 counts. The move behind is gone.
TEST(MotionStop, BrakesAndRemovesAllMoves) {
  Bench bench;
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 700));
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 900));
  bench.run_until(500);
  bench.motion.stop(400);
  bench.run_until(600);
  EXPECT_NEAR(bench.position(), 230.0, 1e-6);
  EXPECT_NEAR(bench.velocity(), 600.0, 1e-6);
  bench.run_until(800);
  EXPECT_NEAR(bench.position(), 275.0, 1e-6);
  EXPECT_TRUE(bench.motion.done());
}

/// 6085h is not buffered: from 600 counts/s on 6000 counts/s^2, 100 ms and 30 counts.
TEST(MotionStop, AnotherDecelerationActsAtOnce) {
  Bench bench;
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 700));
  bench.run_until(500);
  bench.motion.stop(400);
  bench.run_until(600);
  bench.motion.stop(600);
  bench.run_until(650);
  EXPECT_NEAR(bench.velocity(), 300.0, 1e-6);
  bench.run_until(710);
  EXPECT_NEAR(bench.position(), 260.0, 1e-6);
}

/// 100 counts with the deceleration of the move, then the rest of 450 counts: 1150 ms - 850 ms + 300 ms.
TEST(MotionHalt, GoesOnToTheSameTargetWhenReleased) {
  Bench bench;
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 700));
  bench.run_until(500);
  bench.motion.halt(true);
  bench.run_until(1000);
  EXPECT_NEAR(bench.position(), 250.0, 1e-6);
  EXPECT_TRUE(bench.motion.moving());
  bench.motion.halt(false);
  bench.run_until(1100);
  EXPECT_NEAR(bench.position(), 300.0, 1e-6);
  bench.run_until(1602);
  EXPECT_EQ(bench.position(), 700.0);
}

/// The halt of segments brakes with the deceleration of a fault if the segment has none; the rest of the segment is
/// planned from standstill: 375 counts to 1000 counts/s in 750 ms.
TEST(MotionHalt, TheRestOfASegmentBeginsAtStandstill) {
  Bench bench;
  for (const Move& move : {segment(-200, 10'000), segment(800, 10'000), segment(900, 0)}) bench.motion.add(move);
  bench.run_until(700);
  bench.motion.halt(true);
  bench.run_until(1000);
  EXPECT_NEAR(bench.position(), 425.0, 1e-6);
  bench.motion.halt(false);
  bench.run_until(1750);
  EXPECT_NEAR(bench.position(), 800.0, 1e-6);
  EXPECT_NEAR(bench.velocity(), 1000.0, 1e-6);
  bench.run_until(1952);
  EXPECT_EQ(bench.position(), 900.0);
}

/// The axis brakes over the end of the first segment (-200). The chain goes on with the second one, which leads from
/// standstill to standstill and is therefore a fault.
TEST(MotionHalt, ASegmentWhoseEndWasPassedHasEnded) {
  Bench bench;
  bench.motion.add(segment(-200, 10'000));
  bench.motion.add(segment(900, 0));
  bench.run_until(180);
  bench.motion.halt(true);
  bench.run_until(600);
  EXPECT_NEAR(bench.position(), -219.0 + 900.0 * 900.0 / 8000.0, 1e-6);
  bench.motion.halt(false);
  bench.run_until(700);
  EXPECT_EQ(bench.motion.fault(), MotionFault::kVelocityTooSmall);
}

/// A mark at -80, at 1000 counts/s, makes 520 the target, and a second mark does nothing.
TEST(MotionRegistration, TheFirstMarkMakesTheTarget) {
  Bench bench;
  Move move = discrete(MoveType::kTrapezoid, false, 10'000);
  move.beyond_mark = 600;
  bench.motion.add(move);
  bench.run_until(280);
  EXPECT_NEAR(bench.position(), -70.0, 1e-6);
  EXPECT_FALSE(bench.motion.marked());
  bench.motion.mark(-80.0);
  EXPECT_TRUE(bench.motion.marked());
  bench.run_until(300);
  EXPECT_NEAR(bench.position(), -50.0, 1e-6);
  bench.motion.mark(-50.0);
  bench.run_until(2000);
  EXPECT_EQ(bench.position(), 520.0);
}

TEST(MotionRegistration, WithoutAMarkTheMoveGoesToItsTarget) {
  Bench bench;
  Move move = discrete(MoveType::kTrapezoid, false, 700);
  move.beyond_mark = 100;
  bench.motion.mark(-290.0);  // before the move: no effect
  bench.motion.add(move);
  bench.run_until(1152);
  EXPECT_EQ(bench.position(), 700.0);
  bench.motion.mark(650.0);  // after the move: no effect
  bench.run_until(1500);
  EXPECT_EQ(bench.position(), 700.0);
  EXPECT_FALSE(bench.motion.marked());
}

struct Refusal {
  std::string name;
  MotionFault fault;
  Move move;
};

class MotionRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(MotionRefusal, IsAFaultAndNothingMoves) {
  Bench bench;
  EXPECT_EQ(bench.motion.add(GetParam().move), GetParam().fault);
  bench.run_until(20);
  EXPECT_EQ(bench.position(), kStart);
  EXPECT_TRUE(bench.motion.done());
}

constexpr Move altered(std::int32_t velocity, std::int32_t acceleration, std::int32_t deceleration) {
  return {.target = 700, .velocity = velocity, .acceleration = acceleration, .deceleration = deceleration};
}

INSTANTIATE_TEST_SUITE_P(
    Moves, MotionRefusal,
    testing::Values(
        Refusal{"VelocityAboveItsRange", MotionFault::kVelocityTooBig, altered(500'000'001, 1000, 500)},
        Refusal{"NoVelocity", MotionFault::kVelocityTooSmall, altered(0, 1000, 500)},
        Refusal{"AccelerationAboveItsRange", MotionFault::kAccelerationTooBig, altered(10'000, 200'000'001, 500)},
        Refusal{"NoAcceleration", MotionFault::kAccelerationTooSmall, altered(10'000, 0, 500)},
        Refusal{"DecelerationAboveItsRange", MotionFault::kAccelerationTooBig, altered(10'000, 1000, 200'000'001)},
        Refusal{"NoDeceleration", MotionFault::kAccelerationTooSmall, altered(10'000, 1000, 0)},
        Refusal{"NegativeEndVelocity", MotionFault::kVelocityTooSmall, segment(-200, -1)},
        Refusal{"EndVelocityAboveItsRange", MotionFault::kVelocityTooBig, segment(-200, 500'000'001)}),
    [](const auto& row) { return row.param.name; });

TEST(MotionFaults, ValuesAtTheEndOfTheirRangesAreTaken) {
  Bench bench;
  EXPECT_EQ(bench.motion.add(altered(500'000'000, 200'000'000, 200'000'000)), MotionFault::kNone);
  Move s_curve = discrete(MoveType::kSCurve, false, 700);
  s_curve.deceleration = 0;
  EXPECT_EQ(bench.motion.add(s_curve), MotionFault::kNone);
}

TEST(MotionFaults, AMoveOfADisabledDriveIsRefusedAndDisablingRemovesMoves) {
  Bench bench;
  bench.motion.add(discrete(MoveType::kTrapezoid, false, 700));
  bench.run_until(100);
  bench.motion.enable(false);
  bench.run_until(200);
  EXPECT_NEAR(bench.position(), -250.0, 1e-6);
  EXPECT_EQ(bench.velocity(), 0.0);
  EXPECT_EQ(bench.motion.add(discrete(MoveType::kTrapezoid, false, 700)), MotionFault::kDisabled);
}

struct Contradiction {
  std::string name;
  MotionFault fault;
  std::vector<Move> moves;
  double fault_speed = 0.0;  ///< at the end of the last good segment
  double rest = 0.0;         ///< position after braking with 4000 counts/s^2
};

class MotionContradiction : public testing::TestWithParam<Contradiction> {};

TEST_P(MotionContradiction, BrakesTheAxisWithItsFault) {
  Bench bench;
  for (const Move& move : GetParam().moves) ASSERT_EQ(bench.motion.add(move), MotionFault::kNone);
  double fastest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    bench.motion.step(milliseconds{kPeriodMs});
    fastest = std::max(fastest, std::abs(bench.velocity()));
  }
  EXPECT_EQ(bench.motion.fault(), GetParam().fault);
  EXPECT_NEAR(fastest, GetParam().fault_speed, 1e-6);
  EXPECT_NEAR(bench.position(), GetParam().rest, 1e-6);
  EXPECT_TRUE(bench.motion.done());
}

INSTANTIATE_TEST_SUITE_P(
    Segments, MotionContradiction,
    testing::Values(
        Contradiction{"LastOneHasAVelocity", MotionFault::kQueueUnderflow, {segment(-200, 10'000)}, 1000, -75},
        Contradiction{"ADiscreteMoveFollows",
                      MotionFault::kQueueUnderflow,
                      {segment(-200, 10'000), discrete(MoveType::kTrapezoid, false, 700)},
                      1000,
                      -75},
        Contradiction{"TheNextOneLeadsBack",
                      MotionFault::kAccelerationTooBig,
                      {segment(-200, 10'000), segment(-250, 0)},
                      1000,
                      -75},
        Contradiction{"AnotherVelocityWithoutLength",
                      MotionFault::kAccelerationTooBig,
                      {segment(-200, 10'000), segment(-200, 9'000)},
                      1000,
                      -75},
        Contradiction{"NoVelocityAtEitherEnd", MotionFault::kVelocityTooSmall, {segment(-200, 0)}, 0, -300},
        // (50 000 000 counts/s)^2 / 2 in 100 counts.
        Contradiction{"TooShort", MotionFault::kAccelerationTooBig, {segment(-200, 500'000'000)}, 0, -300},
        // (10 counts/s)^2 / (2 x 1000 counts) = 0.05 counts/s^2.
        Contradiction{"TooLong", MotionFault::kAccelerationTooSmall, {segment(700, 100)}, 0, -300}),
    [](const auto& row) { return row.param.name; });

/// An S-curve of the same segment needs twice the acceleration: 600000^2 / 2 / 100 = 1.8e9 counts/s^2 is allowed,
/// 3.6e9 is not.
TEST(MotionFaults, AnSCurveSegmentNeedsTwiceTheAcceleration) {
  for (const bool s_curve : {false, true}) {
    Bench bench;
    bench.motion.add(segment(-200, 6'000'000, s_curve ? MoveType::kSegmentSCurve : MoveType::kSegment));
    bench.motion.add(segment(1'000'000, 0));
    bench.motion.step(milliseconds{kPeriodMs});
    EXPECT_EQ(bench.motion.fault(), s_curve ? MotionFault::kAccelerationTooBig : MotionFault::kNone);
  }
}

TEST(MotionAllocation, MovesSegmentsAndFaultsAllocateNothing) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  Bench bench;
  rt::RtGuard::enter();
  bench.motion.add(discrete(MoveType::kSCurve, true, 500));
  bench.motion.add(segment(400, 10'000));
  bench.run_until(3000);
  bench.motion.mark(3.0);
  bench.motion.stop(400);
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_EQ(bench.motion.fault(), MotionFault::kQueueUnderflow);
}

}  // namespace
}  // namespace driveline::slaves::position_servo::motion_test
