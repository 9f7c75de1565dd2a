// Every kind of fault of the simulated line, as seen by the real master.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using slaves::Fault;
using slaves::FaultDirection;
using slaves::FaultKind;
using testing::HasSubstr;
using wire::AlState;
using wire::AlStatusCode;
namespace reg = wire::reg;

/// Drives in OP, exchanging process data.
class LineFault : public testing::Test {
 protected:
  void to_op(std::size_t count = 3) {
    drives = std::make_unique<DriveLine>(count);
    operation = std::make_unique<LineOperation>(*drives);
    ASSERT_EQ(sentence(operation->to_op()), "");
    operation->run(milliseconds{10});
    before = operation->statistics();
  }
  void scanned(std::size_t count = 2, const RunOptions& options = {}) {
    drives = std::make_unique<DriveLine>(count);
    operation = std::make_unique<LineOperation>(*drives, options);
    ASSERT_EQ(sentence(operation->master().scan()), "");
  }
  bool inject(const Fault& fault) { return drives->line().inject(fault); }
  std::uint64_t lost() { return operation->statistics().lost_frames - before.lost_frames; }
  std::uint64_t wkc_errors() { return operation->statistics().wkc_errors - before.wkc_errors; }
  std::uint64_t stale() { return operation->statistics().stale_frames - before.stale_frames; }
  std::size_t active() { return drives->line().faults().active().size(); }
  template <typename T>
  T peek(std::size_t position, const wire::Register<T>& r, unsigned n = 0) {
    return drives->slave(position).esc().memory().get(r, n);
  }

  std::unique_ptr<DriveLine> drives;
  std::unique_ptr<LineOperation> operation;
  motion::CycleStatistics before;
};

TEST_F(LineFault, DropOnTheWayOutKeepsTheOutputsFromTheDrives) {
  to_op();
  const auto written = drives->slave(0).esc().sync_managers().write_count(2);
  ASSERT_TRUE(inject({.kind = FaultKind::kDrop, .direction = FaultDirection::kOut, .count = 5}));
  operation->run(milliseconds{2});
  EXPECT_EQ(lost(), 5U);
  EXPECT_EQ(drives->slave(0).esc().sync_managers().write_count(2) - written, 16U - 5U);
  EXPECT_EQ(active(), 0U) << "it ends by itself after its count";
  EXPECT_TRUE(drives->all_in(AlState::kOp));
}

TEST_F(LineFault, DropOnTheWayBackComesTooLateForTheOutputs) {
  to_op();
  const auto written = drives->slave(0).esc().sync_managers().write_count(2);
  ASSERT_TRUE(inject({.kind = FaultKind::kDrop, .direction = FaultDirection::kBack, .count = 5}));
  operation->run(milliseconds{2});
  EXPECT_EQ(lost(), 5U);
  EXPECT_EQ(drives->slave(0).esc().sync_managers().write_count(2) - written, 16U) << "all drives have acted on them";
}

TEST_F(LineFault, ChanceHitsItsShareAndTheSameFramesAgain) {
  std::vector<std::uint64_t> counts;
  for (const std::uint32_t seed : {7U, 7U, 8U}) {
    to_op(1);
    ASSERT_TRUE(inject({.kind = FaultKind::kDrop, .chance = 0.1, .seed = seed}));
    std::uint64_t pattern = 0;
    for (int i = 0; i < 64; ++i) {
      const auto so_far = lost();
      operation->cycle();
      pattern = pattern << 1 | (lost() > so_far ? 1U : 0U);
    }
    operation->run(milliseconds{250});
    EXPECT_GT(lost(), 150U) << "of about 2064 frames";
    EXPECT_LT(lost(), 270U);
    counts.push_back(pattern);
  }
  EXPECT_EQ(counts[0], counts[1]);
  EXPECT_NE(counts[0], counts[2]);
}

TEST_F(LineFault, DelayedFramesAreLateAndHoldUpThoseBehind) {
  to_op();
  ASSERT_TRUE(inject({.kind = FaultKind::kDelay, .count = 1, .time = microseconds{400}}));
  operation->run(milliseconds{5});
  EXPECT_EQ(lost(), 3U) << "itself and two behind it; the fourth comes at 400 us, within its own cycle";
  EXPECT_EQ(stale(), 3U) << "they come, and are not taken for new ones";
  EXPECT_EQ(wkc_errors(), 0U);
}

