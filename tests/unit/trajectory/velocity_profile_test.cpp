#include "driveline/trajectory/velocity_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/stop_profile.hpp"
#include "profile_oracle.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::Motion;
using test::ProfileOracle;
using Reason = ProfileError::Reason;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// One second to 2, 1.5 s there, one second back: 2 + 3 faster.
TEST(VelocityProfile, ATrapezoidOfAccelerationByHand) {
  const Profile profile = plan_to_velocity({1.0, -1.0, 0.0}, 4.0, 0.0, {4.0, -2.0, 2.0, -1.0, 2.0}).value();
  EXPECT_DOUBLE_EQ(profile.duration_s(), 3.5);
  EXPECT_DOUBLE_EQ(profile.evaluate(1.75).acceleration, 2.0);
  EXPECT_DOUBLE_EQ(profile.evaluate(1.75).velocity, 1.5);
  test::expect_setpoint(profile.evaluate(3.5), {profile.end().position, 4.0, 0.0});
  EXPECT_DOUBLE_EQ(profile.end().position, 1.0 + 1.5 * 3.5);
}

TEST(VelocityProfile, WithoutJerkLimitTheVelocityIsALine) {
  const Profile profile = plan_to_velocity({0.0, 3.0, 9.0}, -1.0, 5.0, {4.0, -2.0, 2.0, -0.5, kInfinity}).value();
  EXPECT_DOUBLE_EQ(profile.duration_s(), 8.0);
  EXPECT_EQ(profile.evaluate(4.0).acceleration, -0.5);
  EXPECT_DOUBLE_EQ(profile.evaluate(4.0).velocity, 1.0);
}

TEST(VelocityProfile, StopsAsStopProfileDoes) {
  test::Random random;
  for (int round = 0; round < 2000; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const AxisSetpoint from{random.real(-100.0, 100.0), random.real(-200.0, 200.0), random.real(-3000.0, 3000.0)};
    const double acceleration = random.magnitude(10.0, 5000.0);
    const double jerk = random.index(0, 3) == 0 ? kInfinity : random.magnitude(100.0, 1e6);
    const auto profile = plan_to_standstill(from, ProfileLimits::symmetric(kInfinity, acceleration, jerk));
    const auto stop = StopProfile::plan(from, {acceleration, jerk});
    ASSERT_TRUE(profile.has_value() && stop.has_value());
    const double scale =
        std::abs(from.position) + stop->duration_s() * (std::abs(from.velocity) + stop->duration_s() * acceleration);
    if (std::abs(from.acceleration) <= acceleration || !std::isfinite(jerk)) {
      ASSERT_NEAR(profile->duration_s(), stop->duration_s(), 1e-9 * stop->duration_s());
      ASSERT_NEAR(profile->end().position, stop->end_position(), 1e-9 * scale);
      ASSERT_NEAR(profile->evaluate(stop->duration_s() / 3.0).velocity,
                  stop->evaluate(stop->duration_s() / 3.0).velocity,
                  1e-9 * (std::abs(from.velocity) + acceleration * stop->duration_s()));
    }
  }
}

TEST(VelocityProfile, IsTheFastestChangeBetweenRandomStates) {
  test::Random random;
  for (int round = 0; round < test::profile_rounds(5000); ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const ProfileLimits limits{random.real(0.5, 3.0), -random.real(0.5, 3.0), random.real(0.5, 4.0),
                               -random.real(0.5, 4.0), random.real(1.0, 10.0)};
    Motion motion{{random.real(-1.0, 1.0), random.real(-1.0, 1.0) * limits.max_velocity,
                   random.real(limits.min_acceleration, limits.max_acceleration)},
                  {0.0, random.real(-0.9, 0.9) * limits.max_velocity,
                   random.real(limits.min_acceleration, limits.max_acceleration)},
                  limits};
    const auto profile = plan_to_velocity(motion.from, motion.to.velocity, motion.to.acceleration, limits);
    ASSERT_EQ(profile.has_value(), test::is_reachable(motion.to, limits)) << motion.text();
    if (!profile) {
      continue;
    }
    motion.to.position = profile->end().position;
    if (test::is_inside(motion.from, limits)) {
      ASSERT_EQ(ProfileOracle(motion, 50).complaint(*profile), "");
      // There is no faster motion to the position that it reaches.
      ASSERT_NEAR(plan_to_position(motion.from, motion.to, limits)->duration_s(), profile->duration_s(), 1e-6)
          << motion.text();
    }
  }
}

TEST(VelocityProfile, FromOutsideTheLimitsItGoesStraightToTheTarget) {
  const ProfileLimits limits{2.0, -1.0, 3.0, -4.0, 5.0};
  const Profile profile = plan_to_velocity({0.0, 9.0, 0.0}, -0.5, 0.0, limits).value();
  EXPECT_DOUBLE_EQ(profile.duration_s(), 9.5 / 4.0 + 4.0 / 5.0);
  // From an acceleration above the limit to the limit, and on.
  const Profile back = plan_to_velocity({0.0, 0.0, 8.0}, 2.0, 0.0, limits).value();
  EXPECT_DOUBLE_EQ(back.evaluate(0.5).acceleration, 5.5);
  EXPECT_NEAR(back.end().velocity, 2.0, 1e-12);
  EXPECT_GT(back.evaluate(1.6).velocity, 2.0);
}

TEST(VelocityProfile, RefusesWhatItCannotPlan) {
  const ProfileLimits limits{2.0, -1.0, 3.0, -4.0, 5.0};
  const auto reason = [&](const AxisSetpoint& from, double velocity, double acceleration, const ProfileLimits& with) {
    const auto profile = plan_to_velocity(from, velocity, acceleration, with);
    return profile ? Reason::kAxes : profile.error().reason;
  };
  EXPECT_EQ(reason({}, 2.1, 0.0, limits), Reason::kTarget);
  EXPECT_EQ(reason({}, -1.1, 0.0, limits), Reason::kTarget);
  EXPECT_EQ(reason({}, 0.0, 3.1, limits), Reason::kTarget);
  EXPECT_EQ(reason({}, 1.9, -3.0, limits), Reason::kTarget);
  EXPECT_EQ(reason({}, kNan, 0.0, limits), Reason::kTarget);
  EXPECT_EQ(reason({}, 0.0, kNan, limits), Reason::kTarget);
  EXPECT_EQ(reason({kNan, 0.0, 0.0}, 0.0, 0.0, limits), Reason::kState);
  EXPECT_EQ(reason({0.0, kInfinity, 0.0}, 0.0, 0.0, limits), Reason::kState);
  EXPECT_EQ(reason({0.0, 1e300, 0.0}, 0.0, 0.0, limits), Reason::kTooLong);
  EXPECT_EQ(reason({}, 0.0, 0.0, {}), Reason::kLimits);
}

}  // namespace
}  // namespace driveline::trajectory
