#include "driveline/trajectory/deviation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace driveline::trajectory {
namespace {

constexpr double kDeviationStep = 125e-6;
constexpr AxisLimits kGentleLimits{50.0, 1000.0};

/// Up to 39 rad/s and 620 rad/s^2.
AxisSetpoint swing(double t) {
  constexpr double kAmplitude = 2.45;
  constexpr double kOmega = 15.9;
  const double phase = kOmega * t;
  return {kAmplitude * (1.0 - std::cos(phase)), kAmplitude * kOmega * std::sin(phase),
          kAmplitude * kOmega * kOmega * std::cos(phase)};
}

/// Number of cycles until it is on the path.
int return_to(double time, double away, double velocity_away, double& hardest) {
  const auto begin = swing(time);
  Deviation way(begin.position + away, begin.velocity + velocity_away, kGentleLimits);
  double velocity = begin.velocity + velocity_away;
  for (int i = 1; i < 8000; ++i) {
    const auto target = swing(time + i * kDeviationStep);
    const auto setpoint = way.step(target, kDeviationStep);
    const double acceleration = (setpoint.velocity - velocity) / kDeviationStep;
    hardest = std::max(hardest, std::abs(acceleration - target.acceleration));
    EXPECT_NEAR(acceleration, setpoint.acceleration, 25.0) << "what it tells is what it does";
    velocity = setpoint.velocity;
    if (!way.joined()) continue;
    EXPECT_NEAR(setpoint.position, target.position, 1e-6);
    return i;
  }
  return 8000;
}

TEST(Deviation, GoesToZeroWithATenthOfTheAcceleration) {
  for (double time = 0.0; time < 0.4; time += 0.013) {
    for (const double velocity : {-0.9, 0.0, 0.9}) {
      SCOPED_TRACE(testing::Message() << time << " s, " << velocity << " rad/s");
      double hardest = 0.0;
      EXPECT_LT(return_to(time, 1e-3, velocity, hardest), 2400);
      EXPECT_LE(hardest, 0.1 * kGentleLimits.max_acceleration + 25.0);
    }
  }
}

/// Consecutive gaps while the path accelerates: each leaves the axis a little further ahead.
TEST(Deviation, MakesNoAxisFasterThanItMayBe) {
  for (const double ahead : {0.5, 2.0, 4.0}) {
    SCOPED_TRACE(ahead);
    Deviation way(0.0, 46.0 + ahead, kGentleLimits);
    double velocity = 46.0 + ahead;
    for (int i = 1; i < 200; ++i) {
      // At 1000 rad/s^2 to the highest velocity.
      const double t = i * kDeviationStep;
      const bool fast = t >= 4e-3;
      const double at = fast ? 50.0 : 46.0 + 1000.0 * t;
      const double position = 46.0 * t + (fast ? 8e-3 + 4.0 * (t - 4e-3) : 500.0 * t * t);
      const auto setpoint = way.step({position, at, fast ? 0.0 : 1000.0}, kDeviationStep);
      EXPECT_LE(setpoint.velocity, 50.0 + 1e-9);
      EXPECT_GE(setpoint.velocity, velocity - 0.5 * 1000.0 * kDeviationStep);
      velocity = setpoint.velocity;
    }
  }
}

TEST(Deviation, OfAnAxisThatIsTooFastIsBrakedHarder) {
  Deviation way(0.0, 53.0, kGentleLimits);
  double velocity = 53.0;
  for (int i = 1; i <= 60; ++i) {
    const double before = velocity;
    velocity = way.step({50.0 * i * kDeviationStep, 50.0, 0.0}, kDeviationStep).velocity;
    EXPECT_NEAR((velocity - before) / kDeviationStep, velocity > 50.0 ? -400.0 : 0.0, 401.0);
  }
  EXPECT_LE(velocity, 50.0 + 1e-9);
}

}  // namespace
}  // namespace driveline::trajectory
