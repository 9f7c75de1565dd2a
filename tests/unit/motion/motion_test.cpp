#include "driveline/motion/path/motion.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path.hpp"

namespace driveline::motion {
namespace {

trajectory::Interpolator path_of(std::size_t axes) {
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < axes; ++i) EXPECT_TRUE(builder.add_axis({std::to_string(i)}));
  const std::vector<double> positions(axes, 1.0);
  EXPECT_TRUE(builder.add_point(0.0, positions));
  EXPECT_TRUE(builder.add_point(1.0, positions));
  return trajectory::Interpolator::linear(builder.build().value());
}

std::vector<Axis> axes_with(trajectory::AxisLimits limits) {
  AxisConfig config;
  config.limits = limits;
  std::vector<Axis> axes;
  axes.emplace_back(config, ImagePlace{0, 0}, axis_pdo_configuration());
  return axes;
}

TEST(Motion, RefusesAPathWithAnotherNumberOfAxes) {
  EXPECT_THROW(Motion(axes_with({1.0, 1.0}), path_of(2), {}), std::invalid_argument);
}

TEST(Motion, RefusesLimitsThatNoApproachCanBePlannedWith) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_NO_THROW(Motion(axes_with({1.0, 1.0}), path_of(1), {}));
  EXPECT_THROW(Motion(axes_with({kInfinity, 1.0}), path_of(1), {}), std::invalid_argument);
  EXPECT_THROW(Motion(axes_with({1.0, kInfinity}), path_of(1), {}), std::invalid_argument);
  EXPECT_THROW(Motion(axes_with({0.0, 1.0}), path_of(1), {}), std::invalid_argument);
  EXPECT_THROW(Motion(axes_with({1.0, -1.0}), path_of(1), {}), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::motion
