// The EtherCAT state machine: each transition, each refusal with its AL status code, acknowledge rules (ETG.1000.6
// chapter 6, Table 11).
#include <functional>

#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

class AlStateMachineTest : public BenchSlave {
 protected:
  /// Rebuilds the slave with bootstrap mailboxes.
  void with_bootstrap() {
    using Use = SyncManagerLayout::Use;
    auto own = std::make_unique<TestDevice>();
    own->own_profile.bootstrap_mailboxes = {{Use::kMailboxOut, kBootOutAddress, 0x100, 0x200, 0x100},
                                            {Use::kMailboxIn, kBootInAddress, 0x100, 0x200, 0x100}};
    rebuild({}, std::move(own));
  }
  void configure_boot_mailboxes() {
    set_sync_manager(0, {kBootOutAddress, 0x100, 0x26, 0, 1, 0});
    set_sync_manager(1, {kBootInAddress, 0x100, 0x22, 0, 1, 0});
  }
  void expect_refused(AlState target, AlStatusCode expected) {
    const auto before = status().state;
    request(target);
    EXPECT_EQ(to_text(status().state), to_text(before));
    EXPECT_TRUE(status().error);
    EXPECT_EQ(code(), expected);
  }
};

TEST_F(AlStateMachineTest, StartsInInitWithoutError) {
  expect_status(AlState::kInit);
  EXPECT_EQ(get(reg::kAlStatus), 0x0001);
}

TEST_F(AlStateMachineTest, UpStepByStepAndDownInOneLeap) {
  go_to(AlState::kOp);
  expect_request(AlState::kInit, AlState::kInit);
  using T = std::pair<AlState, AlState>;
  EXPECT_EQ(device().transitions, (std::vector<T>{{AlState::kInit, AlState::kPreOp},
                                                  {AlState::kPreOp, AlState::kSafeOp},
                                                  {AlState::kSafeOp, AlState::kOp},
                                                  {AlState::kOp, AlState::kInit}}));
}

TEST_F(AlStateMachineTest, EveryTransitionOfTheStandard) {
  struct Row {
    AlState from, to;
    AlStatusCode code;
  };
  using enum AlState;
  constexpr auto kOk = AlStatusCode::kNoError;
  constexpr auto kIllegal = AlStatusCode::kInvalidRequestedStateChange;
  for (const auto& row : {
           Row{kInit, kInit, kOk},
           Row{kInit, kPreOp, kOk},
           Row{kInit, kSafeOp, kIllegal},
           Row{kInit, kOp, kIllegal},
           Row{kPreOp, kInit, kOk},
           Row{kPreOp, kPreOp, kOk},
           Row{kPreOp, kSafeOp, kOk},
           Row{kPreOp, kOp, kIllegal},
           Row{kPreOp, kBootstrap, kIllegal},
           Row{kSafeOp, kInit, kOk},
           Row{kSafeOp, kPreOp, kOk},
           Row{kSafeOp, kSafeOp, kOk},
           Row{kSafeOp, kOp, kOk},
           Row{kSafeOp, kBootstrap, kIllegal},
           Row{kOp, kInit, kOk},
           Row{kOp, kPreOp, kOk},
           Row{kOp, kSafeOp, kOk},
           Row{kOp, kOp, kOk},
           Row{kOp, kBootstrap, kIllegal},
       }) {
    rebuild();
    go_to(row.from);
    if (row.from == kInit) configure_mailboxes();
    if (row.from == kPreOp) configure_process_data();
    if (row.from == kSafeOp) write_outputs(bytes({1, 2, 3, 4}));
    request(row.to);
    SCOPED_TRACE(std::string(to_text(row.from)) + " -> " + std::string(to_text(row.to)));
    // An illegal request takes a slave out of OP (conformance test TF-1200 #42); elsewhere the state stays.
    const auto refused = row.from == kOp ? kSafeOp : row.from;
    expect_status(row.code == kOk ? row.to : refused, row.code);
  }
}

TEST_F(AlStateMachineTest, BootstrapOnlyFromInitAndOnlyBackToInit) {
  with_bootstrap();
  configure_boot_mailboxes();
  expect_request(AlState::kBootstrap, AlState::kBootstrap);
  for (const auto target : {AlState::kPreOp, AlState::kSafeOp, AlState::kOp}) {
    expect_acknowledged(target, AlState::kBootstrap, AlStatusCode::kInvalidRequestedStateChange);
  }
  expect_acknowledged(AlState::kInit, AlState::kInit);
}

