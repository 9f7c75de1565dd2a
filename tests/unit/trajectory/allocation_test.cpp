#include <gtest/gtest.h>

#include <array>

#include "driveline/rt_guard/rt_guard.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/position_profile.hpp"
#include "driveline/trajectory/start_ramp.hpp"
#include "driveline/trajectory/stop_profile.hpp"
#include "driveline/trajectory/synchronised_profiles.hpp"
#include "driveline/trajectory/velocity_profile.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

TEST(RealTime, EvaluationUsesNeitherHeapNorLocks) {
  if (!rt::RtGuard::available()) {
    GTEST_SKIP() << "a sanitizer owns malloc in this build";
  }
  std::vector<double> times_s;
  std::vector<std::vector<double>> rows;
  for (int k = 0; k < 200; ++k) {
    times_s.push_back(k * 0.01);
    rows.emplace_back(100, static_cast<double>(k % 7));
  }
  Interpolator spline = Interpolator::clamped_spline(test::make_path(times_s, rows));
  std::vector<AxisSetpoint> out(spline.axes().size());
  double sum = 0.0;

  rt::RtGuard::enter();
  for (int cycle = 0; cycle < 20000; ++cycle) {
    const double time_s = (cycle % 3 == 0 ? 20000 - cycle : cycle) * 125e-6;  // jumps, too
    spline.evaluate(time_s, out);
    auto ramp = StartRamp::plan(out[0].position, 10.0, {100.0, 1000.0});
    ramp->stretch_to(0.5);
    const auto stop = StopProfile::plan(out[0], {1000.0, 1e5});
    sum += ramp->evaluate(0.1).position + stop->evaluate(0.01).position;
  }
  const rt::RtGuard::Counts counts = rt::RtGuard::leave();

  EXPECT_EQ(counts.total(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(RealTime, PlanningProfilesUsesNeitherHeapNorLocks) {
  if (!rt::RtGuard::available()) {
    GTEST_SKIP() << "a sanitizer owns malloc in this build";
  }
  test::Random random;
  std::array<AxisMotion, 9> axes;
  std::array<Profile, 9> profiles;
  double sum = 0.0;

  rt::RtGuard::enter();
  for (int cycle = 0; cycle < 300; ++cycle) {
    for (AxisMotion& axis : axes) {
      axis.limits = ProfileLimits::symmetric(random.real(1.0, 9.0), random.real(1.0, 9.0), random.real(1.0, 90.0));
      axis.from = {random.real(-1.0, 1.0), random.real(-12.0, 12.0), random.real(-12.0, 12.0)};
      axis.to = {random.real(-1.0, 1.0), random.real(-1.0, 1.0), 0.0};
    }
    for (const auto how : {Synchronisation::kNone, Synchronisation::kTime, Synchronisation::kPhase}) {
      sum += plan_synchronised(axes, how, profiles)->duration_s;
    }
    const AxisMotion& axis = axes[0];
    sum += possible_durations(axis.from, axis.to, axis.limits)->shortest_s();
    sum += plan_to_velocity(axis.from, 0.5, 0.0, axis.limits)->evaluate(0.1).position;
    sum += profiles[0].extremes().max;
    sum += plan_to_position(axis.from, axis.to, axis.limits, 1e-3).error().possible_duration_s;
  }
  const rt::RtGuard::Counts counts = rt::RtGuard::leave();

  EXPECT_EQ(counts.total(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace driveline::trajectory
