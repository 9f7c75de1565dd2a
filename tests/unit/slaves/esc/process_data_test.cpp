// A slave over time: steps of its device, outputs in OP only, inputs from SAFEOP on, watchdog.
#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

class ProcessDataTest : public BenchSlave {
 protected:
  /// The device works a quarter of a period after its start for the first time, and then every 125 us.
  static constexpr std::chrono::nanoseconds kFirstStep{31250};

  std::vector<std::byte> read_inputs() { return read(kInputsAddress, 6).data; }
};

TEST_F(ProcessDataTest, InputsAreThereWhenSafeOpIsReported) {
  device().inputs[3] = bytes({1, 2, 3, 4, 5, 6});
  go_to(AlState::kSafeOp);
  EXPECT_EQ(read_inputs(), bytes({1, 2, 3, 4, 5, 6}));
}

TEST_F(ProcessDataTest, InputsFollowInStepsOfTheDevice) {
  go_to(AlState::kSafeOp);
  pass(kFirstStep);
  device().inputs[3] = bytes({7});
  pass(124us);
  EXPECT_EQ(read_inputs()[0], std::byte{0});
  pass(1us);
  EXPECT_EQ(read_inputs()[0], std::byte{7});
}

/// How long a bring-up takes must not decide where in the period a free-running device exchanges process data.
TEST_F(ProcessDataTest, StepsOfTheDeviceCountFromItsStart) {
  for (const auto later : {7us, 41us, 90us}) {
    SCOPED_TRACE(later.count());
    rebuild();
    pass(later);
    ASSERT_NE(now() % 125us, 0us);
    go_to(AlState::kSafeOp);
    device().inputs[3] = bytes({7});
    const auto step = (kFirstStep + 125us - now() % 125us) % 125us;
    pass(step - 1us);
    EXPECT_EQ(read_inputs()[0], std::byte{0});
    pass(1us);
    EXPECT_EQ(read_inputs()[0], std::byte{7});
  }
}

TEST_F(ProcessDataTest, OutputsReachTheDeviceInOpOnly) {
  go_to(AlState::kSafeOp);
  write_outputs(bytes({9, 9, 9, 9}));
  pass(1ms);
  EXPECT_EQ(device().output_count, 0);
  write_outputs(bytes({8, 8, 8, 8}));
  expect_request(AlState::kOp, AlState::kOp);
  pass(125us);
  EXPECT_EQ(device().outputs[2], bytes({8, 8, 8, 8})) << "the newest, handed over at the first step";
  EXPECT_EQ(device().output_count, 1);
  pass(1ms);
  EXPECT_EQ(device().output_count, 1) << "nothing new, nothing handed over";
  request(AlState::kSafeOp);
  write_outputs(bytes({7, 7, 7, 7}));
  pass(1ms);
  EXPECT_EQ(device().output_count, 1);
}

TEST_F(ProcessDataTest, OutputsAreTakenOverBeforeTheStep) {
  go_to(AlState::kOp);
  pass(125us);
  const auto count = device().output_count;
  write_outputs(bytes({5, 6, 7, 8}));
  pass(125us);
  EXPECT_EQ(device().output_count, count + 1);
  EXPECT_EQ(device().outputs_at, device().local_time - 125us) << "the device had not advanced to the step yet";
}

TEST_F(ProcessDataTest, TheDeviceLivesOnWhileNoFramesCome) {
  go_to(AlState::kSafeOp);
  pass(kFirstStep);
  const auto steps = device().advance_count;
  pass(100ms);
  EXPECT_EQ(device().advance_count, steps + 800);
  EXPECT_EQ(device().local_time, now());
  EXPECT_FALSE(device().went_back);
}

TEST_F(ProcessDataTest, TheDeviceLivesInInitToo) {
  pass(10ms);
  EXPECT_EQ(device().local_time, now());
  pass(10ms);
  EXPECT_EQ(device().local_time, now());
}

TEST_F(ProcessDataTest, AVeryLongSilenceIsNotMadeUpForStepByStep) {
  go_to(AlState::kSafeOp);
  const auto steps = device().advance_count;
  pass(std::chrono::hours{24});
  EXPECT_LT(device().advance_count, steps + 10);
  EXPECT_LE(device().local_time, now());
  EXPECT_GT(device().local_time, now() - 1ms);
}

TEST_F(ProcessDataTest, WatchdogTripsOnSilence) {
  go_to(AlState::kOp);
  pass(99ms);
  expect_status(AlState::kOp);
  EXPECT_EQ(get(reg::kWatchdogStatusProcessData), 1);
  pass(1ms);
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  EXPECT_EQ(get(reg::kWatchdogStatusProcessData), 0);
  EXPECT_EQ(get(reg::kWatchdogCounterProcessData), 1);
  EXPECT_EQ(device().fall_backs.back(),
            (TestDevice::FallBack{AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog}));
}