TEST_F(AlStateMachineTest, BootstrapNotSupported) {
  expect_refused(AlState::kBootstrap, AlStatusCode::kBootstrapNotSupported);
}

TEST_F(AlStateMachineTest, BootstrapMailboxesAreCheckedWithTheirOwnCode) {
  with_bootstrap();
  configure_mailboxes();  // those of PREOP
  expect_refused(AlState::kBootstrap, AlStatusCode::kInvalidMailboxConfigurationBoot);
}

TEST_F(AlStateMachineTest, UnknownStateCodes) {
  for (const unsigned raw : {0U, 5U, 6U, 7U, 9U, 15U}) {
    rebuild();
    expect_refused(static_cast<AlState>(raw), AlStatusCode::kUnknownRequestedState);
  }
}

TEST_F(AlStateMachineTest, UnknownStateCodesInEveryState) {
  for (const auto from : {AlState::kInit, AlState::kPreOp, AlState::kSafeOp, AlState::kOp}) {
    for (const unsigned raw : {0U, 5U, 6U, 7U, 9U, 15U}) {
      SCOPED_TRACE(testing::Message() << to_text(from) << " -> " << raw);
      rebuild();
      go_to(from);
      request(static_cast<AlState>(raw));
      // OP is left (conformance test TF-1200 #43).
      expect_status(from == AlState::kOp ? AlState::kSafeOp : from, AlStatusCode::kUnknownRequestedState);
    }
  }
}

class LeavingOp : public AlStateMachineTest {
 protected:
  struct Row {
    AlStatusCode code;
    std::function<void()> cause;
  };
  [[nodiscard]] unsigned outputs_written() { return write(kOutputsAddress, bytes({5, 6, 7, 8})); }
  [[nodiscard]] unsigned inputs_read() { return read(kInputsAddress, 6).working_counter; }
  std::vector<Row> rows() {
    return {{AlStatusCode::kInvalidRequestedStateChange, [this] { request(AlState::kBootstrap); }},
            {AlStatusCode::kUnknownRequestedState, [this] { request(static_cast<AlState>(7)); }},
            {AlStatusCode::kSyncManagerWatchdog, [this] { pass(1s); }},
            {AlStatusCode::kBackgroundWatchdog,
             [this] {
               write(reg::kWatchdogTimeProcessData, 0);
               slave().stall(now(), 150ms);
               pass(200ms);
               write(reg::kWatchdogTimeProcessData, 1000);
             }},
            {AlStatusCode::kUnspecifiedError,
             [this] { slave().al().fall_back(AlState::kSafeOp, AlStatusCode::kUnspecifiedError); }}};
  }
};

TEST_F(LeavingOp, ByAnErrorShowsInTheWorkingCounterUntilItIsAcknowledged) {
  for (const auto& row : rows()) {
    SCOPED_TRACE(testing::Message() << std::hex << static_cast<unsigned>(row.code));
    rebuild();
    go_to(AlState::kOp);
    ASSERT_EQ(outputs_written(), 1U);
    row.cause();
    expect_status(AlState::kSafeOp, row.code);
    EXPECT_EQ(device().fall_backs.back(), (TestDevice::FallBack{AlState::kOp, AlState::kSafeOp, row.code}));
    EXPECT_EQ(outputs_written(), 0U);
    EXPECT_EQ(inputs_read(), 1U);
    request(AlState::kSafeOp);
    EXPECT_EQ(outputs_written(), 0U) << "without acknowledge";
    request(AlState::kBootstrap, true);
    EXPECT_EQ(outputs_written(), 0U) << "a request that is an error again";
    expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
    EXPECT_EQ(outputs_written(), 1U);
    expect_request(AlState::kOp, AlState::kOp);
  }
}

TEST_F(LeavingOp, AcknowledgedByTheRequestForOpNeedsNewOutputs) {
  go_to(AlState::kOp);
  request(AlState::kBootstrap);
  expect_acknowledged(AlState::kOp, AlState::kSafeOp);
  pass(10ms);
  expect_status(AlState::kSafeOp);
  EXPECT_EQ(outputs_written(), 1U);
  pass(125us);
  expect_status(AlState::kOp);
}

