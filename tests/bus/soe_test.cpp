#include <gmock/gmock.h>

#include <array>
#include <string>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "fault_ports.hpp"
#include "soe_line.hpp"
#include "started_line.hpp"
#include "support/must.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::SoeClient;
using testing::HasSubstr;
using testing::SizeIs;
using wire::Idn;
using wire::SoeElement;
using Bytes = std::vector<std::byte>;

TEST(SoeOnTheLine, TheDescriptionSaysThatTheSlaveKnowsIt) {
  SoeLine line;
  ASSERT_EQ(line.to_pre_op(), "");
  EXPECT_TRUE(line.master.slaves()[0].info.description.mailbox.soe);
}

TEST(SoeOnTheLine, ReadsTheListOfAllAndEverythingAboutEachInMailboxesOfAnySize) {
  // The list has 4 + 20 bytes: two messages, one byte more than a message, exactly one, less than one.
  for (const auto mailbox : std::array<std::uint16_t, 5>{22, 33, 34, 35, 128}) {
    SoeLine line(mailbox);
    ASSERT_EQ(line.to_pre_op(), "");
    const auto list = line.soe().idn_list({0, {17}});
    ASSERT_EQ(sentence(list), "") << mailbox;
    EXPECT_THAT(*list, testing::ElementsAre(Idn{1}, Idn{11}, Idn{14}, Idn{17}, Idn{40}, Idn{51}, Idn{95}, Idn{99},
                                            Idn{100}, Idn{142}));
    for (const auto idn : *list) {
      const auto parameter = line.soe().parameter({0, idn});
      ASSERT_EQ(sentence(parameter), "") << idn.raw;
      EXPECT_TRUE(parameter->name && parameter->value) << idn.raw;
    }
    const auto together = line.soe().read({0, {1}}, wire::SoeElementSet::of(0xFE));
    ASSERT_EQ(sentence(together), "") << mailbox;
    const auto parameter = must(decode_parameter(*together));
    EXPECT_EQ(parameter->name, "NC cycle time (TNcyc)");
    EXPECT_EQ(parameter->unit, "us");
    EXPECT_EQ(parameter->preset, parameter->value);
  }
}

TEST(SoeOnTheLine, WritesStayAndRefusalsAreNamed) {
  SoeLine line;
  ASSERT_EQ(line.to_pre_op(), "");
  const Bytes value{std::byte{0x2C}, std::byte{0x01}};
  ASSERT_EQ(sentence(line.soe().write_value(kGain, value)), "");
  EXPECT_EQ(line.soe().value(kGain).value(), value);
  EXPECT_NE(line.soe(1).value(kGain).value(), value) << "the other slave";
  EXPECT_EQ(sentence(line.soe().write_value(kGain, Bytes(2))),
            "slave 0: refused S-0-0100 of drive 0 with SoE error 0x7006 (value below its minimum)");
  for (std::uint8_t drive = 2; drive < 8; ++drive) {
    EXPECT_EQ(sentence(line.soe().value({drive, {100}})), "slave 0: refused S-0-0100 of drive " +
                                                              std::to_string(drive) +
                                                              " with SoE error 0x800A (there is no such drive)");
  }
  EXPECT_EQ(sentence(line.soe().value({0, {0x8100}})),
            "slave 0: refused P-0-0256 of drive 0 with SoE error 0x1001 (there is no such IDN)");
  EXPECT_EQ(sentence(line.soe().write({0, {11}}, SoeElement::kValue, Bytes(500))),
            "slave 0: refused S-0-0011 of drive 0 with SoE error 0x7004 (the value cannot be changed)")
      << "in fragments";
}

TEST(SoeOnTheLine, ACommandIsCarriedOutAndTellsIt) {
  SoeLine line;
  ASSERT_EQ(line.to_pre_op(), "");
  ASSERT_EQ(sentence(line.soe().execute(kReset)), "");
  EXPECT_EQ(line.soe().parameter(kReset)->state, 0U) << "cancelled in the end";
  const auto records = line.master.soe_messages().take();
  ASSERT_THAT(records, SizeIs(1));
  EXPECT_THAT(describe(records[0]), HasSubstr("slave 0 drive 0: data state of S-0-0099 is 0x0003 (executed)"));
}

/// Text of `size` bytes; neighbouring bytes differ.
Bytes text_of(std::size_t size) {
  Bytes text(size);
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<std::byte>('!' + i % 89);
  return text;
}

TEST(SoeOnTheLine, TheDrivesOfASlaveAreApart) {
  SoeLine line;
  ASSERT_EQ(line.to_pre_op(), "");
  const Bytes value{std::byte{0x2C}, std::byte{0x01}};
  const auto before = line.soe().value(kGain).value();
  ASSERT_EQ(sentence(line.soe().write_value({1, {100}}, value)), "");
  EXPECT_EQ(line.soe().value({1, {100}}).value(), value);
  EXPECT_EQ(line.soe().value(kGain).value(), before);
  ASSERT_EQ(sentence(line.soe().execute({1, {99}})), "");
  const auto records = line.master.soe_messages().take();
  ASSERT_THAT(records, SizeIs(1));
  EXPECT_EQ(ecat_master::describe_message(records[0]), "drive 1: data state of S-0-0099 is 0x0003 (executed)");
}

