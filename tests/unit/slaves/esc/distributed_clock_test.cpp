// The clock unit: local and system time, latching of receive times, following the reference clock (ETG.1000.4 6.7).
#include <cmath>
#include <cstdlib>

#include "bench_slave.hpp"
#include "driveline/slaves/esc/random_source.hpp"

namespace driveline::slaves::test {
namespace {

using std::chrono::nanoseconds;

class DistributedClockTest : public BenchSlave {
 protected:
  void rebuild_with(const ClockOptions& clock, bool wide = true) {
    SlaveOptions options;
    options.clock = clock;
    auto own = std::make_unique<TestDevice>();
    own->own_profile.distributed_clock_64bit = wide;
    rebuild(options, std::move(own));
  }
  /// Switched on just now, system time set to true time.
  void switch_on(const ClockOptions& clock) {
    rebuild_with(clock);
    slave().set_power(false, now());
    slave().set_power(true, now());
    write(reg::kSystemTimeOffset, static_cast<std::uint64_t>((now() - clock.start).count()));
  }
  /// A reference time arrives with an ARMW / FRMW frame.
  void send_system_time(nanoseconds time) {
    const auto raw = bytes::to_le_bytes(static_cast<std::uint32_t>(time.count()));
    EXPECT_EQ(transfer(Command::kArmw, 1, 0x0910, {raw.begin(), raw.end()}).working_counter, 1);
  }
  std::int64_t difference_ns() {
    const auto raw = get(reg::kSystemTimeDifference);
    const std::int64_t magnitude = raw & 0x7FFFFFFF;
    return (raw & 0x80000000U) != 0 ? -magnitude : magnitude;
  }
  /// Distance of the copy of the system time from true time plus `offset`, modulo 2^32.
  std::int64_t error_ns(nanoseconds offset) {
    return static_cast<std::int32_t>(
        static_cast<std::uint32_t>((esc().clock().system_time(now()) - now() - offset).count()));
  }
  /// Sends a perfect reference time (true time plus `offset`, in steps of 10 ns) every `period` for `time`.
  /// @return the largest error after `settling`
  std::int64_t follow(nanoseconds offset, nanoseconds period, nanoseconds time, nanoseconds settling) {
    std::int64_t worst = 0;
    for (nanoseconds t{0}; t < time; t += period) {
      pass(period);
      send_system_time((now() + offset) / 10 * 10);
      if (t >= settling) worst = std::max(worst, std::abs(error_ns(offset)));
    }
    return worst;
  }
};

TEST_F(DistributedClockTest, SystemTimeIsLocalTimePlusOffset) {
  ClockOptions clock;
  clock.start = 5s;
  rebuild_with(clock);
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 5s).count()));
  write(reg::kSystemTimeOffset, static_cast<std::uint64_t>(-4'000'000'000));
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 1s).count()));
  pass(120ns);
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 1s).count()));
}

TEST_F(DistributedClockTest, TimeAdvancesInStepsOfTheOscillator) {
  const auto before = get(reg::kSystemTime);
  pass(9ns);
  EXPECT_EQ(get(reg::kSystemTime), before);
  pass(1ns);
  EXPECT_EQ(get(reg::kSystemTime), before + 10);
}

