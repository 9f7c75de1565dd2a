#include "text/picture_scale.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(PictureScale, TicksAreAtRoundNumbersAndLabelsShort) {
  struct Case {
    ValueRange values;
    double low;
    double high;
    double step;
    int power;
    const char* unit;
  };
  // A margin of 4 % on either side, and a fifth of the range, rounded up to 1, 2 or 5, between ticks.
  const Case cases[] = {
      {{0.0, 40.0}, -1.6, 41.6, 10.0, 0, "mm"},
      {{-3.0, 7.0}, -3.4, 7.4, 2.0, 0, "mm"},
      {{0.02, 0.05}, 0.0188, 0.0512, 0.01, 0, "mm"},
      {{-0.0012, 0.0008}, -0.00128, 0.00088, 0.0005, -3, "1e-3 mm"},
      {{0.0, 2.76e-6}, -1.104e-7, 2.8704e-6, 1e-6, -6, "1e-6 mm"},
      {{0.0, 2.5e5}, -1e4, 2.6e5, 5e4, 3, "1e3 mm"},
  };
  for (const auto& each : cases) {
    const auto scale = scale_of(each.values);
    EXPECT_NEAR(scale.low, each.low, 1e-9 * each.step) << each.unit;
    EXPECT_NEAR(scale.high, each.high, 1e-9 * each.step) << each.unit;
    EXPECT_NEAR(scale.step, each.step, 1e-9 * each.step) << each.unit;
    EXPECT_EQ(scale.power, each.power) << each.step;
    EXPECT_EQ(scale.unit("mm"), each.unit);
  }
  EXPECT_NEAR(scale_of({0.0, 2.76e-6}).labelled(2e-6), 2.0, 1e-12);
}

TEST(PictureScale, AValueThatDoesNotChangeHasRoomOnBothSides) {
  const auto far = scale_of({-500.0, -500.0});
  EXPECT_NEAR(far.high - far.low, 0.54, 1e-9) << "a thousandth of the value, and the margins";
  const auto resolved = scale_of({0.5, 0.5}, 0.25);
  EXPECT_NEAR(resolved.low, 0.23, 1e-12) << "a step of 0.25 to either side";
  const auto zero = scale_of({0.0, 0.0});
  EXPECT_EQ(zero.low, -1.0);
  EXPECT_EQ(zero.high, 1.0);
}

TEST(PictureScale, NothingHasARangeAllTheSame) {
  ValueRange values;
  values.include(kNan);
  values.include(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(values.empty());
  EXPECT_LT(scale_of(values).low, scale_of(values).high);
}

class ColumnRanges : public test::TemporaryDirectory {};

TEST_F(ColumnRanges, IgnoreTheFirstLineAndWhatIsNoNumber) {
  write(directory / "some.csv", "time,a,b,c\n0.5,nan,-2e-3,\n1.5,nan,4.25,x\n\n1,3.5\n");
  const auto ranges = column_ranges(directory / "some.csv");
  ASSERT_EQ(ranges.size(), 4U);
  EXPECT_EQ(ranges[0].low, 0.5);
  EXPECT_EQ(ranges[0].high, 1.5);
  EXPECT_EQ(ranges[1].low, 3.5);
  EXPECT_EQ(ranges[1].high, 3.5);
  EXPECT_EQ(ranges[2].low, -2e-3);
  EXPECT_EQ(ranges[2].high, 4.25);
  EXPECT_TRUE(ranges[3].empty());
  EXPECT_TRUE(column_ranges(directory / "none.csv").empty());
}

}  // namespace
}  // namespace driveline::cli
