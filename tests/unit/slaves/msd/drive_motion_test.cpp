#include "driveline/slaves/msd/core/drive_motion.hpp"

#include <gtest/gtest.h>

namespace driveline::slaves::msd {
namespace {

/// Motor at rest that follows a position of the bus in every eighth control cycle.
class Follower : public testing::Test {
 protected:
  Follower() {
    settings_.scaling.position_rad = 0.02;
    settings_.scaling.units_per_increment = Ratio::of(1, 4096);
    settings_.scaling.increments_per_unit = Ratio::of(4096, 1);
    settings_.steps_per_setpoint = 8;
  }

  void follow(const Setpoints& setpoints) {
    motion_.configure(settings_);
    motion_.select(MotionCommand::kFollow, MotionSource::kCyclicPosition, false);
    for (int i = 0; i < 64; ++i) {
      if (i % 8 == 0) motion_.set(setpoints);
      motion_.step(false);
    }
  }

  MotionSettings settings_;
  DriveMotion motion_{MotorParameters{}, 0.0};
};

TEST_F(Follower, FollowsAFractionOfAPositionUnit) {
  follow({.position = 3, .position_fraction = 0.375});
  EXPECT_NEAR(motion_.position_demand(), 3.375, 1e-9);
}

TEST_F(Follower, StandsAtASoftwareLimitWithoutAFraction) {
  settings_.position_limited = true;
  settings_.position_min = -2;
  settings_.position_max = 2;
  follow({.position = 3, .position_fraction = 0.375});
  EXPECT_NEAR(motion_.position_demand(), 2.0, 1e-9);
  EXPECT_TRUE(motion_.limited());
}

}  // namespace
}  // namespace driveline::slaves::msd
