// The clock unit: local and system time, latching of receive times, following the reference clock (ETG.1000.4 6.7).
#include <cstdlib>

#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

class DistributedClockTest : public BenchSlave {
 protected:
  /// A reference time arrives with an ARMW / FRMW frame.
  void send_system_time(std::chrono::nanoseconds time) {
    const auto raw = wire::to_le_bytes(static_cast<std::uint32_t>(time.count()));
    EXPECT_EQ(transfer(Command::kArmw, 1, 0x0910, {raw.begin(), raw.end()}).working_counter, 1);
  }
  std::int64_t difference_ns() {
    const auto raw = get(reg::kSystemTimeDifference);
    const std::int64_t magnitude = raw & 0x7FFFFFFF;
    return (raw & 0x80000000U) != 0 ? -magnitude : magnitude;
  }
};

TEST_F(DistributedClockTest, SystemTimeIsLocalTimePlusOffset) {
  SlaveOptions options;
  options.clock.start = 5s;
  rebuild(options);
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 5s).count()));
  write(reg::kSystemTimeOffset, static_cast<std::uint64_t>(-4'000'000'000));
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 1s).count()));
  pass(123ns);
  EXPECT_EQ(get(reg::kSystemTime), static_cast<std::uint64_t>((now() + 1s).count()));
}

TEST_F(DistributedClockTest, OscillatorDrifts) {
  SlaveOptions options;
  options.clock.drift_ppm = 50.0;
  rebuild(options);
  const auto before = get(reg::kSystemTime);
  pass(1s);
  EXPECT_EQ(get(reg::kSystemTime) - before, 1'000'050'000U);
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

TEST_F(DistributedClockTest, PropagationDelayIsTakenIntoAccount) {
  write(reg::kSystemTimeFilterDepth, 0);
  write(reg::kSystemTimeDelay, 250);
  send_system_time(now() - 250ns);
  EXPECT_EQ(difference_ns(), 0);
}

TEST_F(DistributedClockTest, FollowsTheReferenceDespiteDrift) {
  for (const double drift_ppm : {-80.0, 80.0}) {
    SlaveOptions options;
    options.clock.drift_ppm = drift_ppm;
    rebuild(options);
    for (int i = 0; i < 8000; ++i) {
      pass(125us);
      send_system_time(now() + 2us);  // starts 2 us apart
    }
    const auto error = static_cast<std::int64_t>(get(reg::kSystemTime)) - (now() + 2us).count();
    EXPECT_LT(std::abs(error), 100) << "drift " << drift_ppm;
    EXPECT_LT(std::abs(difference_ns()), 100);
  }
}

TEST_F(DistributedClockTest, ABroadcastOfZerosAtStartUpDoesNotUpsetTheClock) {
  pass(3600s);
  const auto before = get(reg::kSystemTime);
  EXPECT_EQ(transfer(Command::kBwr, 0, 0x0910, std::vector<std::byte>(32)).working_counter, 1);
  const auto change = static_cast<std::int64_t>(get(reg::kSystemTime) - before);
  EXPECT_LT(std::abs(change), 10'000) << "bounded by what the control loop can do to the oscillator";
}

TEST_F(DistributedClockTest, ControllerWithoutClock) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.distributed_clock = false;
  rebuild({}, std::move(own));
  EXPECT_EQ(write(0x0900, bytes({0, 0, 0, 0})), 0);
  EXPECT_EQ(write(reg::kSystemTimeOffset, 5), 0);
}

}  // namespace
}  // namespace driveline::slaves::test
