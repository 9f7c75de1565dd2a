// Every possible error in the path of a line, with the whole sentence.
#include "driveline/runtime/config/axis_path.hpp"

#include <gmock/gmock.h>

#include <chrono>

#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

class AxisPath : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    config.slaves.resize(2);
    config.axes.resize(2);
    config.axes[0].name = "x";
    config.axes[0].increments_per_unit = 1000.0;
    config.axes[0].limits = {10.0, 1000.0};
    config.axes[1] = config.axes[0];
    config.axes[1].name = "z";
    config.axes[1].kind = trajectory::AxisKind::kLinear;
    config.path = PathConfig{};
    config.path->file = directory / "path.csv";
  }

  auto load(std::string_view csv) {
    write(config.path->file, csv);
    return load_axis_path(config);
  }
  /// The sentence without the file name in front.
  std::string complaint(std::string_view csv) {
    const auto path = load(csv);
    if (path) return "none";
    const auto file = config.path->file.string();
    EXPECT_EQ(describe(path.error()).substr(0, file.size()), file);
    return describe(path.error()).substr(file.size());
  }

  LineConfig config;
};

TEST_F(AxisPath, ColumnsMayComeInAnyOrder) {
  auto path = must(load("time[s],z[mm],x[rad]\n0,1000,2\n1,1000,2\n"));
  std::vector<trajectory::AxisSetpoint> setpoints(2);
  path->evaluate(0.5, setpoints);
  EXPECT_DOUBLE_EQ(setpoints[0].position, 2.0);
  EXPECT_DOUBLE_EQ(setpoints[1].position, 1.0);
}

TEST_F(AxisPath, FileThatIsNotThere) {
  EXPECT_THAT(describe(load_axis_path(config).error()), testing::StartsWith(config.path->file.string() + ": "));
}

TEST_F(AxisPath, TimeThatDoesNotRiseIsFoundByLine) {
  EXPECT_THAT(complaint("time[s],x[rad],z[m]\n0,0,0\n1,0,0\n1,0,0\n"), testing::StartsWith(":4:"));
}

TEST_F(AxisPath, ColumnOfNoAxis) {
  EXPECT_EQ(complaint("time[s],x[rad],z[m],w[m]\n0,0,0,0\n1,0,0,0\n"), ": there is no [[axis]] for column \"w\"");
}

TEST_F(AxisPath, ColumnThatIsMissing) {
  EXPECT_EQ(complaint("time[s],x[rad]\n0,0\n1,0\n"), ": there is no column for axis \"z\"");
  EXPECT_EQ(complaint("time[s],x[rad],y[m]\n0,0,0\n1,0,0\n"), ": there is no column for axis \"z\"");
  EXPECT_EQ(complaint("time[s],x[rad],Z[m]\n0,0,0\n1,0,0\n"),
            ": there is no column for axis \"z\"; there is \"Z\", and upper and lower case differ");
}

TEST_F(AxisPath, LengthForARotaryAxisAndAngleForALinearOne) {
  EXPECT_EQ(complaint("time[s],x[mm],z[m]\n0,0,0\n1,0,0\n"),
            ": column \"x\" is in mm but the axis is rotary (feed_mm_per_revolution makes it linear)");
  EXPECT_EQ(complaint("time[s],x[rad],z[deg]\n0,0,0\n1,0,0\n"), ": column \"z\" is in deg but the axis is linear");
}

TEST_F(AxisPath, PositionBeyond32Bits) {
  config.axes[0].limits = {1e9, 1e9};
  EXPECT_EQ(complaint("time[s],x[rad],z[m]\n0,2147483.647,0\n1,2147483.647,0\n"), "none");
  EXPECT_EQ(complaint("time[s],x[rad],z[m]\n0,2147483.647,0\n1,2147483.648,0\n"),
            ": axis \"x\" leaves the 32-bit range of its increments at 1 s");
  EXPECT_EQ(complaint("time[s],x[rad],z[m]\n0,-2147483.648,0\n1,0,0\n"),
            ": axis \"x\" leaves the 32-bit range of its increments at 0 s");
}

TEST_F(AxisPath, LimitsOfTheAxis) {
  config.axes[1].limits = {10.0, 1e6};
  EXPECT_THAT(complaint("time[s],x[rad],z[m]\n0,0,0\n0.1,0,5\n0.2,0,10\n"),
              testing::AllOf(testing::StartsWith(": "), testing::HasSubstr("z"), testing::HasSubstr("velocity"),
                             testing::HasSubstr("10 m/s")));
  config.axes[1].limits = {1e3, 10.0};
  EXPECT_THAT(complaint("time[s],x[rad],z[m]\n0,0,0\n0.1,0,5\n0.2,0,10\n"), testing::HasSubstr("acceleration"));
}

