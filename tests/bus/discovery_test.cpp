#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/esi/sii.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::Master;
using wire::AlState;

class Discovery : public testing::TestWithParam<std::size_t> {};

TEST_P(Discovery, FindsEveryDriveWithItsIdentity) {
  DriveLine drives(GetParam());
  ScannedMaster master(drives.line(), drives.clock);
  ASSERT_EQ(master.slaves().size(), GetParam());
  for (std::size_t i = 0; i < GetParam(); ++i) {
    const auto& info = master.slaves()[i].info;
    EXPECT_EQ(info.ref.position, i);
    EXPECT_EQ(info.ref.station, 0x1001 + i);
    EXPECT_EQ(info.description.vendor_id, 0x00000028U) << "Moog";
    EXPECT_EQ(info.description.product_code, slaves::msd::kProductCode);
    EXPECT_EQ(info.description.revision, slaves::msd::kRevision);
    EXPECT_EQ(info.description.serial_number, 1000 + i);
    EXPECT_TRUE(info.description.mailbox.coe);
    EXPECT_EQ(info.description.sync_managers.size(), 4U);
    EXPECT_EQ(drives.slave(i).esc().memory().get(wire::reg::kStationAddress), 0x1001 + i);
    EXPECT_EQ(drives.state(i), AlState::kInit);
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, Discovery, testing::Values(1, 8, 64));

TEST(DiscoveryOfOneDrive, ReadsTheWholeEepromUpToTheEndOfItsCategories) {
  for (const bool eight : {false, true}) {
    slaves::SlaveOptions options;
    options.sii.reads_8_bytes = eight;
    DriveLine drives(1, options);
    ScannedMaster master(drives.line(), drives.clock);
    const auto& image = drives.slave(0).device().profile().sii_image;
    const auto& read = master.slaves()[0].info.sii;
    ASSERT_LE(read.size(), image.size() + 8);
    const auto common = std::min(read.size(), image.size());
    EXPECT_TRUE(std::equal(read.begin(), read.begin() + static_cast<std::ptrdiff_t>(common), image.begin()));
    ASSERT_GE(common, 0x84U);
    EXPECT_TRUE(esi::decode_sii(read).has_value());
  }
}

TEST(DiscoveryOfOneDrive, WaitsForASlowEeprom) {
  slaves::SlaveOptions options;
  options.sii.busy_time = milliseconds{9};
  DriveLine drives(2, options);
  ScannedMaster master(drives.line(), drives.clock);
  EXPECT_EQ(master.slaves()[1].info.description.serial_number, 1001U);
}

TEST(DiscoveryOfOneDrive, GivesUpOnAnEepromThatStaysBusy) {
  slaves::SlaveOptions options;
  options.sii.busy_time = std::chrono::hours{1};
  DriveLine drives(2, options);
  ScannedMaster master(drives.line(), drives.clock);
  ASSERT_TRUE(master.slaves()[0].info.problem);
  EXPECT_EQ(describe(*master.slaves()[0].info.problem), "slave 0: EEPROM interface stays busy at word 0x0000");
  EXPECT_EQ(sentence(master.enter_pre_op()), "slave 0: EEPROM interface stays busy at word 0x0000");
}

TEST(DiscoveryOfNothing, SaysSo) {
  DriveLine drives(2);
  drives.line().set_power(0, false);
  Master master(drives.line(), drives.clock);
  EXPECT_EQ(sentence(master.scan()), "the port has no link");
}

TEST(DiscoveryOfNothing, WithoutSlavesThatAnswer) {
  DriveLine drives(1);
  // Answers return with a working counter of 0, as from a cable that leads back to the master.
  ChangingPort port(drives.line(), {},
                    [](std::span<std::byte> frame) { frame[16 + 10 + 1] = frame[16 + 10 + 2] = std::byte{0}; });
  Master master(port, drives.clock);
  EXPECT_EQ(sentence(master.scan()), "no slave answers on the line");
}

TEST(DiscoveryAfterAnotherMaster, TakesOverALineInOp) {
  DriveLine drives(3);
  {
    IdleOperation first(drives);
    ASSERT_TRUE(drives.all_in(AlState::kOp));
  }  // the master ends without telling the drives
  ScannedMaster second(drives.line(), drives.clock);
  EXPECT_EQ(second.slaves().size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(drives.state(i), AlState::kInit);
    for (unsigned n = 0; n < 4; ++n) {
      EXPECT_EQ(drives.slave(i).esc().memory().at(wire::reg::kSyncManager.at(n) + 6U, 1)[0], std::byte{0});
      EXPECT_EQ(drives.slave(i).esc().memory().at(wire::reg::kFmmu.at(n) + 12U, 1)[0], std::byte{0});
    }
  }
}

TEST(PeekStates, TellsStatesWithoutChangingThem) {
  DriveLine drives(3);
  ConfiguredOperation first(drives);
  drives.slave(1).al().fall_back(AlState::kPreOp, wire::AlStatusCode::kUnspecifiedError);
  Master onlooker(drives.line(), drives.clock);
  const auto reports = onlooker.peek_states();
  ASSERT_EQ(sentence(reports), "");
  ASSERT_EQ(reports->size(), 3U);
  EXPECT_EQ((*reports)[0].status.state, AlState::kSafeOp);
  EXPECT_FALSE((*reports)[0].status.error);
  EXPECT_EQ((*reports)[1].status.state, AlState::kPreOp);
  EXPECT_TRUE((*reports)[1].status.error);
  EXPECT_EQ((*reports)[1].code, wire::AlStatusCode::kUnspecifiedError);
  EXPECT_EQ((*reports)[2].status.state, AlState::kSafeOp);
  EXPECT_EQ(drives.state(0), AlState::kSafeOp);
  EXPECT_EQ(drives.state(1), AlState::kPreOp);
}

TEST(WrongPlan, NamesTheNumberOfSlaves) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans.push_back(plans[0]);
  const auto done = operation.master().configure(plans);
  EXPECT_EQ(sentence(done), "planned slave 2 is not on the line; 2 slaves answer, 3 are planned");
  EXPECT_TRUE(drives.all_in(AlState::kInit)) << "nothing may be configured by a plan for another line";
}