TEST_F(LineFault, DuplicatesAreNotTakenTwice) {
  to_op();
  ASSERT_TRUE(inject({.kind = FaultKind::kDuplicate, .count = 20}));
  operation->run(milliseconds{10});
  EXPECT_EQ(lost(), 0U);
  EXPECT_EQ(wkc_errors(), 0U);
  EXPECT_EQ(stale() + operation->statistics().foreign_frames - before.foreign_frames, 20U);
  CoeClient coe(*operation->master().mailbox(1));
  EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
}

TEST_F(LineFault, CorruptRepliesNeverReachTheAxesUnnoticedInTheHeader) {
  to_op();
  ASSERT_TRUE(
      inject({.kind = FaultKind::kCorrupt, .direction = FaultDirection::kBack, .count = 200, .seed = 3, .bits = 40}));
  operation->run(milliseconds{100});
  EXPECT_GT(lost() + wkc_errors(), 100U) << "40 flipped bits meet header or working counter nearly always";
  EXPECT_EQ(active(), 0U);
  EXPECT_TRUE(drives->all_in(AlState::kOp));
  const auto errors = wkc_errors() + lost();
  operation->run(milliseconds{10});
  EXPECT_EQ(wkc_errors() + lost(), errors) << "afterwards all is well";
}

TEST_F(LineFault, CorruptRequestsLeaveAWorkingLineBehind) {
  to_op();
  ASSERT_TRUE(
      inject({.kind = FaultKind::kCorrupt, .direction = FaultDirection::kOut, .count = 300, .seed = 5, .bits = 8}));
  operation->run(milliseconds{100});
  // A new start succeeds, whatever the flipped bits have written into the drives.
  static_cast<void>(operation->master().shut_down());
  LineOperation again(*drives);
  EXPECT_EQ(sentence(again.to_op()), "");
}

TEST_F(LineFault, DamagedFramesAreCountedWhereTheCableIsBad) {
  to_op(4);
  const auto written = [this](std::size_t i) { return drives->slave(i).esc().sync_managers().write_count(2); };
  const auto near = written(1);
  const auto far = written(2);
  ASSERT_TRUE(inject({.kind = FaultKind::kDamage, .slave = 2, .port = 0, .count = 6}));
  operation->run(milliseconds{2});
  EXPECT_EQ(lost(), 6U) << "the master's interface discards them";
  EXPECT_EQ(peek(2, reg::kRxErrorCounter, 0) & 0xFF, 6) << "who finds the damage";
  EXPECT_EQ(peek(3, reg::kForwardedErrorCounter, 0), 6) << "who is told of it";
  EXPECT_EQ(peek(2, reg::kForwardedErrorCounter, 1), 6) << "and on the way back";
  EXPECT_EQ(peek(0, reg::kForwardedErrorCounter, 1), 6);
  EXPECT_EQ(peek(0, reg::kRxErrorCounter, 0), 0) << "in front of it all was well";
  EXPECT_EQ(peek(1, reg::kRxErrorCounter, 0), 0);
  EXPECT_EQ(written(1) - near, 16U);
  EXPECT_EQ(written(2) - far, 10U) << "damaged outputs are not taken";
}

TEST_F(LineFault, AShortWorkingCounterLacksWhatTheSlaveWouldAdd) {
  to_op();
  const auto expected = operation->line_samples.back().working_counter;
  ASSERT_TRUE(inject({.kind = FaultKind::kShortWorkingCounter, .slave = 1, .count = 4}));
  operation->line_samples.clear();
  operation->run(milliseconds{2});
  EXPECT_EQ(wkc_errors(), 4U);
  EXPECT_EQ(lost(), 0U);
  unsigned shorter = 0;
  for (const auto& sample : operation->line_samples) shorter += sample.working_counter == expected - 3 ? 1 : 0;
  EXPECT_EQ(shorter, 4U) << "read and written: three less";
}

TEST_F(LineFault, ACableBreakCutsOffWhatLiesBehindUntilItHeals) {
  to_op(4);
  const Fault broken{.kind = FaultKind::kCableBreak, .slave = 1, .port = 1};
  ASSERT_TRUE(inject(broken));
  operation->run(milliseconds{5});
  EXPECT_EQ(operation->master().core()->al_status().slaves, 2);
  EXPECT_EQ(peek(1, reg::kLostLinkCounter, 1), 1);
  // The same cable, identified by its other end.
  EXPECT_TRUE(drives->line().heal({.kind = FaultKind::kCableBreak, .slave = 2, .port = 0}));
  operation->run(milliseconds{5});
  EXPECT_EQ(operation->master().core()->al_status().slaves, 4);
  EXPECT_FALSE(drives->line().heal(broken)) << "it is healed already";
}

