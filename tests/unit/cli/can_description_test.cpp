#include "can/can_description.hpp"

#include <gmock/gmock.h>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint32_t kIpAndProfile = 0x61;  // 6502h: modes 1, 6, 7

FoundCanNode drive_node(std::uint8_t node, std::uint32_t modes = kIpAndProfile) {
  FoundCanNode found;
  found.facts.node = node;
  found.facts.device_type = 0x0002'0192;
  found.facts.vendor_id = 0x555;
  found.facts.product_code = 0x402;
  found.facts.revision = 0x0001'0003;
  found.facts.serial_number = 4711;
  found.facts.device_name = "a drive";
  found.drive = FoundDrive{modes, 65536.0, 1.25, 300.0, 0};
  return found;
}

runtime::LineConfig config_of(const FoundCanLine& line) {
  const auto text = describe_can_line(line);
  const auto config = runtime::parse_line_config(text, "line.toml");
  EXPECT_TRUE(config) << (config ? std::string() : runtime::describe(config.error())) << text;
  return config.value_or(runtime::LineConfig{});
}

TEST(CanDescription, IsAConfigurationThatExpectsWhatWasFound) {
  const auto config = config_of({{drive_node(3), drive_node(9)}, "slcan:tcp:127.0.0.1:29550", 500'000, {}});
  ASSERT_TRUE(config.can);
  EXPECT_EQ(config.interface, "slcan:tcp:127.0.0.1:29550");
  EXPECT_EQ(config.can->bit_rate, 500'000U);
  ASSERT_EQ(config.slaves.size(), 2U);
  EXPECT_EQ(config.slaves[1].can.node, 9);
  EXPECT_EQ(config.slaves[1].vendor_id, 0x555U);
  EXPECT_EQ(config.slaves[1].product_code, 0x402U);
  EXPECT_EQ(config.slaves[1].can.revision, 0x0001'0003U);
  EXPECT_EQ(config.slaves[1].can.serial_number, 4711U);
  ASSERT_EQ(config.axes.size(), 2U);
  EXPECT_EQ(config.axes[1].name, "axis9");
  EXPECT_EQ(config.axes[1].slave, 1U);
  EXPECT_EQ(config.axes[1].mode, motion::cia402::Mode::kInterpolatedPosition);
  EXPECT_DOUBLE_EQ(config.axes[1].rated_torque, 1.25);
}

TEST(CanDescription, WhatANodeDoesNotTellIsNotExpected) {
  auto node = drive_node(3);
  node.facts.revision.reset();
  node.facts.serial_number = 0;
  node.drive.reset();
  const auto config = config_of({{node}, "can0", 1'000'000, {}});
  EXPECT_FALSE(config.slaves.at(0).can.revision);
  EXPECT_FALSE(config.slaves[0].can.serial_number);
  EXPECT_TRUE(config.axes.empty());
}

TEST(CanDescription, DrivesThatCannotBeAnAxisAreACommentWithTheReason) {
  auto without_scale = drive_node(5);
  without_scale.drive->increments_per_revolution.reset();
  const FoundCanLine line{{drive_node(4, 0x20), without_scale, drive_node(6)}, "can0", 1'000'000, {}};
  const auto text = describe_can_line(line);
  EXPECT_THAT(
      text, HasSubstr("# node4 is left out: 6502h is 0x00000020: it has no interpolated position, profile position or "
                      "profile velocity.\n# [[axis]]"));
  EXPECT_THAT(text, HasSubstr("# node5 is left out: it does not report the scaling"));
  EXPECT_THAT(text, HasSubstr("mode = \"ip\"  # of ip, pp, hm by 6502h"));
  EXPECT_THAT(axes_of(line), ElementsAre("axis6"));
  EXPECT_EQ(config_of(line).axes.size(), 1U);
}

// 6502h: modes 1 and 3; mode 3 alone.
TEST(CanDescription, DrivesWithoutInterpolatedPositionPlanTheirMotions) {
  FoundCanLine line{{drive_node(4, 0x05), drive_node(6, 0x04), drive_node(8)}, "can0", 1'000'000, {}};
  EXPECT_THAT(describe_can_line(line), HasSubstr("mode = \"pp\"  # of pp, pv by 6502h\n"));
  EXPECT_THAT(describe_can_line(line), HasSubstr("mode = \"pv\"  # of pv by 6502h\n"));
  EXPECT_FALSE(can_follow_path(line));
  const auto config = config_of(line);
  ASSERT_EQ(config.axes.size(), 3U);
  EXPECT_EQ(config.axes[0].mode, motion::cia402::Mode::kProfilePosition);
  EXPECT_EQ(config.axes[1].mode, motion::cia402::Mode::kProfileVelocity);
  EXPECT_EQ(config.axes[2].mode, motion::cia402::Mode::kInterpolatedPosition);
  line.nodes.erase(line.nodes.begin(), line.nodes.begin() + 2);
  EXPECT_TRUE(can_follow_path(line));
}

TEST(CanDescription, ANodeThatDoesNotAnswerIsLeftOut) {
  FoundCanNode silent;
  silent.facts.node = 7;
  silent.facts.trouble = "is on the bus, but does not answer SDOs";
  const FoundCanLine line{{drive_node(3), silent}, "can0", 1'000'000, {}};
  EXPECT_THAT(describe_can_line(line), HasSubstr("# Node 7 is left out: is on the bus, but does not answer SDOs.\n"));
  EXPECT_EQ(config_of(line).slaves.size(), 1U);
}

TEST(CanDescription, TextsOfNodesCannotBreakTheFile) {
  auto node = drive_node(3);
  node.facts.device_name = "evil\n[[slave]]\nname = \"x\"";
  const auto config = config_of({{node}, "can0", 1'000'000, {}});
  EXPECT_EQ(config.slaves.size(), 1U);
}

// 8 axes need 1.87 ms at 1 Mbit/s, with room for another frame of 8 bytes; 16 at 4 ms are 85 % without stuff bits.
TEST(CanDescription, SyncLeavesRoomForThePdosOfAllAxes) {
  const auto period_of = [](std::size_t axes, std::uint32_t bit_rate) {
    FoundCanLine line{{}, "can0", bit_rate, {}};
    for (std::size_t i = 0; i < axes; ++i) line.nodes.push_back(drive_node(static_cast<std::uint8_t>(i + 1)));
    return config_of(line).period;
  };
  EXPECT_EQ(period_of(1, 1'000'000), std::chrono::milliseconds{2});
  EXPECT_EQ(period_of(8, 1'000'000), std::chrono::milliseconds{2});
  EXPECT_EQ(period_of(9, 1'000'000), std::chrono::milliseconds{4});
  EXPECT_EQ(period_of(16, 1'000'000), std::chrono::milliseconds{4});
  EXPECT_EQ(period_of(8, 250'000), std::chrono::milliseconds{10});
}

TEST(CanDescription, APathMovesTheAxesAndComesBack) {
  const FoundCanLine line{{drive_node(3)}, "can0", 1'000'000, "line.path.csv"};
  EXPECT_THAT(describe_can_line(line), HasSubstr("[path]\nfile = \"line.path.csv\"\nrelative = true\n"));
  EXPECT_EQ(gentle_path(axes_of(line), 0.5), "time[s],axis3[rev]\n0,0\n1,0.5\n2,0\n");
}

class DataSheetsTest : public test::TemporaryDirectory {
 protected:
  void write_sheet(const std::string& name, const std::string& revision, const std::string& more = {}) const {
    write(directory / name, "[DeviceInfo]\nVendorNumber=0x555\nProductNumber=0x402\nRevisionNumber=" + revision + more +
                                "\n[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n[1000]\nParameterName=type\n"
                                "ObjectType=0x7\nDataType=0x0007\nAccessType=ro\nPDOMapping=0\n");
  }
};

TEST_F(DataSheetsTest, AreFoundByIdentityAndRevision) {
  write_sheet("a.eds", "0x10001");
  write_sheet("b.EDS", "0x10003");
  write(directory / "c.eds", "no data sheet");
  write(directory / "d.txt", "nor this");
  const auto sheets = must(DataSheets::read(directory));
  auto facts = drive_node(3).facts;
  ASSERT_NE(sheets->find(facts), nullptr);
  EXPECT_EQ(sheets->find(facts)->filename(), "b.EDS");
  facts.revision = 0x0001'0004;
  EXPECT_EQ(sheets->find(facts)->filename(), "a.eds") << "one of another revision is better than none";
  facts.product_code = 0x403;
  EXPECT_EQ(sheets->find(facts), nullptr);
}

TEST_F(DataSheetsTest, ThatOfADeviceOnAnotherBusComesLast) {
  write_sheet("a.eds", "0x10003");
  write_sheet("b.eds", "0x10001", "\nBaudRate_1000=1");
  const auto sheets = must(DataSheets::read(directory));
  EXPECT_EQ(sheets->find(drive_node(3).facts)->filename(), "b.eds");
}

TEST_F(DataSheetsTest, OneThatCannotBeReadIsRefused) {
  EXPECT_FALSE(DataSheets::read(directory / "missing.eds"));
  write(directory / "c.eds", "no data sheet");
  EXPECT_FALSE(DataSheets::read(directory / "c.eds"));
}

}  // namespace
}  // namespace driveline::cli
