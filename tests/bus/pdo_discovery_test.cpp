#include "driveline/ecat_master/configuration/pdo_discovery.hpp"

#include <gmock/gmock.h>

#include "edited_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::Master;
using motion::MappedObject;
using motion::PdoConfiguration;
using wire::AlState;

std::vector<ecat_master::SlaveInfo> infos_of(Master& master) {
  std::vector<ecat_master::SlaveInfo> infos;
  for (const auto& slave : master.slaves()) infos.push_back(slave.info);
  return infos;
}

void expect_same(const PdoConfiguration& found, const PdoConfiguration& written) {
  auto compare = [](const auto& a, const auto& b, std::uint8_t sync_manager) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].index, b[i].index);
      EXPECT_EQ(a[i].objects, b[i].objects);
      EXPECT_EQ(a[i].sync_manager, sync_manager);
    }
  };
  compare(found.outputs, written.outputs, 2);
  compare(found.inputs, written.inputs, 3);
}

TEST(OwnPdos, AreReadBackAsTheyWereWrittenFromAllSlavesAtOnce) {
  DriveLine drives(16);
  ConfiguredOperation operation(drives);
  const auto infos = infos_of(operation.master());
  auto begin = drives.clock.now();
  ecat_master::StartupNotes notes;
  ASSERT_EQ(sentence(read_pdo_configurations(operation.master().mailboxes(), std::span(infos).first(1), notes)[0]), "");
  const auto one = drives.clock.now() - begin;
  begin = drives.clock.now();
  const auto found = read_pdo_configurations(operation.master().mailboxes(), infos, notes);
  EXPECT_LT(drives.clock.now() - begin, 4 * one) << "side by side, not one after the other";
  ASSERT_EQ(found.size(), 16U);
  EXPECT_TRUE(notes.empty());
  for (const auto& configuration : found) {
    ASSERT_EQ(sentence(configuration), "");
    expect_same(*configuration, motion::axis_pdo_configuration());
  }
}

TEST(OwnPdos, ASilentSlaveHasAnErrorOfItsOwn) {
  DriveLine drives(3);
  ConfiguredOperation operation(drives);
  drives.slave(1).mailbox().set_fault(slaves::MailboxTransport::Fault::kSilent);
  ecat_master::StartupNotes notes;
  const auto found = read_pdo_configurations(operation.master().mailboxes(), infos_of(operation.master()), notes);
  EXPECT_EQ(sentence(found[0]), "");
  EXPECT_EQ(sentence(found[1]), "slave 1: no mailbox reply for object 1C12h:00 within 2000 ms");
  EXPECT_EQ(sentence(found[2]), "");
}

TEST(OwnPdos, OfASlaveWithoutMailboxAreThoseOfItsEeprom) {
  esi::DeviceDescription device;
  esi::Pdo outputs;
  outputs.index = 0x1600;
  outputs.sync_manager = 0;
  outputs.entries = {{0x7000, 1, 1, "", esi::DataType::kBoolean}, {0, 0, 7, "", esi::DataType::kUnsigned8}};
  auto second = outputs;
  second.index = 0x1601;
  second.sync_manager = 1;
  auto spare = outputs;
  spare.index = 0x1602;
  spare.sync_manager.reset();
  device.rx_pdos = {outputs, second, spare};
  const auto found = ecat_master::pdo_configuration_from_sii(device);
  ASSERT_EQ(found.outputs.size(), 2U) << "what is not assigned is not exchanged";
  EXPECT_THAT(found.outputs[0].objects, testing::ElementsAre(MappedObject{0x7000, 1, 1}, MappedObject{0, 0, 7}));
  EXPECT_EQ(found.outputs[0].sync_manager, 0);
  EXPECT_EQ(found.outputs[1].sync_manager, 1) << "a second output sync manager";
  EXPECT_TRUE(found.inputs.empty());
}

/// Plans of an axis whose PDOs are given without their objects.
std::vector<ecat_master::SlavePlan> plans_by_index(const LineOperation& operation) {
  auto plans = operation.plans();
  for (auto& plan : plans) {
    for (auto* direction : {&plan.pdos.outputs, &plan.pdos.inputs}) {
      for (auto& pdo : *direction) pdo.objects.clear();
    }
  }
  return plans;
}

TEST(NamedPdos, WithoutObjectsAreTakenAsTheDriveHasMappedThem) {
  DriveLine drives(3);
  {
    // An earlier master has mapped PDOs and left the drives in PREOP.
    ConfiguredOperation before(drives);
  }
  LineOperation operation(drives);
  auto& master = operation.master();
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.configure(plans_by_index(operation))), "");
  const auto& wanted = motion::axis_pdo_configuration();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& pdos = master.slaves()[i].plan.pdos;
    ASSERT_EQ(pdos.outputs.size(), wanted.outputs.size());
    ASSERT_EQ(pdos.inputs.size(), wanted.inputs.size());
    for (std::size_t n = 0; n < wanted.outputs.size(); ++n) {
      EXPECT_EQ(pdos.outputs[n].objects, wanted.outputs[n].objects);
      EXPECT_EQ(pdos.inputs[n].objects, wanted.inputs[n].objects);
    }
    EXPECT_EQ(master.image().places()[i].output_bytes, 19U);
  }
  // It returns with a mapping that is never written again, because a drive may have a fixed one.
  const auto assignments = planned_assignments(master.slaves()[0]);
  ASSERT_EQ(assignments.size(), 2U);
  for (const auto& step : ecat_master::steps_of(assignments)) {
    EXPECT_FALSE(step.at.index >= 0x1600 && step.at.index < 0x1C00) << std::hex << step.at.index;
  }
  operation.start_cycle();
  EXPECT_EQ(sentence(master.go_operational()), "");
}

TEST(NamedPdos, ThatTheDriveDoesNotHaveAreNamed) {
  DriveLine drives(2);
  LineOperation operation(drives);
  auto plans = plans_by_index(operation);
  plans[1].pdos.outputs = {{0x1605, {}}};
  ASSERT_EQ(sentence(operation.master().scan()), "");
  EXPECT_THAT(sentence(operation.master().configure(std::move(plans))),
              testing::StartsWith("slave 1: object 1C12h:01 aborted with 0x06020000"));
}

TEST(LineWithoutDescription, RunsWithWhatTheSlavesHaveAssigned) {
  DriveLine drives(3);
  {
    // An earlier master has mapped PDOs and left the drives in PREOP: the mapping stays.
    ConfiguredOperation before(drives);
  }
  ScannedMaster master(drives.line(), drives.clock);
  ASSERT_EQ(sentence(master.configure({})), "");
  for (std::size_t i = 0; i < 3; ++i) expect_same(master.slaves()[i].plan.pdos, motion::axis_pdo_configuration());
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
}

TEST(LineWithoutDescription, RunsWithNothingAssigned) {
  DriveLine drives(2);
  ScannedMaster master(drives.line(), drives.clock);
  EXPECT_EQ(sentence(master.configure({})), "");
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
}

}  // namespace
}  // namespace driveline::bus_test
