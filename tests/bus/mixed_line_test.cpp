// A line of a coupler, terminals with and without mailbox, a device with two sync managers in each direction, and a
// drive. No PDOs are planned: every slave exchanges the PDOs that its EEPROM assigns.
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "drive_line.hpp"
#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/generic/generic_device.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::Master;
using ecat_master::ProcessVariables;
using ecat_master::SlavePlan;

constexpr std::array kDevices = {"BC100", "DI8", "DO4", "AI2", "MX4"};

class MixedLine : public testing::Test {
 protected:
  MixedLine() {
    std::ifstream stream("examples/terminals.xml", std::ios::binary);  // tests run in the top folder of the project
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const auto file = esi::read_esi(text, "terminals.xml").value();
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (const char* name : kDevices) {
      const auto model = slaves::generic::DeviceModel::create(**file.choose({name, {}, {}})).value();
      slaves::generic::GenericOptions options;
      if (name == std::string("DI8")) options.inputs = {{*model->find_input("Channel 3/Input"), {.low = 1.0}}};
      if (name == std::string("AI2")) options.inputs = {{*model->find_input("Channel 2/Value"), {.low = -1234.0}}};
      made.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::generic::GenericDevice>(model, options)));
    }
    made.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
    line = std::make_unique<slaves::SimulatedLine>(clock, std::move(made));
    master = std::make_unique<Master>(*line, clock, Master::Settings{});
  }
  void to_op() {
    ASSERT_EQ(sentence(master->scan()), "");
    std::vector<SlavePlan> plans;
    for (const char* name : {"coupler", "di", "do", "ai", "mx", "drive"}) {
      plans.emplace_back();
      plans.back().name = name;
    }
    ASSERT_EQ(sentence(master->configure(plans)), "");
    variables = std::make_unique<ProcessVariables>(master->slaves(), master->image());
    ASSERT_TRUE(master->start_cycle(nullptr, {}, {}, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, clock);
    }));
    ASSERT_EQ(sentence(master->go_operational()), "");
  }
  std::uint32_t input(const char* name) {
    const auto bits = variables->bits(name);
    EXPECT_TRUE(bits) << describe(bits.error());
    return bits ? bits->get(master->core()->image().inputs()) : 0;
  }
  void set(const char* name, std::uint32_t value) {
    const auto bits = variables->bits(name);
    ASSERT_TRUE(bits) << describe(bits.error());
    bits->set(master->core()->image().outputs(), value);
  }

  rt::VirtualClock clock{milliseconds{1}};
  std::unique_ptr<slaves::SimulatedLine> line;
  std::unique_ptr<Master> master;
  std::unique_ptr<ProcessVariables> variables;
};

TEST_F(MixedLine, ExchangesWhatTheEepromsAssign) {
  to_op();
  for (std::size_t i = 0; i < line->size(); ++i) EXPECT_EQ(line->slave(i).state(), wire::AlState::kOp) << i;
  set("mx.Setpoint", 0x8123);
  set("mx.Fast setpoint", 0xBEEF);
  set("mx.Select", 5);
  set("do.7020:01", 1);
  master->pass(milliseconds{3});
  EXPECT_EQ(input("mx.Actual value"), 0x8123U);
  EXPECT_EQ(input("mx.Fast value"), 0xBEEFU);
  EXPECT_EQ(input("mx.Selected"), 5U);
  EXPECT_EQ(input("di.6020:01"), 1U);
  EXPECT_EQ(input("di.6010:01"), 0U);
  EXPECT_EQ(input("ai.6010:11"), static_cast<std::uint16_t>(-1234));
  const auto& outputs = dynamic_cast<slaves::generic::GenericDevice&>(line->slave(2).device());
  EXPECT_EQ(outputs.dictionary().raw(*outputs.model().table().find(0x7020, 1)), 1U);
  EXPECT_EQ(outputs.dictionary().raw(*outputs.model().table().find(0x7000, 1)), 0U);
  EXPECT_EQ(master->core()->statistics().wkc_errors, 0U);
  EXPECT_EQ(sentence(master->shut_down()), "");
}

TEST_F(MixedLine, StartsAgainWhenControllersWithoutApplicationShowAnAcknowledge) {
  // A controller without application copies AL control into AL status: after INIT with acknowledge, which starts every
  // scan, its error bit means nothing.
  ASSERT_EQ(sentence(master->scan()), "");
  EXPECT_TRUE(wire::AlStatus::from_raw(line->slave(0).esc().memory().get(wire::reg::kAlStatus)).error);
  to_op();
  EXPECT_EQ(sentence(master->shut_down()), "");
  to_op();
}

TEST_F(MixedLine, TakesSdosOfADeviceFromItsFile) {
  to_op();
  auto* mailbox = master->mailbox(4);
  ASSERT_NE(mailbox, nullptr);
  ecat_master::CoeClient coe(*mailbox);
  EXPECT_EQ(coe.upload_as<std::uint32_t>(0x1018, 2).value(), 0x440U);
  EXPECT_EQ(coe.upload(0x8010, 1).value().size(), 12U);
  EXPECT_EQ(master->mailbox(0), nullptr) << "a coupler has none";
}

}  // namespace
}  // namespace driveline::bus_test
