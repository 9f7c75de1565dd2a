// The name of an axis appears in the line description and as a column of the path: both accept the same names, and
// refuse others with the same sentences.
#include "driveline/trajectory/axis_name.hpp"

#include <gmock/gmock.h>

#include <array>
#include <vector>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/trajectory/path.hpp"

namespace driveline::runtime {
namespace {

/// The refusal by the reader of line descriptions, without file and line; empty: accepted.
std::string line_says(const std::string& name) {
  std::string escaped;
  for (const char c : name) {
    const bool special = c == '"' || c == '\\';
    const auto byte = static_cast<unsigned char>(c);
    if (byte < ' ' || byte == 0x7F) {
      constexpr std::string_view kDigits = "0123456789abcdef";
      escaped += std::string("\\u00") + kDigits[byte >> 4] + kDigits[byte & 0xF];
    } else {
      escaped += std::string(special ? "\\" : "") + c;
    }
  }
  const auto config =
      parse_line_config("[[slave]]\nname = \"s\"\n[[axis]]\nname = \"" + escaped + "\"\nslave = \"s\"\n", "l.toml");
  if (config) return {};
  const std::string place = "l.toml:4: [axis 1] name: ";
  EXPECT_THAT(describe(config.error()), testing::StartsWith(place));
  return describe(config.error()).substr(std::min(place.size(), describe(config.error()).size()));
}

/// The refusal by the reader of paths, without file and line; empty: accepted.
std::string path_says(const std::string& name) {
  const auto path = trajectory::parse_path_csv("time[s]," + name + "[rad]\n0,0\n1,0\n", "p.csv");
  return path ? std::string{} : path.error().reason;
}

TEST(AxisName, LineAndPathSayTheSame) {
  for (const std::string name :
       {"x", "X", "axis_1", "a-b.c", "0", "-", "Time", "times", "", "time", "a b", "a/b", "S\xC3\xA4ge", "x'", "\\",
        "x\"y", "#", "abcdefghijklmnopqrstuvwxyz01234", "abcdefghijklmnopqrstuvwxyz012345"}) {
    // That column is the time.
    if (name == "time") {
      EXPECT_THAT(line_says(name), testing::HasSubstr("not be time"));
      EXPECT_EQ(path_says(name), "the time column must be in s, ms or us, not in rad");
      continue;
    }
    EXPECT_EQ(line_says(name), path_says(name)) << name;
  }
  EXPECT_EQ(line_says("a b"),
            "axis name 'a b' must be 1 to 31 characters out of letters a to z and A to Z, digits and _-., and not be "
            "time");
}

TEST(AxisName, EveryCharacterIsTakenByBothOrByNone) {
  for (unsigned c = 0; c <= 0xFF; ++c) {
    const std::string character =
        c < 0x80 ? std::string(1, static_cast<char>(c))
                 : std::string{static_cast<char>(0xC0 | c >> 6), static_cast<char>(0x80 | (c & 0x3F))};
    const auto name = "a" + character + "b";
    EXPECT_EQ(line_says(name).empty(), path_says(name).empty()) << c;
  }
}

TEST(AxisName, AreComparedCharacterByCharacter) {
  const std::array<std::string_view, 3> names{"x", "Y", "y"};
  EXPECT_EQ(trajectory::find_axis_name("y", names), 2U);
  EXPECT_EQ(trajectory::find_axis_name("X", names), std::nullopt);
  EXPECT_TRUE(trajectory::check_axis_name("X", names));
  EXPECT_EQ(describe(trajectory::check_axis_name("x", names).error()), "axis name 'x' appears twice");
  EXPECT_EQ(trajectory::axis_name_hint("X", names), "; there is \"x\", and upper and lower case differ");
  EXPECT_EQ(trajectory::axis_name_hint("xy", names), "");
}

}  // namespace
}  // namespace driveline::runtime
