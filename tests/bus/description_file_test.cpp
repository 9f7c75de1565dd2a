// Slaves that are configured by their ESI file; parallel set-up; ports that an earlier master has left closed.
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "drive_line.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
namespace facts = ecat_master::facts;
using ecat_master::Master;
using ecat_master::SlavePlan;
using wire::AlState;

/// A device of terminals.xml on the line and, possibly edited, in the plan of the master.
class DescriptionFile : public testing::Test {
 protected:
  using Edit = std::function<void(esi::DeviceDescription&)>;

  void make(const char* name, const Edit& edit = {}, const slaves::SlaveOptions& options = {}) {
    std::ifstream stream("examples/terminals.xml", std::ios::binary);  // tests run in the top folder of the project
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    auto device = **esi::read_esi(text, "terminals.xml").value().choose({name, {}, {}});
    const auto model = slaves::generic::DeviceModel::create(device).value();
    std::vector<std::unique_ptr<slaves::Slave>> made;
    made.push_back(std::make_unique<slaves::Slave>(
        std::make_unique<slaves::generic::GenericDevice>(model, slaves::generic::GenericOptions{}), options));
    line = std::make_unique<slaves::SimulatedLine>(clock, std::move(made));
    master = std::make_unique<Master>(*line, clock);
    if (edit) edit(device);
    plan.own_pdos = true;
    plan.esi = std::make_shared<const esi::DeviceDescription>(std::move(device));
    ASSERT_EQ(sentence(master->scan()), "");
  }
  std::string configure() { return sentence(master->configure({plan})); }
  void to_op() {
    ASSERT_TRUE(master->start_cycle(nullptr, {}, {}, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, clock);
    }));
    ASSERT_EQ(sentence(master->go_operational()), "");
  }

  rt::VirtualClock clock{milliseconds{1}};
  std::unique_ptr<slaves::SimulatedLine> line;
  std::unique_ptr<Master> master;
  SlavePlan plan;
};

TEST_F(DescriptionFile, StartUpCommandsWatchdogsAndAssignmentReachTheSlave) {
  make("MX4", [](esi::DeviceDescription& device) {
    ASSERT_EQ(device.init_commands.size(), 1U);
    device.init_commands[0].data_hex = "C800";
    device.watchdogs = {2498, std::nullopt, 321};
  });
  ASSERT_EQ(configure(), "");
  CoeClient coe(*master->mailbox(0));
  EXPECT_EQ(coe.upload_as<std::uint16_t>(0x8000, 3).value(), 200);
  EXPECT_EQ(line->slave(0).esc().memory().get(wire::reg::kWatchdogTimeProcessData), 321);
  // Two sync managers in each direction, each with an assignment object of its own.
  for (const auto& [assignment, pdo] : {std::pair<std::uint16_t, std::uint16_t>{0x1C12, 0x1600},
                                        {0x1C13, 0x1A00},
                                        {0x1C14, 0x1610},
                                        {0x1C15, 0x1A10}}) {
    EXPECT_EQ(coe.upload_as<std::uint8_t>(assignment, 0).value(), 1);
    EXPECT_EQ(coe.upload_as<std::uint16_t>(assignment, 1).value(), pdo);
  }
  to_op();
  master->pass(milliseconds{2});
  EXPECT_EQ(line->slave(0).state(), AlState::kOp);
  EXPECT_EQ(master->core()->statistics().wkc_errors, 0U);
}

TEST_F(DescriptionFile, PdosOfThePlanTakeTheirEntriesFromIt) {
  make("AI2");
  plan.own_pdos = false;
  plan.pdos.inputs = {{0x1A01, {}, std::nullopt}, {0x1A02, {}, std::nullopt}};
  ASSERT_EQ(configure(), "");
  CoeClient coe(*master->mailbox(0));
  EXPECT_EQ(coe.upload_as<std::uint16_t>(0x1C13, 1).value(), 0x1A01);
  EXPECT_EQ(master->image().places()[0].input_bytes, 6U) << "two of the compact PDO, four of the other";
  to_op();
  EXPECT_EQ(line->slave(0).state(), AlState::kOp);
}

