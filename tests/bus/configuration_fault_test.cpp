#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
namespace facts = ecat_master::facts;
using wire::AlState;

TEST(PdoMappingTooLong, IsRefusedByTheDriveWithItsReason) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  // 2 + 1 + 4 + 2 = 9 bytes; the drive takes 8 (MSD manual 8.3.4).
  plans[1].pdos.outputs = {{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}, {0x6071, 0, 16}}}};
  const auto done = operation.master().configure(plans);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::SdoAbort>());
  EXPECT_EQ(sentence(done),
            "slave 1: object 1600h:00 aborted with 0x06040042 (mapped objects would exceed the PDO length)");
}

TEST(PdoMappingTooLong, MayBeFollowedByAGoodOne) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  // Whatever was exchanged before, the mailbox restarts: one to nine entries are written before the failure, so that
  // every mailbox counter occurs.
  for (std::size_t entries = 0; entries < 9; ++entries) {
    auto plans = operation.plans();
    plans[0].startup_sdos.resize(std::min<std::size_t>(entries, plans[0].startup_sdos.size()));
    while (plans[0].startup_sdos.size() < entries) plans[0].startup_sdos.push_back({0x6065, 0, {4, std::byte{1}}});
    plans[0].startup_sdos.push_back({0x5FFF, 0, {std::byte{1}}});
    const auto failed = operation.master().configure(plans);
    ASSERT_FALSE(failed);
    EXPECT_TRUE(failed.error().is<facts::SdoAbort>()) << sentence(failed);
  }
  EXPECT_EQ(sentence(operation.master().configure(operation.plans())), "");
  EXPECT_TRUE(drives.all_in(AlState::kSafeOp));
}

TEST(EnterPreOp, LeavesNothingOfAnEarlierConfiguration) {
  DriveLine drives(2);
  ConfiguredOperation operation(drives);
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
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans[0].startup_sdos.push_back({0x5FFF, 3, {std::byte{1}}});
  EXPECT_EQ(sentence(operation.master().configure(plans)),
            "slave 0: object 5FFFh:03 aborted with 0x06020000 (object does not exist in the object dictionary)");
}

TEST(StartupSdo, IsWrittenBeforeTheTransitionItIsPlannedFor) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  const auto value = bytes::to_le_bytes<std::uint32_t>(4242);
  plans[1].startup_sdos.push_back(
      {0x6065, 0, {value.begin(), value.end()}, false, motion::StartupState::kSafeOperational});
  ASSERT_EQ(sentence(operation.master().configure(plans)), "");
  EXPECT_NE(CoeClient(*operation.master().mailbox(1)).upload_as<std::uint32_t>(0x6065, 0).value(), 4242U);
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  EXPECT_EQ(CoeClient(*operation.master().mailbox(1)).upload_as<std::uint32_t>(0x6065, 0).value(), 4242U);
}

TEST(Watchdogs, AreSetAsPlanned) {
  DriveLine drives(2);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans[1].watchdog = {2498, 500, 0};
  ASSERT_EQ(sentence(operation.master().configure(plans)), "");
  const auto& memory = drives.slave(1).esc().memory();
  EXPECT_EQ(memory.get(wire::reg::kWatchdogDivider), 2498);
  EXPECT_EQ(memory.get(wire::reg::kWatchdogTimeProcessData), 500);
  EXPECT_EQ(memory.get(wire::reg::kWatchdogTimePdi), 0);
  EXPECT_EQ(drives.slave(0).esc().memory().get(wire::reg::kWatchdogTimeProcessData), 1000) << "as after power-on";
}

/// Changes the data of every write to `address` of the slave with station address 0x1001.
ChangingPort::Change change_write(std::uint16_t address, const std::function<void(std::span<std::byte>)>& change) {
  return [address, change](std::span<std::byte> frame) {
    // Datagrams: command, index, ADP, ADO, length with a flag that more follow, interrupt, data, working counter.
    for (std::size_t at = 16; at + 12 <= frame.size();) {
      const auto word = [&](std::size_t offset) {
        return std::to_integer<unsigned>(frame[at + offset]) | std::to_integer<unsigned>(frame[at + offset + 1]) << 8;
      };
      const std::size_t length = word(6) & 0x7FFU;
      if (frame[at] == std::byte{5} && word(2) == 0x1001 && word(4) == address) change(frame.subspan(at + 10, length));
      if ((word(6) & 0x8000U) == 0) return;
      at += 12 + length;
    }
  };
}

/// The length written to sync manager `number` arrives one byte short.
ChangingPort::Change shorten_sync_manager(unsigned number) {
  return change_write(static_cast<std::uint16_t>(0x0800 + 8 * number),
                      [](std::span<std::byte> data) { data[2] = std::byte{18}; });
}

/// Runs configure() and returns everything that the master reports about its failure.
std::string everything_about(LineOperation& operation, std::vector<ecat_master::SlavePlan> plans) {
  auto& master = operation.master();
  const auto done = master.configure(std::move(plans));
  if (done) return {};
  return describe_with_findings(master.bus(), master.slaves(), master.image(), done.error());
}

TEST(SyncManagerSize, ThatDisagreesWithTheInputsIsNamedWithBothSizes) {
  DriveLine drives(2);
  ChangingPort port(drives.line(), shorten_sync_manager(3), {});
  LineOperation operation(drives, port);
  EXPECT_EQ(sentence(operation.to_safe_op()),
            "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x001E (invalid input configuration); sync "
            "manager "
            "3 is set to 18 bytes, the slave's PDO mapping has 19");
}

