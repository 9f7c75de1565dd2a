// The extent of a path, including the parts between its points.
#include "driveline/trajectory/path_extent.hpp"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

namespace driveline::trajectory {
namespace {

Interpolator path_of(InterpolationMethod method) {
  PathBuilder builder;
  EXPECT_TRUE(builder.add_axis({"x", AxisKind::kRotary}));
  EXPECT_TRUE(builder.add_axis({"y", AxisKind::kRotary}));
  for (const auto& [time_s, x] : {std::pair{1.0, 0.0}, {2.0, 1.0}, {3.0, 1.0}, {4.0, -2.0}}) {
    EXPECT_TRUE(builder.add_point(time_s, std::array{x, 5.0}));
  }
  return Interpolator::make(builder.build().value(), method);
}

TEST(PathExtents, AreThoseOfThePointsOfALinearPath) {
  auto path = path_of(InterpolationMethod::kLinear);
  const auto extents = path_extents(path, 0.125);
  ASSERT_EQ(extents.size(), 2U);
  EXPECT_DOUBLE_EQ(extents[0].lowest, -2.0);
  EXPECT_DOUBLE_EQ(extents[0].highest, 1.0);
  EXPECT_DOUBLE_EQ(extents[0].lowest_at_s, 4.0);
  EXPECT_DOUBLE_EQ(extents[0].highest_at_s, 2.0);
  EXPECT_DOUBLE_EQ(extents[1].lowest, 5.0);
  EXPECT_DOUBLE_EQ(extents[1].highest, 5.0);
}

TEST(PathExtents, HaveWhatASplineOvershoots) {
  auto path = path_of(InterpolationMethod::kClampedSpline);
  const auto extents = path_extents(path, 1e-3);
  EXPECT_GT(extents[0].highest, 1.05);
  EXPECT_GT(extents[0].highest_at_s, 2.0);
  EXPECT_LT(extents[0].highest_at_s, 3.0);
}

TEST(PathExtents, FitARangeWhereverTheyAreMoved) {
  const PathExtent extent{-1.0, 2.0, 0.0, 0.0};
  EXPECT_TRUE(fits(extent, {-1.0, 2.0}));
  EXPECT_FALSE(fits(extent, {-0.999, 2.0}));
  EXPECT_FALSE(fits(extent, {-1.0, 1.999}));
  EXPECT_TRUE(fits(extent, {9.0, 12.0}, 10.0));
  EXPECT_FALSE(fits(extent, {9.0, 12.0}, 10.1));
  EXPECT_TRUE(fits(extent, {-1.0, 2.0}, 1e-12)) << "rounding";
}

TEST(PathExtents, NeedAPeriod) {
  auto path = path_of(InterpolationMethod::kLinear);
  EXPECT_THROW(static_cast<void>(path_extents(path, 0.0)), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::trajectory