TEST_F(LineFault, PowerOffAndOnStartsTheSlaveInInit) {
  to_op();
  ASSERT_TRUE(inject({.kind = FaultKind::kPowerOff, .slave = 2, .duration = milliseconds{50}}));
  operation->run(milliseconds{20});
  EXPECT_EQ(operation->master().core()->al_status().slaves, 2);
  EXPECT_EQ(drives->state(1), AlState::kOp);
  operation->run(milliseconds{50});
  EXPECT_EQ(operation->master().core()->al_status().slaves, 3) << "it is back after its duration";
  EXPECT_EQ(drives->state(2), AlState::kInit);
  EXPECT_EQ(peek(2, reg::kStationAddress), 0);
}

TEST_F(LineFault, ASilentMailboxIsATimeout) {
  scanned();
  ASSERT_EQ(sentence(operation->master().enter_pre_op()), "");
  const Fault silent{.kind = FaultKind::kMailboxSilent, .slave = 1};
  ASSERT_TRUE(inject(silent));
  CoeClient coe(*operation->master().mailbox(1));
  const auto read = coe.upload_as<std::uint32_t>(0x1018, 1);
  ASSERT_FALSE(read);
  EXPECT_THAT(sentence(read), HasSubstr("slave 1: no mailbox reply"));
  EXPECT_EQ(sentence(CoeClient(*operation->master().mailbox(0)).upload_as<std::uint32_t>(0x1018, 1)), "");
  ASSERT_TRUE(drives->line().heal(silent));
  EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
}

TEST_F(LineFault, MalformedAndOversizedMailsAreNamedAndTheNextTransferWorks) {
  scanned();
  ASSERT_EQ(sentence(operation->master().enter_pre_op()), "");
  CoeClient coe(*operation->master().mailbox(1));
  for (const auto kind : {FaultKind::kMailboxMalformed, FaultKind::kMailboxOversized}) {
    const Fault fault{.kind = kind, .slave = 1};
    ASSERT_TRUE(inject(fault));
    EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)),
              "slave 1: sent a malformed mailbox for object 1018h:01");
    EXPECT_EQ(sentence(CoeClient(*operation->master().mailbox(0)).upload_as<std::uint32_t>(0x1018, 1)), "");
    ASSERT_TRUE(drives->line().heal(fault));
    EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
  }
}

TEST_F(LineFault, ALateMailIsWaitedForUntilTheTimeLimitAndIsNotTakenForTheNextAnswer) {
  scanned();
  ASSERT_EQ(sentence(operation->master().enter_pre_op()), "");
  CoeClient coe(*operation->master().mailbox(1));
  const Fault late{.kind = FaultKind::kMailboxLate, .slave = 1, .time = milliseconds{300}};
  ASSERT_TRUE(inject(late));
  const auto begin = drives->clock.now();
  EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
  EXPECT_GE(drives->clock.now() - begin, milliseconds{300});
  EXPECT_LT(drives->clock.now() - begin, milliseconds{310});
  ASSERT_TRUE(drives->line().heal(late));
  const Fault too_late{.kind = FaultKind::kMailboxLate, .slave = 1, .time = milliseconds{2050}};
  ASSERT_TRUE(inject(too_late));
  EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)),
            "slave 1: no mailbox reply for object 1018h:01 within 2000 ms");
  ASSERT_TRUE(drives->line().heal(too_late));
  const auto serial = coe.upload_as<std::uint32_t>(0x1018, 4);
  ASSERT_EQ(sentence(serial), "");
  EXPECT_EQ(*serial, 1001U);
}

TEST_F(LineFault, MailsOfAForeignProtocolAreRefusedAndDelayNothing) {
  scanned();
  ASSERT_EQ(sentence(operation->master().enter_pre_op()), "");
  ASSERT_TRUE(inject({.kind = FaultKind::kMailboxForeign, .slave = 1}));
  CoeClient coe(*operation->master().mailbox(1));
  const auto begin = drives->clock.now();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "") << i;
  EXPECT_LT(drives->clock.now() - begin, milliseconds{100});
  EXPECT_GE(operation->master().mailboxes().statistics(1).refused, 10U);
}

