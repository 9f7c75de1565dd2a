#include "driveline/trajectory/position_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "profile_oracle.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::Motion;
using test::ProfileOracle;
using test::ProfileSearch;
using Reason = ProfileError::Reason;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

tl::expected<Profile, ProfileError> plan(const Motion& motion) {
  return plan_to_position(motion.from, motion.to, motion.limits);
}

/// The profile of a motion that must be possible, checked by the oracle.
Profile judged(const Motion& motion) {
  const auto profile = plan(motion);
  EXPECT_TRUE(profile.has_value()) << motion.text();
  if (!profile) {
    return Profile();
  }
  EXPECT_EQ(ProfileOracle(motion).complaint(*profile), "");
  return *profile;
}

// Two seconds to velocity 1 over one metre, two seconds at it, and the same back.
TEST(PositionProfile, SevenPhasesByHand) {
  const Profile profile = judged({{}, {4.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)});
  EXPECT_DOUBLE_EQ(profile.duration_s(), 6.0);
  EXPECT_EQ(profile.phases().size(), 5U);  // neither acceleration is held
  const Profile longer = judged({{}, {-12.0, 0.0, 0.0}, ProfileLimits::symmetric(2.0, 1.0, 1.0)});
  EXPECT_DOUBLE_EQ(longer.duration_s(), 9.0);  // 3 s to velocity 2 over 3 m
  EXPECT_EQ(longer.phases().size(), 7U);
}

TEST(PositionProfile, WithoutCruiseByHand) {
  // Four phases of one second: 1/6 + (1/2 + 1/2 - 1/6) + the same = 2.
  const Profile profile = judged({{}, {2.0, 0.0, 0.0}, ProfileLimits::symmetric(100.0, 100.0, 1.0)});
  EXPECT_DOUBLE_EQ(profile.duration_s(), 4.0);
  EXPECT_NEAR(profile.evaluate(1.0).acceleration, 1.0, 1e-15);
  EXPECT_NEAR(profile.evaluate(2.0).velocity, 1.0, 1e-15);
}

TEST(PositionProfile, ATrapezoidByHand) {
  const Profile profile = judged({{1.0, 0.0, 5.0}, {7.0, 0.0, -5.0}, {2.0, -1.0, 1.0, -2.0}});
  EXPECT_DOUBLE_EQ(profile.duration_s(), 2.0 + 1.5 + 1.0);
  EXPECT_EQ(profile.evaluate(1.0).acceleration, 1.0);
  EXPECT_EQ(profile.evaluate(3.0).velocity, 2.0);
  EXPECT_EQ(profile.evaluate(4.0).acceleration, -2.0);
  // Past the target and back.
  const Profile back = judged({{0.0, 2.0, 0.0}, {0.5, 0.0, 0.0}, {2.0, -2.0, 1.0, -2.0}});
  EXPECT_GT(back.extremes().max, 0.99);
  EXPECT_EQ(back.end().position, 0.5);
}

TEST(PositionProfile, WhereItIsAlreadyThereIsNothingToDo) {
  for (const double jerk : {3.0, kInfinity}) {
    const Profile profile = judged({{4.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 2.0, jerk)});
    EXPECT_EQ(profile.duration_s(), 0.0);
    test::expect_setpoint(profile.evaluate(0.0), {4.0, 0.0, 0.0});
  }
}

TEST(PositionProfile, AMovingAxisThatIsAlreadyThereComesBack) {
  const Profile profile = judged({{0.0, 1.0, 0.5}, {0.0, 0.0, 0.0}, ProfileLimits::symmetric(2.0, 3.0, 10.0)});
  EXPECT_GT(profile.extremes().max, 0.1);
  EXPECT_GT(profile.duration_s(), 1.0);
  // To the present state: no time, or a full loop.
  EXPECT_EQ(judged({{0.0, 1.0, 0.0}, {0.0, 1.0, 0.0}, ProfileLimits::symmetric(2.0, 3.0, 10.0)}).duration_s(), 0.0);
  EXPECT_EQ(judged({{0.0, 1.0, 0.5}, {0.0, 1.0, 0.5}, ProfileLimits::symmetric(2.0, 3.0, 10.0)}).duration_s(), 0.0);
}

