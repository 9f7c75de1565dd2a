// Process data of terminals: several sync managers per direction, entries of single bits, copies from slave to slave,
// in every layout.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CyclicCore;
using ecat_master::ImageLayout;
using ecat_master::Master;
using ecat_master::ProcessVariables;
using ecat_master::SlavePlan;
using motion::PdoMapping;
using testing::HasSubstr;

/// No mailbox; two sync managers each way: bits that fill no byte, and words. Inputs repeat outputs.
esi::DeviceDescription terminal() {
  using Use = esi::SyncManager::Use;
  esi::DeviceDescription device;
  device.vendor_id = 0x1234;
  device.product_code = 0x0815;
  device.name = "terminal";
  device.type = "terminal";
  // PDI control 0x0E05: an SPI processor, no device emulation.
  device.eeprom_config_data_hex = "050E000000000000000000000000";
  device.sync_managers = {{Use::kOutputs, 0x1000, 2, 2, 2, 0x44, true},
                          {Use::kOutputs, 0x1100, 6, 6, 6, 0x44, true},
                          {Use::kInputs, 0x1200, 2, 2, 2, 0x00, true},
                          {Use::kInputs, 0x1300, 6, 6, 6, 0x00, true}};
  const auto bits = [](std::uint16_t index, std::uint8_t first, const char* name) {
    std::vector<esi::PdoEntry> entries;
    for (std::uint8_t i = 0; i < 5; ++i) {
      const std::uint8_t length = i == 4 ? 7 : 1;
      entries.push_back({index, static_cast<std::uint8_t>(first + i), length, name + std::to_string(i),
                         length == 1 ? esi::DataType::kBoolean : esi::DataType::kBit7});
    }
    return entries;
  };
  const auto words = [](std::uint16_t index, const char* name) {
    return std::vector<esi::PdoEntry>{{index, 1, 16, std::string(name) + " word", esi::DataType::kUnsigned16},
                                      {index, 2, 32, std::string(name) + " long", esi::DataType::kInteger32}};
  };
  device.rx_pdos = {{0x1600, "Bits out", true, true, std::uint8_t{0}, bits(0x7000, 1, "Out ")},
                    {0x1601, "Words out", true, true, std::uint8_t{1}, words(0x7010, "Set")}};
  device.tx_pdos = {{0x1A00, "Bits in", true, true, std::uint8_t{2}, bits(0x6000, 1, "In ")},
                    {0x1A01, "Words in", true, true, std::uint8_t{3}, words(0x6010, "Actual")}};
  return device;
}

std::vector<PdoMapping> mapping(const std::vector<esi::Pdo>& pdos) {
  std::vector<PdoMapping> all;
  for (const auto& pdo : pdos) {
    PdoMapping one{pdo.index, {}, pdo.sync_manager};
    for (const auto& entry : pdo.entries) one.objects.push_back({entry.index, entry.subindex, entry.bit_length});
    all.push_back(std::move(one));
  }
  return all;
}

struct TerminalCase {
  const char* name;
  ecat_master::LayoutSettings layout;
};

class Terminals : public testing::TestWithParam<TerminalCase> {
 protected:
  static constexpr std::size_t kCount = 3;

  Terminals() {
    auto model = slaves::generic::DeviceModel::create(terminal());
    if (!model) throw std::runtime_error(describe(model.error()));
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (std::size_t i = 0; i < kCount; ++i) {
      made.push_back(std::make_unique<slaves::Slave>(
          std::make_unique<slaves::generic::GenericDevice>(*model, slaves::generic::GenericOptions{})));
    }
    line = std::make_unique<slaves::SimulatedLine>(clock, std::move(made));
    master = std::make_unique<Master>(*line, clock, Master::Settings{{}, std::chrono::seconds{1}, GetParam().layout});
  }

  void to_safe_op() {
    ASSERT_EQ(sentence(master->scan()), "");
    std::vector<SlavePlan> plans;
    for (std::size_t i = 0; i < kCount; ++i) {
      SlavePlan plan;
      plan.name = std::string("io") + static_cast<char>('a' + i);
      plan.pdos = {mapping(terminal().rx_pdos), mapping(terminal().tx_pdos)};
      plan.group = GetParam().layout.groups.empty() ? 0 : i % GetParam().layout.groups.size();
      plans.push_back(plan);
    }
    ASSERT_EQ(sentence(master->configure(plans)), "");
    variables = std::make_unique<ProcessVariables>(master->slaves(), master->image());
  }
  void to_op(std::vector<motion::ProcessDataCopy> copies = {}) {
    CyclicCore::Settings settings;
    settings.copies = std::move(copies);
    const auto started = master->start_cycle(nullptr, {}, settings, [this](CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, clock);
    });
    ASSERT_TRUE(started.has_value());
    ASSERT_EQ(sentence(master->go_operational()), "");
  }
  std::span<std::byte> outputs() { return master->core()->image().outputs(); }
  std::span<const std::byte> inputs() { return master->core()->image().inputs(); }
  template <typename T>
  auto entry(const char* name) {
    auto found = variables->entry<T>(name);
    EXPECT_TRUE(found.has_value()) << describe(found.error());
    return found.value_or(motion::PdoEntry<T>{});
  }
  void pass() { master->pass(milliseconds{2}); }

  rt::VirtualClock clock{milliseconds{1}};
  std::unique_ptr<slaves::SimulatedLine> line;
  std::unique_ptr<Master> master;
  std::unique_ptr<ProcessVariables> variables;
};