TEST_F(DistributedClockTest, OscillatorDrifts) {
  ClockOptions clock;
  clock.drift_ppm = 50.0;
  rebuild_with(clock);
  const auto before = get(reg::kSystemTime);
  pass(1s);
  EXPECT_EQ(get(reg::kSystemTime) - before, 1'000'050'000U);
}

TEST_F(DistributedClockTest, LocalTimeBeginsAtPowerOn) {
  ClockOptions clock;
  clock.start = 7us;
  rebuild_with(clock);
  write(reg::kSystemTimeOffset, 1000);
  slave().set_power(false, now());
  pass(1s);
  slave().set_power(true, now());
  EXPECT_EQ(get(reg::kSystemTime), 7'000U);
  pass(2us);
  EXPECT_EQ(get(reg::kSystemTime), 9'000U);
}

TEST_F(DistributedClockTest, WriteToReceiveTimeAsksForLatching) {
  EXPECT_FALSE(esc().clock().latch_requested());
  EXPECT_EQ(transfer(Command::kBwr, 0, 0x0900, bytes({0, 0, 0, 0})).working_counter, 1);
  EXPECT_TRUE(esc().clock().latch_requested());
  esc().clock().latch({now(), now() + 300ns, DistributedClock::kNoFrame, DistributedClock::kNoFrame}, now() + 20ns);
  EXPECT_FALSE(esc().clock().latch_requested());
  const auto local = static_cast<std::uint32_t>(now().count());
  EXPECT_EQ(get(reg::kReceiveTimePort, 0), local);
  EXPECT_EQ(get(reg::kReceiveTimePort, 1), local + 300);
  EXPECT_EQ(get(reg::kReceiveTimePort, 2), 0U);
  EXPECT_EQ(get(reg::kReceiveTimeProcessingUnit), static_cast<std::uint64_t>((now() + 20ns).count()));
}

TEST_F(DistributedClockTest, WritesElsewhereDoNotLatch) {
  write(0x0904, bytes({0, 0, 0, 0}));
  write(reg::kSystemTimeOffset, 0);
  EXPECT_FALSE(esc().clock().latch_requested());
}

TEST_F(DistributedClockTest, ReceiveTimesStraddleThe31And32BitEdges) {
  for (const std::uint64_t edge : {0x8000'0000ULL, 0x1'0000'0000ULL, 0x1'8000'0000ULL}) {
    for (const bool wide : {true, false}) {
      ClockOptions clock;
      clock.start = nanoseconds{static_cast<std::int64_t>(edge) - 100} - now();
      rebuild_with(clock, wide);
      write(reg::kReceiveTimePort, 0);
      esc().clock().latch({now(), now() + 300ns, DistributedClock::kNoFrame, DistributedClock::kNoFrame}, now());
      EXPECT_EQ(get(reg::kReceiveTimePort, 0), static_cast<std::uint32_t>(edge - 100));
      EXPECT_EQ(get(reg::kReceiveTimePort, 1) - get(reg::kReceiveTimePort, 0), 300U);
      const auto unit = edge - 100;
      EXPECT_EQ(get(reg::kReceiveTimeProcessingUnit), wide ? unit : unit & 0xFFFFFFFF);
    }
  }
}

TEST_F(DistributedClockTest, ReceiveTimesJitterWithinTheirLimit) {
  ClockOptions clock;
  clock.receive_jitter = 20ns;
  clock.resolution = 1ns;
  rebuild_with(clock);
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
  for (int i = 0; i < 500; ++i) {
    pass(1us);
    write(reg::kReceiveTimePort, 0);
    esc().clock().latch({now(), now(), now(), now()}, now());
    for (unsigned port = 0; port < 4; ++port) {
      const auto error =
          static_cast<std::int32_t>(get(reg::kReceiveTimePort, port) - static_cast<std::uint32_t>(now().count()));
      lowest = std::min<std::int64_t>(lowest, error);
      highest = std::max<std::int64_t>(highest, error);
    }
  }
  EXPECT_EQ(lowest, -20);
  EXPECT_EQ(highest, 20);
}

TEST_F(DistributedClockTest, DifferenceHasSignAndMagnitude) {
  write(reg::kSystemTimeFilterDepth, 0);
  send_system_time(now() - 700ns);
  EXPECT_EQ(difference_ns(), 700) << "the local copy is ahead";
  write(reg::kSpeedCounterStart, 0x1000);
  EXPECT_EQ(difference_ns(), 0) << "the filter is reset";
  send_system_time(now() + 300ns);
  EXPECT_EQ(difference_ns(), -300);
  EXPECT_EQ(get(reg::kSystemTimeDifference), 0x8000012CU);
}

TEST_F(DistributedClockTest, DifferenceIsAMeanOfTheFilterDepth) {
  write(reg::kSystemTimeFilterDepth, 2);
  send_system_time(now() - 800ns);
  EXPECT_EQ(difference_ns(), 200);
  send_system_time(now() - 800ns);
  EXPECT_EQ(difference_ns(), 350);
  for (int i = 0; i < 50; ++i) send_system_time(now() - 800ns);
  EXPECT_EQ(difference_ns(), 800);
}

TEST_F(DistributedClockTest, PropagationDelayIsTakenIntoAccount) {
  write(reg::kSystemTimeFilterDepth, 0);
  write(reg::kSystemTimeDelay, 250);
  send_system_time(now() - 250ns);
  EXPECT_EQ(difference_ns(), 0);
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() - 250ns).count()))
      << "ECAT reads the time at which the frame passed the reference clock";
  std::array<std::byte, 8> seen{};
  ASSERT_TRUE(esc().pdi_read(0x0910, seen, now()));
  EXPECT_EQ(bytes::load_le<std::uint64_t>(seen), static_cast<std::uint64_t>(now().count()))
      << "the application its own";
}

TEST_F(DistributedClockTest, FollowsTheReferenceDespiteDrift) {
  for (const double drift_ppm : {-200.0, -80.0, 0.0, 100.0, 200.0}) {
    for (const nanoseconds period : {nanoseconds{125us}, nanoseconds{1ms}, nanoseconds{10ms}, nanoseconds{100ms}}) {
      ClockOptions clock;
      clock.drift_ppm = drift_ppm;
      switch_on(clock);
      SCOPED_TRACE(std::to_string(drift_ppm) + " ppm, every " + std::to_string(period.count()) + " ns");
      const bool rare = period > 10ms;
      // Starts 2 us apart.
      EXPECT_LE(follow(2us, period, rare ? 60s : 2s, rare ? 50s : 1s), rare ? 100 : 20);
      EXPECT_LE(std::abs(difference_ns()), rare ? 100 : 20);
    }
  }
}

TEST_F(DistributedClockTest, FollowsThousandsOfReferenceTimesBackToBack) {
  for (const double drift_ppm : {-200.0, 200.0}) {
    ClockOptions clock;
    clock.drift_ppm = drift_ppm;
    switch_on(clock);
    EXPECT_LE(follow(500ns, 4us, 15'000 * 4us, 10'000 * 4us), 20) << drift_ppm;
    // The cyclic frames start a little later.
    pass(1ms);
    EXPECT_LE(follow(500ns, 1ms, 1s, 0s), 30) << drift_ppm;
  }
}

TEST_F(DistributedClockTest, AClockThatWasSetComesBackWithoutOvershoot) {
  for (const double drift_ppm : {-100.0, 0.0, 100.0}) {
    ClockOptions clock;
    clock.drift_ppm = drift_ppm;
    switch_on(clock);
    follow(0ns, 125us, 1s, 1s);
    const auto offset = get(reg::kSystemTimeOffset);
    write(reg::kSystemTimeOffset, offset + 50'000);
    std::int64_t lowest = 0;
    for (int i = 0; i < 8000; ++i) {
      follow(0ns, 125us, 125us, 1s);
      lowest = std::min(lowest, error_ns(0ns));
    }
    EXPECT_GE(lowest, -500) << drift_ppm;
    EXPECT_LE(std::abs(error_ns(0ns)), 20) << drift_ppm;
  }
}

TEST_F(DistributedClockTest, SeveralReferenceTimesInOneFrameCountEach) {
  ClockOptions clock;
  clock.drift_ppm = 100.0;
  switch_on(clock);
  for (int frame = 0; frame < 100; ++frame) {
    pass(500us);
    for (int i = 0; i < 50; ++i) send_system_time(now());
  }
  EXPECT_LE(std::abs(error_ns(0ns)), 20) << "50 ms are enough";
}

TEST_F(DistributedClockTest, SpeedCounterDifferenceTellsTheDrift) {
  for (const double drift_ppm : {-150.0, 0.0, 150.0}) {
    ClockOptions clock;
    clock.drift_ppm = drift_ppm;
    switch_on(clock);
    follow(0ns, 125us, 2s, 1s);
    const double d = static_cast<std::int16_t>(get(reg::kSpeedCounterDifference));
    const double s = get(reg::kSpeedCounterStart);
    const double deviation_ppm = 1e6 * d / (5.0 * (s + d + 2.0) * (s - d + 2.0));
    EXPECT_NEAR(deviation_ppm, -drift_ppm, 1.0);
    write(reg::kSpeedCounterStart, 0x1000);
    EXPECT_EQ(get(reg::kSpeedCounterDifference), 0) << "the filter is reset";
    const auto before = get(reg::kSystemTime);
    pass(100ms);
    EXPECT_NEAR(static_cast<double>(get(reg::kSystemTime) - before), 1e8 * (1.0 + drift_ppm * 1e-6), 20.0);
  }
}

TEST_F(DistributedClockTest, ALargerSpeedCounterStartFollowsMoreSlowly) {
  std::array<std::int64_t, 2> left{};
  for (const bool slow : {false, true}) {
    rebuild();
    write(reg::kSpeedCounterStart, slow ? 0x3FFF : 0x1000);
    follow(5us, 125us, 20ms, 20ms);
    left[slow ? 1 : 0] = std::abs(error_ns(5us));
  }
  EXPECT_LT(left[0] * 3, left[1] * 2) << left[0] << " and " << left[1];
}

TEST_F(DistributedClockTest, FollowsThroughJitterAndTemperature) {
  ClockOptions clock;
  clock.drift_ppm = 100.0;
  clock.receive_jitter = 20ns;
  clock.temperature_ppm_per_s = 1.0;
  clock.temperature_span_ppm = 10.0;
  switch_on(clock);
  EXPECT_LE(follow(0ns, 125us, 5s, 1s), 30);
}

TEST_F(DistributedClockTest, FollowsAcrossThe31And32BitEdgesWhateverItsWidth) {
  for (const bool wide : {true, false}) {
    for (const std::uint64_t edge : {0x8000'0000ULL, 0x1'0000'0000ULL}) {
      ClockOptions clock;
      clock.drift_ppm = -50.0;
      clock.start = nanoseconds{static_cast<std::int64_t>(edge)} - 1s;
      rebuild_with(clock, wide);
      slave().set_power(false, now());
      slave().set_power(true, now());
      EXPECT_LE(follow(clock.start - now(), 125us, 2s, 600ms), 20) << std::hex << edge;
      EXPECT_GT(esc().clock().system_time(now()).count(), static_cast<std::int64_t>(edge));
    }
  }
}

TEST_F(DistributedClockTest, ThirtyTwoBitClocksHaveNoUpperHalves) {
  ClockOptions clock;
  clock.start = 10s;
  rebuild_with(clock, false);
  EXPECT_EQ(get(reg::kFeatures) & 0x0008, 0);
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 10s).count()) & 0xFFFFFFFF);
  write(reg::kSystemTimeOffset, 0x1122'3344'0000'0000);
  EXPECT_EQ(get(reg::kSystemTimeOffset), 0U);
  EXPECT_EQ(write(0x0994, bytes({1, 1, 1, 1})), 0);
}

TEST_F(DistributedClockTest, ABroadcastOfZerosAtStartUpDoesNotUpsetTheClock) {
  pass(3600s);
  const auto before = get(reg::kSystemTime);
  EXPECT_EQ(transfer(Command::kBwr, 0, 0x0910, std::vector<std::byte>(32)).working_counter, 1);
  pass(1s);
  const auto change = static_cast<std::int64_t>(get(reg::kSystemTime) - before) - 1'000'000'000;
  EXPECT_LT(std::abs(change), 10'000) << "bounded by what the control loop can do to the oscillator";
}

TEST_F(DistributedClockTest, ControllerWithoutClock) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.distributed_clock = false;
  rebuild({}, std::move(own));
  EXPECT_EQ(write(0x0900, bytes({0, 0, 0, 0})), 0);
  EXPECT_EQ(write(reg::kSystemTimeOffset, 5), 0);
  EXPECT_EQ(write(reg::kDcActivation, 3), 0);
  EXPECT_EQ(get(reg::kSystemTime), 0U);
}

TEST_F(DistributedClockTest, BufferEventsAreStampedWhenAskedFor) {
  go_to(AlState::kOp);
  write_outputs(bytes({1, 2, 3, 4}));
  pass(125us);
  EXPECT_EQ(get(reg::kEcatBufferChangeTime), 0U);
  EXPECT_EQ(get(reg::kPdiBufferChangeTime), 0U);
  write(0x0816, bytes({0xC1}));
  write(0x081E, bytes({0x41}));
  pass(1ms + 31250ns);  // the application works a quarter of a period after its start, and then every 125 us
  const auto written = static_cast<std::uint32_t>(now().count());
  write_outputs(bytes({1, 2, 3, 4}));
  EXPECT_EQ(get(reg::kEcatBufferChangeTime), written);
  pass(124us);
  EXPECT_EQ(get(reg::kPdiBufferChangeTime), 0U) << "the application works every 125 us";
  pass(1us);
  EXPECT_EQ(get(reg::kPdiBufferStartTime), written + 125'000);
  EXPECT_EQ(get(reg::kPdiBufferChangeTime), written + 125'000);
  pass(10us);
  read(kInputsAddress, 6);
  EXPECT_EQ(get(reg::kEcatBufferChangeTime), static_cast<std::uint32_t>(now().count()));
}

class LatchUnitTest : public DistributedClockTest {
 protected:
  void set(unsigned input, bool high) { esc().clock().set_latch_input(input, high, now()); }
  std::uint16_t irq() { return transfer(Command::kNop, 0, 0, {}).irq; }
};

TEST_F(LatchUnitTest, ContinuousModeKeepsTheLatestEdge) {
  write(reg::kSystemTimeOffset, 1'000'000);
  set(0, true);
  EXPECT_EQ(get(reg::kLatch0Status), 0x04) << "level; events are told in single event mode only";
  const auto first = get(reg::kLatch0PositiveEdge);
  EXPECT_EQ(first, static_cast<std::uint64_t>(now().count()) + 1'000'000);
  pass(1ms);
  set(0, false);
  EXPECT_EQ(get(reg::kLatch0NegativeEdge), first + 1'000'000);
  EXPECT_EQ(get(reg::kLatch0Status), 0);
  set(0, true);
  EXPECT_EQ(get(reg::kLatch0PositiveEdge), first + 1'000'000);
}

TEST_F(LatchUnitTest, SingleEventModeKeepsTheFirstUntilItIsRead) {
  write(reg::kEcatEventMask, 0x0001);
  write(reg::kLatch1Control, 0x01);
  EXPECT_EQ(irq(), 0);
  set(1, true);
  const auto first = static_cast<std::uint64_t>(now().count());
  EXPECT_EQ(get(reg::kLatch1Status), 0x05);
  EXPECT_EQ(irq(), 1);
  pass(1ms);
  set(1, false);
  set(1, true);
  EXPECT_EQ(get(reg::kLatch1PositiveEdge), first);
  EXPECT_EQ(get(reg::kLatch1Status), 0x04) << "reading acknowledges";
  EXPECT_EQ(irq(), 0);
  set(1, false);
  pass(1ms);
  set(1, true);
  EXPECT_EQ(get(reg::kLatch1PositiveEdge), static_cast<std::uint64_t>(now().count()));
}

TEST_F(LatchUnitTest, InputOfTheApplicationIsAcknowledgedByIt) {
  write(reg::kLatch0Control, 0x01);
  write(reg::kCyclicUnitControl, 0x10);
  EXPECT_EQ(write(reg::kLatch0Control, 0x00), 0) << "no longer ours";
  set(0, true);
  get(reg::kLatch0PositiveEdge);
  EXPECT_EQ(get(reg::kLatch0Status), 0x05);
  std::array<std::byte, 8> seen{};
  ASSERT_TRUE(esc().pdi_read(0x09B0, seen, now()));
  EXPECT_EQ(get(reg::kLatch0Status), 0x04);
}

}  // namespace
}  // namespace driveline::slaves::test