TEST(WrongPlan, NamesTheForeignVendor) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans[1].vendor_id = 0x9A;
  EXPECT_EQ(sentence(operation.master().configure(plans)),
            "slave 1: vendor id is 0x00000028 but 0x0000009A is planned");
}

TEST(WrongPlan, NamesTheForeignProduct) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans[0].product_code = 0x12345678;
  EXPECT_EQ(sentence(operation.master().configure(plans)),
            "slave 0: product code is 0x4D534431 but 0x12345678 is planned");
}

TEST(WrongPlan, MayBeFollowedByTheRightOne) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans[0].product_code = 1;
  ASSERT_FALSE(operation.master().configure(plans));
  EXPECT_EQ(sentence(operation.master().configure(operation.plans())), "");
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
}

TEST(Discovery, UnlocksSlavesThatSomebodyHasLockedAgainstWrites) {
  DriveLine drives(3);
  LineOperation operation(drives);
  const auto lock = bytes::to_le_bytes<std::uint8_t>(1);
  auto& bus = operation.master().bus();
  ASSERT_EQ(sentence(bus.broadcast_write(wire::reg::kRegisterWriteProtection.address, lock)), "");
  ASSERT_EQ(sentence(bus.broadcast_write(wire::reg::kEscWriteProtection.address, lock)), "");
  const auto refused = bus.broadcast_write(wire::reg::kStationAddress.address, lock);
  ASSERT_EQ(refused.value_or(99), 0) << "they are locked";
  EXPECT_EQ(sentence(operation.to_op()), "");
}

}  // namespace
}  // namespace driveline::bus_test
