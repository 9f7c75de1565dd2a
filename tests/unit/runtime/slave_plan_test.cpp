#include <gmock/gmock.h>

#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::IdentityRule;
using motion::MappedObject;
using std::chrono::milliseconds;

/// The plan of a single slave with these lines after its name.
SlavePlanConfig parsed(const std::string& rest) {
  const auto config = parse_line_config("[[slave]]\nname = \"x\"\n" + rest, "line.toml");
  if (!config) throw std::runtime_error(describe(config.error()));
  return config->slaves.at(0).plan;
}

std::string refused(const std::string& rest) {
  const auto config = parse_line_config("[[slave]]\nname = \"x\"\n" + rest, "line.toml");
  return config ? std::string{} : describe(config.error());
}

TEST(SlavePlan, SaysNothingByItself) {
  const auto plan = parsed("");
  EXPECT_EQ(plan.revision, IdentityRule{});
  EXPECT_EQ(plan.serial, IdentityRule{});
  EXPECT_FALSE(plan.alias);
  EXPECT_FALSE(plan.device_id);
  EXPECT_EQ(plan.watchdog, ecat_master::WatchdogPlan{});
  EXPECT_TRUE(plan.sdos.empty());
  EXPECT_FALSE(plan.pdos);
}

TEST(SlavePlan, IdentityHasRules) {
  EXPECT_EQ(parsed("revision = 0x00010002\n").revision, IdentityRule::equal(0x10002));
  EXPECT_EQ(parsed("revision = \">= 0x00010002\"\n").revision, IdentityRule::at_least(0x10002));
  EXPECT_EQ(parsed("revision = \">=7\"\n").revision, IdentityRule::at_least(7));
  EXPECT_EQ(parsed("revision = \"= 7\"\n").revision, IdentityRule::equal(7));
  EXPECT_EQ(parsed("revision = \"any\"\n").revision, IdentityRule{});
  EXPECT_EQ(parsed("serial = 4711\n").serial, IdentityRule::equal(4711));
  EXPECT_EQ(parsed("alias = 7\n").alias, 7);
  EXPECT_FALSE(parsed("alias = 7\n").hot_connect);
  EXPECT_TRUE(parsed("device_id = 7\nhot_connect = true\n").hot_connect);
  EXPECT_EQ(parsed("device_id = 9\n").device_id, 9);
}

TEST(SlavePlan, WatchdogsAndTimeLimits) {
  const auto plan = parsed(
      "[slave.watchdog]\nprocess_data_ms = 50\npdi_ms = 0\n[slave.timeouts]\npreop_ms = 1\nsafeop_ms = 2\nop_ms = 3\n"
      "back_to_init_ms = 4\nback_to_safeop_ms = 5\nmailbox_request_ms = 6\nmailbox_response_ms = 7\n"
      "mailbox_repeat_ms = 0\n");
  EXPECT_EQ(plan.watchdog.divider, 2498);
  EXPECT_EQ(plan.watchdog.process_data, 500) << "increments of 100 us";
  EXPECT_EQ(plan.watchdog.pdi, 0);
  EXPECT_EQ(plan.timeouts.to_pre_op, milliseconds{1});
  EXPECT_EQ(plan.timeouts.to_safe_op, milliseconds{2});
  EXPECT_EQ(plan.timeouts.to_op, milliseconds{3});
  EXPECT_EQ(plan.timeouts.back_to_init, milliseconds{4});
  EXPECT_EQ(plan.timeouts.back_to_safe_op, milliseconds{5});
  EXPECT_EQ(plan.mailbox_timeouts, (ecat_master::MailboxTimeouts{milliseconds{6}, milliseconds{7}, milliseconds{0}}));
  const auto both = parsed("state_timeout_ms = 30000\n[slave.timeouts]\nop_ms = 3\n").timeouts;
  EXPECT_EQ(both.to_safe_op, milliseconds{30000});
  EXPECT_EQ(both.to_op, milliseconds{3}) << "the time of the state takes precedence";
  EXPECT_FALSE(both.to_pre_op);
  EXPECT_FALSE(parsed("").mailbox_timeouts.repeat) << "a quarter of the time-out of the answer";
}

TEST(SlavePlan, TheApplicationGetsTheEepromWhenItSaysSo) {
  EXPECT_EQ(parsed("eeprom_to_application = true\n").eeprom_to_application, true);
  EXPECT_EQ(parsed("eeprom_to_application = false\n").eeprom_to_application, false);
  EXPECT_FALSE(parsed("").eeprom_to_application);
  ecat_master::SlavePlan plan;
  parsed("eeprom_to_application = true\n").apply(plan);
  EXPECT_EQ(plan.eeprom_to_application, true);
}

