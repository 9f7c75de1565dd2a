// The drive and SYNC0: its requirements, its reaction to missing SYNC0, and its control steps, which follow SYNC0 (MSD
// manual 9.1).
#include <gmock/gmock.h>

#include <functional>

#include "drive_rig.hpp"
#include "driveline/slaves/esc/slave.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/ethercat_values.hpp"
#include "driveline/wire/registers.hpp"

namespace driveline::slaves::msd {
namespace {

namespace reg = wire::reg;

/// The drive behind its slave controller, with control word and status word as process data.
class MsdSynchronisation : public ::testing::Test {
 protected:
  MsdSynchronisation() : slave_(std::make_unique<MsdDrive>()) { pass(2ms); }

  MsdDrive& device() { return static_cast<MsdDrive&>(slave_.device()); }
  DriveCore& drive() { return device().core(); }
  void pass(std::chrono::nanoseconds time) {
    now_ += time;
    slave_.advance(now_);
  }
  template <typename T>
  void write(const wire::Register<T>& r, std::type_identity_t<T> value) {
    const auto raw = bytes::to_le_bytes(value);
    slave_.esc().begin_frame(++serial_);
    EXPECT_TRUE(slave_.esc().ecat_write(r.address, raw, now_)) << r.name;
  }
  void set_sync_manager(unsigned n, std::uint16_t start, std::size_t length, std::uint8_t control) {
    std::array<std::byte, wire::SyncManagerChannel::kSize> raw{};
    wire::SyncManagerChannel{start, static_cast<std::uint16_t>(length), control, 0, 1, 0}.encode(raw);
    slave_.esc().begin_frame(++serial_);
    EXPECT_TRUE(slave_.esc().ecat_write(0x0800 + 8 * n, raw, now_));
  }
  AlStatusCode request(AlState state) {
    write(reg::kAlControl, wire::AlControl{state, true, false}.raw());
    slave_.advance(now_);
    return static_cast<AlStatusCode>(slave_.esc().memory().get(reg::kAlStatusCode));
  }
  /// Expedited download, passed to the drive as its mailbox message.
  void download(unsigned index, unsigned sub, std::uint32_t value, unsigned size) {
    std::vector<std::byte> mail(kMailboxSize);
    counter_ = counter_ % 7 + 1;
    const std::vector<unsigned> raw = {10,
                                       0,
                                       0,
                                       0,
                                       0,
                                       0x03U | counter_ << 4,
                                       0,
                                       0x20,
                                       0x23 | (4 - size) << 2,
                                       index & 0xFF,
                                       index >> 8,
                                       sub,
                                       value & 0xFF,
                                       value >> 8 & 0xFF,
                                       value >> 16 & 0xFF,
                                       value >> 24};
    for (std::size_t i = 0; i < raw.size(); ++i) mail[i] = static_cast<std::byte>(raw[i]);
    device().mailbox_request(mail);
    std::vector<std::byte> reply(kMailboxSize);
    ASSERT_GT(device().mailbox_reply(reply), 8U);
    ASSERT_EQ(reply[8], std::byte{0x60}) << std::hex << index;
  }
  void to_pre_op() {
    set_sync_manager(0, kMailboxOutStart, kMailboxSize, 0x26);
    set_sync_manager(1, kMailboxInStart, kMailboxSize, 0x22);
    ASSERT_EQ(request(AlState::kPreOp), AlStatusCode::kNoError);
    for (const auto& [pdo, entry] : {std::pair{0x1600U, 0x60400010U}, std::pair{0x1A00U, 0x60410010U}}) {
      download(pdo, 0, 0, 1);
      download(pdo, 1, entry, 4);
      download(pdo, 0, 1, 1);
    }
    set_sync_manager(2, kOutputsStart, device().process_data_size(2), 0x64);
    set_sync_manager(3, kInputsStart, device().process_data_size(3), 0x20);
  }
  void activate(std::uint32_t cycle) {
    write(reg::kDcActivation, 0);
    write(reg::kStartTimeCyclic, static_cast<std::uint64_t>((now_ + 1ms).count()));
    write(reg::kSync0CycleTime, cycle);
    write(reg::kDcActivation, 3);
  }
  void cycle(bool with_outputs = true) {
    const std::vector<std::byte> zeros(device().process_data_size(2));
    slave_.esc().begin_frame(++serial_);
    // A drive that has left OP by an error refuses outputs.
    if (with_outputs) static_cast<void>(slave_.esc().ecat_write(kOutputsStart, zeros, now_));
    pass(1ms);
  }
  void to_op() {
    to_pre_op();
    activate(1'000'000);
    ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
    pass(500us);
    ASSERT_EQ(request(AlState::kOp), AlStatusCode::kNoError);
    for (int i = 0; i < 12; ++i) cycle();
    ASSERT_EQ(slave_.state(), AlState::kOp);
  }
  /// Fetches the waiting mailbox messages, like a master.
  std::vector<std::array<unsigned, 4>> emergencies() {
    std::vector<std::array<unsigned, 4>> found;
    std::vector<std::byte> mail(kMailboxSize);
    for (;;) {
      slave_.esc().begin_frame(++serial_);
      if (!slave_.esc().ecat_read(kMailboxInStart, mail, now_)) return found;
      slave_.advance(now_);
      const auto byte = [&](std::size_t at) { return std::to_integer<unsigned>(mail[at]); };
      if (byte(7) >> 4 == 1) found.push_back({byte(8) | byte(9) << 8, byte(10), byte(11), byte(12)});
    }
  }
  AlStatusCode code() const { return static_cast<AlStatusCode>(slave_.esc().memory().get(reg::kAlStatusCode)); }

