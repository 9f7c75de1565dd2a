// Synchronisation as seen by the slave: invalid settings, missing or uneven SYNC0, late outputs, each with its AL
// status code (ETG.1020).
#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

using std::chrono::nanoseconds;

class SyncSupervisionTest : public BenchSlave {
 protected:
  static constexpr std::uint32_t kCycle = 1'000'000;

  /// In PREOP with process data configured, SYNC as given.
  void prepare(const SyncDemand& demand) {
    auto own = std::make_unique<TestDevice>();
    own->demand = demand;
    rebuild({}, std::move(own));
    go_to(AlState::kPreOp);
    configure_process_data();
  }
  void activate(std::uint32_t cycle0, unsigned activation = 0x03, std::uint32_t cycle1 = 0,
                std::int64_t start_in = kCycle) {
    write(reg::kDcActivation, 0);
    write(reg::kStartTimeCyclic, static_cast<std::uint64_t>(esc().clock().system_time(now()).count() + start_in));
    write(reg::kSync0CycleTime, cycle0);
    write(reg::kSync1CycleTime, cycle1);
    write(reg::kDcActivation, static_cast<std::uint8_t>(activation));
  }
  /// A cycle of the master: outputs 300 us before SYNC0. A slave that has left OP by an error refuses them.
  void cycle(bool with_outputs = true) {
    pass(nanoseconds{kCycle} - 300us);
    if (with_outputs) write(kOutputsAddress, bytes({1, 2, 3, 4}));
    pass(300us);
  }
  void to_op(const SyncDemand& demand) {
    prepare(demand);
    activate(kCycle);
    expect_request(AlState::kSafeOp, AlState::kSafeOp);
    pass(100us);  // between two pulses
    request(AlState::kOp);
    for (int i = 0; i < 20; ++i) cycle();
    expect_status(AlState::kOp);
  }
  void expect_safe_op_refused(AlStatusCode code) { expect_request(AlState::kSafeOp, AlState::kPreOp, code); }
};

SyncDemand demand_of_a_drive() {
  SyncDemand demand;
  demand.sync1 = true;
  demand.time_base = 125us;
  demand.min_cycle = 125us;
  demand.max_cycle = 20ms;
  demand.error_limit = 12;
  return demand;
}

