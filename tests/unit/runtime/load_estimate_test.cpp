// The load of an axis from records synthesised from known figures.
#include "driveline/runtime/identify/load_estimate.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "driveline/runtime/identify/test_motion.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using testing::HasSubstr;
using trajectory::AxisSetpoint;

motion::AxisConfig axis() {
  motion::AxisConfig config;
  config.name = "x";
  config.limits = {100.0, 1000.0};
  return config;
}

/// The load: its torque at each instant of a test motion.
struct Load {
  double inertia = 2e-3;
  double viscous = 3e-3;
  double coulomb = 0.2;
  double gravity = -0.5;
  double pendulum = 0.0;
  double zero = 0.0;
  double noise = 0.0;
};

std::vector<LoadSample> records(const Load& load, const TestMotion& motion) {
  auto path = make_test_path(motion, axis());
  EXPECT_TRUE(path);
  std::vector<LoadSample> samples;
  unsigned random = 1;
  for (double time_s = 0.0; time_s < path->end_s(); time_s += 1e-3) {
    AxisSetpoint at;
    path->evaluate(time_s, std::span(&at, 1));
    random = random * 1664525U + 1013904223U;
    const double noise = load.noise * (static_cast<double>(random) / 2147483648.0 - 1.0);
    const double friction = at.velocity == 0.0 ? 0.0 : std::copysign(load.coulomb, at.velocity);
    samples.push_back({5.0 + time_s, at.position,
                       load.inertia * at.acceleration + load.viscous * at.velocity + friction + load.gravity +
                           load.pendulum * std::sin(at.position - load.zero) + noise});
  }
  return samples;
}

TEST(LoadEstimate, FindsWhatTheTorqueWasMadeFrom) {
  const auto load = must(estimate_load(records({}, {10.0, 80.0, 800.0}), {}));
  EXPECT_NEAR(load->inertia.value, 2e-3, 2e-6);
  EXPECT_NEAR(load->viscous_friction.value, 3e-3, 6e-6);
  EXPECT_NEAR(load->coulomb_friction.value, 0.2, 5e-4);
  EXPECT_NEAR(load->gravity.value, -0.5, 5e-4);
  EXPECT_FALSE(load->pendulum);
  EXPECT_LT(load->residual_rms, 1e-3 * load->torque_rms);
  EXPECT_GT(load->rows.size(), 40U);
}

TEST(LoadEstimate, TheTruthIsWithinTheIntervalThatNoiseLeaves) {
  Load of;
  of.noise = 0.5;
  const auto load = must(estimate_load(records(of, {10.0, 80.0, 800.0}), {}));
  const auto holds = [](const LoadFigure& figure, double truth) {
    EXPECT_GT(figure.interval, 1e-3 * std::abs(truth)) << "noise does not leave it certain";
    EXPECT_NEAR(figure.value, truth, 2.0 * figure.interval);
  };
  holds(load->inertia, 2e-3);
  holds(load->coulomb_friction, 0.2);
  holds(load->gravity, -0.5);
  const auto quiet = must(estimate_load(records({}, {10.0, 80.0, 800.0}), {}));
  EXPECT_LT(quiet->inertia.interval, 0.1 * load->inertia.interval);
}

TEST(LoadEstimate, FindsAPendulumAndItsAngle) {
  Load of;
  of.pendulum = 1.5;
  of.zero = 0.7;
  LoadSettings settings;
  settings.pendulum = true;
  const auto load = must(estimate_load(records(of, {-2.0 * std::numbers::pi, 40.0, 800.0}), settings));
  ASSERT_TRUE(load->pendulum && load->pendulum_zero);
  EXPECT_NEAR(load->pendulum->value, 1.5, 0.01);
  EXPECT_NEAR(load->pendulum_zero->value, 0.7, 0.01);
  EXPECT_NEAR(load->inertia.value, 2e-3, 2e-5);
  EXPECT_NEAR(load->gravity.value, -0.5, 0.01);
}

TEST(LoadEstimate, FiguresThatTheMotionDoesNotTellApartAreNamed) {
  LoadSettings settings;
  settings.pendulum = true;
  const auto short_way = estimate_load(records({}, {0.2, 1.0, 100.0}), settings);
  ASSERT_FALSE(short_way);
  EXPECT_THAT(describe(short_way.error()), HasSubstr("cannot be separated"));
  EXPECT_THAT(describe(short_way.error()), HasSubstr("is needed"));
  auto one_way = records({}, {10.0, 20.0, 800.0});
  std::erase_if(one_way, [](const LoadSample& sample) { return sample.time_s > 5.9; });
  EXPECT_THAT(failure_text(estimate_load(one_way, {})), HasSubstr("a motion in both directions is needed"));
}

