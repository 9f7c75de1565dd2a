#include "driveline/trajectory/setpoint_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "driveline/rt_guard/rt_guard.hpp"
#include "driveline/trajectory/path.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kPeriod = 125e-6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr std::array kAllMethods{StreamMethod::kHold,  StreamMethod::kLinear,  StreamMethod::kHermite,
                                 StreamMethod::kCubic, StreamMethod::kQuintic, StreamMethod::kBSpline};

/// Differentiates the positions of a stream and compares them with the limits. Only the rounding of the positions is
/// tolerated.
class Judge {
 public:
  explicit Judge(const AxisLimits& limits, double start) : limits_(limits), position_(start) {}

  [[nodiscard]] bool accepts(const AxisSetpoint& now) {
    const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(now.position), 1.0);
    const double velocity = (now.position - position_) / kPeriod;
    const double acceleration = (velocity - velocity_) / kPeriod;
    position_ = now.position;
    velocity_ = velocity;
    largest_acceleration_ = std::max(largest_acceleration_, std::abs(acceleration));
    return std::isfinite(now.position) && std::abs(now.velocity) <= limits_.max_velocity &&
           std::abs(now.acceleration) <= limits_.max_acceleration &&
           std::abs(velocity) <= limits_.max_velocity * (1.0 + 1e-9) + rounding / kPeriod &&
           std::abs(acceleration) <= limits_.max_acceleration * (1.0 + 1e-8) + 2.0 * rounding / kPeriod / kPeriod;
  }
  [[nodiscard]] double velocity() const { return velocity_; }
  [[nodiscard]] double largest_acceleration() const { return largest_acceleration_; }

 private:
  AxisLimits limits_;
  double position_;
  double velocity_ = 0.0;
  double largest_acceleration_ = 0.0;
};

constexpr FollowLimits kLimits{{10.0, 200.0}, 1e4};

StreamSettings settings_of(StreamMethod method, double step_s = 1e-3) {
  StreamSettings settings;
  settings.method = method;
  settings.delay_s = static_cast<double>(facts_of(method).delay) * step_s;
  settings.max_gap_s = 5.0 * step_s;
  return settings;
}

/// A smooth motion within kLimits that starts at standstill without acceleration.
StreamPoint swing(double t) {
  const double w = 2.0 * std::numbers::pi;
  const double x = w * t;
  return {t - std::sin(x) / w, 1.0 - std::cos(x), w * std::sin(x)};
}

/// One axis and the wall clock; sends the given setpoints in each cycle.
class Line {
 public:
  explicit Line(const StreamSettings& settings, const FollowLimits& limits = kLimits, double start = 0.0)
      : stream(settings, std::array{limits}), judge(limits.motion, start) {
    stream.begin(0.0, std::array{start});
  }

  StreamVerdict push(double time_s, const StreamPoint& point) { return stream.push(time_s, std::array{point}); }
  AxisSetpoint cycle() {
    ++cycles;
    state = stream.evaluate(now(), out);
    EXPECT_TRUE(judge.accepts(out[0])) << "at " << now() << " s, position " << out[0].position << ", velocity "
                                       << judge.velocity() << ", acceleration up to " << judge.largest_acceleration();
    return out[0];
  }
  [[nodiscard]] double now() const { return cycles * kPeriod; }
  /// The time of the next cycle.
  [[nodiscard]] double next() const { return (cycles + 1) * kPeriod; }

  SetpointStream stream;
  Judge judge;
  int cycles = 0;
  StreamState state = StreamState::kAtRest;
  std::array<AxisSetpoint, 1> out{};
};

std::uint64_t count(const Line& line, StreamVerdict verdict) {
  return line.stream.counters().verdicts[static_cast<std::size_t>(verdict)];
}

