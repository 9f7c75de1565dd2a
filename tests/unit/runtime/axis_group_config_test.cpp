// [[axis_group]] of a line description: valid values, and every possible error.
#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using testing::ElementsAre;

/// Three axes in mm and one in deg; the first line after them is kFirstLine.
std::string axes() {
  std::string text;
  for (const auto* name : {"x", "y", "z", "turn"}) text += std::string("[[slave]]\nname = \"") + name + "\"\n";
  for (const auto* name : {"x", "y", "z"}) {
    text += std::string("[[axis]]\nname = \"") + name +
            "\"\nfeed_mm_per_revolution = 10\nunit = \"mm\"\nmax_jerk = 100000\n";
  }
  return text + "[[axis]]\nname = \"turn\"\nunit = \"deg\"\n";
}
constexpr std::size_t kFirstLine = 27;

Result<LineConfig> read(const std::string& more) {
  return parse_line_config(axes() + more, "line.toml");
}

std::string group(const std::string& keys) {
  return "[[axis_group]]\n" + keys;
}

TEST(AxisGroupConfig, HasItsAxesInTheOrderOfTheCoordinatesAndTheUnitOfTheFirst) {
  const auto one = must(read(group("name = \"plotter\"\naxes = [\"y\", \"x\"]\nmax_feed = 500\ntolerance = 0.2\n")));
  ASSERT_EQ(one->axis_groups.size(), 1U);
  EXPECT_EQ(one->axis_groups[0].name, "plotter");
  EXPECT_THAT(one->axis_groups[0].axes, ElementsAre(1U, 0U));
  EXPECT_DOUBLE_EQ(one->axis_groups[0].max_feed, 0.5);
  EXPECT_DOUBLE_EQ(one->axis_groups[0].tolerance, 2e-4);
  const auto plain = must(read(group("name = \"plotter\"\naxes = [\"x\", \"y\", \"z\"]\n")));
  EXPECT_TRUE(std::isinf(plain->axis_groups[0].max_feed));
  EXPECT_EQ(plain->axis_groups[0].tolerance, 0.0);
  EXPECT_TRUE(read("")->axis_groups.empty());
}

/// Rotary axes of the tests, for machines.
std::string turning(int count) {
  std::string text;
  for (int i = 1; i <= count; ++i) {
    const auto name = "j" + std::to_string(i);
    text += "[[slave]]\nname = \"" + name + "\"\n[[axis]]\nname = \"" + name + "\"\nunit = \"deg\"\n";
  }
  return text;
}

const std::string kArms = "type = \"scara\", unit = \"mm\", upper_arm = 350, forearm = 250";

TEST(AxisGroupConfig, HasAMachineInTheWordsOfFilesOfMovesAndTheUnitsOfItsTool) {
  const auto one =
      must(read(turning(3) + group("name = \"arm\"\naxes = [\"j1\", \"j2\", \"z\", \"j3\"]\nkinematics = { " + kArms +
                                   ", elbow_left = true }\ntool = { max_velocity = 2000, max_jerk = 5e6 }\n"
                                   "max_feed = 500\ntolerance = 2\n"
                                   "output = [{ name = \"gripper\", to = \"x.60FE:01\", bit = 16 }]\n")));
  const auto& arm = one->axis_groups.at(0);
  ASSERT_NE(arm.machine, nullptr);
  EXPECT_EQ(arm.machine->kind(), "scara");
  const auto same = must(trajectory::Machine::make(
      "scara", "m", {{"forearm", 0.25, false}, {"upper_arm", 0.35, false}, {"elbow_left", 1.0, true}}));
  EXPECT_EQ(arm.machine->difference_to(*same), "");
  EXPECT_DOUBLE_EQ(arm.tool.max_velocity, 2.0);
  EXPECT_TRUE(std::isinf(arm.tool.max_acceleration));
  EXPECT_DOUBLE_EQ(arm.tool.max_jerk, 5e3);
  EXPECT_DOUBLE_EQ(arm.max_feed, 0.5) << "of x, not of an arm";
  EXPECT_DOUBLE_EQ(arm.tolerance, 2e-3);
  ASSERT_EQ(arm.outputs.size(), 1U);
  EXPECT_EQ(arm.outputs[0].to, "x.60FE:01");
  EXPECT_EQ(arm.outputs[0].bit, 16U);
  const auto plain = must(read(group("name = \"g\"\naxes = [\"x\", \"y\"]\ntool = { max_acceleration = 300 }\n")));
  EXPECT_EQ(plain->axis_groups[0].machine, nullptr);
  EXPECT_DOUBLE_EQ(plain->axis_groups[0].tool.max_acceleration, 0.3);
}

