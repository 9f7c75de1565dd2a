#include "driveline/trajectory/path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::require;

using testing::ElementsAre;

PathBuilder two_axes() {
  PathBuilder builder;
  require(builder.add_axis({"x", AxisKind::kRotary}));
  require(builder.add_axis({"y", AxisKind::kLinear}));
  return builder;
}

std::string refusal(const tl::expected<void, PathError>& result) {
  return result ? "accepted" : result.error().message();
}

TEST(PathBuilder, KeepsAxesTimesAndPositions) {
  PathBuilder builder = two_axes();
  require(builder.add_point(-1.5, std::array{1.0, 2.0}));
  require(builder.add_point(2.0, std::array{3.0, 4.0}));
  const Path path = builder.build().value();

  ASSERT_EQ(path.axes().size(), 2U);
  EXPECT_EQ(path.axes()[0].name, "x");
  EXPECT_EQ(path.axes()[0].kind, AxisKind::kRotary);
  EXPECT_EQ(path.axes()[1].name, "y");
  EXPECT_EQ(path.axes()[1].kind, AxisKind::kLinear);
  EXPECT_THAT(path.times_s(), ElementsAre(-1.5, 2.0));
  EXPECT_THAT(path.positions(0), ElementsAre(1.0, 2.0));
  EXPECT_THAT(path.positions(1), ElementsAre(3.0, 4.0));
  EXPECT_EQ(path.start_s(), -1.5);
  EXPECT_EQ(path.end_s(), 2.0);
  EXPECT_EQ(path.duration_s(), 3.5);
}

TEST(PathBuilder, RefusesWhatIsNoPoint) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PathBuilder builder = two_axes();
  require(builder.add_point(1.0, std::array{0.0, 0.0}));
  EXPECT_EQ(refusal(builder.add_point(2.0, std::array{0.0})), "expected 2 positions, found 1");
  EXPECT_EQ(refusal(builder.add_point(kNan, std::array{0.0, 0.0})), "time nan s is not within +-1e+05 s");
  EXPECT_EQ(refusal(builder.add_point(100000.1, std::array{0.0, 0.0})), "time 100000.1 s is not within +-1e+05 s");
  EXPECT_EQ(refusal(builder.add_point(1.0, std::array{0.0, 0.0})),
            "time 1 s does not come after the previous time 1 s");
  EXPECT_EQ(refusal(builder.add_point(1.0 + 5e-10, std::array{0.0, 0.0})),
            "time 1.0000000005 s comes less than 1 ns after the previous time 1 s");
  EXPECT_EQ(refusal(builder.add_point(2.0, std::array{kNan, 0.0})),
            "position nan rad of axis 'x' is not within +-1e+09 rad");
  EXPECT_EQ(refusal(builder.add_point(2.0, std::array{0.0, -2e9})),
            "position -2e+09 m of axis 'y' is not within +-1e+09 m");
  // None of these has had an effect.
  require(builder.add_point(1.5, std::array{1.0, 1.0}));
  EXPECT_EQ(builder.build().value().points(), 2U);
}

TEST(PathBuilder, AcceptsTheLimitsThemselves) {
  PathBuilder builder = two_axes();
  EXPECT_EQ(refusal(builder.add_point(-kMaxPathTimeS, std::array{kMaxPathPosition, -kMaxPathPosition})), "accepted");
  EXPECT_EQ(refusal(builder.add_point(kMaxPathTimeS, std::array{-kMaxPathPosition, kMaxPathPosition})), "accepted");
  EXPECT_TRUE(builder.build().has_value());
}

TEST(PathBuilder, RefusesWhatIsNoAxis) {
  PathBuilder builder = two_axes();
  const std::string rule =
      " must be 1 to 31 characters out of letters a to z and A to Z, digits and _-., and not be time";
  EXPECT_EQ(refusal(builder.add_axis({"x", AxisKind::kRotary})), "axis name 'x' appears twice");
  EXPECT_EQ(refusal(builder.add_axis({"", AxisKind::kRotary})), "axis name ''" + rule);
  EXPECT_EQ(refusal(builder.add_axis({"a\nb", AxisKind::kRotary})), "axis name 'a?b'" + rule);
  EXPECT_EQ(refusal(builder.add_axis({"time", AxisKind::kRotary})), "axis name 'time'" + rule);
  EXPECT_EQ(refusal(builder.add_axis({"Time", AxisKind::kRotary})), "accepted");
  const std::string long_name(31, 'n');
  EXPECT_EQ(refusal(builder.add_axis({long_name, AxisKind::kRotary})), "accepted");
  EXPECT_EQ(refusal(builder.add_axis({long_name + "n", AxisKind::kRotary})), "axis name '" + long_name + "n'" + rule);
  require(builder.add_point(0.0, std::array{0.0, 0.0, 0.0, 0.0}));
  EXPECT_EQ(refusal(builder.add_axis({"late", AxisKind::kRotary})), "axes must be declared before the first point");
}

