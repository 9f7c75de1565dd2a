#include <gmock/gmock.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <utility>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/soe/soe_client.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::Master;
using ecat_master::SoeClient;
using ecat_master::facts::SoeDatum;
using slaves::generic::GenericDevice;
using testing::HasSubstr;
using testing::SizeIs;
using wire::Idn;
using wire::SoeElement;
using Bytes = std::vector<std::byte>;

constexpr SoeDatum kGain{0, {100}};
constexpr SoeDatum kReset{0, {99}};

/// A device with mailboxes of `mailbox` bytes that knows SoE and CoE.
esi::DeviceDescription soe_device(std::uint16_t mailbox) {
  using Use = esi::SyncManager::Use;
  esi::DeviceDescription device;
  device.vendor_id = 0x1234;
  device.product_code = 0x0500 + std::uint32_t{mailbox};
  device.name = "SoE drive";
  device.type = "SoE drive";
  device.eeprom_config_data_hex = "050E000000000000000000000000";
  device.mailbox.coe = true;
  device.mailbox.soe = true;
  device.sync_managers = {{Use::kMailboxOut, 0x1000, mailbox, mailbox, mailbox, 0x26, true},
                          {Use::kMailboxIn, 0x1400, mailbox, mailbox, mailbox, 0x22, true}};
  return device;
}

/// Two of them.
struct SoeLine {
  explicit SoeLine(std::uint16_t mailbox = 128) : line(make(mailbox)), master(*line, clock) {}

  std::unique_ptr<slaves::Line> make(std::uint16_t mailbox) {
    auto model = slaves::generic::DeviceModel::create(soe_device(mailbox));
    if (!model) throw std::runtime_error(describe(model.error()));
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (int i = 0; i < 2; ++i) {
      made.push_back(std::make_unique<slaves::Slave>(
          std::make_unique<GenericDevice>(*model, slaves::generic::GenericOptions{}), slaves::SlaveOptions{}));
    }
    return std::make_unique<slaves::Line>(clock, std::move(made), slaves::LineOptions{}, std::nullopt);
  }
  void to_pre_op() {
    ASSERT_EQ(sentence(master.scan()), "");
    ASSERT_EQ(sentence(master.enter_pre_op()), "");
  }
  SoeClient soe(std::uint16_t position = 0) { return {master.mailboxes(), position}; }

  rt::VirtualClock clock{milliseconds{1}};
  std::unique_ptr<slaves::Line> line;
  Master master;
};

TEST(SoeOnTheLine, TheDescriptionSaysThatTheSlaveKnowsIt) {
  SoeLine line;
  line.to_pre_op();
  EXPECT_TRUE(line.master.slaves()[0].info.description.mailbox.soe);
}

TEST(SoeOnTheLine, ReadsTheListOfAllAndEverythingAboutEachInMailboxesOfAnySize) {
  // The list has 4 + 18 bytes: less than a mail, the whole of it, and one byte more than it, twice and three times.
  for (const auto mailbox : std::array<std::uint16_t, 6>{22, 31, 32, 33, 34, 128}) {
    SoeLine line(mailbox);
    line.to_pre_op();
    const auto list = line.soe().idn_list({0, {17}});
    ASSERT_EQ(sentence(list), "") << mailbox;
    EXPECT_THAT(*list,
                testing::ElementsAre(Idn{1}, Idn{11}, Idn{14}, Idn{17}, Idn{40}, Idn{51}, Idn{95}, Idn{99}, Idn{100}));
    for (const auto idn : *list) {
      const auto parameter = line.soe().parameter({0, idn});
      ASSERT_EQ(sentence(parameter), "") << idn.raw;
      EXPECT_TRUE(parameter->name && parameter->value) << idn.raw;
    }
    const auto together = line.soe().read({0, {1}}, wire::SoeElementSet::of(0xFE));
    ASSERT_EQ(sentence(together), "") << mailbox;
    const auto parameter = take_apart(*together);
    ASSERT_TRUE(parameter);
    EXPECT_EQ(parameter->name, "NC cycle time (TNcyc)");
    EXPECT_EQ(parameter->unit, "us");
    EXPECT_EQ(parameter->preset, parameter->value);
  }
}