TEST(PositionProfile, GoesOnAtTheVelocityOfTheEnd) {
  const Profile profile = judged({{}, {3.0, 1.0, 0.5}, ProfileLimits::symmetric(2.0, 3.0, 10.0)});
  test::expect_setpoint(profile.evaluate(profile.duration_s()), {3.0, 1.0, 0.5});
  const AxisSetpoint behind = profile.evaluate(profile.duration_s() + 2.0);
  EXPECT_NEAR(behind.position, 5.0, 1e-12);
  EXPECT_EQ(behind.velocity, 1.0);
  EXPECT_EQ(behind.acceleration, 0.0);
}

TEST(PositionProfile, RefusesWhatIsNotANumberOrContradictsItself) {
  const Motion good{{}, {1.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)};
  const auto reason = [](const Motion& motion) { return plan(motion) ? Reason::kAxes : plan(motion).error().reason; };
  for (const double bad : {kNan, 0.0, -1.0}) {
    Motion motion = good;
    motion.limits.max_velocity = bad;
    EXPECT_EQ(reason(motion), Reason::kLimits);
    motion = good;
    motion.limits.min_velocity = -bad;
    EXPECT_EQ(reason(motion), Reason::kLimits);
    motion = good;
    motion.limits.max_acceleration = bad;
    EXPECT_EQ(reason(motion), Reason::kLimits);
    motion = good;
    motion.limits.min_acceleration = -bad;
    EXPECT_EQ(reason(motion), Reason::kLimits);
    motion = good;
    motion.limits.max_jerk = bad;
    EXPECT_EQ(reason(motion), Reason::kLimits);
  }
  Motion unlimited = good;
  unlimited.limits.max_acceleration = kInfinity;
  EXPECT_EQ(reason(unlimited), Reason::kLimits);
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    for (double AxisSetpoint::*member :
         {&AxisSetpoint::position, &AxisSetpoint::velocity, &AxisSetpoint::acceleration}) {
      Motion motion = good;
      motion.from.*member = bad;
      EXPECT_EQ(reason(motion), Reason::kState);
      motion = good;
      motion.to.*member = bad;
      EXPECT_EQ(reason(motion), Reason::kTarget);
    }
  }
}

TEST(PositionProfile, RefusesATargetThatNeedsMoreThanTheLimits) {
  const ProfileLimits limits{2.0, -1.0, 3.0, -4.0, 5.0};
  const auto reason = [&](double velocity, double acceleration) {
    const auto profile = plan({{}, {1.0, velocity, acceleration}, limits});
    return profile ? Reason::kLimits : profile.error().reason;
  };
  EXPECT_EQ(reason(2.1, 0.0), Reason::kTarget);
  EXPECT_EQ(reason(-1.1, 0.0), Reason::kTarget);
  EXPECT_EQ(reason(0.0, 3.1), Reason::kTarget);
  EXPECT_EQ(reason(0.0, -4.1), Reason::kTarget);
  // It would have been too fast before: 1.5 + 9 / 10 > 2, -0.5 - 9 / 10 < -1.
  EXPECT_EQ(reason(1.5, -3.0), Reason::kTarget);
  EXPECT_EQ(reason(-0.5, 3.0), Reason::kTarget);
  EXPECT_EQ(reason(1.5, 3.0), Reason::kLimits);
  EXPECT_EQ(reason(-0.5, -3.0), Reason::kLimits);
}

TEST(PositionProfile, RefusesWhatTakesForEverOrOverflows) {
  EXPECT_EQ(plan({{}, {1e9, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)}).error().reason, Reason::kTooLong);
  EXPECT_EQ(plan({{-1e308, 0.0, 0.0}, {1e308, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)}).error().reason,
            Reason::kTooLong);
  EXPECT_EQ(plan({{0.0, 1e200, 0.0}, {}, ProfileLimits::symmetric(1.0, 1.0, 1.0)}).error().reason, Reason::kTooLong);
  EXPECT_EQ(plan({{0.0, 0.0, 1e200}, {}, ProfileLimits::symmetric(1.0, 1.0, 1.0)}).error().reason, Reason::kTooLong);
  // On the way back the axis can hardly brake; its profile used to end where it turns.
  for (const double deceleration : {1e-12, 1e-15, 1e-30, 1e-300}) {
    for (const double jerk : {1e5, 1e300, kInfinity}) {
      const ProfileLimits limits{47.0, -47.0, deceleration, -1000.0, jerk};
      const auto profile = plan({{0.3, 4.0, 0.0}, {-1.7, 0.0, 0.0}, limits});
      ASSERT_FALSE(profile) << deceleration << " " << jerk;
      EXPECT_EQ(profile.error().reason, Reason::kTooLong);
    }
  }
}

