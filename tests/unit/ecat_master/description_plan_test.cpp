// Settings of a slave from a description file, and settings with higher priority.
#include "driveline/ecat_master/configuration/description_plan.hpp"

#include <gmock/gmock.h>

namespace driveline::ecat_master {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using Use = esi::SyncManager::Use;

/// Two output PDOs, one of which excludes the other, two inputs, one of them fixed and one mandatory.
esi::DeviceDescription device() {
  esi::DeviceDescription made;
  made.vendor_id = 1;
  made.product_code = 2;
  made.revision = 3;
  made.mailbox.coe = made.mailbox.coe_pdo_assign = made.mailbox.coe_pdo_config = true;
  made.sync_managers = {{Use::kMailboxOut, 0x1000, 128, 0, 0, 0x26, true},
                        {Use::kMailboxIn, 0x1080, 128, 0, 0, 0x22, true},
                        {Use::kOutputs, 0x1100, 4, 0, 0, 0x64, true},
                        {Use::kInputs, 0x1200, 4, 0, 0, 0x20, true}};
  const auto pdo = [](std::uint16_t index, std::uint16_t object, std::optional<std::uint8_t> sync_manager) {
    esi::Pdo one;
    one.index = index;
    one.sync_manager = sync_manager;
    one.entries = {{object, 1, 16, "Value", esi::DataType::kUnsigned16}, {0, 0, 16, "", esi::DataType::kUnsigned8}};
    return one;
  };
  made.rx_pdos = {pdo(0x1600, 0x7000, std::uint8_t{2}), pdo(0x1601, 0x7010, std::nullopt)};
  made.rx_pdos[1].excluded = {0x1600};
  made.tx_pdos = {pdo(0x1A00, 0x6000, std::uint8_t{3}), pdo(0x1A01, 0x6010, std::uint8_t{3})};
  made.tx_pdos[0].fixed = true;
  made.tx_pdos[1].mandatory = true;
  made.timeouts = {2000, 9000, 4000, 300, 100, 5000};
  made.watchdogs = {2498, 10, 500};
  made.init_commands = {{{"SO"}, 0x8001, 0, "02", false},
                        {{"PS"}, 0x8000, 3, "6400", true},
                        {{"IP"}, 0x8002, 1, "03", false},
                        {{"OS"}, 0x8003, 1, "04", false}};
  return made;
}

ConfiguredSlave slave_with_file() {
  ConfiguredSlave slave{};
  slave.info.description.vendor_id = 1;
  slave.info.description.product_code = 2;
  slave.info.description.revision = 7;
  slave.info.description.serial_number = 4711;
  slave.plan.esi = std::make_shared<const esi::DeviceDescription>(device());
  slave.plan.own_pdos = true;
  return slave;
}

std::vector<std::string> texts(const std::vector<SdoScript::Step>& steps) {
  std::vector<std::string> all;
  for (const auto& step : steps) {
    char text[32];
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < step.data.size(); ++i) value |= std::to_integer<std::uint32_t>(step.data[i]) << (8 * i);
    std::snprintf(text, sizeof text, "%04X:%02X=%X", step.at.index, step.at.subindex, value);
    all.emplace_back(text);
  }
  return all;
}

TEST(DescriptionPlan, TheFileDecidesWhereThePlanSaysNothing) {
  auto slave = slave_with_file();
  apply_description(slave);
  const auto& plan = slave.plan;
  EXPECT_EQ(plan.timeouts, (StateTimeouts{milliseconds{2000}, milliseconds{9000}, milliseconds{9000},
                                          milliseconds{4000}, milliseconds{300}}));
  EXPECT_EQ(plan.mailbox_timeouts, (MailboxTimeouts{milliseconds{100}, milliseconds{5000}}));
  EXPECT_EQ(plan.watchdog, (WatchdogPlan{2498, 500, 10}));
  EXPECT_FALSE(plan.own_pdos);
  ASSERT_EQ(plan.pdos.outputs.size(), 1U) << "only what the file assigns";
  EXPECT_EQ(plan.pdos.outputs[0].index, 0x1600);
  EXPECT_EQ(plan.pdos.inputs.size(), 2U);
  EXPECT_EQ(slave.info.description.sync_managers.size(), 4U);
  EXPECT_EQ(slave.info.description.revision, 7U) << "identity stays that of the slave";
  EXPECT_EQ(slave.info.description.serial_number, 4711U);
}

