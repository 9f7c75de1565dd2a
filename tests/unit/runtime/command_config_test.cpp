// [commands] of a line description.
#include <gmock/gmock.h>

#include <chrono>
#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using testing::HasSubstr;

auto read_commands_of(const std::string& text) {
  return parse_line_config("[[slave]]\nname = \"x\"\n" + text, "line.toml");
}

std::string refusal_of(const std::string& text) {
  const auto config = read_commands_of(text);
  return config ? std::string{} : describe(config.error());
}

TEST(CommandConfig, IsOffUnlessItIsSwitchedOn) {
  EXPECT_FALSE(read_commands_of("")->commands);
  EXPECT_FALSE(read_commands_of("[commands]\n")->commands);
  EXPECT_FALSE(read_commands_of("[commands]\ninsecure = true\n")->commands);
  const auto config = must(read_commands_of("[commands]\nenabled = true\ninsecure = true\n"));
  ASSERT_TRUE(config->commands);
  EXPECT_TRUE(config->commands->insecure);
  EXPECT_EQ(config->commands->lease_timeout, std::chrono::milliseconds{500});
}

TEST(CommandConfig, IsSecuredByTheFilesOfTelemetry) {
  const auto config = must(read_commands_of("[telemetry]\nsecurity = \"keys\"\n[commands]\nenabled = true\n"));
  ASSERT_TRUE(config->commands);
  EXPECT_FALSE(config->commands->insecure);
  EXPECT_EQ(config->telemetry.security, "keys");
}

TEST(CommandConfig, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal_of("[commands]\nenabled = true\n"),
              HasSubstr("[commands] enabled: needs [telemetry] security, or insecure = true"));
  EXPECT_THAT(refusal_of("[commands]\nenabled = true\ninsecure = true\n[telemetry]\nenabled = false\n"),
              HasSubstr("[telemetry] is off"));
  EXPECT_THAT(refusal_of("[commands]\nlease_timeout_ms = 49\n"), HasSubstr("lease_timeout_ms"));
  EXPECT_THAT(refusal_of("[commands]\nlease = 1\n"), HasSubstr("lease: unknown key, expected one of"));
}

}  // namespace
}  // namespace driveline::runtime