TEST(SetpointStream, RefusesSettingsThatCannotBe) {
  const auto make = [](const StreamSettings& settings, std::vector<FollowLimits> limits) {
    SetpointStream stream(settings, limits);
  };
  const StreamSettings good = settings_of(StreamMethod::kCubic);
  EXPECT_NO_THROW(make(good, {kLimits}));
  EXPECT_THROW(make(good, {}), std::invalid_argument);
  EXPECT_THROW(make(good, std::vector<FollowLimits>(257, kLimits)), std::invalid_argument);
  for (const double wrong : {0.0, -1.0, kInfinity, kNan}) {
    for (double StreamSettings::*const time :
         {&StreamSettings::period_s, &StreamSettings::max_gap_s, &StreamSettings::max_ahead_s}) {
      StreamSettings bad = good;
      bad.*time = wrong;
      EXPECT_THROW(make(bad, {kLimits}), std::invalid_argument) << wrong;
    }
    EXPECT_THROW(make(good, {{{wrong, 1.0}, 1.0}}), std::invalid_argument);
    EXPECT_THROW(make(good, {{{1.0, wrong}, 1.0}}), std::invalid_argument);
    if (wrong != kInfinity) {
      EXPECT_THROW(make(good, {{{1.0, 1.0}, wrong}}), std::invalid_argument);
    }
  }
  StreamSettings bad = good;
  bad.delay_s = -1e-9;
  EXPECT_THROW(make(bad, {kLimits}), std::invalid_argument);
  bad = good;
  bad.capacity = facts_of(bad.method).delay;
  EXPECT_THROW(make(bad, {kLimits}), std::invalid_argument);
}

TEST(SetpointStream, EveryRefusalHasItsOwnValueAndCounter) {
  StreamSettings settings = settings_of(StreamMethod::kLinear);
  settings.capacity = 4;
  settings.max_ahead_s = 0.1;
  Line line(settings);
  const StreamPoint point{};
  EXPECT_EQ(line.stream.push(0.0, {}), StreamVerdict::kWrongCount);
  EXPECT_EQ(line.stream.push(0.0, std::array<StreamPoint, 2>{}), StreamVerdict::kWrongCount);
  for (const double wrong : {kNan, kInfinity, -kInfinity}) {
    EXPECT_EQ(line.push(wrong, point), StreamVerdict::kNotFinite);
    EXPECT_EQ(line.push(0.0, {wrong, 0.0, 0.0}), StreamVerdict::kNotFinite);
    EXPECT_EQ(line.push(0.0, {0.0, wrong, 0.0}), StreamVerdict::kNotFinite);
    EXPECT_EQ(line.push(0.0, {0.0, 0.0, wrong}), StreamVerdict::kNotFinite);
  }
  EXPECT_EQ(line.push(0.0, {-1.1e9, 0.0, 0.0}), StreamVerdict::kOutOfRange);
  EXPECT_EQ(line.push(0.0, {0.0, 1.1e12, 0.0}), StreamVerdict::kOutOfRange);
  EXPECT_EQ(line.push(0.0, {0.0, 0.0, -1.1e15}), StreamVerdict::kOutOfRange);
  EXPECT_EQ(line.push(-0.0011, point), StreamVerdict::kTooLate) << "the delay is 1 ms";
  EXPECT_EQ(line.push(0.1001, point), StreamVerdict::kTooFarAhead);
  EXPECT_EQ(line.push(0.001, point), StreamVerdict::kAccepted);
  EXPECT_EQ(line.push(0.001, point), StreamVerdict::kDuplicate);
  EXPECT_EQ(line.push(0.001 + 0.9e-9, point), StreamVerdict::kDuplicate);
  EXPECT_EQ(line.push(0.0005, point), StreamVerdict::kOutOfOrder);
  EXPECT_EQ(line.push(0.0061, point), StreamVerdict::kGapTooLarge);
  for (const double time_s : {0.002, 0.003, 0.004, 0.005}) {
    EXPECT_EQ(line.push(time_s, point), StreamVerdict::kAccepted);
  }
  EXPECT_EQ(line.push(0.006, point), StreamVerdict::kOverrun);
  constexpr std::array<std::uint64_t, kStreamVerdicts> kExpected{5, 2, 12, 3, 2, 1, 1, 1, 1, 1};
  EXPECT_EQ(line.stream.counters().verdicts, kExpected);
}

