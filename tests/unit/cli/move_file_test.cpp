#include "text/move_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "support/must.hpp"
#include "support/temporary_directory.hpp"

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
  const auto file = must(parse_moves(kMoveAxes + R"({"line": [3, null], "feed": 100, "tolerance": 0.5})" + "\n\n" +
                                         R"({"line_by": [1, 1]})" + "\n" +
                                         R"({"arc": [4, 5], "center": [4, 4], "clockwise": true, "plane": ["y", "x"]})",
                                     "f"));
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
  EXPECT_EQ(move_refusal("{}"),
            "f:2: a move is one of line, line_by, arc, spline and polyline, or has a dwell or outputs");
  EXPECT_EQ(move_refusal(R"({"line": [1]})"), "f:2: line must be an array of 2 numbers, one for each axis");
  EXPECT_EQ(move_refusal(R"({"line": [1, "a"]})"), "f:2: line of axis y must be a number");
  EXPECT_EQ(move_refusal(R"({"line": [1, 2], "feet": 3})"),
            "f:2: there is no key \"feet\" here; did you mean \"feed\"?");
  EXPECT_EQ(move_refusal(R"({"arc": [1, 2]})"), "f:2: an arc needs either center or via, a point of the arc");
  EXPECT_EQ(move_refusal(R"({"arc": [1, 2], "center": [0, 0], "plane": ["x", "q"]})"), "f:2: there is no axis \"q\"");
  EXPECT_EQ(move_refusal(R"({"spline": []})"), "f:2: spline must be an array of at least one point");
  EXPECT_EQ(move_refusal(""), "f: there is no move");
  EXPECT_EQ(parse_moves("", "f").error(), "f: the line that describes the axes is missing");
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
  EXPECT_EQ(refused.error(), "f:1: the first position of axis 1 is 2e+06; positions lie within +-1e6 m or rad");
}

TEST(MoveFile, AMoveMayDwellAndChangeOutputs) {
  const auto file = must(parse_moves(
      R"({"axes": [{"name": "x", "unit": "mm", "max_velocity": 1, "max_acceleration": 1, "max_jerk": 1}],)"
      R"( "outputs": ["glue", "light"]})"
      "\n"
      R"({"line": [5], "dwell": 0.5, "outputs": [{"name": "light", "value": true, "at": -2}, {"name": "glue", "value": 3}]})"
      "\n"
      R"({"dwell": 1})",
      "f"));
  const auto& move = file->moves[0].move;
  EXPECT_EQ(move.dwell_s, 0.5);
  ASSERT_EQ(move.outputs.size(), 2U);
  EXPECT_EQ(move.outputs[0].change.output, 1U);
  EXPECT_EQ(move.outputs[0].change.value, 1.0);
  EXPECT_EQ(move.outputs[0].at, -0.002);
  EXPECT_EQ(move.outputs[1].change.output, 0U);
  EXPECT_EQ(move.outputs[1].at, std::numeric_limits<double>::infinity());
  // A dwell of one move is not inherited by the next.
  EXPECT_EQ(file->moves[1].move.dwell_s, 1.0);
  EXPECT_TRUE(file->moves[1].move.outputs.empty());
  EXPECT_EQ(file->moves[1].move.target[0], 0.005);
}

const std::string kScaraJoint = R"("max_velocity": 360, "max_acceleration": 3600, "max_jerk": 90000)";

/// A SCARA robot; `more` adds keys to its first joint.
std::string scara_line(const std::string& more, const std::string& kinematics, const std::string& rest) {
  return R"({"kinematics": {"type": "scara", )" + kinematics + R"(}, "axes": [{"name": "j1", "unit": "deg", )" +
         kScaraJoint + more + R"(}, {"name": "j2", "unit": "deg", )" + kScaraJoint +
         R"(}, {"name": "lift", "unit": "mm", "max_velocity": 500, "max_acceleration": 5000, "max_jerk": 1e5}, )" +
         R"({"name": "j4", "unit": "deg", )" + kScaraJoint + R"(}], "start": [400, 0, 0, 0])" + rest + "}\n";
}

const std::string kArms = R"("unit": "mm", "upper_arm": 350, "forearm": 250)";
const std::string kToolLimit = R"(, "tool": {"max_velocity": 2000})";

TEST(MoveFile, AMachineHasCoordinatesOfItsOwn) {
  const auto file = must(parse_moves(scara_line(R"(, "min_position": -120, "max_position": 120)", kArms, kToolLimit) +
                                         R"({"line": [400, 100, -50, 90], "feed": 300})",
                                     "f"));
  ASSERT_EQ(file->coordinates.size(), 4U);
  EXPECT_EQ(file->coordinates[0].name, "x");
  EXPECT_EQ(file->coordinates[3].unit->name, "deg");
  EXPECT_EQ(file->moves[0].move.target[0], 0.4);
  EXPECT_DOUBLE_EQ(file->moves[0].move.feed, 0.3);
  EXPECT_EQ(file->settings.tool.max_velocity, 2.0);
  EXPECT_NEAR(file->settings.limits[0].max_position, 2.0944, 1e-4);
  EXPECT_EQ(refusal_of(*file, "f"), "");
}

