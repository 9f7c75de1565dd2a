// SYNC0 and SYNC1: their true times, how they are started and stopped, what the device receives (ESC data sheet I,
// SyncSignal generation; section II, 0x0980-0x09A7).
#include "bench_slave.hpp"
#include "random.hpp"

namespace driveline::slaves::test {
namespace {

using std::chrono::nanoseconds;

class SyncUnitTest : public BenchSlave {
 protected:
  SyncUnitTest() { reserve(); }

  void rebuild_with(const ClockOptions& clock, bool wide = true) {
    SlaveOptions options;
    options.clock = clock;
    auto own = std::make_unique<TestDevice>();
    own->own_profile.distributed_clock_64bit = wide;
    rebuild(options, std::move(own));
    reserve();
  }
  std::uint64_t system_time() { return static_cast<std::uint64_t>(esc().clock().system_time(now()).count()); }
  /// Set up as by a master: off, times, on.
  void activate(std::uint64_t start, std::uint32_t cycle0, std::uint32_t cycle1 = 0, unsigned activation = 0x03) {
    write(reg::kDcActivation, 0);
    write(reg::kStartTimeCyclic, start);
    write(reg::kSync0CycleTime, cycle0);
    write(reg::kSync1CycleTime, cycle1);
    write(reg::kDcActivation, static_cast<std::uint8_t>(activation));
    slave().advance(now());
  }
  std::vector<nanoseconds> times(SyncSignal signal) {
    std::vector<nanoseconds> result;
    for (const auto& [which, time] : device().sync_events) {
      if (which == signal) result.push_back(time);
    }
    return result;
  }
  std::vector<nanoseconds> sync0() { return times(SyncSignal::kSync0); }
  std::vector<nanoseconds> sync1() { return times(SyncSignal::kSync1); }