TEST(SoeOnTheLine, ADriveWithoutProcessDataSaysSo) {
  SoeLine line;
  ASSERT_EQ(line.to_pre_op(), "");
  line.lose_process_data(0);
  line.clock.advance(milliseconds{1});
  ASSERT_EQ(sentence(line.master.mailbox(0)->poll()), "");
  const auto records = line.master.soe_messages().take();
  ASSERT_THAT(records, SizeIs(2));
  EXPECT_EQ(ecat_master::describe_message(records[1]),
            "drive 1: emergency 0x7500, error register 0x10, 00 00 00 00 00");
  EXPECT_EQ(line.soe().value({1, {11}}).value(), (Bytes{std::byte{0}, std::byte{0x10}}));
  ASSERT_EQ(sentence(line.soe().execute({1, {99}})), "");
  EXPECT_EQ(line.soe().value({1, {11}}).value(), Bytes(2));
  EXPECT_NE(line.soe().value({0, {11}}).value(), Bytes(2)) << "the other drive";
}

TEST(SoeOnTheLine, AllEightDrivesOfASlaveAnswer) {
  auto device = soe_device(128);
  device.mailbox.soe_channels = 8;
  SoeLine line(device);
  ASSERT_EQ(line.to_pre_op(), "");
  for (std::uint8_t drive = 0; drive < 8; ++drive) {
    ASSERT_EQ(sentence(line.soe().write_value({drive, {100}}, Bytes{std::byte(drive + 1), std::byte{0}})), "");
  }
  for (std::uint8_t drive = 0; drive < 8; ++drive) {
    EXPECT_EQ(line.soe().value({drive, {100}}).value()[0], std::byte(drive + 1));
  }
}

TEST(SoeOnTheLine, LongTextsComeAndGoWholeInMailboxesOfAnySize) {
  for (const auto mailbox : std::array<std::uint16_t, 5>{22, 34, 128, 525, 526}) {
    SoeLine line(mailbox);
    ASSERT_EQ(line.to_pre_op(), "");
    for (const std::size_t size : {0U, 1U, 511U, 512U}) {
      ASSERT_EQ(sentence(line.soe().write_value(kApplication, text_of(size))), "") << size << " in " << mailbox;
      EXPECT_EQ(line.soe().value(kApplication).value(), text_of(size)) << size << " in " << mailbox;
    }
    EXPECT_THAT(sentence(line.soe().write_value(kApplication, text_of(513))), HasSubstr("0x7003 (value too long)"));
    EXPECT_EQ(line.soe().value(kApplication).value(), text_of(512)) << "as it was";
  }
}

TEST(SoeOnTheLine, LongWritesArriveWholeBetweenSdosAndOtherWritesWhenFramesAreLost) {
  for (const auto way : {LossyPort::Direction::kOut, LossyPort::Direction::kBack}) {
    SoeLine line(34);
    unsigned frames = 0;
    LossyPort port(*line.line, way, [&](auto, auto) { return ++frames % 13 == 0; });
    PreOpMaster master(port, line.clock);
    SoeClient soe(master.mailboxes(), 0);
    ecat_master::CoeClient coe(master.mailboxes(), 0);
    for (std::size_t size = 300; size < 310; ++size) {
      const auto first = soe.start_write(kApplication, SoeElement::kValue, as_list(text_of(size)));
      const auto second = soe.start_write({1, {142}}, SoeElement::kValue, as_list(text_of(size + 100)));
      std::vector<decltype(coe.start_upload({0x1018, 1}, {}, 0))> uploads;
      for (std::uint8_t priority = 0; priority < 4; ++priority) {
        uploads.push_back(coe.start_upload({0x1018, 2}, {}, priority));
      }
      master.mailboxes().wait(*second);
      master.mailboxes().wait(*first);
      EXPECT_EQ(sentence(first->result()), "");
      EXPECT_EQ(sentence(second->result()), "");
      for (auto& upload : uploads) EXPECT_EQ(sentence(upload.get()), "");
      EXPECT_EQ(soe.value(kApplication).value(), text_of(size));
      EXPECT_EQ(soe.value({1, {142}}).value(), text_of(size + 100));
    }
    EXPECT_GT(port.lost(), 20U);
  }
}