TEST(DescriptionPlan, ThePlanGoesBeforeTheFile) {
  auto slave = slave_with_file();
  slave.plan.timeouts.to_op = milliseconds{1};
  slave.plan.mailbox_timeouts.response = milliseconds{2};
  slave.plan.watchdog.pdi = 77;
  slave.plan.own_pdos = false;
  slave.plan.pdos.outputs = {{0x1601, {}, std::nullopt}};
  slave.plan.startup_sdos.push_back({0x9000, 0, {std::byte{1}}});
  apply_description(slave);
  EXPECT_EQ(slave.plan.timeouts.to_op, milliseconds{1});
  EXPECT_EQ(slave.plan.timeouts.to_safe_op, milliseconds{9000});
  EXPECT_EQ(slave.plan.mailbox_timeouts, (MailboxTimeouts{milliseconds{100}, milliseconds{2}}));
  EXPECT_EQ(slave.plan.watchdog, (WatchdogPlan{std::nullopt, std::nullopt, 77})) << "increments of one divider";
  ASSERT_EQ(slave.plan.pdos.outputs.size(), 1U);
  EXPECT_THAT(slave.plan.pdos.outputs[0].objects,
              ElementsAre(motion::MappedObject{0x7010, 1, 16}, motion::MappedObject{0, 0, 16}))
      << "out of the file";
  EXPECT_TRUE(slave.plan.pdos.inputs.empty());
  std::vector<std::uint16_t> written;
  for (const auto& sdo : slave.plan.startup_sdos) written.push_back(sdo.index);
  EXPECT_THAT(written, ElementsAre(0x8002, 0x8000, 0x8001, 0x9000)) << "the file's first, in the order of the way up";
}

TEST(DescriptionPlan, TheApplicationGetsTheEepromAsPlannedElseAsTheFileSays) {
  for (const bool in_file : {true, false}) {
    for (const std::optional<bool> planned : {std::optional<bool>{}, std::optional{true}, std::optional{false}}) {
      auto slave = slave_with_file();
      auto file = device();
      file.eeprom_to_application = in_file;
      slave.plan.esi = std::make_shared<const esi::DeviceDescription>(file);
      slave.plan.eeprom_to_application = planned;
      apply_description(slave);
      EXPECT_EQ(slave.info.description.eeprom_to_application, planned.value_or(in_file));
      slave.plan.esi = nullptr;
      apply_description(slave);
      EXPECT_EQ(slave.info.description.eeprom_to_application, planned.value_or(false)) << "without the file";
    }
  }
}

TEST(DescriptionPlan, WithoutAFileTheEepromIsInForceAgain) {
  auto slave = slave_with_file();
  apply_description(slave);
  slave.plan = {};
  apply_description(slave);
  EXPECT_TRUE(slave.info.description.sync_managers.empty());
  EXPECT_EQ(slave.plan.timeouts, StateTimeouts{});
}

TEST(DescriptionPlan, PdosOfModulesAreLeftToTheSlave) {
  auto slave = slave_with_file();
  auto modular = device();
  modular.rx_pdos.clear();
  modular.tx_pdos.clear();
  slave.plan.esi = std::make_shared<const esi::DeviceDescription>(modular);
  apply_description(slave);
  EXPECT_TRUE(slave.plan.own_pdos);
}

TEST(StartUpCommands, AreTakenInTheOrderOfTheTransitions) {
  const auto sdos = startup_commands(device());
  ASSERT_EQ(sdos.size(), 3U) << "none on the way down";
  EXPECT_EQ(sdos[0].index, 0x8002);
  EXPECT_EQ(sdos[0].in, motion::StartupState::kPreOperational);
  EXPECT_EQ(sdos[1].index, 0x8000);
  EXPECT_TRUE(sdos[1].complete);
  EXPECT_THAT(sdos[1].data, ElementsAre(std::byte{0x64}, std::byte{0}));
  EXPECT_EQ(sdos[2].in, motion::StartupState::kSafeOperational);
}