TEST(PathBuilder, TakesDerivativesOfTheAxesThatGiveThem) {
  PathBuilder builder;
  require(builder.add_axis({"x", AxisKind::kRotary, nullptr, true, true}));
  require(builder.add_axis({"y", AxisKind::kLinear, nullptr, false, false}));
  EXPECT_EQ(refusal(builder.add_axis({"z", AxisKind::kLinear, nullptr, false, true})),
            "axis 'z' has accelerations but no velocities");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::array two{1.0, kNan};  // y gives none: existing ones are left out
  const std::array positions{1.0, 2.0};
  EXPECT_EQ(refusal(builder.add_point(0.0, positions)), "expected 2 velocities, found 0");
  EXPECT_EQ(refusal(builder.add_point({0.0, positions, two, std::array{1.0}})), "expected 2 accelerations, found 1");
  EXPECT_EQ(refusal(builder.add_point({0.0, positions, std::array{kNan, 0.0}, two})),
            "velocity nan rad/s of axis 'x' is not within +-1e+12 rad/s");
  EXPECT_EQ(refusal(builder.add_point({0.0, positions, two, std::array{2e15, 0.0}})),
            "acceleration 2e+15 rad/s^2 of axis 'x' is not within +-1e+15 rad/s^2");
  require(builder.add_point({0.0, positions, two, two}));
  require(builder.add_point({1.0, positions, std::array{-1e12, 0.0}, std::array{-1e15, 0.0}}));
  const Path path = builder.build().value();
  EXPECT_EQ(path.velocities(0)[0], 1.0);
  EXPECT_EQ(path.velocities(0)[1], 0.0);
  EXPECT_EQ(path.accelerations(1)[0], -1e15);
}

TEST(PathBuilder, RefusesAPathWithoutMotion) {
  PathBuilder empty;
  EXPECT_EQ(refusal(empty.add_point(0.0, {})), "a path needs at least one axis");
  EXPECT_EQ(empty.build().error().message(), "a path needs at least 2 points, found 0");
  PathBuilder builder = two_axes();
  require(builder.add_point(1.0, std::array{0.0, 0.0}));
  EXPECT_EQ(builder.build().error().message(), "a path needs at least 2 points, found 1");
}

TEST(PathBuilder, LimitsTheMemory) {
  PathBuilder builder;
  for (std::size_t i = 0; i < kMaxPathAxes; ++i) {
    require(builder.add_axis({test::axis_name(i), AxisKind::kRotary}));
  }
  EXPECT_EQ(refusal(builder.add_axis({"more", AxisKind::kRotary})), "a path may have at most 256 axes");
  const std::array<double, kMaxPathAxes> positions{};
  for (std::size_t i = 0; i < kMaxPathValues / kMaxPathAxes; ++i) {
    ASSERT_TRUE(builder.add_point(static_cast<double>(i), positions).has_value());
  }
  EXPECT_EQ(refusal(builder.add_point(99999.0, positions)),
            "a path may have at most 8000000 positions (points times axes)");
  EXPECT_EQ(builder.build().value().points(), kMaxPathValues / kMaxPathAxes);
}

TEST(PathError, NamesOnlyThePlaceItKnows) {
  EXPECT_EQ((PathError{"", 0, 0, "why"}.message()), "why");
  EXPECT_EQ((PathError{"f.csv", 0, 0, "why"}.message()), "f.csv: why");
  EXPECT_EQ((PathError{"f.csv", 3, 0, "why"}.message()), "f.csv:3: why");
  EXPECT_EQ((PathError{"f.csv", 3, 14, "why"}.message()), "f.csv:3:14: why");
}

}  // namespace
}  // namespace driveline::trajectory
