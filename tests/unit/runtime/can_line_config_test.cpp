#include "driveline/runtime/can_line/can_line_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "driveline/runtime/can_line/can_line.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {
namespace {

using ::testing::HasSubstr;

constexpr std::string_view kTwoDrives = R"([line]
name = "press"
[bus]
type = "can"
bit_rate = 500000
interface = "can3"
length_m = 42.5
terminators = "last"
seed = 77
[[slave]]
name = "x"
node = 3
[[slave]]
name = "y"
node = 12
model = "servoone"
)";

std::string failure(std::string_view text) {
  const auto config = parse_can_line_config(text, "cell.toml");
  return config ? "" : describe(config.error());
}

TEST(CanLineConfigTest, AllOfIt) {
  const auto config = parse_can_line_config(kTwoDrives, "cell.toml");
  ASSERT_TRUE(config) << describe(config.error());
  EXPECT_EQ(config->name, "press");
  EXPECT_EQ(config->interface, "can3");
  EXPECT_EQ(config->bit_rate, 500'000U);
  EXPECT_EQ(config->wiring.length_m, 42.5);
  EXPECT_FALSE(config->wiring.first_terminated);
  EXPECT_TRUE(config->wiring.last_terminated);
  EXPECT_EQ(config->seed, 77U);
  ASSERT_EQ(config->nodes.size(), 2U);
  EXPECT_EQ(config->nodes[1].name, "y");
  EXPECT_EQ(config->nodes[1].node_id, 12);
  CanLine line(*config);
  EXPECT_EQ(line.size(), 2U);
  EXPECT_EQ(line.bit_rate(), 500'000U);
}

TEST(CanLineConfigTest, WhatIsLeftOutHasItsDefault) {
  const auto config =
      parse_can_line_config("[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\nnode = 127\n", "cell.toml");
  ASSERT_TRUE(config) << describe(config.error());
  EXPECT_EQ(config->bit_rate, 1'000'000U);
  EXPECT_EQ(config->interface, "can0");
  EXPECT_TRUE(config->wiring.first_terminated && config->wiring.last_terminated);
}

/// Boot-up messages of the devices, with their node-IDs, in the first second.
TEST(CanLineConfigTest, DevicesAreOnTheBus) {
  const auto config = parse_can_line_config(
      "[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\nnode = 3\n[[slave]]\nname = \"y\"\nnode = 12\n", "cell.toml");
  ASSERT_TRUE(config) << describe(config.error());
  CanLine line(*config);
  line.bus().advance(std::chrono::seconds{1});
  EXPECT_EQ(line.bus().statistics().frames, 2U);
}

TEST(CanLineConfigTest, AFileTellsItsBus) {
  const auto folder = std::filesystem::temp_directory_path() / "driveline_can_line_config_test";
  std::filesystem::create_directories(folder);
  const auto describes = [&](std::string_view text) {
    std::ofstream(folder / "line.toml") << text;
    return describes_can_line(folder / "line.toml");
  };
  EXPECT_TRUE(describes(kTwoDrives));
  EXPECT_FALSE(describes("[bus]\ntype = \"ethercat\"\n"));
  EXPECT_FALSE(describes("[bus]\n"));
  EXPECT_FALSE(describes("[bus\n"));
  EXPECT_FALSE(describes_can_line(folder / "missing.toml"));
  std::filesystem::remove_all(folder);
}

TEST(CanLineConfigTest, OneBusIsNotTakenForTheOther) {
  EXPECT_THAT(failure("[[slave]]\nname = \"x\"\n"),
              HasSubstr("cell.toml: describes a line of EtherCAT, one with [bus] type = \"can\" is expected"));
}

TEST(CanLineConfigTest, ErrorsHaveFileLineAndReason) {
  const std::string head = "[bus]\ntype = \"can\"\n";
  const std::string node = "[[slave]]\nname = \"x\"\nnode = 3\n";
  EXPECT_THAT(failure(head), HasSubstr("cell.toml:1: there is no [[slave]]"));
  EXPECT_THAT(failure(head + node + "[[slave]]\nname = \"y\"\nnode = 3\n"),
              HasSubstr("cell.toml:8: [slave 2] node: is 3, as that of \"x\""));
  EXPECT_THAT(failure(head + node + node), HasSubstr("\"x\" is there twice"));
  EXPECT_THAT(failure(head + "[[slave]]\nname = \"x\"\nnode = 0\n"), HasSubstr("node"));
  EXPECT_THAT(failure(head + "bit_rate = 300000\n" + node), HasSubstr("cell.toml:3: [bus] bit_rate: is 300000"));
  EXPECT_THAT(failure(head + "interface = \"a_name_of_sixteen\"\n" + node), HasSubstr("interface"));
  EXPECT_THAT(failure(head + node + "model = \"device\"\n"), HasSubstr("model"));
  EXPECT_THAT(failure(head + node + "watchdog = {}\n"), HasSubstr("watchdog"));
}

}  // namespace
}  // namespace driveline::runtime