TEST(MoveFile, PlacesThatAMachineCannotHaveAreRefusedWithFileAndLine) {
  const auto refused = [](const std::string& text) {
    const auto file = parse_moves(text, "f");
    return file ? refusal_of(*file, "f") : file.error();
  };
  const auto machine = scara_line(R"(, "min_position": -45, "max_position": 45)", kArms, kToolLimit);
  EXPECT_EQ(refused(machine + R"({"line": [400, 10, 0, 0]})" + "\n" + R"({"line": [700, 0, 0, 0]})")
                .find("f:3: the machine cannot reach (0.7, 0, 0, 0): the arms reach from 0.1 m to 0.6 m"),
            0U);
  EXPECT_EQ(refused(machine + R"({"line": [0, 400, 0, 0]})").find("f:2: axis j1 would be at "), 0U);
  EXPECT_EQ(refused(scara_line("", kArms, "")), "f:1: a machine with kinematics needs a velocity limit of its tool");
  EXPECT_EQ(refused(scara_line("", R"("unit": "mm", "upper_arm": 350)", kToolLimit)),
            "f:1: a machine of kind scara needs forearm");
  EXPECT_EQ(refused(scara_line("", R"("upper_arm": 350)", kToolLimit)),
            "f:1: the unit of kinematics must be \"m\", \"mm\" or \"um\"");
  EXPECT_EQ(refused(scara_line("", R"("unit": "mm", "upper_arm": 100, "forearm": 100)", kToolLimit))
                .find("f:1: start: the machine cannot reach (0.4, 0, 0, 0): the arms reach from 0 m to 0.2 m"),
            0U);
  EXPECT_EQ(refused(machine + R"({"line": [1, 2]})"),
            "f:2: line must be an array of 4 numbers, one for each coordinate");
}

/// A file of points in a folder of its own.
class PointFile {
 public:
  explicit PointFile(const std::string& text) { std::ofstream(name()) << text; }

  /// The name of a file of moves beside it.
  [[nodiscard]] std::string beside() const { return (folder_.path / "f").string(); }
  [[nodiscard]] std::string name() const { return (folder_.path / "points.csv").string(); }

 private:
  test::TemporaryFolder folder_;
};

TEST(MoveFile, APolylineGoesThroughThePointsOfACsvFile) {
  for (const std::string text : {"y[mm]\n3\n4\n", "time[s],y[um]\n0,3000\n1,4000\n"}) {
    const PointFile points(text);
    const auto file = must(
        parse_moves(kMoveAxes + R"({"polyline": "points.csv", "tolerance": 0.5})" + "\n" + R"({"line_by": [1, 0]})",
                    points.beside()));
    ASSERT_EQ(file->moves.size(), 3U);
    EXPECT_EQ(file->moves[1].move.target[0], 0.001);
    EXPECT_DOUBLE_EQ(file->moves[1].move.target[1], 0.004);
    EXPECT_DOUBLE_EQ(file->moves[1].move.tolerance, 0.0005);
    EXPECT_EQ(file->moves[1].line, 2U);
    EXPECT_DOUBLE_EQ(file->moves[2].move.target[1], 0.004);
    EXPECT_EQ(refusal_of(*file, "f"), "");
  }
}

TEST(MoveFile, APolylineThatIsNoneIsRefusedWithBothFiles) {
  const auto refused = [](const std::string& text) {
    const PointFile points(text);
    const auto file = parse_moves(kMoveAxes + R"({"polyline": "points.csv", "tolerance": 0.5})", points.beside());
    const auto reason = file ? refusal_of(*file, points.beside()) : file.error();
    EXPECT_EQ(reason.find(points.beside() + ":2: "), 0U) << reason;
    return reason.substr(points.beside().size() + 4);
  };
  EXPECT_NE(refused("x[mm]\n1\nb\n").find("points.csv:3"), std::string::npos);
  EXPECT_EQ(refused("q[mm]\n1\n2\n"), "there is no axis \"q\"");
  EXPECT_EQ(refused("x[deg]\n1\n2\n"), "x of points.csv must be a length");
  EXPECT_EQ(refused("x[mm]\n5\n10\n6\n").find("point 3: the path reverses"), 0U);
  const auto missing = parse_moves(kMoveAxes + R"({"polyline": "nowhere.csv"})", "f");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().find("f:2: nowhere.csv"), 0U) << missing.error();
}

TEST(MoveFile, OutputsThatAreNotKnownAreRefused) {
  const auto refused = [](const std::string& names, const std::string& line) {
    const auto file = parse_moves(
        R"({"axes": [{"name": "x", "unit": "mm", "max_velocity": 1, "max_acceleration": 1, "max_jerk": 1}], "outputs": )" +
            names + "}\n" + line,
        "f");
    return file ? refusal_of(*file, "f") : file.error();
  };
  EXPECT_EQ(refused(R"(["glue"])", R"({"line": [1], "outputs": [{"name": "glut", "value": 1}]})"),
            "f:2: the first line names no output \"glut\"; did you mean \"glue\"?");
  EXPECT_EQ(refused(R"(["glue"])", R"({"line": [1], "outputs": [{"name": "glue"}]})"),
            "f:2: a change of an output needs a name and a value");
  EXPECT_EQ(refused(R"(["glue", "glue"])", ""), "f:1: there are two outputs called \"glue\"");
  EXPECT_EQ(refused(R"(["glue"])", R"({"line": [1], "outputs": [{"name": "glue", "value": 1, "at": 2}]})"),
            "f:2: an output would change 0.002 m after the start of a move that is 0.001 m long");
  EXPECT_EQ(refused(R"(["glue"])", R"({"line": [1], "dwell": -1})"),
            "f:2: the dwell is -1 s; it must be from 0 to 3600 s");
}

}  // namespace
}  // namespace driveline::cli
