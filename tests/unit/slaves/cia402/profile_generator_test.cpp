#include "driveline/slaves/cia402/profile_generator.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

namespace driveline::slaves {
namespace {

constexpr double kStep = 62.5e-6;

/// The course of a movement: steps until its end and the largest values.
struct Course {
  int steps = 0;
  double velocity = 0.0;
  double acceleration = 0.0;
  double jerk = 0.0;
  double velocity_step = 0.0;  ///< largest change of speed in one step
};

Course finish(ProfileGenerator& generator, int most = 4'000'000) {
  Course run;
  ProfileState before = generator.state();
  while (!generator.finished() && run.steps < most) {
    generator.step(kStep);
    ++run.steps;
    const ProfileState now = generator.state();
    run.velocity = std::max(run.velocity, std::abs(now.velocity));
    run.acceleration = std::max(run.acceleration, std::abs(now.acceleration));
    run.jerk = std::max(run.jerk, std::abs(now.acceleration - before.acceleration) / kStep);
    run.velocity_step = std::max(run.velocity_step, std::abs(now.velocity - before.velocity));
    before = now;
  }
  return run;
}

TEST(ProfileGenerator, TrapezoidTakesTheTimeOfTheTextbook) {
  ProfileGenerator generator;
  generator.move_to(100.0, {.velocity = 10.0, .acceleration = 20.0, .deceleration = 5.0});
  const Course run = finish(generator);
  // 0.5 s up (2.5), 2 s down (10), the rest of 87.5 at 10
  EXPECT_NEAR(run.steps * kStep, 0.5 + 2.0 + 8.75, 2 * kStep);
  EXPECT_NEAR(run.velocity, 10.0, 1e-9);
  EXPECT_EQ(generator.state().position, 100.0);
  EXPECT_EQ(generator.state().velocity, 0.0);
}

TEST(ProfileGenerator, ShortMovementIsATriangle) {
  ProfileGenerator generator;
  generator.move_to(-1.0, {.velocity = 100.0, .acceleration = 20.0, .deceleration = 5.0});
  const Course run = finish(generator);
  // v^2 / 2 (1/20 + 1/5) = 1
  const double peak = std::sqrt(8.0);
  EXPECT_NEAR(run.velocity, peak, 1e-3);
  EXPECT_NEAR(run.steps * kStep, peak / 20.0 + peak / 5.0, 2 * kStep);
  EXPECT_EQ(generator.state().position, -1.0);
}

TEST(ProfileGenerator, JerkTimeLengthensBothPhasesOfAcceleration) {
  ProfileGenerator generator;
  generator.move_to(100.0, {.velocity = 10.0, .acceleration = 20.0, .deceleration = 5.0, .jerk_time_s = 0.25});
  const Course run = finish(generator);
  // Each phase lasts 0.25 s longer at the same mean speed: 0.75 s up (3.75), 2.25 s down (11.25).
  EXPECT_NEAR(run.steps * kStep, 0.75 + 2.25 + 8.5, 2 * kStep);
  EXPECT_NEAR(run.acceleration, 20.0, 1e-6);
  EXPECT_LE(run.jerk, 20.0 / 0.25 * 1.001);
  EXPECT_EQ(generator.state().position, 100.0);
}

TEST(ProfileGenerator, SpeedIsReachedAndKept) {
  for (const double jerk_time : {0.0, 0.1}) {
    ProfileGenerator generator;
    const GeneratorLimits limits{.acceleration = 20.0, .deceleration = 40.0, .jerk_time_s = jerk_time};
    generator.run_at(10.0, limits);
    EXPECT_NEAR(finish(generator).steps * kStep, 0.5 + jerk_time, 2 * kStep);
    EXPECT_EQ(generator.state().velocity, 10.0);
    const double position = generator.state().position;
    for (int i = 0; i < 1600; ++i) generator.step(kStep);
    EXPECT_NEAR(generator.state().position - position, 1.0, 1e-9);
    EXPECT_EQ(generator.state().velocity, 10.0);
    generator.run_at(-10.0, limits);  // brakes with one limit, accelerates with the other
    EXPECT_NEAR(finish(generator).steps * kStep, 0.25 + 0.5 + 2 * jerk_time, 3 * kStep);
    EXPECT_EQ(generator.state().velocity, -10.0);
  }
}

TEST(ProfileGenerator, TargetBehindTheStoppingDistanceIsReachedByTurningRound) {
  for (const double jerk_time : {0.0, 0.05}) {
    ProfileGenerator generator;
    generator.reset({0.0, 10.0, 0.0});
    generator.move_to(1.0, {.velocity = 20.0, .acceleration = 10.0, .deceleration = 10.0, .jerk_time_s = jerk_time});
    double furthest = 0.0;
    while (!generator.finished()) {
      generator.step(kStep);
      furthest = std::max(furthest, generator.state().position);
    }
    EXPECT_NEAR(furthest, 5.0 + 10.0 * jerk_time / 2.0, 0.01);
    EXPECT_EQ(generator.state().position, 1.0);
  }
}

TEST(ProfileGenerator, NewTargetsInMotionKeepSpeedAndAccelerationContinuous) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const double jerk_time : {0.0, 0.02}) {
    ProfileGenerator generator;
    const GeneratorLimits limits{
        .velocity = 50.0, .acceleration = 400.0, .deceleration = 900.0, .jerk_time_s = jerk_time};
    ProfileState before;
    for (int round = 0; round < 400; ++round) {
      if (round % 5 == 4) {
        generator.run_at(50.0 * unit(random), limits);
      } else {
        generator.move_to(20.0 * unit(random), limits);
      }
      const int steps = static_cast<int>(3000.0 * std::abs(unit(random)));
      for (int i = 0; i < steps; ++i) {
        generator.step(kStep);
        const ProfileState now = generator.state();
        ASSERT_LE(std::abs(now.velocity), 50.0 + 1e-6 + 900.0 * jerk_time);
        ASSERT_LE(std::abs(now.acceleration), 900.0 + 1e-6);
        ASSERT_LE(std::abs(now.velocity - before.velocity), 900.0 * kStep * 1.001);
        ASSERT_NEAR(now.position - before.position, 0.5 * kStep * (now.velocity + before.velocity), 4e-6);
        if (jerk_time > 0.0) {
          ASSERT_LE(std::abs(now.acceleration - before.acceleration), 900.0 / jerk_time * kStep * 1.001);
        }
        before = now;
      }
    }
  }
}