TEST(SoeOnTheLine, WritesStayAndRefusalsAreNamed) {
  SoeLine line;
  line.to_pre_op();
  const Bytes value{std::byte{0x2C}, std::byte{0x01}};
  ASSERT_EQ(sentence(line.soe().write_value(kGain, value)), "");
  EXPECT_EQ(line.soe().value(kGain).value(), value);
  EXPECT_NE(line.soe(1).value(kGain).value(), value) << "the other slave";
  EXPECT_EQ(sentence(line.soe().write_value(kGain, Bytes(2))),
            "slave 0: refused S-0-0100 of drive 0 with SoE error 0x7006 (value below its minimum)");
  EXPECT_EQ(sentence(line.soe().value({1, {100}})),
            "slave 0: refused S-0-0100 of drive 1 with SoE error 0x800A (there is no such drive)");
  EXPECT_EQ(sentence(line.soe().value({0, {0x8100}})),
            "slave 0: refused P-0-0256 of drive 0 with SoE error 0x1001 (there is no such IDN)");
  EXPECT_EQ(sentence(line.soe().write({0, {11}}, SoeElement::kValue, Bytes(500))),
            "slave 0: refused S-0-0011 of drive 0 with SoE error 0x7004 (the value cannot be changed)")
      << "in fragments";
}

TEST(SoeOnTheLine, ACommandIsCarriedOutAndTellsIt) {
  SoeLine line;
  line.to_pre_op();
  ASSERT_EQ(sentence(line.soe().execute(kReset)), "");
  EXPECT_EQ(line.soe().parameter(kReset)->state, 0U) << "cancelled in the end";
  const auto records = line.master.soe_messages().take();
  ASSERT_THAT(records, SizeIs(1));
  EXPECT_THAT(describe(records[0]), HasSubstr("slave 0 drive 0: S-0-0099 is executed (data state 0x0003)"));
}

TEST(SoeOnTheLine, MixesWithSdosAndOtherSlaves) {
  SoeLine line(34);
  line.to_pre_op();
  ecat_master::CoeClient coe(line.master.mailboxes(), 0);
  const auto list = line.soe().start_read({0, {17}}, SoeElement::kValue);
  const auto write = line.soe().start_write({0, {11}}, SoeElement::kValue, Bytes(200));
  const auto sdo = coe.start_upload({0x1018, 2}, {}, 3);
  const auto other = line.soe(1).start_read({0, {17}}, SoeElement::kValue);
  line.master.mailboxes().wait(*other);
  line.master.mailboxes().wait(*list);
  line.master.mailboxes().wait(*write);
  EXPECT_EQ(sentence(sdo.get()), "");
  EXPECT_EQ(sentence(list->result()), "");
  EXPECT_THAT(sentence(write->result()), HasSubstr("0x7004"));
  EXPECT_EQ(other->result()->data, list->result()->data);
}

TEST(SoeOnTheLine, LostFramesCostNothingButTime) {
  for (const auto way : {LossyPort::Way::kOut, LossyPort::Way::kBack}) {
    SoeLine line(34);
    unsigned frames = 0;
    LossyPort port(*line.line, way, [&](auto, auto) { return ++frames % 20 == 0; });
    Master master(port, line.clock);
    ASSERT_EQ(sentence(master.scan()), "");
    ASSERT_EQ(sentence(master.enter_pre_op()), "");
    SoeClient soe(master.mailboxes(), 0);
    for (int i = 0; i < 20; ++i) {
      ASSERT_THAT(soe.idn_list({0, {17}}).value(), SizeIs(9));
      ASSERT_THAT(sentence(soe.write({0, {11}}, SoeElement::kValue, Bytes(100))), HasSubstr("0x7004"));
    }
    EXPECT_GT(port.lost(), 5U);
  }
}

}  // namespace
}  // namespace driveline::bus_test