TEST(SetpointStream, ARefusedSetpointLeavesNoTrace) {
  StreamSettings settings = settings_of(StreamMethod::kCubic);
  Line clean(settings);
  Line dirty(settings);
  for (int k = 0; k < 400; ++k) {
    if (k % 8 == 0) {
      const double t = clean.next();
      EXPECT_EQ(clean.push(t, swing(t)), StreamVerdict::kAccepted);
      EXPECT_EQ(dirty.push(t, swing(t)), StreamVerdict::kAccepted);
      (void)dirty.push(t, {9.0});
      (void)dirty.push(t - 5e-4, {9.0});
      (void)dirty.push(t + 0.5, {9.0});
      (void)dirty.push(t + 1e-4, {kNan});
    }
    test::expect_setpoint(dirty.cycle(), clean.cycle());
  }
  EXPECT_EQ(dirty.stream.counters().underruns, 0U);
}

// Sent just in time, with exactly the stated delay.
TEST(SetpointStream, FollowsTheCurveExactlyWithTheStatedDelay) {
  for (const StreamMethod method : kAllMethods) {
    if (method == StreamMethod::kHold) continue;
    SCOPED_TRACE(static_cast<int>(method));
    Line line(settings_of(method));
    double farthest = 0.0;
    for (int k = 1; k < 8000; ++k) {
      if (k % 8 == 1) {
        ASSERT_EQ(line.push(k * kPeriod, swing((k - 1) * kPeriod)), StreamVerdict::kAccepted);
      }
      const AxisSetpoint now = line.cycle();
      const double t = line.now() - kPeriod - static_cast<double>(facts_of(method).delay) * 1e-3;
      if (t > 0.0) farthest = std::max(farthest, std::abs(now.position - swing(t).position));
    }
    EXPECT_EQ(line.state, StreamState::kFollowing);
    EXPECT_TRUE(line.stream.on_curve());
    EXPECT_EQ(line.stream.counters().underruns, 0U);
    EXPECT_EQ(line.stream.counters().detours, 0U);
    EXPECT_LT(farthest, method == StreamMethod::kQuintic || method == StreamMethod::kHermite ? 1e-10
                        : method == StreamMethod::kCubic                                     ? 1e-8
                                                                                             : 1.1e-5);
  }
}

TEST(SetpointStream, OneSetpointLessOfDelayIsAnUnderrunInEveryStep) {
  for (const StreamMethod method : kAllMethods) {
    if (method == StreamMethod::kHold) continue;
    SCOPED_TRACE(static_cast<int>(method));
    StreamSettings settings = settings_of(method);
    settings.delay_s -= 1e-3;
    settings.coast_cycles = 16;
    Line line(settings);
    for (int k = 1; k < 800; ++k) {
      if (k % 8 == 1) {
        ASSERT_EQ(line.push(k * kPeriod, swing((k - 1) * kPeriod)), StreamVerdict::kAccepted);
      }
      line.cycle();
    }
    EXPECT_GT(line.stream.counters().underruns, 90U);
    EXPECT_LE(line.stream.counters().stops, 2U) << "at its begin; then each underrun has all its cycles to coast";
  }
}