TEST(LoadEstimate, AnAxisThatHardlyMovesShowsNothing) {
  LoadSettings settings;
  settings.standstill = 50.0;
  EXPECT_THAT(failure_text(estimate_load(records({}, {10.0, 80.0, 800.0}), settings)), HasSubstr("in motion in"));
  EXPECT_EQ(describe(estimate_load({}, {}).error()), "there are too few samples of the motion");
}

TEST(LoadEstimate, ADriveThatTellsNoTorqueIsNamedAsTheReason) {
  const auto load = estimate_load(records({0.0, 0.0, 0.0, 0.0}, {10.0, 80.0, 800.0}), {});
  ASSERT_FALSE(load);
  EXPECT_EQ(describe(load.error()),
            "the drive reports no torque: map 6077h (Torque actual value) into its process data");
}

TEST(LoadEstimate, LostRecordsAreNoticed) {
  auto samples = records({}, {10.0, 80.0, 800.0});
  samples.erase(samples.begin() + 300, samples.begin() + 302);
  const auto load = estimate_load(samples, {});
  ASSERT_FALSE(load);
  EXPECT_THAT(describe(load.error()), HasSubstr("records of the motion were lost"));
}

TEST(LoadEstimate, ATorqueAgainstTheAccelerationIsNoLoad) {
  Load of;
  of.inertia = -1e-3;
  EXPECT_EQ(failure_text(estimate_load(records(of, {10.0, 80.0, 800.0}), {})),
            "the torque goes against the acceleration: an inertia of -0.001 was found");
}

TEST(TestMotion, StaysWithinWayAndLimits) {
  for (const TestMotion& motion : {TestMotion{10.0, 80.0, 800.0}, {-3.0, 5.0, 1000.0}, {0.01, 100.0, 50.0}}) {
    auto path = must(make_test_path(motion, axis()));
    double fastest = 0.0;
    double farthest = 0.0;
    double hardest = 0.0;
    AxisSetpoint at;
    for (double time_s = 0.0; time_s <= path->end_s(); time_s += 2e-4) {
      path->evaluate(time_s, std::span(&at, 1));
      fastest = std::max(fastest, std::abs(at.velocity));
      hardest = std::max(hardest, std::abs(at.acceleration));
      farthest = std::max(farthest, std::abs(at.position));
      ASSERT_GT(at.position * std::copysign(1.0, motion.distance), -1e-4 * std::abs(motion.distance));
    }
    EXPECT_NEAR(farthest, std::abs(motion.distance), 1e-3 * std::abs(motion.distance));
    EXPECT_LT(fastest, motion.velocity * 1.001);
    EXPECT_LT(hardest, motion.acceleration * 1.02);
    EXPECT_GT(std::max(fastest / motion.velocity, hardest / motion.acceleration), 0.98) << "as quick as it may be";
    EXPECT_NEAR(at.position, 0.0, 1e-9) << "back where it began";
  }
}

TEST(TestMotion, BeyondTheLimitsIsRefused) {
  const auto refusal = [](const TestMotion& motion) {
    const auto path = make_test_path(motion, axis());
    return path ? std::string{} : describe(path.error());
  };
  EXPECT_EQ(refusal({10.0, 101.0, 800.0}), "axis x: a velocity of 101 rad/s is not within its limit of 100 rad/s");
  EXPECT_EQ(refusal({10.0, 10.0, 1001.0}),
            "axis x: an acceleration of 1001 rad/s² is not within its limit of 1000 rad/s²");
  EXPECT_THAT(refusal({10.0, 0.0, 800.0}), HasSubstr("a velocity of 0 rad/s is not within"));
  EXPECT_THAT(refusal({0.0, 10.0, 800.0}), HasSubstr("a distance of 0 rad is not above 0 and below"));
  EXPECT_THAT(refusal({10.0, 1e-3, 800.0}), HasSubstr("a shorter distance or a higher velocity is needed"));
}

}  // namespace
}  // namespace driveline::runtime
