#include "text/line_description.hpp"

#include <gmock/gmock.h>

#include "driveline/esi/sii.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"

namespace driveline::cli {
namespace {

using testing::HasSubstr;

struct Identity {
  std::uint32_t vendor = 2;
  std::uint32_t revision = 0x00110000;
  std::uint32_t serial = 0;
  std::uint16_t alias = 0;
};

FoundSlave found(std::uint16_t position, const Identity& identity, std::string name) {
  esi::DeviceDescription device;
  device.vendor_id = identity.vendor;
  device.product_code = 0x10U + position;
  device.revision = identity.revision;
  device.serial_number = identity.serial;
  device.name = std::move(name);
  FoundSlave slave;
  slave.view.slave.ref = {position, 0x1001};
  slave.view.sii = esi::make_sii(device);
  slave.view.sii->config.station_alias = identity.alias;
  return slave;
}

runtime::LineConfig described(const FoundLine& line) {
  const auto text = describe_line(line);
  EXPECT_TRUE(text) << text.error().text;
  const auto config = runtime::parse_line_config(*text, "line.toml");
  EXPECT_TRUE(config) << runtime::describe(config.error()) << *text;
  return config.value_or(runtime::LineConfig{});
}

TEST(LineDescription, IsAConfigurationThatExpectsWhatWasFound) {
  const auto config = described(
      {{found(0, {.vendor = 2}, "EK1100"), found(1, {.vendor = 0x28, .serial = 4711}, "MSD")}, "eth1", {}, {}});
  EXPECT_EQ(config.interface, "eth1");
  ASSERT_EQ(config.slaves.size(), 2U);
  EXPECT_EQ(config.slaves[0].vendor_id, 2U);
  EXPECT_EQ(config.slaves[1].vendor_id, 0x28U);
  EXPECT_EQ(config.slaves[1].product_code, 0x11U);
  EXPECT_TRUE(config.slaves[0].plan.revision.accepts(0x00110000));
  EXPECT_FALSE(config.slaves[0].plan.revision.accepts(0x00110001));
  EXPECT_TRUE(config.slaves[0].plan.serial.accepts(99)) << "no serial number in the EEPROM: any";
  EXPECT_TRUE(config.slaves[1].plan.serial.accepts(4711));
  EXPECT_FALSE(config.slaves[1].plan.serial.accepts(4712));
  EXPECT_TRUE(config.axes.empty());
}

TEST(LineDescription, SlavesAreFoundByWhatNoOtherSlaveHas) {
  FoundLine line;
  line.slaves = {found(0, {.alias = 7}, "a"), found(1, {.alias = 9}, "b"), found(2, {.alias = 9}, "c"),
                 found(3, {}, "d"),           found(4, {}, "e"),           found(5, {}, "f")};
  line.slaves[3].device_id = 3;
  line.slaves[4].device_id = 4;
  line.slaves[5].device_id = 4;
  line.slaves[0].device_id = 12;
  const auto config = described(line);
  EXPECT_EQ(config.slaves[0].plan.alias, 7);
  EXPECT_FALSE(config.slaves[0].plan.device_id) << "one of them";
  EXPECT_FALSE(config.slaves[1].plan.alias) << "the alias of two slaves";
  EXPECT_FALSE(config.slaves[2].plan.alias);
  EXPECT_EQ(config.slaves[3].plan.device_id, 3);
  EXPECT_FALSE(config.slaves[4].plan.device_id);
  const auto text = describe_line(line);
  EXPECT_THAT(*text, HasSubstr("# alias = 9  # another slave has the same"));
}

FoundLine one_drive(const FoundDrive& facts, std::uint32_t vendor = 0x28) {
  FoundLine line{{found(0, {.vendor = vendor}, "drive")}, "eth1", {}, {}};
  line.slaves[0].drives = {facts};
  return line;
}

TEST(LineDescription, DrivesBecomeAxesScaledAsTheySay) {
  const auto config = described(one_drive({1U << 8U, 65536.0, 1.25, 300.0}));
  ASSERT_EQ(config.axes.size(), 1U);
  EXPECT_EQ(config.axes[0].name, "axis0");
  EXPECT_EQ(config.axes[0].mode, motion::cia402::Mode::kCyclicVelocity);
  EXPECT_NEAR(config.axes[0].increments_per_unit, 65536.0 / 6.283185307, 1e-3);
  EXPECT_DOUBLE_EQ(config.axes[0].rated_torque, 1.25);
  EXPECT_DOUBLE_EQ(config.axes[0].limits.max_velocity, 300.0);
  EXPECT_FALSE(config.path) << "nothing moves that nobody asked to move";
}

TEST(LineDescription, PositionModeGoesBeforeTheOthers) {
  const auto config = described(one_drive({7U << 7U, 65536.0, {}, {}}));
  ASSERT_EQ(config.axes.size(), 1U);
  EXPECT_EQ(config.axes[0].mode, motion::cia402::Mode::kCyclicPosition);
}

TEST(LineDescription, WhatADriveDoesNotTellStandsThereAsAnAssumption) {
  const auto text = must(describe_line(one_drive({std::nullopt, 65536.0, std::nullopt, 1e9})));
  EXPECT_THAT(*text, HasSubstr("mode = \"csp\"  # assumed: 6502h cannot be read"));
  EXPECT_THAT(*text, HasSubstr("# rated_torque_nm = 2.4  # 6076h cannot be read: this is assumed"));
  EXPECT_THAT(*text, HasSubstr("# max_velocity = 200  # 6080h")) << "a billion rad/s is no limit";
  EXPECT_EQ(described(one_drive({std::nullopt, 65536.0, std::nullopt, 1e9})).axes.size(), 1U);
}

TEST(LineDescription, DriveThatCannotBeAnAxisIsNamedWithTheReason) {
  struct Case {
    FoundDrive facts;
    std::string reason;
  };
  for (const auto& [facts, reason] :
       {Case{{0x25U, 65536.0, 1.0, 300.0}, "6502h is 0x00000025: it has none of the modes csp, csv and cst"},
        Case{{1U << 9U, 65536.0, 1.0, 300.0}, "cst is its only cyclic mode"},
        Case{{1U << 7U, std::nullopt, 1.0, 300.0}, "it does not report the scaling of positions (6091h, 6092h, 608Fh)"},
        Case{{1U << 7U, 0.25, 1.0, 300.0}, "0.25 increments per revolution"}}) {
    const auto text = must(describe_line(one_drive(facts)));
    EXPECT_THAT(*text, HasSubstr("# slave0 is left out: "));
    EXPECT_THAT(*text, HasSubstr(reason));
    EXPECT_TRUE(described(one_drive(facts)).axes.empty()) << reason;
    EXPECT_EQ(gentle_path(one_drive(facts), 1.0), "") << reason;
  }
}

TEST(LineDescription, DriveOfAnotherMakerIsAnAxisOnlyWhereItIsReal) {
  auto line = one_drive({1U << 7U, 65536.0, 1.0, 300.0}, 0x1234);
  EXPECT_EQ(described(line).axes.size(), 1U);
  EXPECT_THAT(*describe_line(line), HasSubstr("# Not a drive of the kind that was tried"));
  line.interface.reset();
  EXPECT_TRUE(described(line).axes.empty());
  EXPECT_THAT(*describe_line(line), HasSubstr("a drive of this kind cannot be simulated"));
}

TEST(LineDescription, PdosOfADriveOfAnotherMakerStandWithItsSlaveToBeTaken) {
  auto line = one_drive({1U << 7U, 65536.0, 1.0, 300.0}, 0x1234);
  line.slaves.push_back(found(1, {}, "EK1100"));
  esi::Pdo assigned;
  assigned.index = 0x1601;
  assigned.sync_manager = 2;
  esi::Pdo spare;
  spare.index = 0x1602;
  line.slaves[0].view.info.description.rx_pdos = {spare, assigned};
  auto text = describe_line(line).value();
  EXPECT_FALSE(described(line).slaves[0].plan.pdos) << "not before the user wants it";
  for (const std::string off : {"# [[slave.pdo]]", "# index = "}) {
    for (auto at = text.find(off); at != std::string::npos; at = text.find(off)) text.erase(at, 2);
  }
  const auto config = must(runtime::parse_line_config(text, "found.toml"));
  EXPECT_FALSE(config->slaves[1].plan.pdos) << "not those of its neighbour";
  const auto& pdos = config->slaves[0].plan.pdos;
  ASSERT_TRUE(pdos);
  ASSERT_EQ(pdos->outputs.size(), 1U);
  EXPECT_EQ(pdos->outputs[0].index, 0x1601);
  ASSERT_EQ(pdos->inputs.size(), 1U);
  EXPECT_EQ(pdos->inputs[0].index, 0x1A00) << "its EEPROM tells of none";
  EXPECT_TRUE(pdos->outputs[0].objects.empty());
}

TEST(LineDescription, EachDriveOfASlaveIsAnAxis) {
  auto line = one_drive({1U << 7U, 65536.0, 1.0, 300.0, 0}, 0x1234);
  line.slaves[0].drives.push_back({1U << 8U, 4000.0, 2.0, 200.0, 1});
  line.slaves[0].drives.push_back({1U << 9U, 4000.0, 2.0, 200.0, 2});
  const auto config = described(line);
  ASSERT_EQ(config.axes.size(), 2U);
  EXPECT_EQ(config.axes[0].name, "axis0_0");
  EXPECT_EQ(config.axes[1].name, "axis0_1");
  EXPECT_EQ(config.axes[1].drive, 1);
  EXPECT_EQ(config.axes[1].slave, 0U);
  EXPECT_EQ(config.axes[1].mode, motion::cia402::Mode::kCyclicVelocity);
  EXPECT_THAT(*describe_line(line), HasSubstr("# drive 2 of slave0 is left out: cst is its only cyclic mode"));
  EXPECT_EQ(gentle_path(line, 2), "time[s],axis0_0[rev],axis0_1[rev]\n0,0,0\n3,2,2\n6,0,0\n");
}

TEST(LineDescription, AxesMoveOutAndBackWhenAskedTo) {
  auto line = one_drive({1U << 7U, 65536.0, 1.0, 300.0});
  line.slaves.push_back(found(1, {}, "EK1100"));
  line.slaves.push_back(line.slaves[0]);
  line.slaves[2].view.slave.ref.position = 2;
  EXPECT_EQ(gentle_path(line, -0.25), "time[s],axis0[rev],axis2[rev]\n0,0,0\n1,-0.25,-0.25\n2,0,0\n");
  EXPECT_EQ(gentle_path(line, 4), "time[s],axis0[rev],axis2[rev]\n0,0,0\n6,4,4\n12,0,0\n");
  line.path_file = "line.path.csv";
  const auto config = described(line);
  ASSERT_TRUE(config.path);
  EXPECT_EQ(config.path->file.filename(), "line.path.csv");
  EXPECT_TRUE(config.path->relative);
}

TEST(LineDescription, NamesOfSlavesCannotBecomeKeys) {
  FoundLine line;
  line.slaves = {found(0, {}, "a\"\n[[axis]]\nname = \"x\"\\")};
  line.tree = "master\n[[axis]]\n";
  const auto config = described(line);
  EXPECT_TRUE(config.axes.empty());
  EXPECT_FALSE(config.interface);
}

TEST(LineDescription, SlaveWithoutIdentityIsNamed) {
  FoundLine line;
  line.slaves = {found(0, {}, "EK1100"), found(1, {}, "?")};
  line.slaves[1].view.sii.reset();
  line.slaves[1].view.trouble = "slave 1: EEPROM content is not usable at word 0x0040";
  const auto text = describe_line(line);
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().text, HasSubstr("slave 1: EEPROM"));
}

}  // namespace
}  // namespace driveline::cli