TEST(SlavePlan, WritesThatASlaveMayRefuse) {
  using motion::WriteNeed;
  const auto by_default = parsed("");
  EXPECT_EQ(by_default.needs, ecat_master::StartupNeeds{});
  EXPECT_EQ(by_default.interpolation_time, WriteNeed::kOptional);
  EXPECT_EQ(by_default.safe_op_retries.count, 2U);
  const auto plan = parsed(
      "[slave.startup]\nsync_objects = \"mandatory\"\ninterpolation_time = \"omit\"\npdo_assignment = \"omit\"\n"
      "pdo_mapping = \"mandatory\"\nsafeop_retries = 7\n");
  EXPECT_EQ(plan.needs.sync_objects, WriteNeed::kMandatory);
  EXPECT_EQ(plan.needs.pdo_assignment, WriteNeed::kOmitted);
  EXPECT_EQ(plan.needs.pdo_mapping, WriteNeed::kMandatory);
  EXPECT_EQ(plan.interpolation_time, WriteNeed::kOmitted);
  EXPECT_EQ(plan.safe_op_retries.count, 7U);
}

/// The key is about the 60C2h of the axis; an SDO of the file has its own key.
TEST(SlavePlan, TheInterpolationTimeOfTheFileIsNotThatOfTheAxis) {
  using motion::WriteNeed;
  const auto config = parsed(
      "[slave.startup]\ninterpolation_time = \"omit\"\n[[slave.sdo]]\nindex = 0x60C2\nsubindex = 1\ntype = \"uint8\"\n"
      "value = 4\n[[slave.sdo]]\nindex = 0x6065\ntype = \"uint32\"\nvalue = 9\noptional = true\n");
  ecat_master::SlavePlan plan;
  plan.startup_sdos.push_back({0x60C2, 1, {std::byte{8}}});
  config.apply(plan);
  ASSERT_EQ(plan.startup_sdos.size(), 3U);
  EXPECT_EQ(plan.startup_sdos[0].need, WriteNeed::kOmitted);
  EXPECT_EQ(plan.startup_sdos[1].need, WriteNeed::kMandatory);
  EXPECT_EQ(plan.startup_sdos[2].need, WriteNeed::kOptional);
}

TEST(SlavePlan, StartupSdosInTheirOrder) {
  const auto plan = parsed(
      "[[slave.sdo]]\nindex = 0x6065\ntype = \"uint32\"\nvalue = 1000\n"
      "[[slave.sdo]]\nindex = 0x2003\nsubindex = 1\ncomplete = true\nbefore = \"op\"\nvalue = \"01 02 03\"\n");
  ASSERT_EQ(plan.sdos.size(), 2U);
  EXPECT_EQ(plan.sdos[0].index, 0x6065);
  EXPECT_THAT(plan.sdos[0].data, testing::ElementsAre(std::byte{0xE8}, std::byte{3}, std::byte{0}, std::byte{0}));
  EXPECT_EQ(plan.sdos[0].in, motion::StartupState::kPreOperational);
  EXPECT_FALSE(plan.sdos[0].complete);
  EXPECT_EQ(plan.sdos[1].subindex, 1);
  EXPECT_TRUE(plan.sdos[1].complete);
  EXPECT_EQ(plan.sdos[1].in, motion::StartupState::kSafeOperational);
  EXPECT_EQ(plan.sdos[1].data.size(), 3U);
}

