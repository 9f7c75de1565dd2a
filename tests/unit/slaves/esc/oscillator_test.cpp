// The oscillator of an emulated slave: its rate, its steps, its conversion from counts to true time.
#include "driveline/slaves/esc/oscillator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "random.hpp"

namespace driveline::slaves::test {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

ClockOptions with_drift(double ppm) {
  ClockOptions options;
  options.drift_ppm = ppm;
  return options;
}

TEST(Oscillator, CountsInStepsOfItsPeriodFromPowerOn) {
  Oscillator oscillator(ClockOptions{});
  oscillator.power_on(1003ns);
  EXPECT_EQ(oscillator.count(1003ns), 0);
  EXPECT_EQ(oscillator.count(1012ns), 0);
  EXPECT_EQ(oscillator.count(1013ns), 10);
  EXPECT_EQ(oscillator.count(1003ns + 1h), (1h / 1ns));
  EXPECT_EQ(oscillator.count(1002ns), -10) << "before power-on, too";
}

TEST(Oscillator, RunsTooFastOrTooSlowByItsDrift) {
  for (const double ppm : {-200.0, -0.1, 0.0, 37.5, 200.0}) {
    const Oscillator oscillator(with_drift(ppm));
    for (const nanoseconds time : {nanoseconds{1s}, nanoseconds{1h}, nanoseconds{24h * 365}}) {
      const double expected = static_cast<double>(time.count()) * ppm * 1e-6;
      const auto gained = static_cast<double>(oscillator.count(time) - time.count());
      EXPECT_NEAR(gained, expected, 11.0) << ppm << " ppm";
    }
  }
}

TEST(Oscillator, KnowsWhenACountIsReached) {
  Random random(7);
  for (const double ppm : {-200.0, 0.0, 200.0}) {
    auto options = with_drift(ppm);
    options.temperature_ppm_per_s = 1.0;
    options.temperature_span_ppm = 20.0;
    Oscillator oscillator(options);
    oscillator.power_on(12345ns);
    for (int i = 0; i < 2000; ++i) {
      const std::int64_t count = static_cast<std::int64_t>(random()) * 1000 + random() % 1000;
      const auto time = oscillator.time_of(count);
      ASSERT_GE(oscillator.count(time), count);
      ASSERT_LT(oscillator.count(time - 1ns), count) << "and not a nanosecond earlier";
    }
  }
}

TEST(Oscillator, NoCountIsTooFar) {
  constexpr auto kFarthest = std::numeric_limits<std::int64_t>::max();
  for (const double ppm : {-500.0, 0.0, 500.0}) {
    Oscillator oscillator(with_drift(ppm));
    oscillator.power_on(1h);
    const auto far = oscillator.time_of(Oscillator::kReach);
    EXPECT_GE(oscillator.count(far), Oscillator::kReach) << ppm;
    EXPECT_LT(oscillator.count(far - 1ns), Oscillator::kReach) << ppm;
    EXPECT_EQ(oscillator.time_of(kFarthest), far);
    EXPECT_EQ(oscillator.time_of(-kFarthest - 1), oscillator.time_of(-Oscillator::kReach));
  }
}

TEST(Oscillator, WandersWithTemperatureWithinItsSpanAndSpeed) {
  ClockOptions options;
  options.drift_ppm = 10.0;
  options.temperature_ppm_per_s = 1.0;
  options.temperature_span_ppm = 5.0;
  options.seed = 42;
  const Oscillator oscillator(options);
  double lowest = 1e9;
  double highest = -1e9;
  double before = oscillator.rate_error_ppm(0s);
  for (int i = 1; i <= 400; ++i) {
    const nanoseconds time = i * 100ms;
    const double rate = oscillator.rate_error_ppm(time);
    EXPECT_LE(std::abs(rate - before), 0.1 + 1e-9) << "1 ppm/s";
    // The count is the integral of the rate.
    const auto gained = static_cast<double>(oscillator.count(time) - oscillator.count(time - 100ms) - 100'000'000);
    EXPECT_NEAR(gained, 100.0 * (rate + before) / 2.0, 12.0);
    lowest = std::min(lowest, rate);
    highest = std::max(highest, rate);
    before = rate;
  }
  EXPECT_NEAR(lowest, 5.0, 0.11);
  EXPECT_NEAR(highest, 15.0, 0.11);
}

TEST(Oscillator, TheSeedDecidesWhereTheTemperatureBegins) {
  ClockOptions options;
  options.temperature_ppm_per_s = 1.0;
  options.temperature_span_ppm = 5.0;
  options.seed = 1;
  const Oscillator one(options);
  const Oscillator same(options);
  options.seed = 2;
  const Oscillator other(options);
  EXPECT_EQ(one.count(10s), same.count(10s));
  EXPECT_NE(one.count(10s), other.count(10s));
}

}  // namespace
}  // namespace driveline::slaves::test
