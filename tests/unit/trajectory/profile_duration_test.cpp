#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "driveline/trajectory/position_profile.hpp"
#include "profile_oracle.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::Motion;
using test::ProfileOracle;
using Reason = ProfileError::Reason;

tl::expected<Profile, ProfileError> plan(const Motion& motion, double duration_s) {
  return plan_to_position(motion.from, motion.to, motion.limits, duration_s);
}

double shortest_s(const Motion& motion) {
  return plan_to_position(motion.from, motion.to, motion.limits)->duration_s();
}

tl::expected<PossibleDurations, ProfileError> durations_of(const Motion& motion) {
  return possible_durations(motion.from, motion.to, motion.limits);
}

bool is_possible(const PossibleDurations& durations, double duration_s) {
  bool possible = duration_s >= durations.shortest_s();
  for (const PossibleDurations::Gap& gap : durations.gaps()) {
    possible = possible && (duration_s <= gap.begin_s || duration_s >= gap.end_s);
  }
  return possible;
}

TEST(ProfileDuration, FromRestToRestAnyLongerOneIsPossible) {
  for (const double jerk : {10.0, std::numeric_limits<double>::infinity()}) {
    const Motion motion{{1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}, {1.5, -1.0, 2.0, -1.0, jerk}};
    const double least_s = shortest_s(motion);
    for (const double factor : {1.0, 1.0001, 1.3, 10.0, 1000.0}) {
      const auto profile = plan(motion, factor * least_s);
      ASSERT_TRUE(profile.has_value()) << factor;
      EXPECT_NEAR(profile->duration_s(), factor * least_s, 1e-12 * factor * least_s);
      EXPECT_EQ(ProfileOracle(motion).complaint(*profile), "");
      // Without reversing.
      EXPECT_GE(profile->extremes().min, 1.0);
      EXPECT_LE(profile->extremes().max, 3.0 + 1e-12);
    }
    EXPECT_TRUE(durations_of(motion)->gaps().empty());
    EXPECT_NEAR(durations_of(motion)->shortest_s(), least_s, 1e-12);
  }
}

