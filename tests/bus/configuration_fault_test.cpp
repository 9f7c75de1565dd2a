#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::ErrorKind;
using ecat_master::Master;
using wire::AlState;

TEST(PdoMappingTooLong, IsRefusedByTheDriveWithItsReason) {
  DriveLine drives(2);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  auto plans = operation.plans();
  // 2 + 1 + 4 + 2 = 9 bytes; the drive takes 8 (MSD manual 8.3.4).
  plans[1].pdos.outputs = {{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}, {0x6071, 0, 16}}}};
  const auto done = operation.master().configure(plans);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::kSdoAbort);
  EXPECT_EQ(sentence(done),
            "slave 1: object 1600h:00 aborted with 0x06040042 (mapped objects would exceed the PDO length)");
}

TEST(PdoMappingTooLong, MayBeFollowedByAGoodOne) {
  DriveLine drives(2);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  // Whatever has been exchanged before, the mailbox starts anew: one to nine entries written before the failure, so
  // that every mailbox counter comes up.
  for (std::size_t entries = 0; entries < 9; ++entries) {
    auto plans = operation.plans();
    plans[0].startup_sdos.resize(std::min<std::size_t>(entries, plans[0].startup_sdos.size()));
    while (plans[0].startup_sdos.size() < entries) plans[0].startup_sdos.push_back({0x6065, 0, {4, std::byte{1}}});
    plans[0].startup_sdos.push_back({0x5FFF, 0, {std::byte{1}}});
    const auto failed = operation.master().configure(plans);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().kind, ErrorKind::kSdoAbort) << sentence(failed);
  }
  EXPECT_EQ(sentence(operation.master().configure(operation.plans())), "");
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
}

TEST(EnterPreOp, LeavesNothingOfAnEarlierConfiguration) {
  DriveLine drives(2);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.to_safe_op()), "");
  ASSERT_EQ(sentence(operation.master().enter_pre_op()), "");
  EXPECT_TRUE(drives.all_in(AlState::kPreOp));
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& memory = drives.slave(i).esc().memory();
    for (const unsigned n : {0U, 1U}) EXPECT_EQ(memory.at(wire::reg::kFmmu.at(n) + 12U, 1)[0], std::byte{0}) << n;
    for (const unsigned n : {2U, 3U}) EXPECT_EQ(memory.at(wire::reg::kSyncManager.at(n) + 6U, 1)[0], std::byte{0}) << n;
  }
}

TEST(StartupSdo, NamesTheObjectThatDoesNotExist) {
  DriveLine drives(1);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  auto plans = operation.plans();
  plans[0].startup_sdos.push_back({0x5FFF, 3, {std::byte{1}}});
  EXPECT_EQ(sentence(operation.master().configure(plans)),
            "slave 0: object 5FFFh:03 aborted with 0x06020000 (object does not exist in the object dictionary)");
}

TEST(StartupSdo, IsWrittenBeforeTheTransitionItIsPlannedFor) {
  DriveLine drives(2);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  auto plans = operation.plans();
  const auto value = wire::to_le_bytes<std::uint32_t>(4242);
  plans[1].startup_sdos.push_back({0x6065, 0, {value.begin(), value.end()}, false, AlState::kOp});
  ASSERT_EQ(sentence(operation.master().configure(plans)), "");
  EXPECT_NE(CoeClient(*operation.master().mailbox(1)).upload_as<std::uint32_t>(0x6065, 0).value(), 4242U);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  EXPECT_EQ(CoeClient(*operation.master().mailbox(1)).upload_as<std::uint32_t>(0x6065, 0).value(), 4242U);
}

TEST(Watchdogs, AreSetAsPlanned) {
  DriveLine drives(2);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  auto plans = operation.plans();
  plans[1].watchdog = {2498, 500, 0};
  ASSERT_EQ(sentence(operation.master().configure(plans)), "");
  const auto& memory = drives.slave(1).esc().memory();
  EXPECT_EQ(memory.get(wire::reg::kWatchdogDivider), 2498);
  EXPECT_EQ(memory.get(wire::reg::kWatchdogTimeProcessData), 500);
  EXPECT_EQ(memory.get(wire::reg::kWatchdogTimePdi), 0);
  EXPECT_EQ(drives.slave(0).esc().memory().get(wire::reg::kWatchdogTimeProcessData), 1000) << "as after power-on";
}

/// The length written to sync manager `number` arrives one byte short.
ChangingPort::Change shorten_sync_manager(unsigned number) {
  return [number](std::span<std::byte> frame) {
    const auto datagram = first_datagram(frame);
    if (datagram.command != wire::Command::kFpwr || datagram.ado != 0x0800 + 8 * number) return;
    frame[16 + 10 + 2] = std::byte{18};
  };
}

TEST(SyncManagerSize, ThatDisagreesWithTheInputsIsNamedWithBothSizes) {
  DriveLine drives(2);
  ChangingPort port(drives.line(), shorten_sync_manager(3), {});
  LineOperation operation(drives, port);
  EXPECT_EQ(sentence(operation.to_safe_op()),
            "slave 0: asked for SAFEOP, is in PREOP, AL status code 0x001E (invalid input configuration); sync manager "
            "3 is set to 18 bytes, the slave's PDO mapping has 19");
}

TEST(SyncManagerSize, ThatDisagreesWithTheOutputsIsNamedWithBothSizes) {
  DriveLine drives(2);
  ChangingPort port(drives.line(), shorten_sync_manager(2), {});
  LineOperation operation(drives, port);
  EXPECT_EQ(
      sentence(operation.to_safe_op()),
      "slave 0: asked for SAFEOP, is in PREOP, AL status code 0x001D (invalid output configuration); sync manager "
      "2 is set to 18 bytes, the slave's PDO mapping has 19");
}

TEST(RefusedTransition, IsNamedAndMayBeRepeated) {
  DriveLine drives(3);
  LineOperation operation(drives);
  drives.slave(2).al().refuse(AlState::kSafeOp, wire::AlStatusCode::kNoValidInputs);
  EXPECT_EQ(sentence(operation.to_safe_op()),
            "slave 2: asked for SAFEOP, is in PREOP, AL status code 0x0018 (no valid inputs available)");
  drives.slave(2).al().clear_refusal();
  EXPECT_EQ(sentence(operation.master().configure(operation.plans())), "");
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
}

TEST(RefusedTransition, ToOpIsNamedAndMayBeRepeated) {
  DriveLine drives(2);
  LineOperation operation(drives);
  drives.slave(1).al().refuse(AlState::kOp, wire::AlStatusCode::kPllError);
  const auto done = operation.to_op();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::kStateRefused);
  EXPECT_EQ(done.error().slave, 1);
  EXPECT_EQ(done.error().code, 0x0032U);
  drives.slave(1).al().clear_refusal();
  EXPECT_EQ(sentence(operation.master().go_operational()), "");
  EXPECT_TRUE(drives.all_in(AlState::kOp));
}

TEST(DeadSlave, IsNamedWithTheRegisterThatItDidNotAnswer) {
  DriveLine drives(3);
  Master master(drives.line(), drives.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  drives.line().set_power(2, false);
  CoeClient coe(*master.mailbox(2));
  const auto done = coe.upload(0x6041, 0);
  ASSERT_FALSE(done);
  EXPECT_THAT(sentence(done), testing::MatchesRegex("slave 2: .*"));
  EXPECT_THAT(sentence(done), testing::Not(testing::HasSubstr("at address 0x6041")))
      << "6041h is an object, not a register";
}

}  // namespace
}  // namespace driveline::bus_test
