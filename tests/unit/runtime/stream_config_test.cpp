// [stream] of a line description.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/trajectory/stream_curve.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kTwoAxes =
    "[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n[[axis]]\nname = \"x\"\n[[axis]]\nname = \"y\"\n";
const std::string kSocket = "socket = \"/tmp/s\"\n";

auto read(const std::string& stream) {
  return parse_line_config(kTwoAxes + "[stream]\n" + stream, "line.toml");
}

std::string refusal(const std::string& stream) {
  const auto config = read(stream);
  return config ? std::string{} : describe(config.error());
}

TEST(StreamConfig, IsForAllAxesAndForWhoRunsTheLineUnlessItSaysMore) {
  const auto config = must(read(kSocket));
  ASSERT_TRUE(config->stream);
  EXPECT_EQ(config->stream->socket, "/tmp/s");
  EXPECT_THAT(config->stream->axes, ElementsAre(0U, 1U));
  EXPECT_TRUE(config->stream->allowed.users.empty());
  EXPECT_FALSE(config->stream->allowed.group);
  EXPECT_EQ(config->stream->settings.method, trajectory::StreamMethod::kCubic);
  EXPECT_EQ(config->stream->settings.keep_alive, 100ms);
  EXPECT_EQ(config->stream->settings.delay, 5ms);
  EXPECT_FALSE(parse_line_config(kTwoAxes, "line.toml")->stream);
  EXPECT_FALSE(read(kSocket + "enabled = false\n")->stream);
}

TEST(StreamConfig, TakesAxesMethodTimesAndUsers) {
  const auto config =
      must(read(kSocket + "axes = [\"y\"]\ninterpolation = \"quintic\"\nkeep_alive_ms = 20\ndelay_ms = 0\n"
                          "users = [\"root\", \"65534\"]\ngroup = \"17\"\n"));
  EXPECT_THAT(config->stream->axes, ElementsAre(1U));
  EXPECT_EQ(config->stream->settings.method, trajectory::StreamMethod::kQuintic);
  EXPECT_EQ(config->stream->settings.keep_alive, 20ms);
  EXPECT_EQ(config->stream->settings.delay, 0ms);
  EXPECT_THAT(config->stream->allowed.users, ElementsAre(0U, 65534U));
  EXPECT_EQ(config->stream->allowed.group, 17U);
}

TEST(StreamConfig, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal(""), HasSubstr("[stream] socket: is missing"));
  EXPECT_THAT(refusal("socket = \"\"\n"), HasSubstr("is empty, the path of a socket is expected"));
  EXPECT_THAT(refusal(kSocket + "axes = [\"z\"]\n"), HasSubstr("line.toml:11: [stream] axes: there is no [[axis]]"));
  EXPECT_THAT(refusal(kSocket + "axes = [\"x\", \"x\"]\n"), HasSubstr("axes: has \"x\" twice"));
  EXPECT_THAT(refusal(kSocket + "axes = []\n"), HasSubstr("no axis is left for streams"));
  EXPECT_THAT(refusal(kSocket + "interpolation = \"spline\"\n"), HasSubstr("interpolation"));
  EXPECT_THAT(refusal(kSocket + "keep_alive_ms = 5\n"), HasSubstr("keep_alive_ms"));
  EXPECT_THAT(refusal(kSocket + "delay_ms = 501\n"), HasSubstr("delay_ms"));
  EXPECT_THAT(refusal(kSocket + "users = [\"no such user\"]\n"), HasSubstr("there is no user \"no such user\""));
  EXPECT_THAT(refusal(kSocket + "group = \"no such group\"\n"), HasSubstr("there is no group \"no such group\""));
  EXPECT_THAT(refusal(kSocket + "user = [\"x\"]\n"), HasSubstr("user: unknown key, expected one of"));
}

}  // namespace
}  // namespace driveline::runtime