TEST(ProfileDuration, AnAxisThatIsToStayDoesNotMove) {
  const Motion motion{{2.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {1.5, -1.0, 2.0, -1.0, 7.0}};
  const Profile profile = plan(motion, 3.0).value();
  EXPECT_EQ(profile.duration_s(), 3.0);
  EXPECT_EQ(profile.extremes().min, 2.0);
  EXPECT_EQ(profile.extremes().max, 2.0);
  // If the given time matches its velocity, the velocity does not change either.
  const Motion steady{{0.0, 0.5, 0.0}, {2.0, 0.5, 0.0}, {1.5, -1.0, 2.0, -1.0, 7.0}};
  const Profile line = plan(steady, 4.0).value();
  for (int i = 0; i <= 10; ++i) {
    EXPECT_NEAR(line.evaluate(0.4 * i).velocity, 0.5, 1e-15);
  }
}

TEST(ProfileDuration, RefusesWhatIsTooShortAndNamesWhatIsPossible) {
  const Motion motion{{1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}, {1.5, -1.0, 2.0, -1.0, 10.0}};
  const double least_s = shortest_s(motion);
  for (const double duration_s : {0.999 * least_s, 0.0, -1.0, -std::numeric_limits<double>::infinity()}) {
    const ProfileError error = plan(motion, duration_s).error();
    EXPECT_EQ(error.reason, Reason::kTooShort);
    EXPECT_NEAR(error.possible_duration_s, least_s, 1e-12);
  }
  EXPECT_EQ(plan(motion, std::numeric_limits<double>::quiet_NaN()).error().reason, Reason::kTooLong);
  EXPECT_EQ(plan(motion, 2.0 * kLongestProfileSeconds).error().reason, Reason::kTooLong);
}

// A little ahead at the present velocity: at once, or with a full loop.
TEST(ProfileDuration, AMovingAxisHasAGap) {
  const Motion motion{{0.0, 1.0, 0.0}, {0.1, 1.0, 0.0}, ProfileLimits::symmetric(2.0, 2.0, 10.0)};
  const PossibleDurations durations = durations_of(motion).value();
  ASSERT_EQ(durations.gaps().size(), 1U);
  const PossibleDurations::Gap gap = durations.gaps()[0];
  EXPECT_LT(durations.shortest_s(), 0.1);
  EXPECT_GT(gap.begin_s, 0.1);
  EXPECT_LT(gap.begin_s, 0.2);
  EXPECT_GT(gap.end_s, 1.0);
  const ProfileError error = plan(motion, (gap.begin_s + gap.end_s) / 2.0).error();
  EXPECT_EQ(error.reason, Reason::kBlocked);
  EXPECT_NEAR(error.possible_duration_s, gap.end_s, 1e-9);
  for (const double duration_s : {durations.shortest_s(), gap.begin_s * (1.0 - 1e-7), gap.end_s, gap.end_s + 1.0}) {
    const auto profile = plan(motion, duration_s);
    ASSERT_TRUE(profile.has_value()) << duration_s;
    EXPECT_EQ(ProfileOracle(motion).complaint(*profile), "");
  }
}

// With an acceleration of 2 at both ends, it either stays or passes through zero.
TEST(ProfileDuration, AnAcceleratingAxisHasAGap) {
  const Motion motion{{0.0, 0.0, 2.0}, {0.0101, 0.2, 2.0}, ProfileLimits::symmetric(2.0, 3.0, 10.0)};
  const PossibleDurations durations = durations_of(motion).value();
  ASSERT_GE(durations.gaps().size(), 1U);
  EXPECT_GT(durations.gaps()[0].end_s, 0.4);
  EXPECT_LT(durations.gaps()[0].begin_s, 0.11);
  EXPECT_LT(durations.shortest_s(), 0.11);
}

/// A motion of random jerks within the limits, and its duration. None: it exceeds them.
std::optional<Profile> random_walk(test::Random& random, const ProfileLimits& limits, const AxisSetpoint& from) {
  Profile walk(from);
  AxisSetpoint at = from;
  const std::size_t phases = random.index(1, 6);
  for (std::size_t i = 0; i < phases; ++i) {
    const double jerks[] = {limits.max_jerk, -limits.max_jerk, 0.0, random.real(-1.0, 1.0) * limits.max_jerk};
    const double jerk = jerks[random.index(0, 3)];
    const double duration_s = random.magnitude(1e-3, 3.0);
    walk.append(duration_s, at.acceleration, jerk);
    at = walk.end();
    for (int k = 0; k <= 20; ++k) {
      const AxisSetpoint on_way = walk.evaluate(walk.duration_s() - duration_s * k / 20.0 * 0.999999);
      if (!(on_way.velocity <= limits.max_velocity && on_way.velocity >= limits.min_velocity &&
            on_way.acceleration <= limits.max_acceleration && on_way.acceleration >= limits.min_acceleration)) {
        return std::nullopt;
      }
    }
  }
  return walk;
}

// The duration of any motion must be possible, and none may be shorter than the shortest.
TEST(ProfileDuration, EveryRandomWalkIsPossible) {
  test::Random random;
  int walks = 0;
  int with_gaps = 0;
  for (int round = 0; walks < test::profile_rounds(3000); ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const ProfileLimits limits{random.real(0.5, 3.0), -random.real(0.5, 3.0), random.real(0.5, 4.0),
                               -random.real(0.5, 4.0), random.real(1.0, 10.0)};
    const AxisSetpoint from{random.real(-1.0, 1.0), random.real(-0.9, 0.9) * limits.max_velocity,
                            random.real(limits.min_acceleration, limits.max_acceleration)};
    const auto walk = random_walk(random, limits, from);
    if (!walk || !test::is_inside(from, limits) || !test::is_reachable(walk->end(), limits)) {
      continue;
    }
    ++walks;
    const Motion motion{from, walk->end(), limits};
    const PossibleDurations durations = durations_of(motion).value();
    ASSERT_LE(durations.shortest_s(), walk->duration_s() * (1.0 + 1e-9)) << motion.text();
    ASSERT_NEAR(durations.shortest_s(), shortest_s(motion), 1e-9) << motion.text();
    const auto same = plan(motion, walk->duration_s());
    if (same) {
      ASSERT_EQ(ProfileOracle(motion, 50).complaint(*same), "") << walk->duration_s();
    } else {
      // A walk at the start of a gap: rounding decides.
      const auto gaps = durations.gaps();
      ASSERT_TRUE(std::any_of(
          gaps.begin(), gaps.end(),
          [&](const PossibleDurations::Gap& gap) { return std::abs(gap.begin_s - walk->duration_s()) < 1e-6; }))
          << walk->duration_s() << motion.text();
    }
    with_gaps += durations.gaps().empty() ? 0 : 1;
  }
  EXPECT_GT(with_gaps, walks / 50);
}

// Both kinds of answers agree, and profiles of both kinds are correct, around every gap.
TEST(ProfileDuration, GapsAreWhereThereIsNoProfile) {
  test::Random random;
  for (int round = 0; round < test::profile_rounds(3000); ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    ProfileLimits limits{random.real(0.5, 3.0), -random.real(0.5, 3.0), random.real(0.5, 4.0), -random.real(0.5, 4.0),
                         random.real(1.0, 10.0)};
    if (round % 4 == 0) limits.max_jerk = std::numeric_limits<double>::infinity();
    const auto state = [&] {
      return AxisSetpoint{random.real(-0.5, 0.5), random.real(-0.9, 0.9) * limits.max_velocity,
                          random.real(limits.min_acceleration, limits.max_acceleration)};
    };
    const Motion motion{state(), state(), limits};
    const auto durations = durations_of(motion);
    if (!durations) {
      ASSERT_EQ(durations.error().reason, Reason::kTarget);
      continue;
    }
    for (int k = 0; k < 10; ++k) {
      const double duration_s = durations->shortest_s() * random.magnitude(0.9, 5.0);
      const auto profile = plan(motion, duration_s);
      ASSERT_EQ(profile.has_value(), is_possible(*durations, duration_s)) << duration_s << motion.text();
      if (profile && test::is_inside(motion.from, limits)) {
        ASSERT_EQ(ProfileOracle(motion, 30).complaint(*profile), "") << duration_s;
      }
      if (!profile) {
        const auto next = plan(motion, profile.error().possible_duration_s);
        ASSERT_TRUE(next.has_value()) << motion.text();
        ASSERT_NEAR(next->duration_s(), profile.error().possible_duration_s, 1e-9 * next->duration_s())
            << motion.text();
      }
    }
  }
}

}  // namespace
}  // namespace driveline::trajectory