TEST(SetpointStream, JitteredStampsAndArrivalsDoNotShowInTheDemand) {
  for (const StreamMethod method : {StreamMethod::kHermite, StreamMethod::kCubic, StreamMethod::kQuintic}) {
    SCOPED_TRACE(static_cast<int>(method));
    test::Random random;
    StreamSettings settings = settings_of(method);
    settings.delay_s += 2e-3;  // for the arrivals
    Line line(settings);
    double next_s = 0.0;
    std::vector<std::pair<double, double>> under_way;  // arrival time, and time stamp
    for (int k = 0; k < 8000; ++k) {
      while (next_s <= line.now()) {
        under_way.emplace_back(next_s + random.real(0.0, 0.9e-3), next_s);
        next_s += random.real(0.6e-3, 1e-3);
      }
      while (!under_way.empty() && under_way.front().first <= line.now()) {
        ASSERT_EQ(line.push(under_way.front().second, swing(under_way.front().second)), StreamVerdict::kAccepted);
        under_way.erase(under_way.begin());
      }
      const AxisSetpoint now = line.cycle();
      const double t = line.now() - settings.delay_s;
      if (t > 0.0) {
        ASSERT_NEAR(now.position, swing(t).position, 1e-7);
      }
    }
    EXPECT_EQ(line.stream.counters().underruns, 0U);
    EXPECT_EQ(line.stream.counters().detours, 0U);
  }
}

/// Streams the motion, except for the setpoints of an interval.
void stream_without(Line& line, double from_s, double to_s, double until_s) {
  while (line.now() < until_s) {
    const double t = line.next();
    if (line.cycles % 8 == 0 && (t < from_s || t >= to_s)) (void)line.push(t, swing(t));
    line.cycle();
  }
}

TEST(SetpointStream, ADroppedSetpointIsBridgedOnThePolynomial) {
  for (const StreamMethod method : kAllMethods) {
    if (method == StreamMethod::kHold) continue;
    SCOPED_TRACE(static_cast<int>(method));
    StreamSettings settings = settings_of(method);
    settings.coast_cycles = 16;
    Line line(settings);
    stream_without(line, 0.3, 0.3009, 0.6);
    EXPECT_EQ(line.stream.counters().underruns, facts_of(method).delay) << "one for each that is waited for with it";
    EXPECT_EQ(line.stream.counters().stops, 0U);
    EXPECT_EQ(line.state, StreamState::kFollowing);
    EXPECT_TRUE(line.stream.on_curve());
  }
}

TEST(SetpointStream, ADroppedSetpointIsNothingToAStepOfDelayToSpare) {
  for (const StreamMethod method : kAllMethods) {
    if (method == StreamMethod::kHold) continue;
    SCOPED_TRACE(static_cast<int>(method));
    StreamSettings settings = settings_of(method);
    settings.delay_s += 1e-3;
    Line line(settings);
    stream_without(line, 0.3, 0.3009, 0.6);
    EXPECT_EQ(line.stream.counters().underruns, 0U);
    EXPECT_EQ(line.stream.counters().detours, 0U);
  }
}

TEST(SetpointStream, ALongLossIsCoastedThenStoppedWithBoundedJerkThenTakenUpAgain) {
  for (const StreamMethod method : kAllMethods) {
    SCOPED_TRACE(static_cast<int>(method));
    StreamSettings settings = settings_of(method);
    settings.coast_cycles = 5;
    Line line(settings);
    stream_without(line, 0.3, 9.0, 0.3);
    const double lost_s = line.now();
    int coasted = 0;
    std::optional<double> stopped_s;
    double jerk = 0.0;
    std::array<double, 2> accelerations{};
    while (!stopped_s && line.now() < 2.0) {
      const double before = line.judge.velocity();
      line.cycle();
      coasted += line.state == StreamState::kCoasting ? 1 : 0;
      const double acceleration = (line.judge.velocity() - before) / kPeriod;
      const double change = (acceleration - accelerations[0]) / kPeriod;
      if (line.state == StreamState::kStopping && accelerations[1] != 0.0) jerk = std::max(jerk, std::abs(change));
      accelerations = {acceleration, line.state == StreamState::kStopping ? 1.0 : 0.0};
      if (line.state == StreamState::kAtRest) stopped_s = line.now();
    }
    ASSERT_TRUE(stopped_s.has_value());
    EXPECT_EQ(coasted, 5);
    EXPECT_EQ(line.stream.counters().underruns, 1U);
    EXPECT_EQ(line.stream.counters().stops, 1U);
    EXPECT_LT(*stopped_s - lost_s, 0.3);
    if (method != StreamMethod::kHold) {
      EXPECT_LT(jerk, kLimits.max_jerk * 1.01);
    }
    const double rest = line.out[0].position;
    for (int k = 0; k < 100; ++k) ASSERT_EQ(line.cycle().position, rest);

    stream_without(line, 0.0, 0.0, line.now() + 1.0);
    EXPECT_EQ(line.state, StreamState::kFollowing);
    EXPECT_EQ(line.stream.counters().underruns, 1U);
    if (method != StreamMethod::kHold) {
      EXPECT_TRUE(line.stream.on_curve()) << "back on the curve";
    }
  }
}