// A state of any kind that can be the start or end of a motion.
AxisSetpoint random_state(test::Random& random, const ProfileLimits& limits, double reach) {
  const double top = std::isfinite(limits.max_velocity) ? limits.max_velocity : 10.0;
  const double bottom = std::isfinite(limits.min_velocity) ? limits.min_velocity : -10.0;
  return {random.real(-reach, reach), random.index(0, 3) == 0 ? 0.0 : random.real(bottom, top),
          random.index(0, 2) == 0 ? 0.0 : random.real(limits.min_acceleration, limits.max_acceleration)};
}

ProfileLimits random_limits(test::Random& random) {
  const bool spread = random.index(0, 1) == 0;
  const auto value = [&] { return spread ? random.magnitude(0.1, 30.0) : random.real(0.5, 10.0); };
  ProfileLimits limits{value(), -value(), value(), -value(), value()};
  if (random.index(0, 9) == 0) {
    limits.max_velocity = kInfinity;
  }
  if (random.index(0, 9) == 0) {
    limits.max_jerk = kInfinity;
  }
  return limits;
}

/// A motion that does not have to return inside the limits first.
Motion random_motion(test::Random& random) {
  for (;;) {
    const ProfileLimits limits = random_limits(random);
    const double reach = random.magnitude(1e-4, 1e2);
    const Motion motion{random_state(random, limits, reach), random_state(random, limits, reach), limits};
    if (test::is_inside(motion.from, limits) && test::is_reachable(motion.to, limits)) {
      return motion;
    }
  }
}

TEST(PositionProfile, ObeysTheLimitsBetweenRandomStates) {
  test::Random random;
  int too_long = 0;
  const int rounds = test::profile_rounds(20000);
  for (int round = 0; round < rounds; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Motion motion = random_motion(random);
    const auto profile = plan(motion);
    if (!profile) {
      ASSERT_EQ(profile.error().reason, Reason::kTooLong) << motion.text();
      ++too_long;
      continue;
    }
    ASSERT_EQ(ProfileOracle(motion, 50).complaint(*profile), "");
  }
  EXPECT_LT(too_long, rounds / 100);
}

TEST(PositionProfile, IsNotSlowerThanTheBestOfASearch) {
  test::Random random;
  int far_off = 0;
  const int rounds = test::profile_rounds(200);
  for (int round = 0; round < rounds; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    Motion motion = random_motion(random);
    if (!std::isfinite(motion.limits.max_jerk) || !std::isfinite(motion.limits.max_velocity)) {
      continue;
    }
    const auto profile = plan(motion);
    ASSERT_TRUE(profile.has_value()) << motion.text();
    const double found_s = ProfileSearch(motion).shortest_s(50, 10);
    ASSERT_LE(profile->duration_s(), found_s * (1.0 + 1e-9) + 1e-9) << motion.text();
    far_off += found_s > 1.1 * profile->duration_s() ? 1 : 0;
  }
  // The search must find almost the same, or it would prove nothing.
  EXPECT_LT(far_off, rounds / 10);
}

/// A motion that reaches every limit.
Motion demanding() {
  return {{}, {20.0, 0.0, 0.0}, {2.0, -1.0, 1.0, -0.5, 1.0}};
}

