#include "driveline/trajectory/synchronised_profiles.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "driveline/trajectory/position_profile.hpp"
#include "profile_oracle.hpp"
#include "support.hpp"
#include "support/must.hpp"

namespace driveline::trajectory {
namespace {

using test::ProfileOracle;
using Reason = ProfileError::Reason;

ProfileLimits random_limits(test::Random& random) {
  return {random.real(0.5, 3.0), -random.real(0.5, 3.0), random.real(0.5, 4.0), -random.real(0.5, 4.0),
          random.real(1.0, 10.0)};
}

AxisMotion random_motion(test::Random& random) {
  for (;;) {
    const ProfileLimits limits = random_limits(random);
    const auto state = [&] {
      return AxisSetpoint{random.real(-2.0, 2.0), random.real(-1.0, 1.0) * limits.max_velocity,
                          random.real(limits.min_acceleration, limits.max_acceleration)};
    };
    const AxisMotion motion{state(), state(), limits};
    if (test::is_inside(motion.from, limits) && test::is_reachable(motion.to, limits)) {
      return motion;
    }
  }
}

void expect_right(const AxisMotion& axis, const Profile& profile) {
  ASSERT_EQ(ProfileOracle({axis.from, axis.to, axis.limits}, 40).complaint(profile), "");
}

TEST(SynchronisedProfiles, WithoutSynchronisationEachIsAsFastAsItCanBe) {
  const std::array axes{AxisMotion{{}, {4.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)},
                        AxisMotion{{}, {-2.0, 0.0, 0.0}, ProfileLimits::symmetric(100.0, 100.0, 1.0)}};
  std::array<Profile, 2> profiles;
  const SynchronisedPlan plan = plan_synchronised(axes, Synchronisation::kNone, profiles).value();
  EXPECT_EQ(plan, (SynchronisedPlan{Synchronisation::kNone, profiles[0].duration_s()}));
  EXPECT_DOUBLE_EQ(profiles[0].duration_s(), 6.0);
  EXPECT_DOUBLE_EQ(profiles[1].duration_s(), 4.0);
}

TEST(SynchronisedProfiles, AllEndTogether) {
  test::Random random;
  int gaps = 0;
  for (int round = 0; round < test::profile_rounds(1000); ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    std::vector<AxisMotion> axes(random.index(1, 9));
    double longest_s = 0.0;
    for (AxisMotion& axis : axes) {
      axis = random_motion(random);
      longest_s = std::max(longest_s, plan_to_position(axis.from, axis.to, axis.limits)->duration_s());
    }
    std::vector<Profile> profiles(axes.size());
    const auto plan = must(plan_synchronised(axes, Synchronisation::kTime, profiles));
    ASSERT_EQ(plan->synchronisation, Synchronisation::kTime);
    ASSERT_GE(plan->duration_s, longest_s * (1.0 - 1e-12));
    gaps += plan->duration_s > longest_s * (1.0 + 1e-9) ? 1 : 0;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      ASSERT_NEAR(profiles[i].duration_s(), plan->duration_s, 1e-11 * plan->duration_s);
      expect_right(axes[i], profiles[i]);
    }
    if (plan->duration_s > longest_s * (1.0 + 1e-6)) {
      // Waiting was necessary: just before, and half way, there is an axis that cannot arrive.
      for (const double share : {0.5, 1.0 - 1e-6}) {
        const double earlier_s = longest_s + share * (plan->duration_s - longest_s);
        bool can = true;
        for (const AxisMotion& axis : axes) {
          can = can && plan_to_position(axis.from, axis.to, axis.limits, earlier_s).has_value();
        }
        ASSERT_FALSE(can) << earlier_s;
      }
    }
  }
  EXPECT_GT(gaps, 0);
}

// Both outer axes can be early or late; the middle axis ends in their gap and makes all of them wait.
TEST(SynchronisedProfiles, WaitUntilTheEndOfAGap) {
  const AxisMotion gap{{0.0, 1.0, 0.0}, {0.1, 1.0, 0.0}, ProfileLimits::symmetric(2.0, 2.0, 10.0)};
  const AxisMotion slow{{}, {1.0, 0.0, 0.0}, ProfileLimits::symmetric(2.5, 2.0, 10.0)};
  const std::array axes{gap, slow, gap};
  std::array<Profile, 3> profiles;
  const double end_s = possible_durations(gap.from, gap.to, gap.limits)->gaps()[0].end_s;
  EXPECT_NEAR(must(plan_synchronised(axes, Synchronisation::kTime, profiles))->duration_s, end_s, 1e-9);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    expect_right(axes[i], profiles[i]);
  }
}

TEST(SynchronisedProfiles, FromRestToRestTheyGoOnAStraightLine) {
  test::Random random;
  for (int round = 0; round < 300; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    std::vector<AxisMotion> axes(random.index(2, 9));
    for (AxisMotion& axis : axes) {
      axis = {{random.real(-2.0, 2.0), 0.0, 0.0}, {random.real(-2.0, 2.0), 0.0, 0.0}, random_limits(random)};
    }
    axes.back().to.position = axes.back().from.position;
    std::vector<Profile> profiles(axes.size());
    const auto plan = must(plan_synchronised(axes, Synchronisation::kPhase, profiles));
    ASSERT_EQ(plan->synchronisation, Synchronisation::kPhase);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      ASSERT_EQ(profiles[i].duration_s(), plan->duration_s);
      expect_right(axes[i], profiles[i]);
    }
    for (int k = 0; k <= 20; ++k) {
      const auto share = [&](std::size_t i) {
        return (profiles[i].evaluate(plan->duration_s * k / 20.0).position - axes[i].from.position) /
               (axes[i].to.position - axes[i].from.position);
      };
      for (std::size_t i = 1; i + 1 < axes.size(); ++i) {
        ASSERT_NEAR(share(i), share(0), 1e-9);
      }
    }
  }
}