TEST(SlavePlan, StartupIdns) {
  const auto plan = parsed(
      "[[slave.idn]]\ndrive = 2\nnumber = \"P-0-3030\"\nvalue = 3\ntransition = \"SO\"\nread_back = false\n"
      "[[slave.idn]]\nnumber = \"S-0-0016\"\nvalue = [\"S-0-0040\", 51, -7]\n"
      "[[slave.idn]]\nnumber = \"S-0-0142\"\nvalue = \"crane\"\n"
      "[[slave.idn]]\nnumber = \"S-0-0044\"\ndata = \"0A 1b00\"\n");
  ASSERT_EQ(plan.idns.size(), 4U);
  using Idn = ecat_master::StartupIdn;
  EXPECT_EQ(plan.idns[0].at, (ecat_master::facts::SoeDatum{2, {0x8000 + 3030}}));
  EXPECT_EQ(std::get<Idn::Single>(plan.idns[0].value), "3");
  EXPECT_EQ(plan.idns[0].in, motion::StartupState::kSafeOperational);
  EXPECT_FALSE(plan.idns[0].read_back);
  EXPECT_EQ(plan.idns[0].place, "line.toml:5: [slave 1.idn 1] number");
  EXPECT_EQ(std::get<Idn::List>(plan.idns[1].value), (Idn::List{"S-0-0040", "51", "-7"}));
  EXPECT_EQ(plan.idns[1].in, motion::StartupState::kPreOperational);
  EXPECT_TRUE(plan.idns[1].read_back);
  EXPECT_EQ(std::get<Idn::Single>(plan.idns[2].value), "crane");
  EXPECT_EQ(std::get<Idn::Raw>(plan.idns[3].value), (Idn::Raw{std::byte{0x0A}, std::byte{0x1B}, std::byte{0}}));
  ecat_master::SlavePlan applied;
  plan.apply(applied);
  EXPECT_EQ(applied.startup_idns.size(), 4U);
}

TEST(SlavePlan, PdosGoWhereTheirIndexBelongs) {
  const auto plan = parsed(
      "[[slave.pdo]]\nindex = 0x1600\nentries = [\"0x6040:0:16\", \"0x607A:0:32\"]\n"
      "[[slave.pdo]]\nindex = 0x1A00\nsync_manager = 3\nentries = [\"0x6041:0:16\"]\n");
  ASSERT_TRUE(plan.pdos);
  ASSERT_EQ(plan.pdos->outputs.size(), 1U);
  EXPECT_THAT(plan.pdos->outputs[0].objects,
              testing::ElementsAre(MappedObject{0x6040, 0, 16}, MappedObject{0x607A, 0, 32}));
  EXPECT_FALSE(plan.pdos->outputs[0].sync_manager);
  ASSERT_EQ(plan.pdos->inputs.size(), 1U);
  EXPECT_EQ(plan.pdos->inputs[0].sync_manager, 3);
}

TEST(SlavePlan, ApplyAddsToWhatIsPlanned) {
  const auto config = parsed("alias = 3\n[[slave.sdo]]\nindex = 0x6065\ntype = \"uint32\"\nvalue = 1\n");
  ecat_master::SlavePlan plan;
  plan.startup_sdos.push_back({0x6060, 0, {std::byte{8}}, false, motion::StartupState::kPreOperational});
  plan.pdos.outputs.push_back({0x1600, {}, std::nullopt});
  config.apply(plan);
  EXPECT_EQ(plan.alias, 3);
  ASSERT_EQ(plan.startup_sdos.size(), 2U);
  EXPECT_EQ(plan.startup_sdos[1].index, 0x6065);
  EXPECT_EQ(plan.pdos.outputs.size(), 1U) << "nothing is said about PDOs";
}

/// A line with the head of a group; `rest` starts at line 5.
std::string with_head(const std::string& rest) {
  return "[[slave]]\nname = \"head\"\nalias = 7\nhot_connect = true\n" + rest;
}

std::string refused_group(const std::string& rest) {
  const auto config = parse_line_config(with_head(rest), "line.toml");
  return config ? std::string{} : describe(config.error());
}

TEST(SlavePlan, SlavesOfAHotConnectGroupFollowTheirHead) {
  const auto config = parse_line_config(with_head("[[slave]]\nname = \"a\"\nhot_connect = \"head\"\n"
                                                  "[[slave]]\nname = \"b\"\nhot_connect = \"head\"\n"),
                                        "line.toml");
  ASSERT_TRUE(config) << describe(config.error());
  EXPECT_FALSE(config->slaves[0].plan.behind);
  EXPECT_EQ(config->slaves[1].plan.behind, (ecat_master::HotConnectPlace{0, 1}));
  EXPECT_EQ(config->slaves[2].plan.behind, (ecat_master::HotConnectPlace{0, 2}));
  ecat_master::SlavePlan plan;
  config->slaves[2].plan.apply(plan);
  EXPECT_TRUE(plan.hot_connect);
  EXPECT_EQ(plan.behind, (ecat_master::HotConnectPlace{0, 2}));
}