TEST(PositionProfile, ALimitThatIsOnePercentTooLargeIsFound) {
  for (double ProfileLimits::*limit : {&ProfileLimits::max_velocity, &ProfileLimits::max_acceleration,
                                       &ProfileLimits::min_acceleration, &ProfileLimits::max_jerk}) {
    const Motion motion = demanding();
    Motion wrong = motion;
    wrong.limits.*limit *= 1.01;
    EXPECT_EQ(ProfileOracle(motion).complaint(plan(motion).value()), "");
    EXPECT_NE(ProfileOracle(motion).complaint(plan(wrong).value()), "");
    wrong.limits.*limit = motion.limits.*limit / 1.01;
    EXPECT_GT(plan(wrong)->duration_s(), plan(motion)->duration_s() * 1.0001) << "a limit is not made use of";
  }
  Motion back = demanding();
  back.to.position = -20.0;
  Motion wrong = back;
  wrong.limits.min_velocity *= 1.01;
  EXPECT_NE(ProfileOracle(back).complaint(plan(wrong).value()), "");
}

TEST(PositionProfile, LimitsOfVeryDifferentSizes) {
  for (const double distance : {1e-9, 1e-6, 1e-3, 1.0, 1e3}) {
    for (const double velocity : {1e-3, 1.0, 1e6}) {
      for (const double acceleration : {1e-2, 1.0, 1e9}) {
        for (const double jerk : {1e-1, 1.0, 1e12, kInfinity}) {
          if (distance / velocity > 1e4) {
            continue;
          }
          const Motion motion{{}, {distance, 0.0, 0.0}, ProfileLimits::symmetric(velocity, acceleration, jerk)};
          judged(motion);
          // From rest to rest the highest velocity is in the middle, and the return takes as long.
          const double duration_s = plan(motion)->duration_s();
          const AxisSetpoint middle = plan(motion)->evaluate(duration_s / 2.0);
          EXPECT_NEAR(middle.position, distance / 2.0, 1e-9 * distance) << motion.text();
        }
      }
    }
  }
}

// An axis that is replanned while it cruises has a velocity one rounding below the limit.
TEST(PositionProfile, VelocitiesThatDifferInTheirLastDigits) {
  for (const double velocity : {2.9959738429213414, 50.0, 1e-3, 700.0}) {
    double slower = velocity;
    for (int digit = 0; digit < 6; ++digit) {
      slower = std::nextafter(slower, 0.0);
      for (const double jerk : {kInfinity, 641.7, 1e9}) {
        for (const double way : {3.5219569 * velocity, 1e-3 * velocity, 100.0 * velocity}) {
          const auto limits = ProfileLimits::symmetric(velocity, 619.3, jerk);
          judged({{0.8135, slower, 0.0}, {0.8135 + way, velocity, 0.0}, limits});
          judged({{0.8135, velocity, 0.0}, {0.8135 + way, slower, 0.0}, limits});
        }
      }
    }
  }
}

TEST(PositionProfile, TinyDistancesFarFromZero) {
  const Motion motion{{1e9, 0.0, 0.0}, {1e9 + 1e-6, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 10.0, 1000.0)};
  const Profile profile = judged(motion);
  const double way = motion.to.position - motion.from.position;
  EXPECT_NEAR(profile.duration_s(), 4.0 * std::cbrt(way / 2.0 / 1000.0), 1e-12);
}

TEST(PositionProfile, ComesBackInsideTheLimitsFirst) {
  const ProfileLimits limits{2.0, -1.0, 3.0, -4.0, 5.0};
  test::Random random;
  for (int round = 0; round < test::profile_rounds(5000); ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Motion motion{{random.real(-5.0, 5.0), random.real(-8.0, 8.0), random.real(-12.0, 12.0)},
                        {random.real(-5.0, 5.0), 0.0, 0.0},
                        limits};
    const auto profile = plan(motion);
    ASSERT_TRUE(profile.has_value()) << motion.text();
    // Only a value that starts outside may stay outside, and only as long as necessary.
    double back_s = 0.0;
    while (back_s < profile->duration_s() && !test::is_inside(profile->evaluate(back_s), limits)) {
      back_s += profile->duration_s() / 500.0;
    }
    ASSERT_EQ(ProfileOracle(motion).complaint(*profile, back_s + 0.01), "");
  }
}