TEST(SetpointStream, ALeapOfTheSetpointsIsADetourWithinTheLimits) {
  for (const StreamMethod method : kAllMethods) {
    SCOPED_TRACE(static_cast<int>(method));
    Line line(settings_of(method));
    while (line.now() < 1.5) {
      if (line.cycles % 8 == 0) (void)line.push(line.next(), {line.now() < 0.2 ? 0.0 : 2.0});
      line.cycle();
    }
    EXPECT_EQ(line.stream.counters().detours, 1U);
    EXPECT_EQ(line.out[0].position, 2.0);
    EXPECT_TRUE(line.stream.on_curve());
  }
}

TEST(SetpointStream, AFarGapIsRefusedWhileTheCurveRunsAndBeginsANewOneAfterIt) {
  Line line(settings_of(StreamMethod::kLinear));
  stream_without(line, 0.2, 9.0, 0.2);
  EXPECT_EQ(line.push(line.now() + 0.01, {5.0}), StreamVerdict::kGapTooLarge);
  while (line.state != StreamState::kStopping) {
    EXPECT_EQ(line.push(line.now() + 0.01, {5.0}), StreamVerdict::kGapTooLarge);
    line.cycle();
  }
  const double first_s = line.now() + 0.01;
  EXPECT_EQ(line.push(first_s, {0.5}), StreamVerdict::kAccepted);
  EXPECT_EQ(line.push(first_s + 0.006, {0.5}), StreamVerdict::kGapTooLarge) << "that one is still ahead";
  EXPECT_EQ(line.push(first_s + 0.0049, {0.5}), StreamVerdict::kAccepted);
  while (line.now() < first_s) {
    line.cycle();
    ASSERT_NE(line.state, StreamState::kFollowing) << "nothing joins it with what was before";
  }
  while (line.now() < first_s + 0.0055) line.cycle();
  EXPECT_EQ(line.state, StreamState::kFollowing);
}

TEST(SetpointStream, ComesToRestWhenToldToAndFollowsAgain) {
  Line line(settings_of(StreamMethod::kCubic));
  stream_without(line, 0.0, 0.0, 0.3);
  line.stream.run(false);
  stream_without(line, 0.0, 0.0, 0.6);
  EXPECT_EQ(line.state, StreamState::kAtRest);
  EXPECT_EQ(line.judge.velocity(), 0.0);
  EXPECT_EQ(count(line, StreamVerdict::kOverrun), 0U) << "they pass";
  EXPECT_EQ(line.stream.counters().underruns, 0U) << "none were missing";
  line.stream.run(true);
  stream_without(line, 0.0, 0.0, 1.6);
  EXPECT_TRUE(line.stream.on_curve());
}

TEST(SetpointStream, TimeNeverGoesBack) {
  Line line(settings_of(StreamMethod::kLinear));
  stream_without(line, 0.0, 0.0, 0.1);
  const double at = line.out[0].position;
  for (const double time_s : {0.05, -kInfinity, kNan, kInfinity}) {
    EXPECT_EQ(line.stream.evaluate(time_s, line.out), StreamState::kFollowing);
    EXPECT_NEAR(line.out[0].position, at, 1e-3);
  }
}