  Slave slave_;
  std::chrono::nanoseconds now_ = 1s;
  std::uint64_t serial_ = 0;
  unsigned counter_ = 0;
};

TEST_F(MsdSynchronisation, TheCycleMustBeAMultipleOf125Microseconds) {
  to_pre_op();
  activate(200'000);
  EXPECT_EQ(request(AlState::kSafeOp), AlStatusCode::kDcSync0CycleTime);
  activate(250'000);
  EXPECT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
}

TEST_F(MsdSynchronisation, FreeRunNeedsNoSync0) {
  to_pre_op();
  ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
  cycle();
  ASSERT_EQ(request(AlState::kOp), AlStatusCode::kNoError);
  for (int i = 0; i < 50; ++i) cycle();
  EXPECT_EQ(slave_.state(), AlState::kOp);
}

TEST_F(MsdSynchronisation, Sync0ThatStopsIsALocalError) {
  to_op();
  write(reg::kDcActivation, 0);
  for (int i = 0; i < 4; ++i) cycle();
  EXPECT_EQ(slave_.state(), AlState::kSafeOp);
  EXPECT_EQ(code(), AlStatusCode::kFatalSyncError);
  EXPECT_EQ(drive().fault(), Fault::kLocalError);
}

TEST_F(MsdSynchronisation, OutputsThatComeNoMoreAreNoticedBeforeTheWatchdog) {
  to_op();
  for (int i = 0; i < 10; ++i) cycle(false);
  EXPECT_EQ(slave_.state(), AlState::kOp);
  cycle(false);
  EXPECT_EQ(slave_.state(), AlState::kSafeOp);
  EXPECT_EQ(code(), AlStatusCode::kDcSyncTimeout);
  EXPECT_EQ(drive().fault(), Fault::kLocalError);
}

/// Emergencies sent by the slave: error code, error register, fault number and location.
using Emergencies = std::vector<std::array<unsigned, 4>>;

/// Er 14 06 in manufacturer-specific form (MSD manual 13.3, FF00h).
const Emergencies kLocalErrorReported{{0xFF00, 0x11, 14, 6}};

TEST_F(MsdSynchronisation, EveryLossInOpHasItsCodeAndItsEmergency) {
  struct Row {
    AlStatusCode code;
    std::function<void()> cause;
  };
  const std::array rows{
      Row{AlStatusCode::kFatalSyncError,
          [this] {
            write(reg::kDcActivation, 0);
            for (int i = 0; i < 4; ++i) cycle();
          }},
      Row{AlStatusCode::kPllError,
          [this] {
            write(reg::kSystemTimeOffset, static_cast<std::uint64_t>(-100'000));
            for (int i = 0; i < 2; ++i) cycle();
          }},
      Row{AlStatusCode::kDcSyncIoError,
          [this] {
            for (int i = 0; i < 60; ++i) cycle(i % 2 == 0);
          }},
      Row{AlStatusCode::kDcSyncTimeout,
          [this] {
            for (int i = 0; i < 11; ++i) cycle(false);
          }},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(static_cast<unsigned>(row.code));
    ASSERT_EQ(request(AlState::kInit), AlStatusCode::kNoError);
    device().restart();
    pass(2ms);
    write(reg::kDcActivation, 0);
    write(reg::kSystemTimeOffset, 0);
    to_op();
    static_cast<void>(emergencies());
    EXPECT_FALSE(drive().dictionary().get(kBusValue.sync_error));
    row.cause();
    EXPECT_EQ(slave_.state(), AlState::kSafeOp);
    EXPECT_EQ(code(), row.code);
    EXPECT_EQ(drive().fault(), Fault::kLocalError);
    EXPECT_EQ(emergencies(), kLocalErrorReported);
    EXPECT_TRUE(drive().dictionary().get(kBusValue.sync_error)) << "1C32h:20";
    // Acknowledging the AL error, then INIT.
    write(reg::kAlControl, wire::AlControl{AlState::kSafeOp, true, false}.raw());
    slave_.advance(now_);
  }
}

TEST_F(MsdSynchronisation, ProcessDataThatSynchroniseAndStayAwayAreALocalError) {
  to_pre_op();
  download(0x1C32, 1, 1, 2);
  ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
  cycle();
  ASSERT_EQ(request(AlState::kOp), AlStatusCode::kNoError);
  for (int i = 0; i < 50; ++i) cycle();
  ASSERT_EQ(slave_.state(), AlState::kOp);
  static_cast<void>(emergencies());
  for (int i = 0; i < 12; ++i) cycle(false);
  EXPECT_EQ(slave_.state(), AlState::kSafeOp);
  EXPECT_EQ(code(), AlStatusCode::kSynchronizationError);
  EXPECT_EQ(emergencies(), kLocalErrorReported);
}

TEST_F(MsdSynchronisation, SettingsThatCannotWorkAreRefusedWithoutAFault) {
  to_pre_op();
  download(0x1C32, 1, 2, 2);
  EXPECT_EQ(request(AlState::kSafeOp), AlStatusCode::kInvalidDcSyncConfiguration) << "SYNC0 is off";
  activate(200'000);
  EXPECT_EQ(request(AlState::kSafeOp), AlStatusCode::kDcSync0CycleTime);
  EXPECT_EQ(drive().fault(), std::nullopt);
  EXPECT_THAT(emergencies(), testing::IsEmpty());
}

TEST_F(MsdSynchronisation, SetpointsMustComeInWholeCyclesOfSync0) {
  struct Row {
    std::uint32_t ms;
    AlStatusCode code;
  };
  // SYNC0 comes every 2 ms; process data of a group may come in every second or third of them.
  for (const Row row : {Row{1, AlStatusCode::kDcInvalidSyncCycleTime}, Row{2, AlStatusCode::kNoError},
                        Row{3, AlStatusCode::kDcInvalidSyncCycleTime}, Row{4, AlStatusCode::kNoError}}) {
    SCOPED_TRACE(row.ms);
    ASSERT_EQ(request(AlState::kInit), AlStatusCode::kNoError);
    device().restart();
    pass(2ms);
    to_pre_op();
    download(0x60C2, 1, row.ms, 1);
    download(0x2132, 0, std::bit_cast<std::uint32_t>(static_cast<float>(row.ms)), 4);
    activate(2'000'000);
    ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
    request(AlState::kOp);
    for (int i = 0; i < 24; ++i) cycle();
    EXPECT_EQ(code(), row.code);
    const bool good = row.code == AlStatusCode::kNoError;
    EXPECT_EQ(slave_.state(), good ? AlState::kOp : AlState::kSafeOp);
    EXPECT_EQ(drive().fault(), good ? std::nullopt : std::optional(Fault::kInvalidConfiguration));
  }
}

/// README: a line of 1 ms may have SYNC0 at any fraction of it that is a multiple of 125 us.
TEST_F(MsdSynchronisation, Sync0MayBeFinerThanTheCycleOfTheSetpoints) {
  for (const std::uint32_t sync0 : {125'000U, 250'000U, 500'000U}) {
    SCOPED_TRACE(sync0);
    ASSERT_EQ(request(AlState::kInit), AlStatusCode::kNoError);
    device().restart();
    pass(2ms);
    EXPECT_EQ(drive().dictionary().get(kBusValue.sync_cycle), 125'000U) << "without SYNC0, the drive's own cycle";
    write(reg::kDcActivation, 0);
    to_pre_op();
    activate(sync0);
    ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
    EXPECT_EQ(drive().dictionary().get(kBusValue.sync_cycle), sync0) << "1C32h:02";
    pass(560us);
    request(AlState::kOp);
    for (int i = 0; i < 60; ++i) cycle();
    EXPECT_EQ(code(), AlStatusCode::kNoError);
    ASSERT_EQ(slave_.state(), AlState::kOp);
    EXPECT_EQ(drive().fault(), std::nullopt);
    EXPECT_EQ(slave_.al().sync_margin().missed, 0U);
    // Missing setpoints count once per setpoint cycle, whatever SYNC0 is.
    for (int i = 0; i < 10; ++i) cycle(false);
    EXPECT_EQ(slave_.state(), AlState::kOp);
    cycle(false);
    EXPECT_EQ(code(), AlStatusCode::kDcSyncTimeout);
    write(reg::kAlControl, wire::AlControl{AlState::kSafeOp, true, false}.raw());
    slave_.advance(now_);
  }
}

TEST_F(MsdSynchronisation, AnIllegalRequestInOpIsNoErrorOfADriveThatIsOff) {
  to_op();
  static_cast<void>(emergencies());
  EXPECT_EQ(request(AlState::kBootstrap), AlStatusCode::kInvalidRequestedStateChange);
  EXPECT_EQ(slave_.state(), AlState::kSafeOp);
  EXPECT_EQ(drive().fault(), std::nullopt);
  EXPECT_THAT(emergencies(), testing::IsEmpty());
}

TEST_F(MsdSynchronisation, Sync0ThatNeverCameIsNoWayToOp) {
  to_pre_op();
  activate(1'000'000);
  write(reg::kDcActivation, 0);
  write(reg::kStartTimeCyclic, static_cast<std::uint64_t>((now_ - 1us).count()));
  write(reg::kDcActivation, 3);
  ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
  request(AlState::kOp);
  for (int i = 0; i < 10'000 && code() == AlStatusCode::kNoError; ++i) cycle();
  EXPECT_EQ(slave_.state(), AlState::kSafeOp);
  EXPECT_EQ(code(), AlStatusCode::kNoSyncError);
}

TEST_F(MsdSynchronisation, TheLimitOfMissingOutputsIsASetting) {
  to_pre_op();
  download(0x10F1, 2, 12, 2);
  activate(1'000'000);
  ASSERT_EQ(request(AlState::kSafeOp), AlStatusCode::kNoError);
  pass(500us);
  ASSERT_EQ(request(AlState::kOp), AlStatusCode::kNoError);
  for (int i = 0; i < 12; ++i) cycle();
  ASSERT_EQ(slave_.state(), AlState::kOp);
  for (int i = 0; i < 4; ++i) cycle(false);
  EXPECT_EQ(slave_.state(), AlState::kOp);
  cycle(false);
  EXPECT_EQ(code(), AlStatusCode::kDcSyncTimeout);
}

/// Outputs arrive 500 us before SYNC0, once 200 us later, and three times not at all, which 1C32h reports.
TEST_F(MsdSynchronisation, TheDriveMeasuresHowPunctualOutputsAre) {
  to_op();
  for (int i = 0; i < 20; ++i) cycle();
  pass(200us);
  cycle();
  pass(800us);
  for (int i = 0; i < 2; ++i) cycle(false);
  cycle();
  const auto& margin = slave_.al().sync_margin();
  EXPECT_GT(margin.pulses, 20U);
  EXPECT_EQ(margin.missed, 3U);
  EXPECT_EQ(margin.longest - margin.shortest, 200us);
  EXPECT_GT(margin.mean(), margin.shortest);
  EXPECT_LT(margin.mean(), margin.longest);
  const auto& dictionary = drive().dictionary();
  EXPECT_EQ(dictionary.get(kBusValue.sync_events_missed), 3U);
  EXPECT_EQ(dictionary.get(kBusValue.sync_distance_min), margin.shortest.count());
  EXPECT_EQ(dictionary.get(kBusValue.sync_distance_max), margin.longest.count());
}

TEST(MsdSynchronisationType, DcInsistsOnSync0) {
  DriveRig rig;
  EXPECT_FALSE(rig.device.sync_demand().type);
  ASSERT_EQ(rig.write(0x1C32, 1, 2, 2), 0U);
  EXPECT_EQ(rig.device.sync_demand().type, SyncType::kSync0);
}

TEST(MsdSynchronisationType, AnIllegalRequestEndsTheOutputsOfAMotorThatIsOn) {
  for (const auto code : {AlStatusCode::kInvalidRequestedStateChange, AlStatusCode::kUnknownRequestedState}) {
    EnabledRig rig(8);
    rig.device.fall_back(AlState::kOp, AlState::kSafeOp, code);
    EXPECT_EQ(rig.drive.fault(), Fault::kMissingOutputs) << "Er 14 05, as for a request for SAFEOP";
  }
}

TEST(MsdSynchronisationType, InputsHaveATypeOfTheirOwn) {
  DriveRig rig;
  EXPECT_FALSE(rig.device.sync_demand().input_type);
  ASSERT_EQ(rig.write(0x1C33, 1, 0x22, 2), 0U);
  EXPECT_EQ(rig.device.sync_demand().input_type, SyncType::kSm2Event);
  EXPECT_FALSE(rig.device.sync_demand().type);
  EXPECT_FALSE(rig.device.sync_demand().outputs) << "nothing is mapped";
  rig.map(0x1600, {0x60400010});
  EXPECT_TRUE(rig.device.sync_demand().outputs);
}

/// ETG.1020: cycle, SM event missed, cycle exceeded, shift too short, sync error; the same for outputs and inputs.
TEST(MsdSynchronisationType, ParametersOfBothSyncManagersShowWhatRuns) {
  OperatingRig rig;
  SyncMargin margin;
  margin.missed = 70'000;
  margin.exceeded = 3;
  margin.too_short = 5;
  rig.device.sync_margin(margin);
  rig.device.sync_started(750us);
  for (const std::uint16_t index : {std::uint16_t{0x1C32}, std::uint16_t{0x1C33}}) {
    SCOPED_TRACE(index);
    EXPECT_EQ(rig.read(index, 0x00), 0x20U);
    EXPECT_EQ(rig.read(index, 0x02), 750'000U);
    EXPECT_EQ(rig.read(index, 0x0B), 0xFFFFU) << "as much as 16 bits hold";
    EXPECT_EQ(rig.read(index, 0x0C), 3U);
    EXPECT_EQ(rig.read(index, 0x0D), 5U);
    EXPECT_EQ(rig.read(index, 0x20), 0U);
  }
  margin.missed = 9;
  rig.device.sync_margin(margin);
  for (const std::uint16_t index : {std::uint16_t{0x1C32}, std::uint16_t{0x1C33}}) EXPECT_EQ(rig.read(index, 0x0B), 9U);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kFatalSyncError);
  for (const std::uint16_t index : {std::uint16_t{0x1C32}, std::uint16_t{0x1C33}}) EXPECT_EQ(rig.read(index, 0x20), 1U);
}

/// Largest difference of two speeds while the setpoint moves at constant speed, in increments per second. SYNC0 comes
/// every 125.025 us; the drive's own time base is 200 ppm faster.
std::int32_t ripple(bool sync) {
  EnabledRig rig(8);
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = std::numeric_limits<std::int32_t>::min();
  for (int i = 0; i < 12'000; ++i) {
    rig.target_position += 500;
    rig.cycle(125'025ns);
    if (sync) rig.device.sync_event(SyncSignal::kSync0, rig.now);
    if (i < 4000) continue;
    lowest = std::min(lowest, rig.velocity);
    highest = std::max(highest, rig.velocity);
  }
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  return highest - lowest;
}

TEST(MsdSynchronisationType, ControlStepsFollowSync0) {
  const auto synchronised = ripple(true);
  EXPECT_LT(synchronised, 6000);
  EXPECT_LT(synchronised * 3, ripple(false));
}

}  // namespace
}  // namespace driveline::slaves::msd