TEST_F(DescriptionFile, TimeLimitsAreThoseOfTheFileUnlessThePlanSaysOtherwise) {
  slaves::SlaveOptions slow;
  slow.al.transition_delay = milliseconds{100};
  make(
      "MX4", [](esi::DeviceDescription& device) { device.timeouts.to_safe_op_and_op = 50; }, slow);
  EXPECT_THAT(configure(), testing::HasSubstr("requested SAFEOP, is in PREOP and did not change within 50 ms"));
  plan.timeouts.to_safe_op = milliseconds{200};
  EXPECT_EQ(configure(), "");
}

TEST_F(DescriptionFile, MailboxTimeLimitsLikewise) {
  make("MX4", [](esi::DeviceDescription& device) { device.timeouts.mailbox_response = 30; });
  ASSERT_EQ(configure(), "");
  ASSERT_TRUE(line->inject({.kind = slaves::FaultKind::kMailboxSilent, .slave = 0}));
  const auto before = clock.now();
  const auto done = CoeClient(*master->mailbox(0)).upload(0x1018, 2);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::MailboxTimeout>());
  EXPECT_THAT(sentence(done), testing::HasSubstr("within 30 ms"));
  EXPECT_LT(clock.now() - before, milliseconds{100});
}

TEST_F(DescriptionFile, IsFoundByTheIdentityOfTheSlave) {
  make("MX4");
  const auto file = plan.esi;
  Master::Settings settings;
  settings.describe = [&](const ecat_master::SlaveInfo& info) {
    return info.description.product_code == 0x440 ? file : nullptr;
  };
  master = std::make_unique<Master>(*line, clock, settings);
  ASSERT_EQ(sentence(master->scan()), "");
  ASSERT_EQ(sentence(master->configure({})), "");
  EXPECT_EQ(master->slaves()[0].plan.esi, file);
  EXPECT_EQ(master->slaves()[0].info.description.objects.size(), file->objects.size());
}

TEST(ProcessDataSetup, TravelsForAllSlavesTogether) {
  DriveLine drives(8);
  std::size_t frames = 0;
  ChangingPort port(drives.line(),
                    [&](std::span<std::byte> frame) {
                      bool fmmus = false;
                      for (std::size_t at = 16; at + 12 <= frame.size();) {
                        const auto byte = [&](std::size_t offset) {
                          return std::to_integer<unsigned>(frame[at + offset]);
                        };
                        fmmus = fmmus || (frame[at] == std::byte{5} && byte(4) == 0x00 && byte(5) == 0x06);
                        if ((byte(7) & 0x80U) == 0) break;
                        at += 12 + (byte(6) | (byte(7) & 0x07U) << 8);
                      }
                      // Frames of the preceding clearing are shorter, without the data that are not zero; only the
                      // set-up is counted.
                      if (fmmus && drives.state(0) == AlState::kPreOp) ++frames;
                    },
                    {});
  ConfiguredOperation operation(drives, port);
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
  EXPECT_EQ(frames, 1U) << "not one for each drive";
}

TEST(PortsThatWereLeftClosed, AreOpenedBeforeSlavesAreCounted) {
  constexpr auto kLoopControl = static_cast<std::uint16_t>(wire::reg::kDlControl.address + 1);
  DriveLine drives(4);
  {
    ScannedMaster predecessor(drives.line(), drives.clock);
    // Port 1 always closed (3 in bits 2 and 3), first far away, then nearby: one hides the other.
    const std::array<std::byte, 1> closed{std::byte{0x0C}};
    ASSERT_EQ(sentence(predecessor.bus().write(predecessor.slaves()[2].info.ref, kLoopControl, closed)), "");
    ASSERT_EQ(sentence(predecessor.bus().write(predecessor.slaves()[0].info.ref, kLoopControl, closed)), "");
  }
  ScannedMaster master(drives.line(), drives.clock);
  EXPECT_EQ(master.slaves().size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(drives.slave(i).esc().memory().at(kLoopControl, 1)[0], std::byte{0}) << i;
  }
}

}  // namespace
}  // namespace driveline::bus_test