TEST_P(Terminals, RepeatEveryEntryOfEverySyncManager) {
  to_safe_op();
  to_op();
  const char* slaves[] = {"ioa", "iob", "ioc"};
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::string who = slaves[i];
    entry<bool>((who + ".Out 1").c_str()).set(outputs(), true);
    entry<bool>((who + ".7000:04").c_str()).set(outputs(), i == 1);
    variables->bits(who + ".Out 4").value().set(outputs(), static_cast<std::uint32_t>(0x41 + i));
    entry<std::uint16_t>((who + ".Set word").c_str()).set(outputs(), static_cast<std::uint16_t>(0xABC0 + i));
    entry<std::int32_t>((who + ".0x7010:2").c_str()).set(outputs(), -1000 - static_cast<std::int32_t>(i));
  }
  pass();
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::string who = slaves[i];
    EXPECT_FALSE(entry<bool>((who + ".In 0").c_str()).get(inputs()));
    EXPECT_TRUE(entry<bool>((who + ".In 1").c_str()).get(inputs()));
    EXPECT_EQ(entry<bool>((who + ".In 3").c_str()).get(inputs()), i == 1);
    EXPECT_EQ(variables->bits(who + ".In 4").value().get(inputs()), 0x41 + i);
    EXPECT_EQ(entry<std::uint16_t>((who + ".Actual word").c_str()).get(inputs()), 0xABC0 + i);
    EXPECT_EQ(entry<std::int32_t>((who + ".6010h:02").c_str()).get(inputs()), -1000 - static_cast<std::int32_t>(i));
  }
  EXPECT_EQ(master->core()->statistics().wkc_errors, 0U);
}

TEST_P(Terminals, HandValuesToEachOther) {
  to_safe_op();
  const auto word = variables->copy("ioa.Actual word", "iob.Set word");
  const auto seven_bits = variables->copy("iob.In 4", "ioc.Out 4");
  ASSERT_TRUE(word && seven_bits);
  to_op({*word, *seven_bits});
  entry<std::uint16_t>("ioa.Set word").set(outputs(), 0x1357);
  variables->bits("iob.Out 4").value().set(outputs(), 0x55);
  pass();
  EXPECT_EQ(entry<std::uint16_t>("iob.Actual word").get(inputs()), 0x1357);
  EXPECT_EQ(variables->bits("ioc.In 4").value().get(inputs()), 0x55U);
  // Inputs of a missing slave keep their last values.
  entry<std::uint16_t>("ioa.Set word").set(outputs(), 0x2468);
  line->break_cable({0, 1});
  line->set_power(0, false);
  pass();
  EXPECT_EQ(entry<std::uint16_t>("iob.Set word").get(outputs()), 0x1357);
}

TEST_P(Terminals, GroupZeroesItsOutputsAfterItsLimitAndNotBefore) {
  to_safe_op();
  to_op();
  entry<std::uint16_t>("ioa.Set word").set(outputs(), 0x1111);
  pass();
  const auto limit = master->core()->image().groups()[0].bad_cycle_limit;
  if (limit == 0) {
    line->drop_frames(200);
    pass();
    pass();
    EXPECT_FALSE(master->core()->groups()[0].outputs_zeroed) << "not asked for";
    return;
  }
  const auto frames = master->image().frame_count();
  line->drop_frames(static_cast<unsigned>((limit - 1) * frames));
  pass();
  EXPECT_FALSE(master->core()->groups()[0].outputs_zeroed) << "one exchange less than the limit";
  EXPECT_EQ(entry<std::uint16_t>("ioa.Actual word").get(inputs()), 0x1111);
  line->drop_frames(static_cast<unsigned>(limit * frames));
  pass();
  EXPECT_TRUE(master->core()->groups()[0].outputs_zeroed);
  EXPECT_EQ(entry<std::uint16_t>("ioa.Actual word").get(inputs()), 0) << "zeros have reached the slave";
  EXPECT_EQ(entry<std::uint16_t>("ioa.Set word").get(outputs()), 0x1111) << "the application's value is kept";
  master->core()->release_outputs(0);
  pass();
  EXPECT_EQ(entry<std::uint16_t>("ioa.Actual word").get(inputs()), 0x1111);
}

