// Gantry pairs in a line description, and the sentences about them.
#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

/// Lines 1 to 18.
const std::string kTwoAxes =
    "[[slave]]\nname = \"x1\"\n[[slave]]\nname = \"x2\"\n"
    "[[axis]]\nname = \"x1\"\nfeed_mm_per_revolution = 10\nunit = \"mm\"\nmax_velocity = 500\n"
    "max_acceleration = 5000\n"
    "[[axis]]\nname = \"x2\"\nfeed_mm_per_revolution = 10\nunit = \"mm\"\nmax_velocity = 400\n"
    "max_acceleration = 6000\n";

Result<LineConfig> gantry_of(const std::string& keys, const std::string& axes = kTwoAxes) {
  return parse_line_config(axes + "[[gantry]]\n" + keys, "line.toml");
}

std::string sentence_of(const std::string& keys, const std::string& axes = kTwoAxes) {
  const auto config = gantry_of(keys, axes);
  return config ? "" : describe(config.error());
}

const std::string kPair = "leader = \"x1\"\nfollower = \"x2\"\n";

TEST(GantryConfig, BothAxesGetLimitsThatTheyKeepTogether) {
  const auto config =
      must(gantry_of(kPair + "skew_limit = 2\noffset = 0.5\nsquare_velocity = 5\nreference = \"homing\"\n"));
  ASSERT_EQ(config->gantries.size(), 1U);
  const auto& gantry = config->gantries.front();
  EXPECT_EQ(gantry.leader, 0U);
  EXPECT_EQ(gantry.follower, 1U);
  EXPECT_DOUBLE_EQ(gantry.skew_limit, 0.002);
  EXPECT_DOUBLE_EQ(gantry.skew_warning, 0.001);
  EXPECT_DOUBLE_EQ(gantry.offset, 0.0005);
  EXPECT_DOUBLE_EQ(gantry.square_velocity, 0.005);
  EXPECT_DOUBLE_EQ(gantry.square_acceleration, 0.1);
  EXPECT_TRUE(gantry.when_homed);
  EXPECT_FALSE(gantry.square_when_enabled);
  EXPECT_DOUBLE_EQ(config->axes[0].limits.max_velocity, 0.395);
  EXPECT_DOUBLE_EQ(config->axes[1].limits.max_velocity, 0.4);
  EXPECT_DOUBLE_EQ(config->axes[0].limits.max_acceleration, 5.0);
  EXPECT_DOUBLE_EQ(config->axes[1].limits.max_acceleration, 5.0);
}

TEST(GantryConfig, BadInputHasOneSentence) {
  const std::pair<std::string, std::string> cases[] = {
      {"follower = \"x2\"\nskew_limit = 1\n", "line.toml:17: [gantry 1] leader: is missing, a string is expected"},
      {"leader = \"y\"\nfollower = \"x2\"\nskew_limit = 1\n",
       "line.toml:18: [gantry 1] leader: there is no [[axis]] named \"y\""},
      {"leader = \"x1\"\nfollower = \"x1\"\nskew_limit = 1\n",
       "line.toml:19: [gantry 1] follower: is \"x1\", the same as the leader: a gantry needs two axes"},
      {kPair, "line.toml:17: [gantry 1] skew_limit: is missing, a number is expected"},
      {kPair + "skew_limit = 0\n", "line.toml:20: [gantry 1] skew_limit: is 0, 1e-09 to 1000000000 is expected"},
      {kPair + "skew_limit = 1\nskew_warning = 2\n", "line.toml:21: [gantry 1] skew_warning: is 2, 0 to 1 is expected"},
      {kPair + "skew_limit = 1\nsquare_velocity = 300\n",
       "line.toml:21: [gantry 1] square_velocity: is 300, 1e-09 to 200 is expected"},
      {kPair + "skew_limit = 1\nout_of_skew = \"ignore\"\n",
       "line.toml:21: [gantry 1] out_of_skew: is \"ignore\", one of \"refuse\", \"square\" is expected"},
      {kPair + "skew_limit = 1\n[[gantry]]\nleader = \"x2\"\nfollower = \"x1\"\nskew_limit = 1\n",
       "line.toml:22: [gantry 2] leader: \"x2\" is already in a [[gantry]] above"},
      {kPair + "skew_limit = 1\n[path]\nfile = \"p.csv\"\n",
       "line.toml:17: [gantry 1]: needs axes that wait for requests: remove [path], which moves all axes"},
  };
  for (const auto& [keys, wanted] : cases) EXPECT_EQ(sentence_of(keys), wanted);
  const std::string keys = kPair + "skew_limit = 1\n";
  EXPECT_EQ(sentence_of(keys, kTwoAxes + "mode = \"csv\"\n"),
            "line.toml:20: [gantry 1] follower: \"x2\" is in mode \"csv\", but the leader \"x1\" in \"csp\"");
  EXPECT_EQ(sentence_of(keys, kTwoAxes + "min_position = 0\nmax_position = 100\n"),
            "line.toml:21: [gantry 1] follower: \"x2\" has min_position and max_position: those of the leader are "
            "expected alone");
  EXPECT_EQ(sentence_of(keys, kTwoAxes + "backlash = 0.1\ncompensate = \"homed\"\n"),
            "line.toml:21: [gantry 1] follower: \"x2\" is compensated only after homing, which a gantry does not do: "
            "compensate = \"always\" is expected");
  EXPECT_EQ(
      sentence_of(keys, kTwoAxes + "[stream]\nsocket = \"/tmp/s\"\n"),
      "line.toml:21: [gantry 1] follower: \"x2\" is one of the axes of [stream]: only the leader is expected there");
}

TEST(GantryConfig, SentencesHaveTheNumbers) {
  const auto config = must(gantry_of(kPair + "skew_limit = 1\n"));
  const auto axis = events::event_axis(config->axes[0]);
  EXPECT_EQ(describe(Event{events::AxisFailed{axis, motion::AxisError::kSkew, 0, GantrySkew{-0.0012, 0.001}}}),
            "axis x1: ErrorStop: the skew of its gantry was -1.2 mm, the limit is 1 mm; it stops with the other "
            "axis of its gantry");
  EXPECT_EQ(describe(Event{events::GantryAskew{axis, "x2", 0.0007, 0.0005, 0.001}}),
            "gantry of x1 and x2: the skew is 0.7 mm, above skew_warning = 0.5 mm; at 1 mm both axes stop");
  AxisRefusal refusal;
  refusal.why = AxisRefusal::Why::kByAxis;
  refusal.error = motion::AxisError::kSkew;
  refusal.skew = GantrySkew{0.004, 0.001};
  EXPECT_EQ(describe(axis, refusal), "axis x1: the skew of its gantry was 4 mm, the limit is 1 mm");
}

}  // namespace
}  // namespace driveline::runtime