TEST_F(LeavingOp, OnRequestLeavesTheOutputsOn) {
  go_to(AlState::kOp);
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
  EXPECT_EQ(outputs_written(), 1U);
}

TEST_F(LeavingOp, ForALowerStateAndBackLeavesNothingLocked) {
  go_to(AlState::kOp);
  pass(1s);
  request(AlState::kPreOp, true);
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
  EXPECT_EQ(outputs_written(), 1U);
}

TEST_F(LeavingOp, WithoutOutputsLocksTheInputsWhereTheErrorMakesThemInvalid) {
  struct Case {
    AlStatusCode code;
    unsigned inputs;
  };
  for (const auto& row : {Case{AlStatusCode::kFatalSyncError, 0}, Case{AlStatusCode::kPllError, 0},
                          Case{AlStatusCode::kUnknownRequestedState, 1}}) {
    SCOPED_TRACE(testing::Message() << std::hex << static_cast<unsigned>(row.code));
    auto own = std::make_unique<TestDevice>();
    own->sizes = {0, 0, 0, 6};
    rebuild({}, std::move(own));
    go_to(AlState::kPreOp);
    set_sync_manager(3, inputs());
    request(AlState::kSafeOp);
    expect_request(AlState::kOp, AlState::kOp);
    slave().al().fall_back(AlState::kSafeOp, row.code);
    expect_status(AlState::kSafeOp, row.code);
    EXPECT_EQ(inputs_read(), row.inputs);
    request(AlState::kSafeOp, true);
    EXPECT_EQ(inputs_read(), 1U);
  }
}

TEST_F(AlStateMachineTest, MailboxSettingsAreChecked) {
  const auto refused_with = [this](unsigned n, wire::SyncManagerChannel channel) {
    rebuild();
    configure_mailboxes();
    write(static_cast<std::uint16_t>(0x0806 + 8 * n), bytes({0}));
    set_sync_manager(n, channel);
    expect_refused(AlState::kPreOp, AlStatusCode::kInvalidMailboxConfigurationPreOp);
  };
  auto channel = mailbox_out();
  channel.activate = 0;
  refused_with(0, channel);
  channel = mailbox_out();
  channel.length = 0x1F;
  refused_with(0, channel);
  channel.length = 0x81;
  refused_with(0, channel);
  channel = mailbox_out();
  channel.start_address += 2;
  refused_with(0, channel);
  channel = mailbox_out();
  channel.control = 0x22;
  refused_with(0, channel);
  channel = mailbox_in();
  channel.control = 0x20;
  refused_with(1, channel);
  rebuild();
  expect_refused(AlState::kPreOp, AlStatusCode::kInvalidMailboxConfigurationPreOp);
}

TEST_F(AlStateMachineTest, MailboxLengthsOfTheWholeRangeAreAccepted) {
  for (const unsigned length : {0x20U, 0x80U}) {
    rebuild();
    auto out = mailbox_out();
    out.length = static_cast<std::uint16_t>(length);
    set_sync_manager(0, out);
    set_sync_manager(1, mailbox_in());
    expect_request(AlState::kPreOp, AlState::kPreOp);
  }
}

TEST_F(AlStateMachineTest, OutputAndInputSettingsAreChecked) {
  const auto refused_with = [this](unsigned n, wire::SyncManagerChannel channel, AlStatusCode expected) {
    rebuild();
    go_to(AlState::kPreOp);
    if (n != 2) set_sync_manager(2, outputs());
    if (n != 3) set_sync_manager(3, inputs());
    set_sync_manager(n, channel);
    expect_refused(AlState::kSafeOp, expected);
  };
  constexpr auto kOutput = AlStatusCode::kInvalidOutputConfiguration;
  constexpr auto kInput = AlStatusCode::kInvalidInputConfiguration;
  refused_with(2, outputs(3), kOutput);
  refused_with(2, outputs(5), kOutput);
  refused_with(3, inputs(5), kInput);
  refused_with(3, inputs(7), kInput);
  auto channel = outputs();
  channel.activate = 0;
  refused_with(2, channel, kOutput);
  channel = outputs();
  channel.control = 0x20;
  refused_with(2, channel, kOutput);
  channel = outputs();
  channel.start_address += 4;
  refused_with(2, channel, kOutput);
  channel = inputs();
  channel.control = 0x24;
  refused_with(3, channel, kInput);
  channel = inputs();
  channel.activate = 0;
  refused_with(3, channel, kInput);
  channel = inputs();
  channel.control = 0x22;
  refused_with(3, channel, AlStatusCode::kFreeRunNeedsThreeBufferMode);
  refused_with(4, {0x1900, 4, 0x24, 0, 1, 0}, AlStatusCode::kInvalidSyncManagerConfiguration);
}