struct WrongGroup {
  std::string text;
  std::size_t line;  ///< counted from the first line after the axes
  std::string sentence;
};

void PrintTo(const WrongGroup& wrong, std::ostream* stream) {
  *stream << wrong.sentence;
}

class AxisGroupConfigError : public testing::TestWithParam<WrongGroup> {};

TEST_P(AxisGroupConfigError, IsOneSentenceWithFileAndLine) {
  EXPECT_EQ(failure_text(read(GetParam().text)),
            "line.toml:" + std::to_string(kFirstLine + GetParam().line - 1) + ": " + GetParam().sentence);
}

/// A machine of existing axes; kinematics are in line 4.
std::string machine(const std::string& axes, const std::string& kinematics, const std::string& more = "") {
  return "[[axis_group]]\nname = \"m\"\naxes = [" + axes + "]\nkinematics = { " + kinematics + " }\n" + more;
}
const std::string kTool = "tool = { max_velocity = 100 }\n";
const std::string kPortal = "type = \"cartesian\", unit = \"mm\"";
const std::string kThree = "\"x\", \"y\", \"z\"";
const std::string kColumns =
    "type = \"linear_delta\", unit = \"mm\", column_radius = 300, platform_radius = 50, rod = ";

const std::string kPlain = "[[axis_group]]\nname = \"g\"\naxes = [\"x\", \"y\"]\n";