TEST_F(SyncSupervisionTest, ADeviceThatNeedsSync0DoesNotRunWithoutIt) {
  SyncDemand demand;
  demand.free_run = demand.sm_event = false;
  prepare(demand);
  expect_safe_op_refused(AlStatusCode::kFreeRunNotSupported);
  activate(kCycle);
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(SyncSupervisionTest, FreeRunThatIsSetButNotSupported) {
  SyncDemand demand;
  demand.free_run = false;
  demand.type = SyncType::kFreeRun;
  prepare(demand);
  expect_safe_op_refused(AlStatusCode::kFreeRunNotSupported);
}

TEST_F(SyncSupervisionTest, TypesThatAreNotSupported) {
  SyncDemand no_clock;
  no_clock.sync0 = false;
  prepare(no_clock);
  activate(kCycle);
  expect_safe_op_refused(AlStatusCode::kSyncModeNotSupported);

  SyncDemand no_sync1;
  prepare(no_sync1);
  activate(kCycle, 0x07, 0);
  expect_safe_op_refused(AlStatusCode::kSyncModeNotSupported);

  SyncDemand unknown;
  unknown.type = static_cast<SyncType>(7);
  prepare(unknown);
  expect_safe_op_refused(AlStatusCode::kSyncModeNotSupported);
}

TEST_F(SyncSupervisionTest, ActivationThatContradictsTheTypeOrItself) {
  struct Row {
    std::optional<SyncType> type;
    unsigned activation;
  };
  for (const auto& row : {Row{SyncType::kSync0, 0x00}, Row{SyncType::kFreeRun, 0x03}, Row{SyncType::kSmEvent, 0x03},
                          Row{SyncType::kSync1, 0x03}, Row{{}, 0x05}, Row{{}, 0x01}}) {
    auto demand = demand_of_a_drive();
    demand.type = row.type;
    prepare(demand);
    activate(kCycle, row.activation);
    SCOPED_TRACE(row.activation);
    expect_safe_op_refused(AlStatusCode::kInvalidDcSyncConfiguration);
  }
}

TEST_F(SyncSupervisionTest, Sync0CycleTimesThatDoNotFit) {
  for (const std::uint32_t cycle : {0U, 200'000U, 62'500U, 40'000'000U}) {
    prepare(demand_of_a_drive());
    activate(cycle);
    SCOPED_TRACE(cycle);
    expect_safe_op_refused(AlStatusCode::kDcSync0CycleTime);
  }
  for (const std::uint32_t cycle : {125'000U, 20'000'000U}) {
    prepare(demand_of_a_drive());
    activate(cycle);
    expect_request(AlState::kSafeOp, AlState::kSafeOp);
  }
}

TEST_F(SyncSupervisionTest, Sync1CycleTimesThatDoNotFit) {
  prepare(demand_of_a_drive());
  activate(250'000, 0x07, 300'000);
  expect_safe_op_refused(AlStatusCode::kDcSync1CycleTime);
  activate(250'000, 0x07, 100'000);  // a shift
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(SyncSupervisionTest, ACycleOtherThanTheOneTheApplicationIsSetTo) {
  auto demand = demand_of_a_drive();
  demand.cycle = 1ms;
  prepare(demand);
  activate(500'000);
  expect_safe_op_refused(AlStatusCode::kDcInvalidSyncCycleTime);
  activate(250'000, 0x07, 750'000);  // SYNC1 at every fourth SYNC0
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(SyncSupervisionTest, OpWaitsForEvenPulses) {
  prepare(demand_of_a_drive());
  activate(kCycle);
  request(AlState::kSafeOp);
  pass(100us);
  request(AlState::kOp);
  // The first pulse gives no interval, the next eight are even.
  for (int i = 0; i < 8; ++i) cycle();
  expect_status(AlState::kSafeOp);
  cycle();
  expect_status(AlState::kOp);
}

TEST_F(SyncSupervisionTest, OpIsNotReachedWithoutSync0) {
  prepare(demand_of_a_drive());
  activate(kCycle, 0x03, 0, -1000);  // a start time in the past
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
  request(AlState::kOp);
  for (int i = 0; i < 1001; ++i) cycle();
  expect_status(AlState::kSafeOp, AlStatusCode::kNoSyncError);
}

TEST_F(SyncSupervisionTest, OpIsNotReachedWithAClockThatIsSetAgainAndAgain) {
  prepare(demand_of_a_drive());
  activate(kCycle);
  request(AlState::kSafeOp);
  request(AlState::kOp);
  for (int i = 0; i < 1001; ++i) {
    cycle();
    if (i % 5 == 0) write(reg::kSystemTimeOffset, static_cast<std::uint64_t>(std::int64_t{-40'000} * (i / 5 % 2)));
  }
  expect_status(AlState::kSafeOp, AlStatusCode::kPllError);
}

TEST_F(SyncSupervisionTest, AClockThatIsSetInOp) {
  to_op(demand_of_a_drive());
  write(reg::kSystemTimeOffset, static_cast<std::uint64_t>(-100'000));
  cycle();
  cycle();
  expect_status(AlState::kSafeOp, AlStatusCode::kPllError);
  EXPECT_EQ(device().fall_backs.back(),
            (TestDevice::FallBack{AlState::kOp, AlState::kSafeOp, AlStatusCode::kPllError}));
}

TEST_F(SyncSupervisionTest, Sync0ThatStopsInOp) {
  to_op(demand_of_a_drive());
  write(reg::kDcActivation, 0);
  pass(2800us);
  expect_status(AlState::kOp);
  pass(200us);
  expect_status(AlState::kSafeOp, AlStatusCode::kFatalSyncError);
}

TEST_F(SyncSupervisionTest, SmallCorrectionsOfTheClockAreNoReason) {
  to_op(demand_of_a_drive());
  for (int i = 0; i < 200; ++i) {
    cycle();
    const auto ahead = bytes::to_le_bytes(static_cast<std::uint32_t>(now().count() + 2000));
    transfer(Command::kArmw, 1, 0x0910, {ahead.begin(), ahead.end()});
  }
  expect_status(AlState::kOp);
}

TEST_F(SyncSupervisionTest, OutputsThatComeNoMore) {
  to_op(demand_of_a_drive());
  for (int i = 0; i < 4; ++i) cycle(false);
  expect_status(AlState::kOp);
  cycle(false);
  expect_status(AlState::kSafeOp, AlStatusCode::kDcSyncTimeout);
}

/// A master whose cycle is a multiple of SYNC0's, e.g. 1 ms with SYNC0 at 125 us.
TEST_F(SyncSupervisionTest, OutputsAreDueOnceInTheCycleOfTheApplication) {
  auto demand = demand_of_a_drive();
  demand.outputs_cycle = 4ms;
  to_op(demand);
  for (int i = 0; i < 400; ++i) cycle(i % 4 == 1);
  expect_status(AlState::kOp);
  EXPECT_EQ(slave().al().sync_margin().missed, 0U);
  // The last outputs came two pulses ago. They are missing after six, and after every fourth from there; five missing
  // ones exceed the limit of 12.
  for (int i = 0; i < 19; ++i) cycle(false);
  expect_status(AlState::kOp);
  EXPECT_EQ(slave().al().sync_margin().missed, 4U);
  cycle(false);
  expect_status(AlState::kSafeOp, AlStatusCode::kDcSyncTimeout);
}

TEST_F(SyncSupervisionTest, OutputsNearAPulseMayComeAPulseEarlierOrLater) {
  auto demand = demand_of_a_drive();
  demand.outputs_cycle = 4ms;
  to_op(demand);
  for (int i = 0; i < 400; ++i) cycle(i % 8 == 1 || i % 8 == 6);  // five pulses, then three
  expect_status(AlState::kOp);
  EXPECT_EQ(slave().al().sync_margin().missed, 0U);
}

TEST_F(SyncSupervisionTest, OutputsThatAreDueMoreOftenThanSync0AreDueAtEachPulse) {
  auto demand = demand_of_a_drive();
  demand.outputs_cycle = 250us;
  to_op(demand);
  for (int i = 0; i < 4; ++i) cycle(false);
  expect_status(AlState::kOp);
  cycle(false);
  expect_status(AlState::kSafeOp, AlStatusCode::kDcSyncTimeout);
}

TEST_F(SyncSupervisionTest, PulsesThatTheApplicationCannotServeExceedItsCycle) {
  to_op(demand_of_a_drive());
  for (int i = 0; i < 20; ++i) cycle();
  slave().stall(now(), 2500us);
  for (int i = 0; i < 20; ++i) cycle();
  expect_status(AlState::kOp);
  EXPECT_EQ(slave().al().sync_margin().exceeded, 2U);
  EXPECT_EQ(slave().al().sync_margin().missed, 0U);
}

TEST_F(SyncSupervisionTest, OutputsThatComeTooShortlyBeforeTheirPulse) {
  auto demand = demand_of_a_drive();
  demand.calc_and_copy = 50us;
  to_op(demand);
  for (int i = 0; i < 10; ++i) cycle();
  EXPECT_EQ(slave().al().sync_margin().too_short, 0U) << "200 us before";
  for (const auto ahead : {49us, 50us, 51us}) {
    pass(nanoseconds{kCycle} - ahead - 100us);
    write_outputs(bytes({1, 2, 3, 4}));
    pass(ahead + 100us);
  }
  EXPECT_EQ(slave().al().sync_margin().too_short, 1U) << "SYNC0 comes 100 us before the end of the cycle";
}

TEST_F(SyncSupervisionTest, TypesOfTheInputs) {
  struct Row {
    SyncType type;
    bool outputs;
    unsigned activation;
    AlStatusCode code;
  };
  for (const auto& row : {Row{SyncType::kSm2Event, true, 0x00, AlStatusCode::kNoError},
                          Row{SyncType::kSm2Event, true, 0x03, AlStatusCode::kNoError},
                          Row{SyncType::kSm2Event, false, 0x00, AlStatusCode::kSyncModeNotSupported},
                          Row{SyncType::kSync0, true, 0x03, AlStatusCode::kNoError},
                          Row{SyncType::kSync0, true, 0x00, AlStatusCode::kInvalidDcSyncConfiguration},
                          Row{SyncType::kSync1, true, 0x03, AlStatusCode::kInvalidDcSyncConfiguration},
                          Row{static_cast<SyncType>(0x21), true, 0x00, AlStatusCode::kSyncModeNotSupported}}) {
    SCOPED_TRACE(testing::Message() << static_cast<unsigned>(row.type) << ", activation " << row.activation);
    auto demand = demand_of_a_drive();
    demand.input_type = row.type;
    demand.outputs = row.outputs;
    prepare(demand);
    activate(kCycle, row.activation);
    expect_request(AlState::kSafeOp, row.code == AlStatusCode::kNoError ? AlState::kSafeOp : AlState::kPreOp, row.code);
  }
}

TEST_F(SyncSupervisionTest, TheApplicationIsToldTheCycleThatRuns) {
  prepare(demand_of_a_drive());
  activate(kCycle);
  request(AlState::kSafeOp);
  EXPECT_EQ(device().sync0_cycles, (std::vector<nanoseconds>{1ms}));
  activate(2 * kCycle);
  request(AlState::kOp);
  EXPECT_EQ(device().sync0_cycles.back(), 2ms) << "activated in SAFEOP";
  write(reg::kDcActivation, 0);
  request(AlState::kPreOp);
  request(AlState::kSafeOp);
  EXPECT_EQ(device().sync0_cycles.back(), 0ms);
}

TEST_F(SyncSupervisionTest, OutputsThatMissEverySecondPulse) {
  to_op(demand_of_a_drive());
  for (int i = 0; i < 20; ++i) cycle(i % 2 == 0);
  expect_status(AlState::kSafeOp, AlStatusCode::kDcSyncIoError);
}

/// On a network interface a frame may be served before the preceding pulse is processed.
TEST_F(SyncSupervisionTest, OutputsBehindThePulseAreNotItsOwn) {
  EscMemory memory(8);
  memory.set(reg::kDcActivation, 0x03);
  memory.set(reg::kSync0CycleTime, kCycle);
  SyncSupervision supervision(memory);
  supervision.start(demand_of_a_drive());
  supervision.enter_op(0ns, 10);
  supervision.pulse(SyncSignal::kSync0, 1ms, 10, 0ns);  // the first one gives no interval
  supervision.pulse(SyncSignal::kSync0, 2ms, 11, 1700us);
  EXPECT_EQ(supervision.margin().shortest, 300us);
  supervision.pulse(SyncSignal::kSync0, 3ms, 12, 3100us);  // arrived 100 us too late
  EXPECT_EQ(supervision.margin().missed, 1U);
  supervision.pulse(SyncSignal::kSync0, 4ms, 12, 3100us);  // used for this pulse
  EXPECT_EQ(supervision.margin().missed, 1U);
  EXPECT_EQ(supervision.margin().longest, 900us);
  supervision.pulse(SyncSignal::kSync0, 5ms, 14, 5100us);  // one in time, one for the next pulse
  EXPECT_EQ(supervision.margin().missed, 1U);
  EXPECT_EQ(supervision.margin().pulses, 2U);
  EXPECT_EQ(supervision.margin().shortest, 300us);
}

TEST_F(SyncSupervisionTest, ASingleMissedPulseIsForgiven) {
  to_op(demand_of_a_drive());
  for (int i = 0; i < 200; ++i) cycle(i % 4 != 0);
  expect_status(AlState::kOp);
}

TEST_F(SyncSupervisionTest, WithoutALimitOnlyTheWatchdogLooksAtOutputs) {
  auto demand = demand_of_a_drive();
  demand.error_limit = 0;
  to_op(demand);
  for (int i = 0; i < 90; ++i) cycle(false);
  expect_status(AlState::kOp);
  for (int i = 0; i < 20; ++i) cycle(false);
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
}

TEST_F(SyncSupervisionTest, ProcessDataThatSynchroniseAndComeTooLate) {
  auto demand = demand_of_a_drive();
  demand.type = SyncType::kSmEvent;
  demand.cycle = 1ms;
  prepare(demand);
  request(AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  expect_request(AlState::kOp, AlState::kOp);
  for (int i = 0; i < 100; ++i) cycle();
  expect_status(AlState::kOp);
  for (int i = 0; i < 6; ++i) cycle(false);
  expect_status(AlState::kSafeOp, AlStatusCode::kSynchronizationError);
}

TEST_F(SyncSupervisionTest, AfterTheErrorANewStartUpSucceeds) {
  to_op(demand_of_a_drive());
  for (int i = 0; i < 6; ++i) cycle(false);
  expect_status(AlState::kSafeOp, AlStatusCode::kDcSyncTimeout);
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
  cycle();
  request(AlState::kOp);
  cycle();
  expect_status(AlState::kOp);
  for (int i = 0; i < 100; ++i) cycle();
  expect_status(AlState::kOp);
}

TEST_F(SyncSupervisionTest, DevicesWithoutDemandsFollowWhateverIsActivated) {
  prepare({});
  request(AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  expect_request(AlState::kOp, AlState::kOp);
  activate(kCycle);
  for (int i = 0; i < 90; ++i) cycle();
  expect_status(AlState::kOp);
  EXPECT_GT(device().output_count, 80);
}

}  // namespace
}  // namespace driveline::slaves::test