TEST(SetpointStream, WritesNoMoreThanAxesAndSpanHave) {
  SetpointStream stream(settings_of(StreamMethod::kHold), std::array{kLimits, kLimits});
  stream.begin(0.0, std::array{1.0, 2.0});
  std::array<AxisSetpoint, 3> out{};
  out.fill({7.0, 7.0, 7.0});
  stream.evaluate(kPeriod, std::span(out).first(1));
  EXPECT_EQ(out[1].position, 7.0);
  stream.evaluate(2.0 * kPeriod, out);
  EXPECT_EQ(out[0].position, 1.0);
  EXPECT_EQ(out[1].position, 2.0);
  EXPECT_EQ(out[2].position, 7.0);
}

TEST(SetpointStream, HundredAndTwentyEightAxesKeepTheirOwnLimits) {
  std::vector<FollowLimits> limits;
  std::vector<Judge> judges;
  for (std::size_t i = 0; i < 128; ++i) {
    limits.push_back({{1.0 + static_cast<double>(i), 10.0 * (1.0 + static_cast<double>(i))}, 1e3});
    judges.emplace_back(limits.back().motion, 0.0);
  }
  SetpointStream stream(settings_of(StreamMethod::kQuintic), limits);
  stream.begin(0.0, std::vector<double>(128));
  std::vector<AxisSetpoint> out(128);
  std::vector<StreamPoint> points(128);
  test::Random random;
  for (int k = 0; k < 4000; ++k) {
    if (k % 8 == 0) {
      for (auto& point : points) point = {random.real(-1.0, 1.0), random.real(-10.0, 10.0), random.real(-1e2, 1e2)};
      ASSERT_EQ(stream.push(k * kPeriod, points), StreamVerdict::kAccepted);
    }
    stream.evaluate(k * kPeriod, out);
    for (std::size_t i = 0; i < 128; ++i) ASSERT_TRUE(judges[i].accepts(out[i])) << "axis " << i << " cycle " << k;
  }
}

/// All disturbances between a sender and a cycle, at random.
struct Sequence {
  StreamSettings settings;
  FollowLimits limits;
  double start = 0.0;
  double step_s = 1e-3;
};

Sequence random_sequence(test::Random& random) {
  Sequence sequence;
  auto& settings = sequence.settings;
  settings.method = kAllMethods[random.index(0, kAllMethods.size() - 1)];
  sequence.step_s = random.magnitude(1e-4, 1e-2);
  settings.delay_s = static_cast<double>(random.index(0, 4)) * sequence.step_s;
  settings.max_gap_s = random.magnitude(1.0, 10.0) * sequence.step_s;
  settings.max_ahead_s = random.magnitude(1e-3, 1.0);
  settings.capacity = random.index(4, 12);
  settings.coast_cycles = static_cast<std::uint32_t>(random.index(0, 40));
  sequence.limits = {{random.magnitude(0.1, 100.0), random.magnitude(1.0, 1e5)}, random.magnitude(10.0, 1e7)};
  if (random.index(0, 4) == 0) sequence.limits.max_jerk = kInfinity;
  sequence.start = random.real(-1.0, 1.0) * random.magnitude(1e-3, 1e5);
  return sequence;
}

double wild_time(test::Random& random, double now_s, double step_s) {
  switch (random.index(0, 6)) {
    case 0:
      return now_s - random.magnitude(1e-9, 10.0);
    case 1:
      return now_s + random.magnitude(1e-9, 10.0);
    case 2:
      return kNan;
    default:
      return now_s + random.real(-2.0, 4.0) * step_s;
  }
}