TEST(ProfileGenerator, EveryMovementEndsExactlyOnItsTarget) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int round = 0; round < 3000; ++round) {
    const GeneratorLimits limits{.velocity = 1.0 + 50.0 * std::abs(unit(random)),
                                 .acceleration = 10.0 + 5000.0 * std::abs(unit(random)),
                                 .deceleration = 10.0 + 5000.0 * std::abs(unit(random)),
                                 .jerk_time_s = round % 3 == 0 ? 0.0 : 0.02 * std::abs(unit(random))};
    ProfileGenerator generator;
    generator.reset({unit(random), 50.0 * unit(random), 1000.0 * unit(random)});
    const double target = 10.0 * unit(random);
    generator.move_to(target, limits);
    ProfileState before = generator.state();
    int steps = 0;
    while (!generator.finished() && steps++ < 4'000'000) {
      before = generator.state();
      generator.step(kStep);
    }
    ASSERT_TRUE(generator.finished());
    EXPECT_EQ(generator.state().position, target);
    EXPECT_EQ(generator.state().velocity, 0.0);
    // The exact end is not a correction of an inexact plan.
    EXPECT_NEAR(before.position + kStep * before.velocity, target, 5100.0 * kStep * kStep);
  }
}

TEST(ProfileGenerator, StaysFiniteWhateverItIsTold) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  ProfileGenerator generator;
  generator.reset({kNan, kInf, -kInf});
  for (const double value : {kNan, kInf, -kInf, 0.0, -1.0, 1e300}) {
    const GeneratorLimits limits{value, value, value, value};
    generator.move_to(1.0, limits);
    for (int i = 0; i < 100; ++i) generator.step(kStep);
    ASSERT_TRUE(std::isfinite(generator.state().position)) << value;
    generator.run_at(value, {});
    generator.run_at(0.0, limits);
    for (int i = 0; i < 100; ++i) generator.step(kStep);
    ASSERT_TRUE(std::isfinite(generator.state().velocity)) << value;
    generator.reset({});
  }
}

}  // namespace
}  // namespace driveline::slaves