INSTANTIATE_TEST_SUITE_P(
    All, AxisGroupConfigError,
    testing::Values(
        WrongGroup{"[[axis_group]]\naxes = [\"x\", \"y\"]\n", 1,
                   "[axis_group 1] name: is missing, a string is expected"},
        WrongGroup{
            "[[axis_group]]\nname = \"a b\"\naxes = [\"x\", \"y\"]\n", 2,
            "[axis_group 1] name: is \"a b\": 1 to 31 letters a to z and A to Z, digits and _-. are expected, and not "
            "\"time\""},
        WrongGroup{kPlain + "[[axis_group]]\nname = \"g\"\naxes = [\"z\"]\n", 5,
                   "[axis_group 2] name: \"g\" is there twice"},
        WrongGroup{"[[axis_group]]\nname = \"x\"\naxes = [\"x\", \"y\"]\n", 2,
                   "[axis_group 1] name: \"x\" is the name of an [[axis]], another name is expected"},
        WrongGroup{"[[axis_group]]\nname = \"wait\"\naxes = [\"x\", \"y\"]\n", 2,
                   "[axis_group 1] name: \"wait\" is a reserved word of requests, another name is expected"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\n", 1,
                   "[axis_group 1] axes: 0 are named, 2 to 128 names of [[axis]] tables are expected"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\naxes = [\"x\"]\n", 3,
                   "[axis_group 1] axes: 1 are named, 2 to 128 names of [[axis]] tables are expected"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\naxes = [\"x\", \"tunr\"]\n", 3,
                   "[axis_group 1] axes: there is no [[axis]] named \"tunr\"; did you mean \"turn\"?"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\naxes = [\"x\", \"x\"]\n", 3, "[axis_group 1] axes: has \"x\" twice"},
        WrongGroup{kPlain + "[[axis_group]]\nname = \"h\"\naxes = [\"z\", \"y\"]\n", 6,
                   "[axis_group 2] axes: \"y\" is already in group \"g\""},
        WrongGroup{kPlain + "max_feed = 0\n", 4, "[axis_group 1] max_feed: is 0, 0.001 to 1000000000 is expected"},
        WrongGroup{kPlain + "max_feed = nan\n", 4, "[axis_group 1] max_feed: is nan, 0.001 to 1000000000 is expected"},
        WrongGroup{kPlain + "tolerance = -1\n", 4, "[axis_group 1] tolerance: is -1, 0 to 1000000 is expected"},
        WrongGroup{kPlain + "tolerence = 1\n", 4,
                   "[axis_group 1] tolerence: unknown key, expected one of: axes, kinematics, max_feed, name, output, "
                   "tolerance, tool"},
        WrongGroup{
            machine(kThree, "type = \"dleta\", unit = \"mm\"", kTool), 4,
            "[axis_group 1.kinematics] type: there is no machine of kind 'dleta'; there are cartesian, scara, delta "
            "and linear_delta"},
        WrongGroup{machine(kThree, "unit = \"mm\"", kTool), 4,
                   "[axis_group 1.kinematics] type: is missing, a string is expected"},
        WrongGroup{machine(kThree, "type = \"cartesian\", unit = \"deg\"", kTool), 4,
                   "[axis_group 1.kinematics] unit: the unit of kinematics must be \"m\", \"mm\" or \"um\""},
        WrongGroup{machine(kThree, kPortal + ", rod = 3", kTool), 4,
                   "[axis_group 1.kinematics] rod: a machine of kind cartesian has no 'rod'"},
        WrongGroup{machine(kThree, kColumns + "0", kTool), 4,
                   "[axis_group 1.kinematics] rod: rod is 0 m; it must be above 0"},
        WrongGroup{machine(kThree, kColumns + "nan", kTool), 4,
                   "[axis_group 1.kinematics] rod: is nan, -1000000000 to 1000000000 is expected"},
        WrongGroup{machine(kThree, kColumns + "\"long\"", kTool), 4,
                   "[axis_group 1.kinematics] rod: is a string, a number is expected"},
        WrongGroup{machine(kThree, kArms, kTool), 3, "[axis_group 1] axes: the machine has 4 joints, the group 3 axes"},
        WrongGroup{machine("\"x\", \"turn\", \"z\"", kPortal, kTool), 3,
                   "[axis_group 1] axes: axis turn is a sliding joint of the machine; its unit must be one of lengths"},
        WrongGroup{
            machine(kThree, kPortal), 4,
            "[axis_group 1] kinematics: a machine needs a velocity limit of its tool: tool = { max_velocity = ... } "
            "is expected"},
        WrongGroup{machine(kThree, kPortal, "tool = { max_velocity = 0 }\n"), 5,
                   "[axis_group 1.tool] max_velocity: is 0, 0.001 to 1000000000 is expected"},
        WrongGroup{
            kPlain + "tool = { max_speed = 5 }\n", 4,
            "[axis_group 1.tool] max_speed: unknown key, expected one of: max_acceleration, max_jerk, max_velocity"},
        WrongGroup{kPlain + "[[axis_group.output]]\nname = \"a\"\nto = \"x.60FE:01\"\nbit = 32\n", 7,
                   "[axis_group 1.output 1] bit: is 32, 0 to 31 is expected"},
        WrongGroup{
            kPlain + "[[axis_group.output]]\nname = \"a b\"\n", 5,
            "[axis_group 1.output 1] name: is \"a b\": 1 to 31 letters a to z and A to Z, digits and _-. are expected"},
        WrongGroup{kPlain + "output = [{ name = \"a\", to = \"x.1\" }, { name = \"a\", to = \"x.2\" }]\n", 4,
                   "[axis_group 1.output 2] name: \"a\" is there twice"},
        WrongGroup{kPlain + "[path]\nfile = \"a.csv\"\n", 1,
                   "axis_group: needs axes that wait for requests: remove [path], which moves all axes"},
        WrongGroup{kPlain + "[stream]\nsocket = \"/tmp/s\"\naxes = [\"z\", \"y\"]\n", 1,
                   "axis_group: \"g\" has axis \"y\", which [stream] has, too: its axes must be told, and be others"}));

}  // namespace
}  // namespace driveline::runtime