StreamPoint wild_point(test::Random& random, const Sequence& sequence, double t) {
  const double v = sequence.limits.motion.max_velocity;
  switch (random.index(0, 9)) {
    case 0:
      return {sequence.start + random.real(-1.0, 1.0), random.real(-v, v), 0.0};
    case 1:
      return {random.real(-1e9, 1e9), random.real(-1e12, 1e12), random.real(-1e15, 1e15)};
    case 2:
      return {kNan, 0.0, 0.0};
    default: {
      const double w = sequence.limits.motion.max_acceleration / v;
      return {sequence.start + v / w * std::sin(w * t), v * std::cos(w * t), -v * w * std::sin(w * t)};
    }
  }
}

TEST(SetpointStream, NoSequenceOfEventsBreaksALimit) {
  test::Random random;
  constexpr int kSequences = 100'000;
  std::uint64_t accepted = 0;
  std::array<std::uint64_t, 4> states{};
  for (int round = 0; round < kSequences; ++round) {
    const Sequence sequence = random_sequence(random);
    SetpointStream stream(sequence.settings, std::array{sequence.limits});
    Judge judge(sequence.limits.motion, sequence.start);
    double now_s = random.real(-10.0, 10.0);
    stream.begin(now_s, std::array{sequence.start});
    std::array<AxisSetpoint, 1> out{};
    double next_s = now_s;
    const std::size_t cycles = random.index(10, 150);
    for (std::size_t cycle = 0; cycle < cycles; ++cycle) {
      now_s += random.index(0, 30) == 0 ? random.real(0.0, 10.0) * kPeriod : kPeriod;
      while (next_s < now_s) {
        if (random.index(0, 9) != 0) (void)stream.push(next_s, std::array{wild_point(random, sequence, next_s)});
        next_s += sequence.step_s * random.real(0.5, 1.5);
        if (random.index(0, 40) == 0) next_s += random.magnitude(1.0, 30.0) * sequence.step_s;
      }
      if (random.index(0, 9) == 0) {
        const double t = wild_time(random, now_s, sequence.step_s);
        (void)stream.push(t, std::array{wild_point(random, sequence, t)});
      }
      if (random.index(0, 60) == 0) stream.run(random.index(0, 1) == 0);
      ++states[static_cast<std::size_t>(stream.evaluate(random.index(0, 99) == 0 ? kNan : now_s, out))];
      if (!judge.accepts(out[0])) {
        FAIL() << "DRIVELINE_TEST_SEED=" << random.seed() << ", round " << round << ", cycle " << cycle << ", method "
               << static_cast<int>(sequence.settings.method) << ", state " << static_cast<int>(stream.state())
               << ": position " << out[0].position << " velocity " << judge.velocity() << " of "
               << sequence.limits.motion.max_velocity << ", acceleration " << judge.largest_acceleration() << " of "
               << sequence.limits.motion.max_acceleration;
      }
    }
    accepted += stream.counters().verdicts[0];
  }
  EXPECT_GT(accepted, 100'000U);
  for (const std::uint64_t visits : states) EXPECT_GT(visits, 10'000U);
}

TEST(SetpointStream, UsesNeitherHeapNorLocks) {
  if (!rt::RtGuard::available()) {
    GTEST_SKIP() << "a sanitizer owns malloc in this build";
  }
  for (const StreamMethod method : kAllMethods) {
    SetpointStream stream(settings_of(method), std::vector<FollowLimits>(100, kLimits));
    stream.begin(0.0, std::vector<double>(100));
    std::vector<AxisSetpoint> out(100);
    std::vector<StreamPoint> points(100);
    rt::RtGuard::enter();
    for (int k = 0; k < 4000; ++k) {
      const double t = k * kPeriod;
      if (k % 8 == 0 && k % 1000 < 800) {  // with losses, and leaps
        points.assign(100, swing(k % 1500 == 0 ? 0.0 : t));
        (void)stream.push(t, points);
        (void)stream.push(t, points);
      }
      (void)stream.evaluate(t, out);
      stream.run(k % 3000 < 2500);
    }
    const rt::RtGuard::Counts counts = rt::RtGuard::leave();
    EXPECT_EQ(counts.total(), 0U);
  }
}

}  // namespace
}  // namespace driveline::trajectory