 private:
  void reserve() { device().sync_events.reserve(100'000); }
};

TEST_F(SyncUnitTest, Sync0ComesAtTheStartTimeAndEveryCycle) {
  const auto begin = now();
  activate(system_time() + 1'000'000, 125'000);
  pass(999us);
  EXPECT_TRUE(sync0().empty());
  pass(251us);
  EXPECT_EQ(sync0(), (std::vector<nanoseconds>{begin + 1ms, begin + 1125us, begin + 1250us}));
  EXPECT_EQ(esc().clock().sync0_count(), 3U);
  EXPECT_EQ(esc().clock().last_sync0(), begin + 1250us);
}

TEST_F(SyncUnitTest, PulsesComeAtTheirTimeHoweverLateSomebodyLooks) {
  const auto begin = now();
  activate(system_time() + 100'000, 1'000'000);
  pass(1s);
  const auto pulses = sync0();
  ASSERT_EQ(pulses.size(), 1000U);
  EXPECT_EQ(pulses.back(), begin + 100us + 999ms);
  EXPECT_FALSE(device().went_back);
}

TEST_F(SyncUnitTest, TheCycleIsThatOfTheSlavesOwnClock) {
  ClockOptions clock;
  clock.drift_ppm = 200.0;
  rebuild_with(clock);
  activate(system_time() + 10'000, 1'000'000);
  pass(10s);
  const auto pulses = sync0();
  ASSERT_GT(pulses.size(), 10'000U);
  EXPECT_NEAR(static_cast<double>((pulses[10'000] - pulses[0]).count()), 1e10 / 1.0002, 11.0);
}

TEST_F(SyncUnitTest, PulsesLieOnStepsOfTheOscillator) {
  ClockOptions clock;
  clock.resolution = 10ns;
  rebuild_with(clock);
  const auto begin = now();
  activate(system_time() + 1003, 125'001);
  pass(1ms);
  ASSERT_GE(sync0().size(), 3U);
  EXPECT_EQ(sync0()[0], begin + 1010ns);
  EXPECT_EQ(sync0()[1], begin + 126'010ns) << "1003 + 125001, at the step behind";
}

TEST_F(SyncUnitTest, ActivationStatusTellsThatTheFirstPulseIsPending) {
  activate(system_time() + 1'000'000, 125'000, 0, 0x07);
  EXPECT_EQ(get(reg::kDcActivationStatus), 0x03);
  pass(1ms);
  EXPECT_EQ(get(reg::kDcActivationStatus), 0x00);
  write(reg::kDcActivation, 0);
  slave().advance(now());
  const auto count = sync0().size();
  pass(1ms);
  EXPECT_EQ(sync0().size(), count) << "switched off";
}

TEST_F(SyncUnitTest, RegistersTellTheNextPulses) {
  const auto start = system_time() + 1'000'000;
  activate(start, 125'000, 20'000, 0x07);
  EXPECT_EQ(get(reg::kStartTimeCyclic), start);
  pass(1010us);
  EXPECT_EQ(get(reg::kStartTimeCyclic), start + 125'000);
  EXPECT_EQ(get(reg::kNextSync1), start + 20'000);
}

TEST_F(SyncUnitTest, SingleShot) {
  const auto begin = now();
  activate(system_time() + 1'000'000, 0);
  pass(10ms);
  EXPECT_EQ(sync0(), (std::vector<nanoseconds>{begin + 1ms}));
  EXPECT_FALSE(esc().clock().sync().running());
  activate(system_time() + 1'000'000, 0);
  pass(10ms);
  EXPECT_EQ(sync0().size(), 2U) << "again after another activation";
}

TEST_F(SyncUnitTest, PulsesCloserThanTheirLengthAreOneSignal) {
  for (const std::uint32_t cycle : {1U, 10U, 1000U}) {
    rebuild_with({});
    activate(system_time() + 1'000'000, cycle, 1, 0x07);
    pass(9s);
    EXPECT_EQ(sync0().size(), 1U) << cycle;
    EXPECT_EQ(sync1().size(), 1U) << cycle;
  }
}

TEST_F(SyncUnitTest, ShortCyclesAreNotMadeUpForWithoutEnd) {
  activate(system_time() + 1'000'000, 1010);
  pass(100ms);
  const auto pulses = sync0().size();
  EXPECT_NEAR(static_cast<double>(pulses), 99e6 / 1010, 2.0);
  pass(9s);
  EXPECT_LT(sync0().size(), pulses + 100) << "nobody looked for too long";
}

TEST_F(SyncUnitTest, Sync1FollowsSync0) {
  struct Row {
    std::uint32_t cycle1;
    std::vector<int> expected_us;  ///< after the start
  };
  for (const auto& row : {Row{0, {0, 100, 200, 300, 400, 500, 600}},        // with SYNC0
                          Row{30'000, {30, 130, 230, 330, 430, 530, 630}},  // behind it
                          Row{100'000, {100, 300, 500}},                    // every second one
                          Row{200'000, {200, 500}},                         // every third one
                          Row{130'000, {130, 330, 530}}}) {                 // every second one, and behind it
    rebuild_with({});
    const auto begin = now() + 1ms;
    activate(system_time() + 1'000'000, 100'000, row.cycle1, 0x07);
    pass(1ms + 650us);
    std::vector<nanoseconds> expected;
    for (const int us : row.expected_us) expected.push_back(begin + std::chrono::microseconds{us});
    EXPECT_EQ(sync1(), expected) << "SYNC1 cycle time " << row.cycle1;
    EXPECT_EQ(sync0().size(), 7U);
  }
}

TEST_F(SyncUnitTest, AStartTimeAtTheEdgeOfTheClocksRangeIsWaitedFor) {
  constexpr std::uint64_t kHalf = std::uint64_t{1} << 63;
  ClockOptions clock;
  clock.drift_ppm = 50.0;
  for (const std::uint64_t ahead : {kHalf - (std::uint64_t{1} << 30), kHalf - 1, kHalf / 2, std::uint64_t{1} << 57}) {
    for (const std::uint64_t offset : {std::uint64_t{0}, kHalf - 500'000, kHalf, std::uint64_t{0} - 500'000}) {
      rebuild_with(clock);
      write(reg::kSystemTimeOffset, offset);
      const auto start = system_time() + ahead;
      activate(start, 1'000'000);
      EXPECT_EQ(esc().clock().sync_due(), DistributedClock::kNever) << "not in this life";
      pass(10ms);
      EXPECT_TRUE(sync0().empty()) << std::hex << ahead << ' ' << offset;
      EXPECT_EQ(get(reg::kStartTimeCyclic), start);
      EXPECT_EQ(get(reg::kDcActivationStatus), 0x01) << "pending";
    }
  }
}

TEST_F(SyncUnitTest, PulsesGoOnWhereTheClockBeginsAgainAtZero) {
  for (const std::uint64_t edge : {std::uint64_t{0}, std::uint64_t{1} << 63}) {
    rebuild_with({});
    write(reg::kSystemTimeOffset, edge - 500'000 - static_cast<std::uint64_t>(now().count()));
    const auto begin = now();
    activate(edge - 250'000, 125'000, 200'000, 0x07);
    pass(1130us);
    std::vector<nanoseconds> expected;
    for (int i = 0; i < 8; ++i) expected.push_back(begin + 250us + i * 125us);
    ASSERT_EQ(sync0(), expected);
    EXPECT_EQ(sync1(), (std::vector<nanoseconds>{begin + 450us, begin + 700us, begin + 950us}));
    EXPECT_EQ(get(reg::kStartTimeCyclic), edge - 250'000 + 8 * 125'000);
    EXPECT_EQ(get(reg::kSystemTime), edge + 630'000);
  }
}

TEST_F(SyncUnitTest, AFarSync1IsNotMadeUpForPulseByPulse) {
  activate(system_time() + 100'000, 1010, 0xFFFF'FFFF, 0x07);
  pass(200us);
  const auto first = sync0().front();
  pass(4s);
  EXPECT_LT(sync0().size(), 1000U);
  EXPECT_TRUE(sync1().empty());
  pass(50ms);
  EXPECT_EQ((sync0().back() - first) % 1010ns, 0ns) << "in their phase";
  device().sync_events.clear();
  pass(190ms);
  pass(60ms);
  ASSERT_EQ(sync1().size(), 1U);
  EXPECT_EQ(sync1()[0], first + nanoseconds{0xFFFF'FFFF} + 5ns) << "at the next step of the oscillator";
}

TEST_F(SyncUnitTest, NoClockRegisterLeadsTheUnitAstray) {
  Random random(2026);
  const auto edge = [&random]() -> std::uint64_t {
    const auto power = std::uint64_t{1} << random() % 64;
    switch (random() % 4) {
      case 0:
        return power;
      case 1:
        return std::uint64_t{0} - power;
      case 2:
        return power - 1;
      default:
        return (std::uint64_t{random()} << 32) | random();
    }
  };
  ClockOptions clock;
  clock.drift_ppm = -200.0;
  clock.temperature_ppm_per_s = 1.0;
  clock.temperature_span_ppm = 20.0;
  for (const bool wide : {true, false}) {
    rebuild_with(clock, wide);
    for (int i = 0; i < 20'000; ++i) {
      device().sync_events.clear();
      switch (random() % 9) {
        case 0:
          write(reg::kSystemTimeOffset, edge());
          break;
        case 1:
          write(reg::kStartTimeCyclic, system_time() + edge());
          break;
        case 2:
          write(reg::kSync0CycleTime, static_cast<std::uint32_t>(edge()) | 0x4'0000U);
          break;
        case 3:
          write(reg::kSync1CycleTime, static_cast<std::uint32_t>(edge()));
          break;
        case 4:
          write(reg::kDcActivation, static_cast<std::uint8_t>(random()));
          break;
        case 5: {
          const auto time = bytes::to_le_bytes(static_cast<std::uint32_t>(system_time() + edge()));
          write(0x0910, {time.begin(), time.end()});
          break;
        }
        case 6:
          write(reg::kSystemTimeDelay, static_cast<std::uint32_t>(edge()));
          break;
        case 7:
          write(reg::kSpeedCounterStart, static_cast<std::uint16_t>(edge()));
          write(reg::kSpeedFilterDepth, static_cast<std::uint8_t>(random()));
          break;
        default:
          pass(nanoseconds{random() % 3'000'000});
      }
      slave().advance(now());
      // When a pulse is due, the clock shows its time, not a nanosecond less.
      const auto next = esc().clock().sync().next();
      const auto due = esc().clock().sync_due();
      if (!next || due == DistributedClock::kNever) continue;
      const auto ahead = [&](nanoseconds at) {
        return static_cast<std::int64_t>(static_cast<std::uint64_t>(esc().clock().system_time(at).count()) - *next);
      };
      ASSERT_GE(due, now()) << i;
      ASSERT_GE(ahead(due), 0) << i;
      ASSERT_LT(ahead(due - 1ns), 0) << i;
    }
  }
}

TEST_F(SyncUnitTest, AStartTimeInThePastIsNeverReachedWith64Bits) {
  activate(system_time() - 1, 125'000);
  pass(20s);
  EXPECT_TRUE(sync0().empty());
  EXPECT_EQ(get(reg::kDcActivationStatus), 0x01) << "still pending";
}

TEST_F(SyncUnitTest, AStartTimeInThePastIsReachedWhenA32BitClockComesByAgain) {
  rebuild_with({}, false);
  const auto begin = now();
  activate((system_time() - 1'000'000) & 0xFFFFFFFF, 1'000'000'000);
  pass(4293ms);
  EXPECT_TRUE(sync0().empty());
  pass(1s);
  ASSERT_EQ(sync0().size(), 1U);
  // The clock advances in steps of 10 ns, and 2^32 ns is not a multiple.
  EXPECT_EQ(sync0()[0], begin - 1ms + nanoseconds{4'294'967'300});
}

TEST_F(SyncUnitTest, PlausibilityCheckStartsAtOnce) {
  for (const bool wide : {true, false}) {
    rebuild_with({}, wide);
    const auto begin = now();
    activate(wide ? system_time() - 5'000'000 : (system_time() - 5'000'000) & 0xFFFFFFFF, 125'000, 0, 0x23);
    EXPECT_EQ(get(reg::kDcActivationStatus) & 0x04, 0x04) << "and says so";
    pass(100us);
    ASSERT_EQ(sync0().size(), 1U);
    EXPECT_EQ(sync0()[0], begin + 10ns);
  }
}

TEST_F(SyncUnitTest, NearFutureIsHalfTheRangeOrTwoSeconds) {
  const auto far = system_time() + 3'000'000'000;
  activate(far, 125'000, 0, 0x23);
  EXPECT_EQ(get(reg::kDcActivationStatus) & 0x04, 0) << "half of 64 bits";
  activate(far, 125'000, 0, 0x63);
  EXPECT_EQ(get(reg::kDcActivationStatus) & 0x04, 0x04) << "2^31 ns";
}

TEST_F(SyncUnitTest, WritingTheStartTimeMayActivate) {
  write(reg::kSync0CycleTime, 125'000);
  write(reg::kDcActivation, 0x0A);
  pass(1ms);
  EXPECT_TRUE(sync0().empty());
  const auto begin = now();
  write(reg::kStartTimeCyclic, system_time() + 100'000);
  EXPECT_EQ(get(reg::kDcActivation), 0x0B);
  pass(110us);
  EXPECT_EQ(sync0(), (std::vector<nanoseconds>{begin + 100us}));
}

TEST_F(SyncUnitTest, AStartTimeOf32BitsMayBeExtended) {
  write(reg::kSystemTimeOffset, 0x0123'4567'FFFF'0000 - static_cast<std::uint64_t>(now().count()));
  write(reg::kSync0CycleTime, 125'000);
  write(reg::kDcActivation, 0x12);
  const auto begin = now();
  const auto lower = static_cast<std::uint32_t>(system_time() + 100'000);  // beyond the edge of 32 bits
  const auto raw = bytes::to_le_bytes(lower);
  write(0x0990, {raw.begin(), raw.end()});
  write(reg::kDcActivation, 0x13);
  pass(110us);
  EXPECT_EQ(sync0(), (std::vector<nanoseconds>{begin + 100us}));
}

TEST_F(SyncUnitTest, PulsesCrossThe32BitEdge) {
  for (const bool wide : {true, false}) {
    ClockOptions clock;
    clock.start = nanoseconds{0x1'0000'0000} - now() - 300us;
    clock.resolution = 1ns;
    rebuild_with(clock, wide);
    const auto begin = now();
    activate(static_cast<std::uint32_t>(system_time() + 100'000), 125'000);
    pass(1ms);
    ASSERT_EQ(sync0().size(), 8U);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(sync0()[i], begin + 100us + static_cast<int>(i) * 125us);
  }
}

TEST_F(SyncUnitTest, AJumpOfTheClockOverThePulseStopsTheSignal) {
  activate(system_time() + 100'000, 125'000);
  pass(1ms);
  const auto count = sync0().size();
  EXPECT_GT(count, 5U);
  write(reg::kSystemTimeOffset, 1'000'000);
  pass(1s);
  EXPECT_EQ(sync0().size(), count);
  activate(system_time() + 100'000, 125'000);
  pass(1ms);
  EXPECT_GT(sync0().size(), count) << "until it is started anew";
}

TEST_F(SyncUnitTest, AJumpBackDelaysTheNextPulse) {
  const auto begin = now();
  activate(system_time() + 100'000, 125'000);
  pass(110us);
  write(reg::kSystemTimeOffset, static_cast<std::uint64_t>(-50'000));
  pass(200us);
  EXPECT_EQ(sync0(), (std::vector<nanoseconds>{begin + 100us, begin + 275us}));
}

TEST_F(SyncUnitTest, TheUnitMayBelongToTheApplication) {
  write(reg::kCyclicUnitControl, 0x01);
  EXPECT_EQ(write(reg::kSync0CycleTime, 125'000), 0);
  EXPECT_EQ(write(reg::kDcActivation, 3), 0);
  const auto pdi = [this](std::uint16_t address, std::uint64_t value) {
    const auto raw = bytes::to_le_bytes(value);
    return esc().pdi_write(address, std::span(raw).first(address == 0x0981 ? 1 : address == 0x09A0 ? 4 : 8), now());
  };
  EXPECT_TRUE(pdi(0x09A0, 125'000));
  EXPECT_TRUE(pdi(0x0990, system_time() + 100'000));
  EXPECT_TRUE(pdi(0x0981, 3));
  slave().advance(now());
  pass(1ms);
  EXPECT_EQ(sync0().size(), 8U);
}

TEST_F(SyncUnitTest, OutputsChangeHandsAtSync0) {
  go_to(AlState::kPreOp);
  const auto begin = now();
  activate(system_time() + 1'000'000, 500'000);
  configure_process_data();
  request(AlState::kSafeOp);
  write_outputs(bytes({1, 2, 3, 4}));
  pass(6001us);
  expect_request(AlState::kOp, AlState::kOp);
  for (unsigned i = 0; i < 10; ++i) {
    pass(400us);
    write_outputs(bytes({i, 2, 3, 4}));
    const auto before = device().output_count;
    pass(98us);
    EXPECT_EQ(device().output_count, before) << "waits for SYNC0";
    pass(2us);
    EXPECT_EQ(device().output_count, before + 1);
    EXPECT_EQ(device().outputs_at, begin + 6ms + (i + 1) * 500us);
    EXPECT_EQ(device().outputs[2], bytes({i, 2, 3, 4}));
  }
  EXPECT_FALSE(device().went_back);
}

TEST_F(SyncUnitTest, WithoutSync0TheStepsOfTheDeviceReturn) {
  go_to(AlState::kSafeOp);
  activate(system_time() + 100'000, 125'000);
  pass(1ms);
  auto before = device().input_count;
  pass(1ms);
  EXPECT_EQ(device().input_count, before + 8) << "at SYNC0, and not in steps as well";
  write(reg::kDcActivation, 0);
  pass(500us);
  before = device().input_count;
  pass(1ms);
  EXPECT_EQ(device().input_count, before + 8);
}

TEST_F(SyncUnitTest, AVeryLongSilenceIsNotMadeUpForPulseByPulse) {
  activate(system_time() + 100'000, 125'000, 250'000, 0x07);
  pass(std::chrono::hours{24});
  EXPECT_LT(device().sync_events.size(), 1000U);
  const auto before = device().sync_events.size();
  const auto start = esc().clock().sync_due();
  pass(750us);
  const auto pulses = sync0();
  EXPECT_GE(device().sync_events.size(), before + 6);
  EXPECT_EQ((pulses.back() - start) % 125us, 0ns);
}

}  // namespace
}  // namespace driveline::slaves::test