TEST(SoeOnTheLine, MixesWithSdosAndOtherSlaves) {
  SoeLine line(34);
  ASSERT_EQ(line.to_pre_op(), "");
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
  for (const auto way : {LossyPort::Direction::kOut, LossyPort::Direction::kBack}) {
    SoeLine line(34);
    unsigned frames = 0;
    LossyPort port(*line.line, way, [&](auto, auto) { return ++frames % 20 == 0; });
    PreOpMaster master(port, line.clock);
    SoeClient soe(master.mailboxes(), 0);
    for (int i = 0; i < 20; ++i) {
      ASSERT_THAT(soe.idn_list({0, {17}}).value(), SizeIs(10));
      ASSERT_THAT(sentence(soe.write({0, {11}}, SoeElement::kValue, Bytes(100))), HasSubstr("0x7004"));
    }
    EXPECT_GT(port.lost(), 5U);
  }
}

using Objects = std::vector<motion::MappedObject>;

TEST(SoeProcessData, AreThoseOfTheListsOfEachDrive) {
  SoeLine line(drive_by_idn());
  ASSERT_EQ(line.to_pre_op(), "");
  ASSERT_EQ(
      sentence(line.soe().write_value({1, {16}}, Bytes{std::byte{51}, std::byte{0}, std::byte{40}, std::byte{0}})), "");
  ASSERT_EQ(sentence(line.soe().write_value({0, {24}}, {})), "");
  ASSERT_EQ(sentence(line.master.configure({})), "");
  const auto& first = line.master.slaves()[0].plan.pdos;
  ASSERT_THAT(first.outputs, SizeIs(1));
  EXPECT_EQ(first.outputs[0].index, 24);
  EXPECT_EQ(first.outputs[0].objects, (Objects{{134, 0, 16}, {134, 1, 16}, {47, 1, 32}}));
  ASSERT_THAT(first.inputs, SizeIs(1));
  EXPECT_EQ(first.inputs[0].index, 16);
  EXPECT_EQ(first.inputs[0].objects, (Objects{{135, 0, 16}, {51, 0, 32}, {135, 1, 16}, {51, 1, 32}, {40, 1, 32}}));
  const auto& second = line.master.slaves()[1].plan.pdos;
  EXPECT_EQ(second.outputs.at(0).objects, (Objects{{134, 0, 16}, {47, 0, 32}, {134, 1, 16}, {47, 1, 32}}));
}

TEST(SoeProcessData, GoThroughTheCycle) {
  SoeLine line(drive_by_idn());
  ASSERT_EQ(sentence(line.master.scan()), "");
  ecat_master::SlavePlan plan;
  plan.own_pdos = true;
  std::vector<ecat_master::SlavePlan> plans{plan, plan};
  plans[0].name = "a";
  plans[1].name = "b";
  ASSERT_EQ(sentence(line.master.configure(plans)), "");
  const ecat_master::ProcessVariables variables(line.master.slaves(), line.master.image());
  ASSERT_TRUE(line.master.start_cycle(nullptr, {}, {}, [&line](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, line.clock);
  }));
  ASSERT_EQ(sentence(line.master.go_operational()), "");
  auto& image = line.master.core()->image();
  const auto command = must(variables.entry<std::int32_t>("b.0x002F:1"));
  command->set(image.outputs(), -70000);
  line.master.pass(milliseconds{5});
  EXPECT_EQ(variables.entry<std::int32_t>("b.0x0033:1")->get(image.inputs()), -70000);
  EXPECT_EQ(variables.entry<std::int32_t>("b.0x0033:0")->get(image.inputs()), 0) << "the other drive";
  EXPECT_EQ(variables.entry<std::int32_t>("a.0x0033:1")->get(image.inputs()), 0) << "the other slave";
  EXPECT_EQ(line.soe(1).value({1, {47}}).value(), line.soe(1).value({1, {51}}).value()) << "over the mailbox";
  EXPECT_THAT(sentence(line.soe(1).write_value({1, {24}}, {})), HasSubstr("0x7005")) << "protected while it runs";
  EXPECT_EQ(sentence(line.master.shut_down()), "");
}

TEST(SoeProcessData, AListNamesWhatMayBeExchanged) {
  SoeLine line(drive_by_idn());
  ASSERT_EQ(line.to_pre_op(), "");
  EXPECT_THAT(sentence(line.soe().write_value({0, {16}}, Bytes{std::byte{47}, std::byte{0}})), HasSubstr("0x7008"));
  EXPECT_THAT(sentence(line.soe().write_value({0, {24}}, Bytes{std::byte{51}, std::byte{0}})), HasSubstr("0x7008"));
  EXPECT_EQ(line.soe().idn_list({0, {16}}).value(), (std::vector<Idn>{{51}})) << "as it was";
}

TEST(SoeProcessData, ASlaveThatTellsNoNumberOfDrivesIsAskedUntilThereIsNone) {
  auto device = drive_by_idn();
  device.mailbox.soe_channels = 0;
  SoeLine line(device);
  ASSERT_EQ(sentence(line.master.scan()), "");
  ASSERT_EQ(sentence(line.master.configure({})), "");
  EXPECT_EQ(line.master.slaves()[0].plan.pdos.outputs.at(0).objects, (Objects{{134, 0, 16}, {47, 0, 32}}));
}

}  // namespace
}  // namespace driveline::bus_test