TEST_F(AxisPath, SoftwareLimits) {
  config.axes[0].limits = {1e3, 1e6};
  config.axes[0].software_limits = trajectory::PositionRange{-1.0, 2.0};
  EXPECT_EQ(complaint("time[s],x[rad],z[m]\n0,-1,0\n1,2,0\n2,-1,0\n"), "none");
  EXPECT_EQ(complaint("time[s],x[rad],z[m]\n0,0,0\n1,2.5,0\n2,0,0\n"),
            ": axis \"x\" would go to 2.5 rad at 1 s; its max_position is 2 rad");
  config.axes[0].unit = nullptr;
  EXPECT_EQ(complaint("time[s],x[deg],z[m]\n0,0,0\n1,-90,0\n2,0,0\n"),
            ": axis \"x\" would go to -90 deg at 1 s; its min_position is -57.2958 deg");
  EXPECT_THAT(complaint("time[s],x[rad],z[m]\n0,0,0\n1,2,0\n2,2,0\n3,0,0\n"),
              testing::HasSubstr("its max_position is 2 rad"))
      << "a spline that overshoots its points";
  config.path->relative = true;
  EXPECT_EQ(complaint("time[s],x[rad],z[m]\n0,0,0\n1,2.5,0\n2,0,0\n"), "none") << "it is not known where it begins";
}

TEST_F(AxisPath, UnitIsThatOfTheColumnUnlessTheLineSaysOne) {
  ASSERT_TRUE(load("time[s],z[mm],x[deg]\n0,1000,2\n1,1000,2\n"));
  EXPECT_EQ(motion::position_unit(config.axes[0]).name, "deg");
  EXPECT_EQ(motion::position_unit(config.axes[1]).name, "mm");
  config.axes[1].unit = trajectory::find_position_unit("um");
  ASSERT_TRUE(load("time[s],z[mm],x[deg]\n0,1000,2\n1,1000,2\n"));
  EXPECT_EQ(motion::position_unit(config.axes[1]).name, "um");
}

TEST_F(AxisPath, LimitsAreToldInTheUnitOfTheAxis) {
  config.axes[1].limits = {0.01, 1e6};
  const auto* const path = "time[s],x[rad],z[mm]\n0,0,0\n1,0,0\n1.5,0,10\n2,0,20\n3,0,20\n";
  EXPECT_THAT(complaint(path),
              testing::AllOf(testing::HasSubstr(" mm/s at "), testing::HasSubstr("its limit is 10 mm/s")));
  config.axes[1].unit = trajectory::find_position_unit("um");
  EXPECT_THAT(complaint(path), testing::HasSubstr("its limit is 10000 um/s"));
}

TEST_F(AxisPath, CornersOfALinearPathAreLeftToTheDrives) {
  const auto corner = "time[s],x[rad],z[m]\n0,0,0\n1,5,0\n2,0,0\n";
  config.axes[0].limits.max_acceleration = 10.0;
  EXPECT_THAT(complaint(corner), testing::HasSubstr("acceleration"));
  config.path->interpolation = trajectory::InterpolationMethod::kLinear;
  EXPECT_EQ(complaint(corner), "none");
  config.axes[0].limits.max_velocity = 4.0;
  EXPECT_THAT(complaint(corner), testing::HasSubstr("velocity"));
}

TEST_F(AxisPath, HeldPointsThatJumpAreRefused) {
  config.path->interpolation = trajectory::InterpolationMethod::kHold;
  config.axes[1].limits = {8.0, 1e9};
  config.period = std::chrono::milliseconds{1};
  EXPECT_EQ(complaint("time[s],x[rad],z[mm]\n0,0,0\n0.5,0,20\n1,0,20\n"),
            ": axis 'z' would jump from point to point and need a velocity of 20000 mm/s at 0.5 s; its limit is 8000 "
            "mm/s");
  EXPECT_EQ(complaint("time[s],x[rad],z[mm]\n0,0,5\n0.5,0,5\n1,0,5\n"), "none");
}

TEST_F(AxisPath, VelocitiesGoWithTheirAxis) {
  config.path->interpolation = trajectory::InterpolationMethod::kHermite;
  config.axes[0].limits = config.axes[1].limits = {1e3, 1e9};
  auto path = must(load("x[rad/s],time[s],z[mm],x[rad],x[rad/s^2]\n2,0,7,1,0\n2,1,7,1,5\n"));
  std::vector<trajectory::AxisSetpoint> setpoints(2);
  path->evaluate(0.25, setpoints);
  EXPECT_DOUBLE_EQ(setpoints[0].position, 1.0 + 0.1875);  // 2 t (1 - t) (1 - 2 t)
  EXPECT_DOUBLE_EQ(setpoints[1].position, 7e-3);
}

TEST_F(AxisPath, InterpolationIsTheConfiguredOne) {
  // Half way between a point at rest and the next: a straight line is at the middle, a clamped spline is not.
  const auto csv = "time[s],x[rad],z[m]\n0,0,0\n1,1,0\n2,0,0\n";
  config.axes[0].limits.max_acceleration = 1e6;  // only the clamped one starts at standstill
  auto position = [&](trajectory::InterpolationMethod kind) {
    config.path->interpolation = kind;
    std::vector<trajectory::AxisSetpoint> setpoints(2);
    load(csv).value().evaluate(0.25, setpoints);
    return setpoints[0].position;
  };
  const double linear = position(trajectory::InterpolationMethod::kLinear);
  const double natural = position(trajectory::InterpolationMethod::kNaturalSpline);
  const double clamped = position(trajectory::InterpolationMethod::kClampedSpline);
  EXPECT_DOUBLE_EQ(linear, 0.25);
  EXPECT_NEAR(natural, 0.3671875, 1e-12);  // 1.5 t - 0.5 t^3
  EXPECT_NEAR(clamped, 0.15625, 1e-12);    // 3 t^2 - 2 t^3
}

}  // namespace
}  // namespace driveline::runtime
