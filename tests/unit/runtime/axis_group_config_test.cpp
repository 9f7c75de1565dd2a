// [[axis_group]] of a line description: what can be said, and every way in which it can be wrong.
#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {
namespace {

using testing::ElementsAre;

/// Three axes in mm and one in deg; the first line behind them is kFirstLine.
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
  const auto one = read(group("name = \"plotter\"\naxes = [\"y\", \"x\"]\nmax_feed = 500\ntolerance = 0.2\n"));
  ASSERT_TRUE(one) << describe(one.error());
  ASSERT_EQ(one->axis_groups.size(), 1U);
  EXPECT_EQ(one->axis_groups[0].name, "plotter");
  EXPECT_THAT(one->axis_groups[0].axes, ElementsAre(1U, 0U));
  EXPECT_DOUBLE_EQ(one->axis_groups[0].max_feed, 0.5);
  EXPECT_DOUBLE_EQ(one->axis_groups[0].tolerance, 2e-4);
  const auto plain = read(group("name = \"plotter\"\naxes = [\"x\", \"y\", \"z\"]\n"));
  ASSERT_TRUE(plain) << describe(plain.error());
  EXPECT_TRUE(std::isinf(plain->axis_groups[0].max_feed));
  EXPECT_EQ(plain->axis_groups[0].tolerance, 0.0);
  EXPECT_TRUE(read("")->axis_groups.empty());
}

struct WrongGroup {
  std::string text;
  std::size_t line;  ///< counted from the first one behind the axes
  std::string sentence;
};

void PrintTo(const WrongGroup& wrong, std::ostream* stream) {
  *stream << wrong.sentence;
}

class AxisGroupConfigError : public testing::TestWithParam<WrongGroup> {};

TEST_P(AxisGroupConfigError, IsOneSentenceWithFileAndLine) {
  const auto config = read(GetParam().text);
  ASSERT_FALSE(config);
  EXPECT_EQ(describe(config.error()),
            "line.toml:" + std::to_string(kFirstLine + GetParam().line - 1) + ": " + GetParam().sentence);
}

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
                   "[axis_group 1] name: \"x\" is the name of an [[axis]], another one is expected"},
        WrongGroup{"[[axis_group]]\nname = \"wait\"\naxes = [\"x\", \"y\"]\n", 2,
                   "[axis_group 1] name: \"wait\" is a word of requests, another one is expected"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\n", 1,
                   "[axis_group 1] axes: 0 are named, 2 to 128 names of [[axis]] tables are expected"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\naxes = [\"x\"]\n", 3,
                   "[axis_group 1] axes: 1 are named, 2 to 128 names of [[axis]] tables are expected"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\naxes = [\"x\", \"tunr\"]\n", 3,
                   "[axis_group 1] axes: there is no [[axis]] named \"tunr\"; did you mean \"turn\"?"},
        WrongGroup{"[[axis_group]]\nname = \"g\"\naxes = [\"x\", \"x\"]\n", 3, "[axis_group 1] axes: has \"x\" twice"},
        WrongGroup{kPlain + "[[axis_group]]\nname = \"h\"\naxes = [\"z\", \"y\"]\n", 6,
                   "[axis_group 2] axes: \"y\" is in group \"g\" already"},
        WrongGroup{kPlain + "max_feed = 0\n", 4, "[axis_group 1] max_feed: is 0, 0.001 to 1000000000 is expected"},
        WrongGroup{kPlain + "max_feed = nan\n", 4, "[axis_group 1] max_feed: is nan, 0.001 to 1000000000 is expected"},
        WrongGroup{kPlain + "tolerance = -1\n", 4, "[axis_group 1] tolerance: is -1, 0 to 1000000 is expected"},
        WrongGroup{kPlain + "tolerence = 1\n", 4,
                   "[axis_group 1] tolerence: unknown key, expected one of: axes, max_feed, name, tolerance"},
        WrongGroup{kPlain + "[path]\nfile = \"a.csv\"\n", 1,
                   "axis_group: goes with axes that wait for requests: there must be no [path], which they would "
                   "follow"},
        WrongGroup{kPlain + "[stream]\nsocket = \"/tmp/s\"\naxes = [\"z\", \"y\"]\n", 1,
                   "axis_group: \"g\" has axis \"y\", which [stream] has, too: its axes must be told, and be others"}));

}  // namespace
}  // namespace driveline::runtime