TEST_F(LineFault, ABusyMailboxTakesOneRequestAndNoMore) {
  scanned();
  ASSERT_EQ(sentence(operation->master().enter_pre_op()), "");
  ASSERT_TRUE(inject({.kind = FaultKind::kMailboxBusy, .slave = 0}));
  CoeClient coe(*operation->master().mailbox(0));
  EXPECT_FALSE(coe.upload_as<std::uint32_t>(0x1018, 1)) << "the request lies in the mailbox and nobody takes it";
  EXPECT_TRUE(drives->slave(0).esc().sync_managers().full(0));
  const auto second = coe.upload_as<std::uint32_t>(0x1018, 1);
  ASSERT_FALSE(second) << "and the next one finds it full";
  EXPECT_EQ(second.error().slave, 0);
  ASSERT_TRUE(drives->line().heal({.kind = FaultKind::kMailboxBusy, .slave = 0}));
  ASSERT_EQ(sentence(operation->master().enter_pre_op()), "");
  EXPECT_EQ(sentence(CoeClient(*operation->master().mailbox(0)).upload_as<std::uint32_t>(0x1018, 1)), "");
}

TEST_F(LineFault, ABusyEepromIsWaitedForOrNamed) {
  drives = std::make_unique<DriveLine>(2);
  operation = std::make_unique<LineOperation>(*drives);
  ASSERT_TRUE(inject({.kind = FaultKind::kEepromBusy, .slave = 1, .time = milliseconds{1}}));
  const auto begin = drives->clock.now();
  ASSERT_EQ(sentence(operation->master().scan()), "");
  const auto slow = drives->clock.now() - begin;
  EXPECT_GT(slow, milliseconds{4}) << "identity alone takes four words";
  ASSERT_TRUE(inject({.kind = FaultKind::kEepromBusy, .slave = 1, .time = std::chrono::seconds{60}}));
  ASSERT_EQ(sentence(operation->master().scan()), "") << "the others are found";
  const auto& problem = operation->master().slaves()[1].info.problem;
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->slave, 1);
  EXPECT_THAT(describe(*problem), HasSubstr("EEPROM"));
}

TEST_F(LineFault, AWrongEepromChecksumKeepsTheApplicationDownAfterPowerOn) {
  scanned();
  const Fault checksum{.kind = FaultKind::kEepromChecksum, .slave = 1};
  ASSERT_TRUE(inject(checksum));
  ASSERT_TRUE(inject({.kind = FaultKind::kPowerOff, .slave = 1, .duration = milliseconds{10}}));
  drives->leave_alone(milliseconds{20});
  EXPECT_FALSE(drives->slave(1).esc().pdi_operational());
  EXPECT_NE(peek(1, reg::kSiiControl) & 0x0800, 0) << "checksum error (ETG.1000.4 Table 50)";
  LineOperation again(*drives);
  EXPECT_NE(sentence(again.to_safe_op()), "") << "its AL control is never answered";
  EXPECT_EQ(drives->state(1), AlState::kInit);
  ASSERT_TRUE(drives->line().heal(checksum));
  ASSERT_TRUE(inject({.kind = FaultKind::kPowerOff, .slave = 1, .duration = milliseconds{10}}));
  drives->leave_alone(milliseconds{20});
  LineOperation healed(*drives);
  EXPECT_EQ(sentence(healed.to_safe_op()), "");
}

TEST_F(LineFault, ASlowTransitionIsWaitedForOrNamed) {
  scanned(2, RunOptions{.state_timeout = milliseconds{500}});
  ASSERT_TRUE(inject({.kind = FaultKind::kSlowTransition, .slave = 1, .time = milliseconds{80}}));
  ASSERT_EQ(sentence(operation->to_safe_op()), "");
  ASSERT_TRUE(inject({.kind = FaultKind::kSlowTransition, .slave = 1, .time = std::chrono::seconds{3}}));
  operation->start_cycle();
  const auto done = operation->master().go_operational();
  ASSERT_FALSE(done);
  EXPECT_THAT(sentence(done), HasSubstr("slave 1: requested OP, is in SAFEOP"));
  ASSERT_TRUE(drives->line().heal({.kind = FaultKind::kSlowTransition, .slave = 1}));
  EXPECT_EQ(drives->slave(1).al().transition_delay(), nanoseconds{0}) << "as it was, not as the fault before had it";
}

TEST_F(LineFault, ARefusedTransitionComesWithItsCode) {
  scanned();
  ASSERT_TRUE(inject({.kind = FaultKind::kRefuseTransition,
                      .slave = 1,
                      .state = AlState::kSafeOp,
                      .code = AlStatusCode::kDcInvalidSyncCycleTime}));
  const auto done = operation->to_safe_op();
  ASSERT_FALSE(done);
  EXPECT_THAT(sentence(done), HasSubstr("slave 1: requested SAFEOP"));
  EXPECT_THAT(sentence(done), HasSubstr("0x0035"));
  ASSERT_TRUE(drives->line().heal({.kind = FaultKind::kRefuseTransition, .slave = 1}));
  EXPECT_EQ(sentence(operation->to_safe_op()), "");
}