TEST_F(AlStateMachineTest, OverlappingSyncManagersAreRefused) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sync_managers[3].start_address = kOutputsAddress + 8;  // inside the third output buffer
  rebuild({}, std::move(own));
  go_to(AlState::kPreOp);
  set_sync_manager(2, outputs());
  set_sync_manager(3, {kOutputsAddress + 8, 6, 0x20, 0, 1, 0});
  expect_refused(AlState::kSafeOp, AlStatusCode::kInvalidSyncManagerConfiguration);
}

TEST_F(AlStateMachineTest, InputOnlyAndOutputOnlyDevices) {
  for (const bool has_outputs : {true, false}) {
    auto own = std::make_unique<TestDevice>();
    own->sizes = has_outputs ? std::array<std::size_t, 8>{0, 0, 4, 0} : std::array<std::size_t, 8>{0, 0, 0, 6};
    rebuild({}, std::move(own));
    go_to(AlState::kPreOp);
    set_sync_manager(has_outputs ? 2 : 3, has_outputs ? outputs() : inputs());
    expect_request(AlState::kSafeOp, AlState::kSafeOp);
    if (has_outputs) write_outputs(bytes({1, 2, 3, 4}));
    expect_request(AlState::kOp, AlState::kOp);
    // Without process data a sync manager must stay off.
    rebuild({}, [has_outputs] {
      auto other = std::make_unique<TestDevice>();
      other->sizes = has_outputs ? std::array<std::size_t, 8>{0, 0, 4, 0} : std::array<std::size_t, 8>{0, 0, 0, 6};
      return other;
    }());
    go_to(AlState::kPreOp);
    configure_process_data();
    expect_refused(AlState::kSafeOp,
                   has_outputs ? AlStatusCode::kInvalidInputConfiguration : AlStatusCode::kInvalidOutputConfiguration);
  }
}