TEST(PdosOfAFile, AreCheckedAgainstWhatTheDeviceAllows) {
  const auto refusal = [](const esi::DeviceDescription& made, std::vector<motion::PdoMapping> out,
                          std::vector<motion::PdoMapping> in) {
    motion::PdoConfiguration pdos{std::move(out), std::move(in)};
    complete_pdos(made, pdos);
    const auto fit = check_pdos(made, pdos);
    return fit ? std::string{} : describe(fit.error());
  };
  const motion::PdoMapping mandatory{0x1A01, {}, std::nullopt};
  EXPECT_EQ(refusal(device(), {{0x1600, {}, {}}}, {mandatory}), "");
  EXPECT_EQ(refusal(device(), {{0x1600, {{0x7020, 1, 8}}, {}}}, {mandatory}), "") << "its content can be changed";
  EXPECT_EQ(refusal(device(), {}, {}), "PDO 1A01h is mandatory and missing");
  EXPECT_EQ(refusal(device(), {{0x1600, {}, {}}, {0x1601, {}, {}}}, {mandatory}), "PDO 1601h excludes PDO 1600h");
  EXPECT_EQ(refusal(device(), {}, {{0x1A00, {{0x6000, 1, 8}}, {}}, mandatory}),
            "PDO 1A00h is fixed: its entries cannot be changed");
  EXPECT_EQ(refusal(device(), {{0x1600, {}, 3}}, {mandatory}),
            "PDO 1600h is assigned to sync manager 3, which carries no outputs");
  EXPECT_EQ(refusal(device(), {{0x1600, {}, 9}}, {mandatory}),
            "PDO 1600h is assigned to sync manager 9, which carries no outputs");
  auto two = device();
  two.sync_managers.push_back(two.sync_managers.back());
  EXPECT_EQ(refusal(two, {}, {{0x1A00, {}, 4}, mandatory}),
            "PDO 1A00h is fixed in sync manager 3, sync manager 4 is planned");
  auto rigid = device();
  rigid.mailbox.coe_pdo_config = false;
  EXPECT_THAT(refusal(rigid, {{0x1600, {{0x7020, 1, 8}}, {}}}, {mandatory}), HasSubstr("no PDO configuration"));
  EXPECT_EQ(refusal(rigid, {{0x1605, {{0x7020, 1, 8}}, {}}}, {mandatory}),
            "the device has no PDO 1605h in this direction");
  rigid.mailbox.coe_pdo_assign = false;
  EXPECT_EQ(refusal(rigid, {{0x1601, {}, {}}}, {mandatory}),
            "PDO 1600h is assigned by the device, which cannot be changed");
  EXPECT_EQ(refusal(rigid, {{0x1600, {}, {}}, {0x1601, {}, {}}}, {{0x1A00, {}, {}}, mandatory}),
            "PDO 1601h excludes PDO 1600h");
}

TEST(PdosOfAFile, AreWrittenAsFarAsTheDeviceAllows) {
  auto made = device();
  motion::PdoConfiguration pdos{{{0x1600, {}, {}}}, {{0x1A00, {}, {}}, {0x1A01, {}, {}}}};
  complete_pdos(made, pdos);
  EXPECT_THAT(texts(steps_of(plan_assignments(pdos, made))),
              ElementsAre("1C12:00=0", "1600:00=0", "1600:01=70000110", "1600:02=10", "1600:00=2", "1C12:00=0",
                          "1C12:01=1600", "1C12:00=1",  //
                          "1C13:00=0", "1A01:00=0", "1A01:01=60100110", "1A01:02=10", "1A01:00=2", "1C13:00=0",
                          "1C13:01=1A00", "1C13:02=1A01", "1C13:00=2"))
      << "1A00h is fixed";
  made.mailbox.coe_pdo_config = false;
  EXPECT_THAT(
      texts(steps_of(plan_assignments(pdos, made))),
      ElementsAre("1C12:00=0", "1C12:01=1600", "1C12:00=1", "1C13:00=0", "1C13:01=1A00", "1C13:02=1A01", "1C13:00=2"));
  made.mailbox.coe_pdo_assign = false;
  EXPECT_TRUE(plan_assignments(pdos, made).empty());
}

}  // namespace
}  // namespace driveline::ecat_master
