// Distributed clocks on a line: measurements of a master compared with the true times.
#include <cmath>

#include "random.hpp"

#include "test_line.hpp"

namespace driveline::slaves::test {
namespace {

using std::chrono::nanoseconds;
using wire::DatagramAddress;

class ClockLineTest : public LineTest {
 protected:
  void build_clocks(const std::vector<ClockOptions>& clocks, const LineOptions& options,
                    std::optional<Wiring> wiring = std::nullopt) {
    std::vector<SlaveOptions> slaves(clocks.size());
    for (std::size_t i = 0; i < clocks.size(); ++i) slaves[i].clock = clocks[i];
    build(clocks.size(), options, std::move(wiring), slaves);
  }
  void latch() { exchange(Command::kBwr, DatagramAddress::physical(0, 0x0900), bytes({0, 0, 0, 0})); }
  std::uint32_t port_time(std::size_t slave, unsigned port) { return peek(slave, reg::kReceiveTimePort, port); }
  std::uint32_t between(std::size_t slave, unsigned first, unsigned second) {
    return port_time(slave, second) - port_time(slave, first);
  }
  template <typename T>
  void set(std::size_t slave, const wire::Register<T>& r, std::type_identity_t<T> value) {
    const auto raw = bytes::to_le_bytes(value);
    exchange(Command::kApwr, DatagramAddress::position(static_cast<std::uint16_t>(slave), r.address),
             {raw.begin(), raw.end()});
  }
  /// ARMW of the first slave's system time, as a master sends it in every cycle.
  void compensate(nanoseconds period) {
    exchange(Command::kArmw, DatagramAddress::position(0, 0x0910), bytes({0, 0, 0, 0}));
    clock().advance(period - clock().now() % period);
  }
};

TEST_F(ClockLineTest, PortTimesOfAPlainLineGiveTheTrueDelays) {
  LineOptions options;
  options.delays = {300ns, 260ns};
  options.cable_delay = 50ns;
  std::vector<ClockOptions> clocks(4);
  clocks[1].start = 123456789ns;
  clocks[1].drift_ppm = 100.0;
  clocks[2].start = nanoseconds{0xFFFF'FF80} - 1s;
  clocks[2].drift_ppm = -200.0;
  build_clocks(clocks, options);
  latch();
  // After slave i there are 3 - i cables in both directions, a turn-around in the last slave, and the slaves in
  // between.
  for (std::size_t i = 0; i < 3; ++i) {
    const auto behind = static_cast<std::int64_t>(3 - i);
    const std::int64_t round_trip = 300 + behind * 2 * 50 + behind * 300 + (behind - 1) * 260;
    EXPECT_NEAR(between(i, 0, 1), static_cast<double>(round_trip), 10.0) << i;
  }
  EXPECT_EQ(port_time(3, 1), 0U) << "nothing is plugged in there";
  // As masters compute it: half of the difference of the round trips.
  for (std::size_t i = 0; i < 2; ++i) {
    const double delay = (static_cast<double>(between(i, 0, 1)) - static_cast<double>(between(i + 1, 0, 1))) / 2.0;
    EXPECT_NEAR(delay, (2 * 50 + 300 + 260) / 2.0, 10.0) << i;
  }
}

TEST_F(ClockLineTest, PortTimesOfABranchGiveTheTrueDelays) {
  Wiring wiring(4);
  wiring.connect_master(MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 3}, {1, 0}, 100ns);
  wiring.connect({0, 1}, {2, 0}, 200ns);
  wiring.connect({2, 1}, {3, 0}, 400ns);
  LineOptions options;
  options.delays = {320ns, 280ns};
  std::vector<ClockOptions> clocks(4);
  for (std::size_t i = 0; i < 4; ++i) clocks[i].start = nanoseconds{static_cast<std::int64_t>(i) * 1'000'000'007};
  build_clocks(clocks, options, std::move(wiring));
  latch();
  EXPECT_NEAR(between(0, 0, 3), 320 + 2 * 100 + 320, 10.0) << "to slave 1 and back";
  EXPECT_NEAR(between(0, 3, 1), 280 + 2 * 200 + 320 + 2 * 400 + 320 + 280, 10.0) << "to slaves 2 and 3 and back";
  EXPECT_NEAR(between(2, 0, 1), 320 + 2 * 400 + 320, 10.0);
}

TEST_F(ClockLineTest, ASlaveWithoutAClockInBetweenOnlyAddsItsDelay) {
  std::vector<ClockOptions> clocks(3);
  LineOptions options;
  options.delays = {300ns, 300ns};
  options.cable_delay = 100ns;
  without_clock = 1;
  build_clocks(clocks, options);
  latch();
  EXPECT_EQ(port_time(1, 0), 0U);
  EXPECT_NEAR(between(0, 0, 1), 300 + 4 * 100 + 3 * 300, 10.0);
}

TEST_F(ClockLineTest, AFramePassesEverySlaveLaterByTheTrueDelay) {
  LineOptions options;
  options.delays = {300ns, 260ns};
  options.cable_delay = 50ns;
  build_clocks(std::vector<ClockOptions>(3), options);
  latch();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(peek(i, reg::kReceiveTimeProcessingUnit) - peek(0, reg::kReceiveTimeProcessingUnit), i * 350U);
  }
}

TEST_F(ClockLineTest, TheSync0OfAllSlavesIsOnePulseInTrueTime) {
  constexpr std::size_t kSlaves = 8;
  constexpr nanoseconds kCycle = 125us;
  LineOptions options;
  options.delays = {300ns, 260ns};
  options.cable_delay = 50ns;
  std::vector<ClockOptions> clocks(kSlaves);
  Random random(11);
  for (std::size_t i = 0; i < kSlaves; ++i) {
    clocks[i].start = nanoseconds{random() % 1'000'000'000};
    clocks[i].drift_ppm = static_cast<double>(random() % 4001) / 10.0 - 200.0;
    clocks[i].receive_jitter = 10ns;
    clocks[i].temperature_ppm_per_s = 1.0;
    clocks[i].temperature_span_ppm = 5.0;
    clocks[i].seed = i;
  }
  build_clocks(clocks, options);
  // True delays and offsets, which a master would measure.
  for (std::size_t i = 0; i < kSlaves; ++i) {
    set(i, reg::kSystemTimeDelay, static_cast<std::uint32_t>(350 * i));
    const auto now = clock().now();
    auto& own = line().slave(i).esc().clock();
    const auto offset = line().slave(0).esc().clock().system_time(now) - own.local_time(now);
    set(i, reg::kSystemTimeOffset, static_cast<std::uint64_t>(offset.count()));
  }
  for (int i = 0; i < 8000; ++i) compensate(kCycle);
  const auto reference = line().slave(0).esc().clock().system_time(clock().now());
  const auto start = static_cast<std::uint64_t>((reference / kCycle + 10) * kCycle.count());
  for (std::size_t i = 0; i < kSlaves; ++i) {
    set(i, reg::kStartTimeCyclic, start);
    set(i, reg::kSync0CycleTime, static_cast<std::uint32_t>(kCycle.count()));
    set(i, reg::kDcActivation, 3);
  }
  for (int i = 0; i < 100; ++i) compensate(kCycle);
  double worst = 0.0;
  for (int i = 0; i < 8000; ++i) {
    compensate(kCycle);
    const auto& first = line().slave(0).esc().clock();
    for (std::size_t s = 1; s < kSlaves; ++s) {
      const auto& other = line().slave(s).esc().clock();
      // At this very moment a pulse may have reached one of them and not the other.
      const auto apart = static_cast<double>((*other.last_sync0() - *first.last_sync0()).count());
      worst = std::max(worst, std::abs(std::remainder(apart, static_cast<double>(kCycle.count()))));
    }
  }
  EXPECT_LE(worst, 40.0) << "ns";
  EXPECT_GT(line().slave(7).esc().clock().sync0_count(), 8000U);
}

}  // namespace
}  // namespace driveline::slaves::test