INSTANTIATE_TEST_SUITE_P(Layouts, Terminals,
                         testing::Values(TerminalCase{"overlapped", {ImageLayout::kOverlapped, {}}},
                                         TerminalCase{"sequential", {ImageLayout::kSequential, {}}},
                                         TerminalCase{"separate", {ImageLayout::kSeparate, {}}},
                                         TerminalCase{"groups_with_limit",
                                                      {ImageLayout::kOverlapped, {{1, 0, 4}, {1, 0, 4}}}},
                                         TerminalCase{"separate_with_limit", {ImageLayout::kSeparate, {{1, 0, 3}}}},
                                         TerminalCase{"divided", {ImageLayout::kSequential, {{1, 0}, {2, 1}, {4, 2}}}}),
                         [](const auto& name) { return std::string(name.param.name); });

TEST(SlaveWithoutLrw, IsToldByItsEepromAndGetsLwrAndLrd) {
  rt::VirtualClock clock{milliseconds{1}};
  auto special = terminal();
  special.not_lrw = true;
  std::vector<std::unique_ptr<slaves::Slave>> made;
  for (const auto& device : {terminal(), special}) {
    const auto model = slaves::generic::DeviceModel::create(device).value();
    made.push_back(std::make_unique<slaves::Slave>(
        std::make_unique<slaves::generic::GenericDevice>(model, slaves::generic::GenericOptions{})));
  }
  slaves::SimulatedLine line(clock, std::move(made));
  ScannedMaster master(line, clock);
  EXPECT_FALSE(master.slaves()[0].info.description.not_lrw);
  EXPECT_TRUE(master.slaves()[1].info.description.not_lrw);
  ASSERT_EQ(sentence(master.configure({})), "");
  const auto command_of = [&](std::size_t datagram) { return master.image().datagrams()[datagram].command; };
  const auto places = master.image().places();
  EXPECT_EQ(command_of(places[0].output_datagram), wire::Command::kLrw);
  EXPECT_EQ(places[0].output_datagram, places[0].input_datagram);
  EXPECT_EQ(command_of(places[1].output_datagram), wire::Command::kLwr);
  EXPECT_EQ(command_of(places[1].input_datagram), wire::Command::kLrd);
  // The plan has priority over the EEPROM.
  std::vector<SlavePlan> plans(2);
  for (auto& plan : plans) plan.own_pdos = true;
  plans[0].lrw = false;
  plans[1].lrw = true;
  ASSERT_EQ(sentence(master.configure(plans)), "");
  const auto planned = master.image().places();
  EXPECT_EQ(command_of(planned[0].output_datagram), wire::Command::kLwr);
  EXPECT_EQ(command_of(planned[1].output_datagram), wire::Command::kLrw);
}

class NamesOfTerminals : public Terminals {};
INSTANTIATE_TEST_SUITE_P(One, NamesOfTerminals, testing::Values(TerminalCase{"overlapped", {}}));

TEST_P(NamesOfTerminals, AreRefusedWithWhatThereIs) {
  to_safe_op();
  const auto error = [this](const char* name) {
    const auto found = variables->find(name);
    return found ? std::string("found") : describe(found.error());
  };
  EXPECT_EQ(error("ioa.Out 0"), "found");
  EXPECT_EQ(error("1.Out 0"), "found") << "by position";
  EXPECT_THAT(error("ioa.Out 9"),
              HasSubstr("there is no process variable 'ioa.Out 9'; the slave has ioa.7000h:01 (Out 0)"));
  EXPECT_THAT(error("iox.Out 0"), HasSubstr("expected slave.object, for example ioa.7000h:01 (Out 0)"));
  EXPECT_THAT(error("ioa.6041"), HasSubstr("there is no process variable 'ioa.6041'"));
  EXPECT_EQ(describe(variables->entry<std::uint16_t>("ioa.Out 4").error()),
            "ioa.7000h:05 (Out 4) has 7 bits from bit 4 of a byte on; the handle is for 16 bits on a byte border");
  EXPECT_EQ(describe(variables->entry<bool>("ioa.Set word").error()),
            "ioa.7010h:01 (Set word) has 16 bits from bit 0 of a byte on; the handle is for 1 bits");
  EXPECT_EQ(describe(variables->copy("ioa.Set word", "iob.Set word").error()),
            "ioa.7010h:01 (Set word) cannot be the source of a copy: it is an output");
  EXPECT_EQ(describe(variables->copy("ioa.Actual word", "iob.Actual word").error()),
            "iob.6010h:01 (Actual word) cannot be the target of a copy: it is an input");
  EXPECT_EQ(describe(variables->copy("ioa.Actual word", "iob.Set long").error()),
            "ioa.6010h:01 (Actual word) has 16 bits and iob.7010h:02 (Set long) has 32: they cannot be copied");
}

}  // namespace
}  // namespace driveline::bus_test
