// Every homing method on an axis with switches and index pulses, from starts on all sides of them.
#include "driveline/slaves/position_servo/homing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

namespace driveline::slaves::position_servo::homing_test {
namespace {

using std::chrono::milliseconds;
using State = Homing::State;

constexpr std::int64_t kPeriodMs = 2;
constexpr std::int32_t kOffset = 40;

enum class Home : std::uint8_t { kNone, kPositive, kNegative, kCam };

/// Limit switches are active from -500 down and from 500 up, index pulses are at 37 + 100 n. The home switch is active
/// from 130 up (kPositive), from -130 down (kNegative), or from 100 to 259 (kCam).
struct Machine {
  Home home = Home::kNone;
  bool index = true;
  bool limits = true;

  [[nodiscard]] bool home_switch(std::int64_t p) const {
    if (home == Home::kPositive) return p >= 130;
    if (home == Home::kNegative) return p <= -130;
    return home == Home::kCam && p >= 100 && p < 260;
  }
  /// The pulse between two positions, both whole counts; at most one, as an axis of this test is not that fast.
  [[nodiscard]] std::optional<std::int64_t> pulse(std::int64_t from, std::int64_t to) const {
    const std::int64_t step = to > from ? 1 : -1;
    for (std::int64_t p = from; index && p != to; p += step) {
      if ((p + step - 37) % 100 == 0) return p + step;
    }
    return std::nullopt;
  }
  [[nodiscard]] HomingInputs inputs(std::int64_t p) const {
    HomingInputs seen;
    seen.negative_limit = limits && p <= -500;
    seen.positive_limit = limits && p >= 500;
    seen.home_switch = home_switch(p);
    seen.position = p;
    return seen;
  }
};

/// An axis that follows the demand at once.
struct Bench {
  Machine machine;
  Homing homing;
  std::int64_t position;
  double fastest = 0.0;
  int first_direction = 0;

