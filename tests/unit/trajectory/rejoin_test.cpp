#include "driveline/trajectory/rejoin.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace driveline::trajectory {
namespace {

/// A path that needs at most half of the limits.
struct Wave {
  AxisLimits limits;
  double period_s;
  double frequency;
  double phase;
  double amplitude;

  Wave(std::mt19937& random, double period)
      : limits{pick(random, 1.0, 300.0), pick(random, 10.0, 5000.0)},
        period_s(period),
        frequency(pick(random, 0.2, 20.0)),
        phase(pick(random, 0.0, 6.0)),
        amplitude(
            std::min(0.5 * limits.max_velocity / frequency, 0.5 * limits.max_acceleration / (frequency * frequency))) {}
  static double pick(std::mt19937& random, double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  }
  [[nodiscard]] AxisSetpoint at(double t) const {
    const double angle = frequency * t + phase;
    return {amplitude * std::sin(angle), amplitude * frequency * std::cos(angle),
            -amplitude * frequency * frequency * std::sin(angle)};
  }
};

TEST(Rejoin, CatchesUpWithAnyPathAndNeverAsksForMoreThanTheLimits) {
  std::mt19937 random(4711);
  for (int run = 0; run < 500; ++run) {
    const Wave wave(random, run % 2 == 0 ? 125e-6 : 2e-3);
    const double start = Wave::pick(random, -20.0, 20.0);
    double before_position = start;
    double before_velocity = Wave::pick(random, -0.5, 0.5) * wave.limits.max_velocity;
    Rejoin rejoin(before_position, before_velocity, wave.limits);
    const double most = wave.limits.max_acceleration * wave.period_s;
    // From rest to the limit, the whole distance at half of it and back, with time to settle.
    const double patience = 10.0 + 8.0 * wave.limits.max_velocity / wave.limits.max_acceleration +
                            6.0 * std::abs(start) / wave.limits.max_velocity;
    double t = 0.0;
    while (!rejoin.joined()) {
      t += wave.period_s;
      ASSERT_LT(t, patience) << "run " << run << " does not arrive";
      const auto setpoint = rejoin.step(wave.at(t), wave.period_s);
      const double velocity = (setpoint.position - before_position) / wave.period_s;
      ASSERT_LE(std::abs(velocity), wave.limits.max_velocity + most) << "run " << run;
      // The difference quotient of a step that ends on the path knows its velocity half a step late.
      ASSERT_LE(std::abs(velocity - before_velocity), 1.8 * most) << "run " << run << " jumps at " << t;
      before_position = setpoint.position;
      before_velocity = velocity;
    }
    // From there on it follows the path itself.
    t += wave.period_s;
    EXPECT_EQ(rejoin.step(wave.at(t), wave.period_s).position, wave.at(t).position);
  }
}

TEST(Rejoin, StaysOnAPathThatAsksForAllOfTheLimitsAndLeavesOneThatAsksForMore) {
  for (const double acceleration : {100.0, -100.0, 101.0}) {
    constexpr double kStep = 1e-3;
    Rejoin axis(1.0, 0.0, {2.0, 100.0});
    (void)axis.step({1.0, 0.0, 0.0}, kStep);
    ASSERT_TRUE(axis.joined());
    bool stays = true;
    for (int k = 1; k <= 40; ++k) {
      // Up to the highest velocity within 20 steps.
      const double t = std::min(k * kStep, 0.02);
      const double velocity = acceleration * t;
      const double position = 1.0 + 0.5 * velocity * t + velocity * (k * kStep - t);
      const auto told = axis.step({position, velocity, 0.0}, kStep);
      stays = stays && axis.joined() && std::abs(told.position - position) <= 0.0;
    }
    EXPECT_EQ(stays, std::abs(acceleration) <= 100.0) << acceleration;
  }
}

TEST(Rejoin, StandsOnAPathThatStands) {
  Rejoin rejoin(1.0, 0.0, {10.0, 100.0});
  const AxisSetpoint rest{-2.0, 0.0, 0.0};
  AxisSetpoint last{};
  for (int i = 0; i < 20000 && !rejoin.joined(); ++i) last = rejoin.step(rest, 125e-6);
  EXPECT_TRUE(rejoin.joined());
  EXPECT_EQ(last.position, -2.0);
  EXPECT_EQ(last.velocity, 0.0);
}

TEST(Rejoin, DoesNotArriveWhereThePathIsAtTheLimitItself) {
  Rejoin rejoin(0.0, 0.0, {10.0, 100.0});
  for (int i = 1; i < 8000; ++i) {
    const double t = i * 125e-6;
    const auto setpoint = rejoin.step({1.0 + 10.0 * t, 10.0, 0.0}, 125e-6);
    ASSERT_LE(setpoint.velocity, 10.0);
  }
  EXPECT_FALSE(rejoin.joined());
}

TEST(Rejoin, StaysOnAPathThatTakesNearlyAllOfTheAcceleration) {
  constexpr double kStep = 125e-6;
  constexpr double kOmega = 20.0;
  constexpr double kAmplitude = 990.0 / (kOmega * kOmega);
  const auto at = [](int step) {
    const double phase = kOmega * step * kStep;
    return AxisSetpoint{kAmplitude * std::sin(phase), kAmplitude * kOmega * std::cos(phase),
                        -kAmplitude * kOmega * kOmega * std::sin(phase)};
  };
  Rejoin rejoin(0.0, kAmplitude * kOmega, {60.0, 1000.0});
  for (int i = 1; i < 8000; ++i) {
    EXPECT_EQ(rejoin.step(at(i), kStep).position, at(i).position) << i;
    EXPECT_TRUE(rejoin.joined()) << i;
  }
}

TEST(Rejoin, LeavesAPathThatGetsFasterThanTheAxisMay) {
  constexpr double kStep = 125e-6;
  Rejoin rejoin(0.0, 0.0, {10.0, 100.0});
  double last = 0.0;
  double fastest = 0.0;
  for (int i = 1; i < 2000; ++i) {
    const double t = i * kStep;
    // The velocity of the setpoint is capped at the limit, the acceleration is not.
    const auto setpoint = rejoin.step({0.5 * 90.0 * t * t, std::min(10.0, 90.0 * t), 90.0}, kStep);
    fastest = std::max(fastest, (setpoint.position - last) / kStep);
    last = setpoint.position;
  }
  EXPECT_LE(fastest, 10.0 + 1e-6);
  EXPECT_GT(fastest, 9.9);
}

TEST(Rejoin, HandsOnNoVelocityThatLeaps) {
  constexpr double kStep = 125e-6;
  Rejoin rejoin(0.0, 1.0, {10.0, 100.0});
  double last = 1.0;
  for (int i = 1; i < 400; ++i) {
    const double told = i % 50 == 0 ? -10.0 : 1.0;
    const auto setpoint = rejoin.step({1.0 * i * kStep, told, 0.0}, kStep);
    EXPECT_LE(std::abs(setpoint.velocity - last), 100.0 * kStep * 1.01) << i;
    last = setpoint.velocity;
  }
}

}  // namespace
}  // namespace driveline::trajectory
