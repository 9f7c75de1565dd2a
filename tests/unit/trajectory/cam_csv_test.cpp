#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <utility>

#include "driveline/trajectory/cam.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kPi = std::numbers::pi;

std::string complaint(std::string_view text, CamMethod method = CamMethod::kCubic, CamKind kind = CamKind::kPeriodic) {
  const auto table = parse_cam_csv(text, "c.csv");
  if (!table) return table.error().message();
  const auto cam = Cam::make(*table, method, kind);
  return cam ? "" : cam.error().message();
}

TEST(CamCsv, ConvertsPositionsAndDerivativesToSi) {
  const auto table = parse_cam_csv(
      "# a cam\r\nslave[mm],master[deg],slave[mm/deg],slave[mm/deg^2]\r\n1,0,2,3\r\n5,180,0,0\r\n", "c.csv");
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_TRUE(table->gives_slope);
  EXPECT_TRUE(table->gives_curvature);
  ASSERT_EQ(table->points.size(), 2U);
  EXPECT_EQ(table->points[1].master, kPi);
  EXPECT_EQ(table->points[1].slave, 5e-3);
  EXPECT_EQ(table->points[1].line, 4U);
  EXPECT_DOUBLE_EQ(table->points[0].slope, 2e-3 * 180.0 / kPi);
  EXPECT_DOUBLE_EQ(table->points[0].curvature, 3e-3 * 180.0 / kPi * 180.0 / kPi);
}

TEST(CamCsv, FilesAreReadAndMissingOnesNamed) {
  const auto missing = load_cam_table("/nowhere/cam.csv");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message(), "/nowhere/cam.csv: cannot be read: No such file or directory");
}

TEST(CamBadInput, HasOneSentenceWithLineAndColumn) {
  const std::string head = "master[deg],slave[mm]\n";
  const std::pair<std::string, std::string> cases[] = {
      {"", "c.csv:1: the file has no header row such as master[rad],slave[mm]"},
      {"master[deg];slave[mm]\n",
       "c.csv:1: the separator is a comma, and numbers have a decimal point: master[rad],slave[mm]"},
      {"0,0\n", "c.csv:1:1: column '0' must be a name and a unit such as master[rad]"},
      {"master[s],slave[mm]\n",
       "c.csv:1:1: unknown unit 's' of column 'master'; expected rad, deg, rev, m, mm or um, for slopes a quotient "
       "such as mm/deg, for curvatures mm/deg^2"},
      {"master[deg],x[mm]\n", "c.csv:1:13: column 'x[mm]' is unknown; a cam has master[...] and slave[...]"},
      {"master[deg/deg],slave[mm]\n",
       "c.csv:1:1: column 'master[deg/deg]' is unknown; a cam has master[...] and slave[...]"},
      {"slave[mm]\n", "c.csv:1: the header has no positions of the master; it must be such as master[rad],slave[mm]"},
      {"master[deg]\n", "c.csv:1: the header has no positions of the slave; it must be such as master[rad],slave[mm]"},
      {"master[deg],slave[mm],slave[um]\n", "c.csv:1:23: the positions of the slave appear twice"},
      {"master[deg],slave[mm],slave[mm/mm]\n",
       "c.csv:1:23: the slopes of the slave must fit a slave in mm and a master in deg"},
      {"master[deg],slave[mm],slave[mm/deg^2]\n", "c.csv:1:23: the curvatures of the slave need slopes as well"},
      {head + "0,0,1\n",
       "c.csv:2: expected 2 fields as in the header, found 3; the separator is a comma, and numbers have a decimal "
       "point"},
      {head + "0,nan\n", "c.csv:2:3: 'nan' is not a finite number"},
      {head + "0,1e999\n", "c.csv:2:3: '1e999' is beyond the range of a double"},
      {head + "0,1e13\n1,0\n",
       "c.csv:2: a value of the point is not finite, or beyond +-1e9 rad or m (derivatives: 1e12)"},
      {head, "c.csv: a cam of 0 points is not possible: 2 to 1000000 are expected"},
      {head + "0,0\n", "c.csv: a cam of 1 points is not possible: 2 to 1000000 are expected"},
      {head + "0,0\n90,5\n90,6\n360,0\n", "c.csv:4: the master is at 90 deg twice in a row: a cam has one point there"},
      {head + "0,0\n90,5\n80,6\n360,0\n",
       "c.csv:4: the master goes back from 90 deg to 80 deg: its positions must rise"},
      {head + "0,1\n90,5\n360,1.5\n", "c.csv:4: the cam does not close: its slave begins at 1 mm and ends at 1.5 mm"},
  };
  for (const auto& [text, sentence] : cases) EXPECT_EQ(complaint(text), sentence) << text;
}

TEST(CamBadInput, DerivativesMustCloseWhereTheMethodUsesThem) {
  const std::string open_velocity = "master[deg],slave[mm],slave[mm/deg]\n0,0,0.5\n90,5,0\n360,0,0.25\n";
  EXPECT_EQ(
      complaint(open_velocity),
      "c.csv:4: the cam does not close in velocity: it begins with the slope 0.5 mm/deg and ends with 0.25 mm/deg");
  EXPECT_EQ(complaint(open_velocity, CamMethod::kSpline), "");
  EXPECT_EQ(complaint(open_velocity, CamMethod::kCubic, CamKind::kOneShot),
            "c.csv:2: a one-shot cam must start and end at rest, but its slope is 0.5 mm/deg");
  const std::string open_acceleration =
      "master[deg],slave[mm],slave[mm/deg],slave[mm/deg^2]\n0,0,0,0.5\n90,5,0,0\n360,2,0,0.25\n";
  EXPECT_EQ(complaint(open_acceleration, CamMethod::kQuintic, CamKind::kAdvancing),
            "c.csv:4: the cam does not close in acceleration: it begins with the curvature 0.5 mm/deg^2 and ends with "
            "0.25 mm/deg^2");
  EXPECT_EQ(complaint(open_acceleration, CamMethod::kCubic, CamKind::kAdvancing), "");
  EXPECT_EQ(complaint(open_acceleration, CamMethod::kQuintic, CamKind::kOneShot),
            "c.csv:2: a one-shot cam must start and end at rest, but its curvature is 0.5 mm/deg^2");
}

TEST(CamBadInput, APeriodicSplineNeedsThreePoints) {
  const std::string two = "master[deg],slave[mm]\n0,0\n360,0\n";
  EXPECT_EQ(complaint(two, CamMethod::kSpline), "c.csv: a cam of 2 points is not possible: 3 to 1000000 are expected");
  EXPECT_EQ(complaint(two, CamMethod::kSpline, CamKind::kOneShot), "");
}

}  // namespace
}  // namespace driveline::trajectory