TEST_F(LineFault, AScriptBringsFaultsAtTheirTimes) {
  to_op();
  auto& faults = drives->line().faults();
  const auto begin = drives->clock.now();
  faults.schedule(begin + milliseconds{30}, {.kind = FaultKind::kDrop, .count = 3});
  faults.schedule(begin + milliseconds{10},
                  {.kind = FaultKind::kShortWorkingCounter, .slave = 0, .duration = milliseconds{1}});
  operation->run(milliseconds{9});
  EXPECT_EQ(wkc_errors(), 0U);
  operation->run(milliseconds{10});
  EXPECT_EQ(wkc_errors(), 8U) << "1 ms of 125 us";
  EXPECT_EQ(lost(), 0U);
  operation->run(milliseconds{20});
  EXPECT_EQ(lost(), 3U);
  // The fault event, with its time.
  slaves::FaultEvent event;
  std::vector<std::pair<FaultKind, nanoseconds>> seen;
  while (faults.next_event(event)) seen.emplace_back(event.fault.kind, event.time - begin);
  ASSERT_EQ(seen.size(), 4U);
  EXPECT_EQ(seen[0], (std::pair{FaultKind::kShortWorkingCounter, nanoseconds{milliseconds{10}}}));
  EXPECT_EQ(seen[1], (std::pair{FaultKind::kShortWorkingCounter, nanoseconds{milliseconds{11}}}));
  EXPECT_EQ(seen[2], (std::pair{FaultKind::kDrop, nanoseconds{milliseconds{30}}}));
  EXPECT_EQ(seen[3].first, FaultKind::kDrop);
}

TEST_F(LineFault, TakesEffectAtItsTimeHoweverLateTheNextFrameComes) {
  scanned();
  auto& line = drives->line();
  const auto begin = drives->clock.now();
  line.faults().schedule(begin + milliseconds{5},
                         {.kind = FaultKind::kPowerOff, .slave = 1, .duration = milliseconds{5}});
  drives->leave_alone(milliseconds{100});
  EXPECT_TRUE(drives->slave(1).powered());
  EXPECT_EQ(peek(1, reg::kStationAddress), 0) << "it was off in between";
  EXPECT_NE(peek(0, reg::kStationAddress), 0);
}

TEST_F(LineFault, WhatIsNotThereCannotBreak) {
  scanned();
  EXPECT_FALSE(inject({.kind = FaultKind::kPowerOff, .slave = 2}));
  EXPECT_FALSE(inject({.kind = FaultKind::kCableBreak, .slave = 1, .port = 1})) << "no cable at the end of the line";
  EXPECT_FALSE(inject({.kind = FaultKind::kDamage, .slave = 0, .port = 3}));
  EXPECT_FALSE(drives->line().heal({.kind = FaultKind::kDrop}));
  EXPECT_EQ(active(), 0U);
}

TEST_F(LineFault, AllHealAtOnce) {
  scanned(3);
  for (std::uint16_t i = 0; i < 3; ++i) ASSERT_TRUE(inject({.kind = FaultKind::kPowerOff, .slave = i}));
  ASSERT_TRUE(inject({.kind = FaultKind::kDrop}));
  ASSERT_TRUE(inject({.kind = FaultKind::kPowerOff, .slave = 1})) << "in place of the one that is there";
  EXPECT_EQ(active(), 4U);
  drives->line().faults().schedule(drives->clock.now() + milliseconds{1}, {.kind = FaultKind::kDrop});
  drives->line().faults().heal_all(drives->clock.now());
  EXPECT_EQ(active(), 0U);
  drives->leave_alone(milliseconds{2});
  EXPECT_EQ(active(), 0U) << "the script is forgotten";
  EXPECT_EQ(sentence(operation->to_safe_op()), "");
}

TEST_F(LineFault, ThereIsRoomForManyButNotForAnyNumber) {
  drives = std::make_unique<DriveLine>(slaves::LineFaults::kMaxActive + 1);
  for (std::uint16_t i = 0; i < slaves::LineFaults::kMaxActive; ++i) {
    ASSERT_TRUE(inject({.kind = FaultKind::kMailboxSilent, .slave = i}));
  }
  EXPECT_FALSE(inject({.kind = FaultKind::kMailboxSilent, .slave = slaves::LineFaults::kMaxActive}));
  EXPECT_TRUE(inject({.kind = FaultKind::kMailboxBusy, .slave = 0})) << "takes the place of the other one";
}

}  // namespace
}  // namespace driveline::bus_test