TEST_F(AlStateMachineTest, WatchdogThatCannotDoItsDuty) {
  go_to(AlState::kPreOp);
  configure_process_data();
  write(reg::kWatchdogTimeProcessData, 0);
  expect_refused(AlState::kSafeOp, AlStatusCode::kInvalidWatchdogConfiguration);
  write(reg::kWatchdogTimeProcessData, 1);  // 100 us, but the device works every 125 us
  expect_acknowledged(AlState::kSafeOp, AlState::kPreOp, AlStatusCode::kInvalidWatchdogConfiguration);
  write(reg::kWatchdogTimeProcessData, 2);
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(AlStateMachineTest, WatchdogMayBeOffWhenTheSyncManagerDoesNotTriggerIt) {
  go_to(AlState::kPreOp);
  auto channel = outputs();
  channel.control = 0x24;
  set_sync_manager(2, channel);
  set_sync_manager(3, inputs());
  write(reg::kWatchdogTimeProcessData, 0);
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  expect_request(AlState::kOp, AlState::kOp);
  pass(10s);
  expect_status(AlState::kOp);
}

TEST_F(AlStateMachineTest, ApplicationRefusesWithItsOwnCode) {
  go_to(AlState::kPreOp);
  configure_process_data();
  device().refusal = AlStatusCode::kInvalidOutputMapping;
  expect_refused(AlState::kSafeOp, AlStatusCode::kInvalidOutputMapping);
  device().refusal = AlStatusCode::kNoError;
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(AlStateMachineTest, IncompleteFirmwareDoesNotLeaveInit) {
  with_bootstrap();
  device().firmware_complete = false;  // as left by an interrupted download in BOOT
  configure_mailboxes();
  expect_refused(AlState::kPreOp, AlStatusCode::kNoValidFirmware);
  for (const unsigned n : {0U, 1U}) write(static_cast<std::uint16_t>(0x0806 + 8 * n), bytes({0}));
  configure_boot_mailboxes();
  expect_acknowledged(AlState::kBootstrap, AlState::kBootstrap);
}

TEST_F(AlStateMachineTest, MappingIsCheckedBeforeTheSyncManagers) {
  for (const auto wrong : {AlStatusCode::kInvalidInputMapping, AlStatusCode::kInvalidOutputMapping}) {
    rebuild();
    go_to(AlState::kPreOp);
    device().mapping = wrong;  // the sync managers are not set up, either
    expect_refused(AlState::kSafeOp, wrong);
    device().mapping = AlStatusCode::kNoError;
    configure_process_data();
    expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
  }
}

TEST_F(AlStateMachineTest, InputsWithoutASensorAreNotValid) {
  go_to(AlState::kPreOp);
  configure_process_data();
  device().sensor_present = false;
  expect_refused(AlState::kSafeOp, AlStatusCode::kNoValidInputs);
  device().sensor_present = true;
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(AlStateMachineTest, AnApplicationThatHungReportsItsBackgroundWatchdog) {
  go_to(AlState::kOp);
  write(reg::kWatchdogTimeProcessData, 0);
  slave().stall(now(), 200ms);
  pass(150ms);
  expect_status(AlState::kOp);
  EXPECT_EQ(write(reg::kAlControl, 0x0001), 1);
  EXPECT_EQ(write(reg::kAlControl, 0x0001), 0) << "nobody takes the request";
  const int steps = device().advance_count;
  pass(49ms);
  EXPECT_EQ(device().advance_count, steps);
  expect_status(AlState::kOp);
  pass(1ms);
  EXPECT_EQ(device().fall_backs.back(),
            (TestDevice::FallBack{AlState::kOp, AlState::kSafeOp, AlStatusCode::kBackgroundWatchdog}));
  expect_status(AlState::kInit);  // the waiting request
  pass(1ms);
  EXPECT_GT(device().advance_count, steps);
}

TEST_F(AlStateMachineTest, BackgroundWatchdogOfTheApplicationIsShown) {
  go_to(AlState::kOp);
  write(reg::kWatchdogTimeProcessData, 0);
  slave().stall(now(), 101ms);
  pass(101ms);
  expect_status(AlState::kSafeOp, AlStatusCode::kBackgroundWatchdog);
}

TEST_F(AlStateMachineTest, AShortStandstillIsNotNoticed) {
  go_to(AlState::kOp);
  slave().stall(now(), 50ms);
  pass(60ms);
  expect_status(AlState::kOp);
}

TEST_F(AlStateMachineTest, RefusalChosenFromOutside) {
  configure_mailboxes();
  slave().al().refuse(AlState::kPreOp, AlStatusCode::kNoValidFirmware);
  expect_refused(AlState::kPreOp, AlStatusCode::kNoValidFirmware);
  slave().al().refuse(AlState::kSafeOp, AlStatusCode::kNoValidInputs);
  expect_acknowledged(AlState::kPreOp, AlState::kPreOp);
  configure_process_data();
  expect_refused(AlState::kSafeOp, AlStatusCode::kNoValidInputs);
  slave().al().clear_refusal();
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(AlStateMachineTest, ErrorBlocksRequestsUntilAcknowledged) {
  go_to(AlState::kPreOp);
  expect_refused(AlState::kOp, AlStatusCode::kInvalidRequestedStateChange);
  configure_process_data();
  expect_request(AlState::kSafeOp, AlState::kPreOp, AlStatusCode::kInvalidRequestedStateChange);
  expect_request(AlState::kPreOp, AlState::kPreOp, AlStatusCode::kInvalidRequestedStateChange);
  expect_acknowledged(AlState::kPreOp, AlState::kPreOp);
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(AlStateMachineTest, AcknowledgeAndNewStateInOneRequest) {
  go_to(AlState::kPreOp);
  expect_refused(AlState::kOp, AlStatusCode::kInvalidRequestedStateChange);
  configure_process_data();
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
}

TEST_F(AlStateMachineTest, InitIsAcceptedWithoutAcknowledge) {
  go_to(AlState::kPreOp);
  expect_refused(AlState::kOp, AlStatusCode::kInvalidRequestedStateChange);
  expect_request(AlState::kInit, AlState::kInit);
}

TEST_F(AlStateMachineTest, AcknowledgeWithoutErrorDoesNoHarm) {
  configure_mailboxes();
  expect_acknowledged(AlState::kInit, AlState::kInit);
  expect_acknowledged(AlState::kPreOp, AlState::kPreOp);
}

TEST_F(AlStateMachineTest, ANewErrorReplacesTheAcknowledgedOne) {
  go_to(AlState::kPreOp);
  expect_refused(AlState::kOp, AlStatusCode::kInvalidRequestedStateChange);
  expect_acknowledged(AlState::kSafeOp, AlState::kPreOp, AlStatusCode::kInvalidOutputConfiguration);
}

TEST_F(AlStateMachineTest, DelayedTransitionHappensWhileNobodyAsks) {
  SlaveOptions options;
  options.al.transition_delay = 30ms;
  rebuild(options);
  configure_mailboxes();
  expect_request(AlState::kPreOp, AlState::kInit);
  pass(29ms);
  expect_status(AlState::kInit);
  EXPECT_TRUE(device().transitions.empty());
  pass(1ms);
  expect_status(AlState::kPreOp);
}

TEST_F(AlStateMachineTest, DelayedTransitionHappensAtItsTimeInALongSilence) {
  SlaveOptions options;
  options.al.transition_delay = 30ms;
  rebuild(options);
  configure_mailboxes();
  request(AlState::kPreOp);
  pass(30ms);
  configure_process_data();
  request(AlState::kSafeOp);
  const auto steps = device().advance_count;
  pass(1s);
  expect_status(AlState::kSafeOp);
  EXPECT_GE(device().advance_count, steps + 970 * 8) << "steps of 125 us from the transition on";
  EXPECT_FALSE(device().went_back);
}

TEST_F(AlStateMachineTest, ANewRequestReplacesADelayedOne) {
  SlaveOptions options;
  options.al.transition_delay = 30ms;
  rebuild(options);
  configure_mailboxes();
  request(AlState::kPreOp);
  pass(10ms);
  request(AlState::kInit);
  pass(1s);
  expect_status(AlState::kInit);
}

TEST_F(AlStateMachineTest, OpWaitsForOutputs) {
  go_to(AlState::kSafeOp);
  expect_request(AlState::kOp, AlState::kSafeOp);
  pass(500ms);
  expect_status(AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  pass(125us);
  expect_status(AlState::kOp);
}

TEST_F(AlStateMachineTest, OpWithoutOutputsTimesOut) {
  go_to(AlState::kSafeOp);
  request(AlState::kOp);
  pass(999ms);
  expect_status(AlState::kSafeOp);
  pass(1ms);
  expect_status(AlState::kSafeOp, AlStatusCode::kNoValidOutputs);
}

TEST_F(AlStateMachineTest, OpWithOutputsThatHaveStoppedTimesOutWithTheWatchdogCode) {
  go_to(AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  pass(200ms);  // the watchdog has expired meanwhile
  expect_status(AlState::kSafeOp);
  expect_request(AlState::kOp, AlState::kSafeOp);
  pass(1s);
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
}

TEST_F(AlStateMachineTest, SwitchingOffAMailboxFallsBackToInit) {
  go_to(AlState::kOp);
  write(0x080E, bytes({0}));
  slave().advance(now());
  expect_status(AlState::kInit, AlStatusCode::kInvalidMailboxConfigurationPreOp);
  EXPECT_EQ(device().fall_backs.back(),
            (TestDevice::FallBack{AlState::kOp, AlState::kInit, AlStatusCode::kInvalidMailboxConfigurationPreOp}));
}

TEST_F(AlStateMachineTest, SwitchingOffProcessDataFallsBackToPreOp) {
  go_to(AlState::kOp);
  write(0x081E, bytes({0}));
  slave().advance(now());
  expect_status(AlState::kPreOp, AlStatusCode::kInvalidInputConfiguration);
  EXPECT_EQ(device().fall_backs.back(),
            (TestDevice::FallBack{AlState::kOp, AlState::kPreOp, AlStatusCode::kInvalidInputConfiguration}));
}

TEST_F(AlStateMachineTest, TogglingTheRepeatBitIsNoReasonToFallBack) {
  go_to(AlState::kOp);
  write(0x080E, bytes({3}));
  slave().advance(now());
  expect_status(AlState::kOp);
}

TEST_F(AlStateMachineTest, SyncManagersAreLockedOutsideTheirStates) {
  configure_mailboxes();
  configure_process_data();
  EXPECT_EQ(write(kMailboxOutAddress, std::vector<std::byte>(kMailboxLength)), 0) << "no mailbox in INIT";
  request(AlState::kPreOp);
  EXPECT_EQ(write(kMailboxOutAddress, std::vector<std::byte>(kMailboxLength)), 1);
  EXPECT_EQ(write(kOutputsAddress, bytes({1, 2, 3, 4})), 0);
  EXPECT_EQ(read(kInputsAddress, 6).working_counter, 0);
  request(AlState::kSafeOp);
  EXPECT_EQ(write(kOutputsAddress, bytes({1, 2, 3, 4})), 1);
  EXPECT_EQ(read(kInputsAddress, 6).working_counter, 1);
  request(AlState::kPreOp);
  EXPECT_EQ(write(kOutputsAddress, bytes({1, 2, 3, 4})), 0);
  request(AlState::kInit);
  EXPECT_EQ(write(kMailboxOutAddress, std::vector<std::byte>(kMailboxLength)), 0);
}

TEST_F(AlStateMachineTest, DeviceIdentificationOnRequest) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.device_id = 0x1234;
  rebuild({}, std::move(own));
  configure_mailboxes();
  request(AlState::kPreOp, false, true);
  EXPECT_EQ(get(reg::kAlStatus), 0x0022);
  EXPECT_EQ(get(reg::kAlStatusCode), 0x1234);
  request(AlState::kPreOp);
  EXPECT_EQ(get(reg::kAlStatus), 0x0002);
  EXPECT_EQ(get(reg::kAlStatusCode), 0);
  // On an error the status code register contains the error, not the identification.
  request(AlState::kOp, false, true);
  EXPECT_EQ(get(reg::kAlStatus), 0x0012);
  EXPECT_EQ(get(reg::kAlStatusCode), 0x0011);
}

TEST_F(AlStateMachineTest, DeviceIdentificationWithoutAnIdIsZero) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.identification = true;
  rebuild({}, std::move(own));
  request(AlState::kInit, false, true);
  EXPECT_EQ(get(reg::kAlStatus), 0x0021);
  EXPECT_EQ(get(reg::kAlStatusCode), 0);
}

TEST_F(AlStateMachineTest, DeviceIdentificationIsNotShownInBoot) {
  with_bootstrap();
  SlaveOptions options;
  options.al.device_id = 0x0307;
  auto own = std::make_unique<TestDevice>();
  own->own_profile.bootstrap_mailboxes = device().own_profile.bootstrap_mailboxes;
  rebuild(options, std::move(own));
  configure_boot_mailboxes();
  request(AlState::kInit, false, true);
  EXPECT_EQ(get(reg::kAlStatusCode), 0x0307);
  request(AlState::kBootstrap, false, true);
  EXPECT_EQ(get(reg::kAlStatus), 0x0003);
  EXPECT_EQ(get(reg::kAlStatusCode), 0);
}

TEST_F(AlStateMachineTest, DeviceIdentificationNotSupported) {
  request(AlState::kInit, false, true);
  EXPECT_EQ(get(reg::kAlStatus), 0x0001);
}

TEST_F(AlStateMachineTest, DeviceEmulationCopiesAlControl) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sii_image = test_image(0x0104);  // digital I/O, device emulation
  rebuild({}, std::move(own));
  request(AlState::kSafeOp);
  EXPECT_EQ(get(reg::kAlStatus), 0x0004) << "no checks: there is no application";
  request(AlState::kPreOp, true);
  EXPECT_EQ(get(reg::kAlStatus), 0x0012) << "as the controller does, acknowledge bit included";
  EXPECT_TRUE(device().transitions.empty());
}

}  // namespace
}  // namespace driveline::slaves::test
