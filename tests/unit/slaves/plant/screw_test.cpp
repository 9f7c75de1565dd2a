#include "driveline/slaves/plant/screw.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace driveline::slaves {
namespace {

TEST(Screw, TheLoadStandsWhileTheShaftIsInTheBacklash) {
  Screw screw({.backlash_rad = 0.1}, 1.0);
  screw.turn(2.0);
  EXPECT_DOUBLE_EQ(screw.load_rad(), 2.0);
  screw.turn(1.95);
  EXPECT_DOUBLE_EQ(screw.load_rad(), 2.0);
  screw.turn(1.5);
  EXPECT_DOUBLE_EQ(screw.load_rad(), 1.6);
  screw.turn(1.58);
  EXPECT_DOUBLE_EQ(screw.load_rad(), 1.6);
  screw.turn(1.7);
  EXPECT_DOUBLE_EQ(screw.load_rad(), 1.7);
}

TEST(Screw, HasAWaveAndIsTooLong) {
  const Screw screw({.wave_rad = 0.01, .wave_length_rad = 4.0, .stretch = 0.001}, 0.0);
  EXPECT_DOUBLE_EQ(screw.position_of(1.0), 1.0 + 0.001 + 0.01);
  EXPECT_NEAR(screw.position_of(2.0), 2.0 + 0.002, 1e-15);
  EXPECT_NEAR(screw.position_of(-1.0), -1.0 - 0.001 - 0.01, 1e-15);
}

}  // namespace
}  // namespace driveline::slaves