TEST(SyncManagerSize, ThatDisagreesWithTheOutputsIsNamedWithBothSizes) {
  DriveLine drives(2);
  ChangingPort port(drives.line(), shorten_sync_manager(2), {});
  LineOperation operation(drives, port);
  EXPECT_EQ(sentence(operation.to_safe_op()),
            "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x001D (invalid output configuration); "
            "sync manager "
            "2 is set to 18 bytes, the slave's PDO mapping has 19");
}

TEST(RefusedTransition, NamesFmmusThatAreNotAsTheyWereWritten) {
  DriveLine drives(2);
  // FMMU 1 maps the inputs: its length is changed to 7, the other settings are not.
  ChangingPort port(drives.line(), change_write(0x0600, [](std::span<std::byte> data) { data[16 + 4] = std::byte{7}; }),
                    {});
  LineOperation operation(drives, port);
  drives.slave(0).al().refuse(AlState::kSafeOp, wire::AlStatusCode::kInvalidInputMapping);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  EXPECT_EQ(everything_about(operation, operation.plans()),
            "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x0024 (invalid input mapping); FMMU 1: "
            "length is 7 "
            "instead of 19; FMMU 1 maps 7 bytes of sync manager 3, which has 19");
}

TEST(RefusedTransition, NamesEverySizeThatDisagrees) {
  DriveLine drives(2);
  ChangingPort port(drives.line(), shorten_sync_manager(3), {});
  ScannedOperation operation(drives, port);
  EXPECT_EQ(everything_about(operation, operation.plans()),
            "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x001E (invalid input configuration); sync "
            "manager "
            "3 is set to 18 bytes, the slave's PDO mapping has 19; sync manager 3: length is 18 instead of 19; FMMU 1 "
            "maps 19 bytes of sync manager 3, which has 18");
}

TEST(RefusedTransition, NamesPdosThatAreNotThePlannedOnes) {
  DriveLine drives(1);
  LineOperation operation(drives);
  drives.slave(0).al().refuse(AlState::kSafeOp, wire::AlStatusCode::kInvalidOutputMapping);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  EXPECT_EQ(everything_about(operation, operation.plans()),
            "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x0025 (invalid output mapping)")
      << "nothing disagrees, nothing is said";
  auto& slave = const_cast<ecat_master::ConfiguredSlave&>(operation.master().slaves()[0]);
  slave.plan.pdos.outputs.pop_back();
  const auto findings = check_configuration(operation.master().bus(), slave, operation.master().image(),
                                            wire::AlStatusCode::kInvalidOutputMapping);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(describe(findings[0]),
            "the PDOs planned for sync manager 2 have 15 bytes, the PDOs assigned by the slave have 19");
}

TEST(RefusedTransition, NamesTheWatchdogThatIsSwitchedOff) {
  DriveLine drives(1);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  plans[0].watchdog.process_data = 0;
  EXPECT_THAT(everything_about(operation, plans),
              testing::MatchesRegex(
                  "slave 0: requested SAFEOP, is in PREOP \\+ error, AL status code 0x001F .*; sync manager 2 "
                  "triggers the watchdog, which is switched off"));
  plans = operation.plans();
  plans[0].watchdog = {0, 1, std::nullopt};
  EXPECT_THAT(everything_about(operation, plans), testing::HasSubstr("which is switched off"))
      << "80 ns are none in microseconds";
}

TEST(RefusedTransition, NamesMailboxesOfAnotherDevicesFile) {
  DriveLine drives(1);
  ScannedOperation operation(drives);
  auto plans = operation.plans();
  auto file = operation.master().slaves()[0].info.description;
  file.sync_managers[0].start_address = 0x1E00;
  file.sync_managers[1].default_size = 64;
  plans[0].esi = std::make_shared<const esi::DeviceDescription>(file);
  const auto text = everything_about(operation, plans);
  EXPECT_THAT(text, testing::StartsWith("slave 0: requested PREOP, is in INIT + error, AL status code 0x0016"));
  EXPECT_THAT(text, testing::HasSubstr("; sync manager 0: start address is 0x1E00 by the description file, 0x1"));
  EXPECT_THAT(text, testing::HasSubstr("; sync manager 1: length is 64 by the description file, "));
  // Without the file the configuration succeeds.
  EXPECT_EQ(everything_about(operation, operation.plans()), "");
}

TEST(RefusedTransition, IsNamedAndMayBeRepeated) {
  DriveLine drives(3);
  LineOperation operation(drives);
  drives.slave(2).al().refuse(AlState::kSafeOp, wire::AlStatusCode::kNoValidInputs);
  EXPECT_EQ(sentence(operation.to_safe_op()),
            "slave 2: requested SAFEOP, is in PREOP + error, AL status code 0x0018 (no valid inputs available)");
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
  EXPECT_TRUE(done.error().is<facts::StateRefused>());
  EXPECT_EQ(done.error().slave, 1);
  EXPECT_EQ(std::get<facts::StateRefused>(done.error().facts).code, wire::AlStatusCode::kPllError);
  drives.slave(1).al().clear_refusal();
  EXPECT_EQ(sentence(operation.master().go_operational()), "");
  EXPECT_TRUE(drives.all_in(AlState::kOp));
}

TEST(DeadSlave, IsNamedWithTheRegisterThatItDidNotAnswer) {
  DriveLine drives(3);
  PreOpMaster master(drives.line(), drives.clock);
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