TEST(SynchronisedProfiles, OnAStraightLineOneAxisIsAtALimit) {
  const std::array axes{AxisMotion{{}, {1.0, 0.0, 0.0}, {1.0, -1.0, 9.0, -9.0, 90.0}},
                        AxisMotion{{}, {-2.0, 0.0, 0.0}, {1.0, -1.5, 7.0, -9.0, 90.0}}};
  std::array<Profile, 2> profiles;
  ASSERT_TRUE(plan_synchronised(axes, Synchronisation::kPhase, profiles).has_value());
  double fastest = 0.0;
  double hardest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const AxisSetpoint at = profiles[1].evaluate(profiles[1].duration_s() * i / 1000.0);
    fastest = std::min(fastest, at.velocity);
    hardest = std::max(hardest, at.acceleration);
  }
  // -2 / 1 as fast as the first axis, which could do 1.
  EXPECT_NEAR(fastest, -1.5, 1e-9);
  // sqrt(jerk * velocity) is what a change of velocity by 1.5 comes to, unless it is limited.
  EXPECT_NEAR(hardest, 7.0, 1e-9);
}

TEST(SynchronisedProfiles, MovingAxesStayOnTheirLine) {
  std::array axes{AxisMotion{{0.0, 0.4, -0.2}, {1.0, 0.2, 0.1}, ProfileLimits::symmetric(1.0, 2.0, 10.0)},
                  AxisMotion{{5.0, -0.8, 0.4}, {3.0, -0.4, -0.2}, ProfileLimits::symmetric(1.0, 2.0, 10.0)}};
  std::array<Profile, 2> profiles;
  EXPECT_EQ(plan_synchronised(axes, Synchronisation::kPhase, profiles)->synchronisation, Synchronisation::kPhase);
  EXPECT_NEAR(profiles[1].evaluate(0.3).position - 5.0, -2.0 * profiles[0].evaluate(0.3).position, 1e-12);
  for (double AxisSetpoint::*member : {&AxisSetpoint::velocity, &AxisSetpoint::acceleration}) {
    auto other = axes;
    other[1].from.*member *= 1.001;
    EXPECT_EQ(plan_synchronised(other, Synchronisation::kPhase, profiles)->synchronisation, Synchronisation::kTime);
    other = axes;
    other[1].to.*member *= 1.001;
    EXPECT_EQ(plan_synchronised(other, Synchronisation::kPhase, profiles)->synchronisation, Synchronisation::kTime);
  }
}

TEST(SynchronisedProfiles, WithoutAWayThereIsNoLine) {
  const std::array axes{AxisMotion{{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 2.0, 10.0)},
                        AxisMotion{{5.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 2.0, 10.0)}};
  std::array<Profile, 2> profiles;
  EXPECT_EQ(plan_synchronised(axes, Synchronisation::kPhase, profiles).value(),
            (SynchronisedPlan{Synchronisation::kTime, 0.0}));
}

TEST(SynchronisedProfiles, NameTheAxisThatIsWrong) {
  std::vector<AxisMotion> axes(3, {{}, {1.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)});
  std::vector<Profile> profiles(3);
  axes[2].limits.max_jerk = 0.0;
  for (const auto how : {Synchronisation::kNone, Synchronisation::kTime, Synchronisation::kPhase}) {
    const auto plan = plan_synchronised(axes, how, profiles);
    ASSERT_FALSE(plan.has_value());
    EXPECT_EQ(plan.error(), (AxisProfileError{2, {Reason::kLimits, 0.0}}));
  }
  axes[2].limits.max_jerk = 1.0;
  axes[1].to.velocity = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(plan_synchronised(axes, Synchronisation::kPhase, profiles).error(),
            (AxisProfileError{1, {Reason::kTarget, 0.0}}));
}

TEST(SynchronisedProfiles, RefuseListsThatDoNotMatch) {
  std::vector<AxisMotion> axes(kMaxSynchronisedAxes + 1,
                               {{}, {1.0, 0.0, 0.0}, ProfileLimits::symmetric(1.0, 1.0, 1.0)});
  std::vector<Profile> profiles(axes.size());
  EXPECT_EQ(plan_synchronised(axes, Synchronisation::kTime, profiles).error().error.reason, Reason::kAxes);
  EXPECT_EQ(plan_synchronised({}, Synchronisation::kTime, {}).error().error.reason, Reason::kAxes);
  axes.resize(2);
  EXPECT_EQ(plan_synchronised(axes, Synchronisation::kTime, profiles).error().error.reason, Reason::kAxes);
  axes.resize(kMaxSynchronisedAxes, axes[0]);
  profiles.resize(kMaxSynchronisedAxes);
  EXPECT_TRUE(plan_synchronised(axes, Synchronisation::kTime, profiles).has_value());
}

}  // namespace
}  // namespace driveline::trajectory