  Bench(const Machine& made, std::int64_t start) : machine(made), position(start) {}
  [[nodiscard]] bool start(std::int8_t method) { return homing.start(settings(method), machine.inputs(position)); }
  /// 2500 and 100 counts/s: 5 and 0.2 counts in a period; 200000 counts/s^2.
  static HomingSettings settings(std::int8_t method) {
    return {.method = method, .fast = 25'000, .slow = 1000, .acceleration = 20'000, .offset = kOffset};
  }
  void step() {
    const auto now = static_cast<std::int64_t>(std::floor(homing.demand().position));
    HomingInputs seen = machine.inputs(now);
    const double velocity = homing.demand().velocity;
    seen.travel = velocity > 0.0 ? 1 : velocity < 0.0 ? -1 : 0;
    seen.index_pulse = machine.pulse(position, now);
    position = now;
    if (first_direction == 0) first_direction = seen.travel;
    fastest = std::max(fastest, std::abs(velocity));
    homing.step(seen, milliseconds{kPeriodMs});
  }
  void run() {
    for (int i = 0; i < 50'000 && (homing.state() == State::kSearching || homing.state() == State::kMoving); ++i)
      step();
  }
  /// The home position in old counts.
  [[nodiscard]] std::int64_t home() const { return -kOffset - homing.shift(); }
};

struct Row {
  std::int8_t method;
  Home home;
  std::int64_t position;  ///< where home is, from every start
  int direction;          ///< first direction from -90, where no switch is active
};

class PositionServoHoming : public testing::TestWithParam<Row> {};

TEST_P(PositionServoHoming, EndsOnItsEdgeFromEveryStart) {
  const Row& row = GetParam();
  for (const std::int64_t start : {-520, -480, -400, -140, -90, 0, 120, 180, 250, 400, 520}) {
    Bench bench({.home = row.home}, start);
    ASSERT_TRUE(bench.start(row.method));
    bench.run();
    EXPECT_EQ(bench.homing.state(), State::kAttained) << start;
    EXPECT_EQ(bench.home(), row.position) << start;
    EXPECT_EQ(bench.homing.demand().velocity, 0.0);
    EXPECT_LE(bench.fastest, 2500.0 + 1e-9);
    if (start == -90) {
      EXPECT_EQ(bench.first_direction, row.direction);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, PositionServoHoming,
    testing::Values(Row{1, Home::kNone, -463, -1}, Row{2, Home::kNone, 437, 1}, Row{3, Home::kPositive, 37, 1},
                    Row{4, Home::kPositive, 137, 1}, Row{5, Home::kNegative, -63, -1},
                    Row{6, Home::kNegative, -163, -1}, Row{7, Home::kCam, 37, 1}, Row{8, Home::kCam, 137, 1},
                    Row{9, Home::kCam, 237, 1}, Row{10, Home::kCam, 337, 1}, Row{11, Home::kCam, 337, -1},
                    Row{12, Home::kCam, 237, -1}, Row{13, Home::kCam, 137, -1}, Row{14, Home::kCam, 37, -1},
                    Row{17, Home::kNone, -499, -1}, Row{18, Home::kNone, 499, 1}, Row{19, Home::kPositive, 129, 1},
                    Row{21, Home::kNegative, -129, -1}, Row{23, Home::kCam, 99, 1}, Row{25, Home::kCam, 259, 1},
                    Row{27, Home::kCam, 260, -1}, Row{29, Home::kCam, 100, -1}),
    [](const auto& row) { return std::to_string(row.param.method); });

TEST(PositionServoHomingIndex, IsTheFirstInItsDirection) {
  for (const auto& [method, expected] : {std::pair{33, -63}, std::pair{34, 37}}) {
    Bench bench({}, -20);
    ASSERT_TRUE(bench.start(static_cast<std::int8_t>(method)));
    bench.run();
    EXPECT_EQ(bench.homing.state(), State::kAttained);
    EXPECT_EQ(bench.home(), expected);
    EXPECT_NEAR(bench.fastest, 100.0, 1e-9);
  }
}

TEST(PositionServoHomingMethods, AreThoseOfTheManualAndOthersAreRefused) {
  const std::set<int> known = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                               13, 14, 17, 18, 19, 21, 23, 25, 27, 29, 33, 34, 35};
  for (int method = -128; method <= 127; ++method) {
    Bench bench({}, -20);
    EXPECT_EQ(bench.start(static_cast<std::int8_t>(method)), known.contains(method)) << method;
    EXPECT_EQ(bench.homing.state() == State::kSearching, known.contains(method)) << method;
  }
}

TEST(PositionServoHomingMethods, RefuseSpeedsAndAccelerationsOutsideTheirRanges) {
  const HomingSettings good = Bench::settings(1);
  for (const std::int32_t bad : {0, -1, 500'000'001}) {
    HomingSettings fast = good;
    fast.fast = bad;
    HomingSettings slow = good;
    slow.slow = bad;
    HomingSettings acceleration = good;
    acceleration.acceleration = bad;
    for (const HomingSettings& settings : {fast, slow, acceleration}) {
      EXPECT_FALSE(Homing{}.start(settings, HomingInputs{})) << bad;
    }
  }
}

/// Zero is home plus the offset, so the home position has the value -40.
TEST(PositionServoHomingHere, Method0DoesNotMove) {
  Bench bench({}, -123);
  ASSERT_TRUE(bench.start(0));
  bench.run();
  EXPECT_EQ(bench.homing.state(), State::kAttained);
  EXPECT_EQ(bench.homing.shift(), 83);
  EXPECT_EQ(bench.homing.demand().position, -40.0);
}

/// 100 counts/s after 100 ms and 5 counts; 30 counts in 300 ms; the first period sets home.
TEST(PositionServoHomingHere, Method35MovesToTheNewZero) {
  Bench bench({}, -123);
  HomingSettings settings = Bench::settings(35);
  settings.fast = 1000;
  settings.acceleration = 100;
  ASSERT_TRUE(bench.homing.start(settings, bench.machine.inputs(-123)));
  std::int64_t now = 0;
  for (const auto& [ms, position, velocity] : {std::tuple{2, -40.0, 0.0}, std::tuple{102, -35.0, 100.0},
                                               std::tuple{252, -20.0, 100.0}, std::tuple{452, -1.25, 50.0}}) {
    for (; now < ms; now += kPeriodMs) bench.step();
    EXPECT_NEAR(bench.homing.demand().position, position, 1e-6) << ms;
    EXPECT_NEAR(bench.homing.demand().velocity, velocity, 1e-6) << ms;
    EXPECT_EQ(bench.homing.state(), State::kMoving);
  }
  bench.run();
  EXPECT_EQ(bench.homing.state(), State::kAttained);
  EXPECT_EQ(bench.homing.demand().position, 0.0);
}

struct Missing {
  std::string name;
  std::int8_t method;
  Machine machine;
  HomingSequence::Failure failure;
};

class PositionServoHomingFailure : public testing::TestWithParam<Missing> {};

TEST_P(PositionServoHomingFailure, StopsTheAxis) {
  Bench bench(GetParam().machine, 60);
  ASSERT_TRUE(bench.start(GetParam().method));
  bench.run();
  EXPECT_EQ(bench.homing.state(), State::kFailed);
  EXPECT_EQ(bench.homing.failure(), GetParam().failure);
  EXPECT_EQ(bench.homing.shift(), 0);
  for (int i = 0; i < 20; ++i) bench.step();
  EXPECT_EQ(bench.homing.demand().velocity, 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    Signals, PositionServoHomingFailure,
    testing::Values(
        Missing{"NoIndexFromTheLimit", 1, {.index = false}, HomingSequence::Failure::kLimitSwitch},
        Missing{"NoHomeSwitch", 3, {}, HomingSequence::Failure::kLimitSwitch},
        Missing{"NoCam", 7, {}, HomingSequence::Failure::kLimitSwitch},
        Missing{"NoCamWithoutIndex", 29, {}, HomingSequence::Failure::kLimitSwitch},
        Missing{"NoIndexAtTheCam", 10, {.home = Home::kCam, .index = false}, HomingSequence::Failure::kLimitSwitch},
        Missing{"NoIndexToTheLimit", 33, {.index = false}, HomingSequence::Failure::kLimitSwitch},
        Missing{"NothingAtAll", 34, {.index = false, .limits = false}, HomingSequence::Failure::kTimeOut}),
    [](const auto& row) { return row.param.name; });

/// 200000 counts/s^2 from 2500 counts/s: 12.5 ms, 15.625 counts.
TEST(PositionServoHomingStop, BrakesWithTheHomingAcceleration) {
  Bench bench({}, 400);
  ASSERT_TRUE(bench.start(1));
  for (int i = 0; i < 50; ++i) bench.step();
  const double from = bench.homing.demand().position;
  bench.homing.stop();
  EXPECT_EQ(bench.homing.state(), State::kIdle);
  for (int i = 0; i < 7; ++i) bench.step();
  EXPECT_NEAR(bench.homing.demand().position, from - 15.625, 1e-6);
  EXPECT_EQ(bench.homing.demand().velocity, 0.0);
  EXPECT_EQ(bench.homing.shift(), 0);
}

}  // namespace
}  // namespace driveline::slaves::position_servo::homing_test