TEST(SlavePlan, GroupsThatAreNoneAreRefused) {
  EXPECT_EQ(
      refused_group("[[slave]]\nname = \"a\"\nhot_connect = \"hand\"\n"),
      "line.toml:7: [slave 2] hot_connect: is \"hand\": true, false, or the name of a [[slave]] above is expected");
  EXPECT_EQ(
      refused_group("[[slave]]\nname = \"a\"\n[[slave]]\nname = \"b\"\nhot_connect = \"a\"\n"),
      "line.toml:9: [slave 3] hot_connect: is \"a\", which is not the head of a group: hot_connect = true and alias "
      "or device_id of \"a\" are expected");
  EXPECT_EQ(refused_group("[[slave]]\nname = \"a\"\n[[slave]]\nname = \"b\"\nhot_connect = \"head\"\n"),
            "line.toml:9: [slave 3] hot_connect: is \"head\", but \"a\" is between them and not in that group: the "
            "slaves of a group must be adjacent");
  EXPECT_EQ(refused_group("[[slave]]\nname = \"a\"\nalias = 9\nhot_connect = \"head\"\n"),
            "line.toml:8: [slave 2] hot_connect: names the head of its group, \"head\", which is identified by its own "
            "alias or device_id: remove the key from this slave");
}

TEST(SlavePlan, WrongValuesAreNamedWithTheirLine) {
  EXPECT_EQ(refused("revision = \"newer\"\n"),
            "line.toml:3: [slave 1] revision: is \"newer\", expected a number, \">= number\" or \"any\"");
  EXPECT_EQ(
      refused("hot_connect = true\n"),
      "line.toml:3: [slave 1] hot_connect: needs alias or device_id to identify the slave wherever it is plugged in");
  EXPECT_EQ(refused("alias = 1\ndevice_id = 2\n"),
            "line.toml:4: [slave 1] device_id: is set together with alias: only one of them is expected");
  EXPECT_THAT(refused("alias = 0\n"), testing::StartsWith("line.toml:3: [slave 1] alias: "));
  EXPECT_THAT(refused("[slave.watchdog]\nprocess_data_ms = -1\n"),
              testing::StartsWith("line.toml:4: [slave 1.watchdog] process_data_ms: "));
  EXPECT_THAT(refused("[[slave.sdo]]\nindex = 0x6065\ntype = \"uint8\"\nvalue = 300\n"),
              testing::StartsWith("line.toml:6: [slave 1.sdo 1] value: "));
  EXPECT_THAT(refused("[[slave.sdo]]\nindex = 0x6065\ntype = \"word\"\nvalue = 3\n"),
              testing::StartsWith("line.toml:5: [slave 1.sdo 1] type: "));
  EXPECT_EQ(refused("[[slave.pdo]]\nindex = 0x1600\nentries = [\"0x6040:16\"]\n"),
            "line.toml:5: [slave 1.pdo 1] entries: \"0x6040:16\" is not \"index:sub-index:bits\", e.g. "
            "\"0x6040:0:16\"");
  EXPECT_EQ(refused("[[slave.idn]]\nnumber = \"S-0-4096\"\nvalue = 1\n"),
            "line.toml:4: [slave 1.idn 1] number: is \"S-0-4096\", expected an IDN like \"S-0-0044\" or \"P-0-3030\"");
  EXPECT_EQ(refused("[[slave.idn]]\nnumber = \"S-0-0044\"\ndata = \"0A 1\"\n"),
            "line.toml:5: [slave 1.idn 1] data: is \"0A 1\", expected bytes in hexadecimal like \"0A 00\"");
  EXPECT_EQ(refused("[[slave.idn]]\nnumber = \"S-0-0044\"\nvalue = 1\ndata = \"0A\"\n"),
            "line.toml:6: [slave 1.idn 1] data: is set together with value: only one of them is expected");
  EXPECT_THAT(refused("[[slave.idn]]\ndrive = 8\nnumber = \"S-0-0044\"\nvalue = 1\n"),
              testing::StartsWith("line.toml:4: [slave 1.idn 1] drive: "));
  EXPECT_THAT(refused("[[slave.idn]]\nnumber = \"S-0-0044\"\nvalue = [true]\n"),
              testing::StartsWith("line.toml:5: [slave 1.idn 1] value: contains "));
  EXPECT_THAT(refused("[slave.watchdog]\nsm_ms = 1\n"), testing::HasSubstr("sm_ms: unknown key"));
  EXPECT_EQ(
      refused("[slave.startup]\npdo_mapping = \"optionally\"\n"),
      "line.toml:4: [slave 1.startup] pdo_mapping: is \"optionally\", one of \"mandatory\", \"optional\", \"omit\" is "
      "expected; did you mean \"optional\"?");
}

}  // namespace
}  // namespace driveline::runtime