TEST_F(ProcessDataTest, WatchdogTripsAtItsTimeEvenWhenNobodyLooksForLong) {
  go_to(AlState::kOp);
  pass(3s);
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  EXPECT_FALSE(device().went_back);
  EXPECT_EQ(get(reg::kWatchdogCounterProcessData), 1);
}

TEST_F(ProcessDataTest, WatchdogIsKeptAliveByOutputs) {
  go_to(AlState::kOp);
  for (int i = 0; i < 50; ++i) {
    pass(60ms);
    write_outputs(bytes({1, 2, 3, 4}));
  }
  expect_status(AlState::kOp);
}

TEST_F(ProcessDataTest, ReadingInputsDoesNotKeepTheWatchdogAlive) {
  go_to(AlState::kOp);
  for (int i = 0; i < 3; ++i) {
    pass(50ms);
    read_inputs();
  }
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
}

TEST_F(ProcessDataTest, ProperStartUpLeavesTheExpiredWatchdogBehind) {
  go_to(AlState::kOp);
  pass(1s);
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  expect_request(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  expect_acknowledged(AlState::kSafeOp, AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  expect_request(AlState::kOp, AlState::kOp);
  EXPECT_EQ(get(reg::kWatchdogStatusProcessData), 1);
}

TEST_F(ProcessDataTest, ProperStartUpThroughInitToo) {
  go_to(AlState::kOp);
  pass(1s);
  expect_acknowledged(AlState::kInit, AlState::kInit);
  for (unsigned n = 0; n < 4; ++n) write(static_cast<std::uint16_t>(0x0806 + 8 * n), bytes({0}));
  go_to(AlState::kOp);
  expect_status(AlState::kOp);
}

TEST_F(ProcessDataTest, WatchdogTimeFollowsItsRegisters) {
  write(reg::kWatchdogDivider, 0x03E6);       // 998 + 2 ticks of 40 ns: 40 us
  write(reg::kWatchdogTimeProcessData, 100);  // 4 ms
  go_to(AlState::kOp);
  pass(3900us);
  expect_status(AlState::kOp);
  pass(100us);
  expect_status(AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
}

TEST_F(ProcessDataTest, WatchdogCountersClearTogether) {
  go_to(AlState::kOp);
  pass(1s);
  EXPECT_EQ(write(reg::kWatchdogCounterPdi, 0), 1);
  EXPECT_EQ(get(reg::kWatchdogCounterProcessData), 0);
}

TEST_F(ProcessDataTest, SeveralSyncManagersPerDirection) {
  using Use = SyncManagerLayout::Use;
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sync_managers.push_back({Use::kOutputs, 0x1A00, 0, 0, 2});
  own->own_profile.sync_managers.push_back({Use::kInputs, 0x1B00, 0, 0, 1});
  own->sizes = {0, 0, 4, 6, 2, 1};
  own->inputs[5] = bytes({0x77});
  rebuild({}, std::move(own));
  go_to(AlState::kPreOp);
  configure_process_data();
  set_sync_manager(4, {0x1A00, 2, 0x24, 0, 1, 0});
  set_sync_manager(5, {0x1B00, 1, 0x20, 0, 1, 0});
  expect_request(AlState::kSafeOp, AlState::kSafeOp);
  EXPECT_EQ(read(0x1B00, 1).data, bytes({0x77}));
  write_outputs(bytes({1, 2, 3, 4}));
  expect_request(AlState::kOp, AlState::kSafeOp);  // the second output sync manager has had nothing yet
  write(0x1A00, bytes({8, 9}));
  pass(125us);
  expect_status(AlState::kOp);
  pass(125us);
  EXPECT_EQ(device().outputs[2], bytes({1, 2, 3, 4}));
  EXPECT_EQ(device().outputs[4], bytes({8, 9}));
}

TEST_F(ProcessDataTest, PowerCycleStartsOver) {
  write(reg::kStationAddress, kStation);
  go_to(AlState::kOp);
  slave().set_power(false, now());
  pass(1s);
  slave().set_power(true, now());
  pass(1ms);
  expect_status(AlState::kInit);
  EXPECT_EQ(get(reg::kStationAddress), 0);
  EXPECT_EQ(read(0x0800, 8).data[0], std::byte{0});
  EXPECT_GE(device().restarts, 1);
  EXPECT_TRUE(device().fall_backs.empty()) << "losing the supply is not a fault of communication";
  go_to(AlState::kOp);
  expect_status(AlState::kOp);
}

}  // namespace
}  // namespace driveline::slaves::test
