#include "driveline/trajectory/profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::expect_setpoint;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Up to acceleration 2 within a second, held for one, and down within half a second.
Profile three_phases() {
  Profile profile({10.0, -1.0, 0.0});
  profile.append(1.0, 0.0, 2.0);
  profile.append(0.0, 5.0, 5.0);
  profile.append(1.0, 2.0, 0.0);
  profile.append(0.5, 2.0, -4.0);
  return profile;
}

TEST(Profile, IntegratesItsPhases) {
  const Profile profile = three_phases();
  EXPECT_EQ(profile.phases().size(), 3U);
  EXPECT_EQ(profile.duration_s(), 2.5);
  expect_setpoint(profile.evaluate(0.0), {10.0, -1.0, 0.0});
  EXPECT_NEAR(profile.evaluate(0.5).position, 10.0 - 0.5 + 2.0 * 0.125 / 6.0, 1e-15);
  expect_setpoint(profile.evaluate(1.5), {10.0 - 2.0 / 3.0 + 0.25, 1.0, 2.0});
  EXPECT_DOUBLE_EQ(profile.end().velocity, 2.5);
  EXPECT_DOUBLE_EQ(profile.end().acceleration, 0.0);
}

TEST(Profile, HoldsTheVelocityOfTheEndAndBeginsAtZero) {
  Profile profile = three_phases();
  profile.end_at({11.0, 2.5, 0.5});
  expect_setpoint(profile.evaluate(2.5), {11.0, 2.5, 0.5});
  expect_setpoint(profile.evaluate(4.5), {16.0, 2.5, 0.0});
  EXPECT_TRUE(profile.finished(2.5));
  for (const double before : {-1.0, -kInfinity, kNan}) {
    expect_setpoint(profile.evaluate(before), {10.0, -1.0, 0.0});
    EXPECT_FALSE(profile.finished(before));
  }
  profile.end_at({11.0, 0.0, 0.0});
  expect_setpoint(profile.evaluate(kInfinity), {11.0, 0.0, 0.0});
}

TEST(Profile, WithoutPhasesItGoesOnAsItIs) {
  const Profile profile({1.0, 2.0, 0.0});
  EXPECT_EQ(profile.duration_s(), 0.0);
  expect_setpoint(profile.evaluate(0.0), {1.0, 2.0, 0.0});
  expect_setpoint(profile.evaluate(2.0), {5.0, 2.0, 0.0});
  EXPECT_EQ(profile.extremes().min, 1.0);
  EXPECT_EQ(profile.extremes().max, 1.0);
}

TEST(Profile, TakesNoMorePhasesThanItHasPlacesFor) {
  Profile profile;
  for (std::size_t i = 0; i < Profile::kMaxPhases + 3; ++i) {
    profile.append(1.0, 0.0, 0.0);
  }
  EXPECT_EQ(profile.phases().size(), Profile::kMaxPhases);
  EXPECT_EQ(profile.duration_s(), static_cast<double>(Profile::kMaxPhases));
}

TEST(Profile, ExtremesAreThoseBetweenTheEnds) {
  // v = -1 + t^2 is zero at 1, where the distance is -2/3; the end is higher than the start.
  Profile profile({10.0, -1.0, 0.0});
  profile.append(3.0, 0.0, 2.0);
  EXPECT_DOUBLE_EQ(profile.extremes().min, 10.0 - 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(profile.extremes().max, 16.0);
  // v = t - 1 without jerk, v = 1 - 3 t + t^2 with two turns.
  Profile line({0.0, -1.0, 1.0});
  line.append(2.0, 1.0, 0.0);
  EXPECT_DOUBLE_EQ(line.extremes().min, -0.5);
  EXPECT_DOUBLE_EQ(line.extremes().max, 0.0);
  Profile wave({0.0, 1.0, -3.0});
  wave.append(3.5, -3.0, 2.0);
  const double turn = (3.0 - std::sqrt(5.0)) / 2.0;
  EXPECT_NEAR(wave.extremes().max, turn - 1.5 * turn * turn + turn * turn * turn / 3.0, 1e-14);
  EXPECT_LT(wave.extremes().min, wave.end().position);
}

TEST(Profile, ExtremesAreThoseOfManySamples) {
  test::Random random;
  for (int round = 0; round < 300; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    Profile profile({random.real(-1.0, 1.0), random.real(-2.0, 2.0), 0.0});
    double acceleration = random.real(-2.0, 2.0);
    for (int phase = 0; phase < 5; ++phase) {
      const double duration_s = random.real(0.1, 1.0);
      const double jerk = random.index(0, 2) == 0 ? 0.0 : random.real(-9.0, 9.0);
      profile.append(duration_s, acceleration, jerk);
      acceleration += duration_s * jerk;
    }
    PositionRange seen{profile.evaluate(0.0).position, profile.evaluate(0.0).position};
    for (int i = 0; i <= 4000; ++i) {
      const double position = profile.evaluate(profile.duration_s() * i / 4000.0).position;
      seen = {std::min(seen.min, position), std::max(seen.max, position)};
    }
    const PositionRange exact = profile.extremes();
    ASSERT_LE(exact.min, seen.min + 1e-12);
    ASSERT_GE(exact.max, seen.max - 1e-12);
    ASSERT_NEAR(exact.min, seen.min, 1e-4);
    ASSERT_NEAR(exact.max, seen.max, 1e-4);
    EXPECT_TRUE(fits(profile, exact));
    EXPECT_FALSE(fits(profile, {exact.min + 1e-9, exact.max}));
    EXPECT_FALSE(fits(profile, {exact.min, exact.max - 1e-9}));
  }
}

TEST(Profile, IsScaledOntoALine) {
  const Profile profile = three_phases();
  const Profile scaled = profile.scaled(-2.0, {5.0, 2.0, 0.0}, {5.5, -5.0, 0.0});
  EXPECT_EQ(scaled.duration_s(), profile.duration_s());
  for (const double t : {0.0, 0.4, 1.3, 2.2}) {
    const AxisSetpoint one = profile.evaluate(t);
    const AxisSetpoint other = scaled.evaluate(t);
    EXPECT_NEAR(other.position - 5.0, -2.0 * (one.position - 10.0), 1e-14);
    EXPECT_EQ(other.velocity, -2.0 * one.velocity);
    EXPECT_EQ(other.acceleration, -2.0 * one.acceleration);
  }
  expect_setpoint(scaled.evaluate(2.5), {5.5, -5.0, 0.0});
}

}  // namespace
}  // namespace driveline::trajectory
