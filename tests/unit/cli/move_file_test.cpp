#include "text/move_file.hpp"

#include <gtest/gtest.h>

namespace driveline::cli {
namespace {

const std::string kMoveAxes =
    R"({"axes": [{"name": "x", "unit": "mm", "max_velocity": 1000, "max_acceleration": 1e4, "max_jerk": 1e6},)"
    R"( {"name": "y", "unit": "mm", "max_velocity": 1000, "max_acceleration": 1e4, "max_jerk": 1e6}], "start": [1, 2]})"
    "\n";

std::string move_refusal(const std::string& line) {
  const auto file = parse_moves(kMoveAxes + line, "f");
  return file ? "" : file.error();
}

TEST(MoveFile, ValuesAreInTheUnitsOfTheAxesAndFeedAndToleranceStay) {
  const auto file = parse_moves(kMoveAxes + R"({"line": [3, null], "feed": 100, "tolerance": 0.5})" + "\n\n" +
                                    R"({"line_by": [1, 1]})" + "\n" +
                                    R"({"arc": [4, 5], "center": [4, 4], "clockwise": true, "plane": ["y", "x"]})",
                                "f");
  ASSERT_TRUE(file) << file.error();
  EXPECT_EQ(file->settings.limits[1].max_velocity, 1.0);
  ASSERT_EQ(file->moves.size(), 3U);
  EXPECT_EQ(file->moves[0].move.target[0], 0.003);
  EXPECT_EQ(file->moves[0].move.target[1], 0.002);
  EXPECT_EQ(file->moves[1].line, 4U);
  EXPECT_DOUBLE_EQ(file->moves[1].move.target[0], 0.004);
  EXPECT_DOUBLE_EQ(file->moves[1].move.feed, 0.1);
  EXPECT_DOUBLE_EQ(file->moves[1].move.tolerance, 0.0005);
  EXPECT_TRUE(file->moves[2].move.clockwise);
  EXPECT_EQ(file->moves[2].move.first_axis, 1U);
}

TEST(MoveFile, IsRefusedWithFileAndLine) {
  EXPECT_EQ(move_refusal("{"), "f:2: this is not JSON");
  EXPECT_EQ(move_refusal("[]"), "f:2: a line must be a JSON object, {...}");
  EXPECT_EQ(move_refusal("{}"), "f:2: a move is one of line, line_by, arc and spline");
  EXPECT_EQ(move_refusal(R"({"line": [1]})"), "f:2: line must be an array of 2 numbers, one for each axis");
  EXPECT_EQ(move_refusal(R"({"line": [1, "a"]})"), "f:2: line of axis y must be a number");
  EXPECT_EQ(move_refusal(R"({"line": [1, 2], "feet": 3})"),
            "f:2: there is no key \"feet\" here; did you mean \"feed\"?");
  EXPECT_EQ(move_refusal(R"({"arc": [1, 2]})"), "f:2: an arc needs either its center or a point via which it goes");
  EXPECT_EQ(move_refusal(R"({"arc": [1, 2], "center": [0, 0], "plane": ["x", "q"]})"), "f:2: there is no axis \"q\"");
  EXPECT_EQ(move_refusal(R"({"spline": []})"), "f:2: spline must be an array of at least one point");
  EXPECT_EQ(move_refusal(""), "f: there is no move");
  EXPECT_EQ(parse_moves("", "f").error(), "f: there is no line that describes the axes");
  const auto axis = [](const std::string& limits) {
    return parse_moves(R"({"axes": [{"name": "x", "unit": "mm", )" + limits + "}]}", "f").error();
  };
  EXPECT_EQ(axis(R"("max_velocity": 1, "max_acceleration": 0, "max_jerk": 1)"),
            "f:1: max_acceleration of axis x is 0; it must be above 0");
  EXPECT_EQ(axis(R"("max_velocity": 1, "max_acceleration": 1)"), "f:1: axis x needs max_jerk");
  const std::string far =
      R"({"axes": [{"name": "x", "unit": "m", "max_velocity": 1, "max_acceleration": 1, "max_jerk": 1}],)"
      R"( "start": [2e6]})"
      "\n"
      R"({"line": [1]})";
  const auto refused = parse_moves(far, "f");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), "f:1: the first place of axis 1 is 2e+06; positions lie within +-1e6 m or rad");
}

}  // namespace
}  // namespace driveline::cli