TEST(PositionProfile, TurnedRoundItIsTheSame) {
  test::Random random;
  for (int round = 0; round < test::profile_rounds(5000); ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const Motion motion{{random.real(-5.0, 5.0), random.real(-4.0, 4.0), random.real(-6.0, 6.0)},
                        {random.real(-5.0, 5.0), random.real(-0.5, 0.5), 0.0},
                        {2.0, -1.0, 3.0, -4.0, 5.0}};
    const Motion turned{{-motion.from.position, -motion.from.velocity, -motion.from.acceleration},
                        {-motion.to.position, -motion.to.velocity, 0.0},
                        {1.0, -2.0, 4.0, -3.0, 5.0}};
    const Profile one = plan(motion).value();
    const Profile other = plan(turned).value();
    ASSERT_NEAR(one.duration_s(), other.duration_s(), 1e-9);
    ASSERT_NEAR(one.evaluate(0.3).position, -other.evaluate(0.3).position, 1e-9);
  }
}

// Jerk 5: in 0.8 s to a deceleration of 4 and 1.6 slower, in 0.1 s the remaining 0.4.
TEST(PositionProfile, BrakesAsHardAsItMay) {
  const Motion motion{{0.0, 4.0, 0.0}, {9.0, 0.0, 0.0}, {2.0, -1.0, 3.0, -4.0, 5.0}};
  const Profile profile = plan(motion).value();
  EXPECT_EQ(ProfileOracle(motion).complaint(profile, 0.9 + 1e-9), "");
  EXPECT_NEAR(profile.evaluate(0.9).velocity, 2.0, 1e-12);
  EXPECT_NEAR(profile.evaluate(0.9).acceleration, -4.0, 1e-12);
  Motion turned{{0.0, -4.0, 0.0}, {-9.0, 0.0, 0.0}, {1.0, -2.0, 4.0, -3.0, 5.0}};
  EXPECT_EQ(plan(turned)->duration_s(), profile.duration_s());
  EXPECT_NEAR(plan(turned)->evaluate(0.9).velocity, -2.0, 1e-12);
  turned.limits.max_jerk = kInfinity;
  EXPECT_NEAR(plan(turned)->evaluate(0.5).velocity, -2.0, 1e-12);
  EXPECT_EQ(ProfileOracle(turned).complaint(plan(turned).value(), 0.5 + 1e-9), "");
}

// A deceleration d at velocity 0.1 leads to 0.1 - d^2 / 10, which may be -0.1.
TEST(PositionProfile, BrakesNoHarderThanTheOtherLimitAllows) {
  const Motion motion{{0.0, 1.0, 0.0}, {0.0, 0.0, 0.0}, {0.1, -0.1, 3.0, -4.0, 5.0}};
  const Profile profile = plan(motion).value();
  double t = 0.0;
  while (profile.evaluate(t).velocity > 0.1) {
    t += 1e-5;
  }
  EXPECT_NEAR(profile.evaluate(t).acceleration, -std::sqrt(2.0), 1e-3);
  EXPECT_EQ(ProfileOracle(motion).complaint(profile, t + 1e-5), "");
}

TEST(PositionProfile, StaysInARangeOrBrakes) {
  const ProfileLimits limits = ProfileLimits::symmetric(2.0, 1.0, 4.0);
  const AxisSetpoint from{0.0, 1.0, 0.0};
  const AxisSetpoint near{0.2, 0.0, 0.0};
  const double farthest = plan_to_position(from, near, limits)->extremes().max;
  EXPECT_GT(farthest, 0.5);
  EXPECT_EQ(plan_to_position(from, near, limits, {-1.0, farthest}, OutOfRange::kRefuse)->end().position, 0.2);
  EXPECT_EQ(plan_to_position(from, near, limits, {-1.0, farthest - 1e-9}, OutOfRange::kRefuse).error().reason,
            Reason::kPositionRange);
  const AxisSetpoint far{3.0, 0.0, 0.0};
  EXPECT_EQ(plan_to_position(from, far, limits, {-kInfinity, 2.9}, OutOfRange::kRefuse).error().reason,
            Reason::kPositionRange);
  const Profile braked = plan_to_position(from, far, limits, {-1.0, 2.9}, OutOfRange::kBrake).value();
  EXPECT_EQ(braked.end().velocity, 0.0);
  EXPECT_EQ(braked.end().acceleration, 0.0);
  EXPECT_DOUBLE_EQ(braked.end().position, 0.625);
}

}  // namespace
}  // namespace driveline::trajectory
