// The frequency of the reference clock from frames, many of which were delayed.
#include "dc/mapping_fit.hpp"

#include <gtest/gtest.h>

#include <random>

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// Frames 300 us apart arrive at a clock that is `ppm` fast; `held_up` returns the delay of each.
template <typename HeldUp>
ClockMapping fitted(double ppm, std::size_t frames, HeldUp&& held_up) {
  const ClockMapping truth{seconds{1}, 5'000'000'000U, ppm};
  ClockMapping mapping{seconds{1}, 5'000'000'000U, 0.0};
  MappingFit fit;
  nanoseconds sent = seconds{1};
  for (std::size_t i = 0; i < frames; ++i, sent += microseconds{300}) {
    fit.add({sent, difference(truth.at(sent + held_up(i)), mapping.at(sent))});
  }
  fit.apply(mapping);
  const auto now = sent - microseconds{300};
  EXPECT_EQ(mapping.local, now);
  EXPECT_NEAR(static_cast<double>(difference(mapping.reference, truth.at(now)).count()), 0.0, 3000.0);
  return mapping;
}

TEST(MappingFit, WithoutDisturbanceTheSpeedIsExact) {
  for (const double ppm : {-480.0, -3.0, 0.0, 100.0}) {
    EXPECT_NEAR(fitted(ppm, 469, [](std::size_t) { return nanoseconds{0}; }).ppm, ppm, 0.01);
  }
}

/// As over virtual interfaces on a busy machine: a microsecond of noise, every fifth frame up to some ms late.
TEST(MappingFit, FramesThatWereHeldUpDoNotMoveIt) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> noise(1.0 / 800.0);
    std::exponential_distribution<double> stall(1.0 / 2e6);
    std::bernoulli_distribution held(0.2);
    const auto mapping = fitted(42.0, 469, [&](std::size_t) {
      return nanoseconds{std::llround(noise(random) + (held(random) ? stall(random) : 0.0))};
    });
    EXPECT_NEAR(mapping.ppm, 42.0, 3.0) << seed;
  }
}

/// Late frames at one end only would tilt a least-squares line the most.
TEST(MappingFit, NorDoesAMachineThatWasBusyAtTheStart) {
  for (const auto late : {microseconds{40}, microseconds{900}}) {
    const auto mapping =
        fitted(-20.0, 469, [late](std::size_t i) { return i < 100 ? nanoseconds{late} : nanoseconds{0}; });
    EXPECT_NEAR(mapping.ppm, -20.0, 0.5) << late.count();
  }
}

TEST(MappingFit, AFrameOrTwoAreEnoughToBeUsedAndTooFewToBeTrusted) {
  EXPECT_EQ(fitted(50.0, 1, [](std::size_t) { return nanoseconds{0}; }).ppm, 0.0);
  EXPECT_NEAR(fitted(50.0, 2, [](std::size_t) { return nanoseconds{0}; }).ppm, 50.0, 5.0);
  ClockMapping mapping{seconds{1}, 7, 3.0};
  MappingFit{}.apply(mapping);
  EXPECT_EQ(mapping.reference, 7U);
  EXPECT_EQ(mapping.ppm, 3.0);
}

TEST(MappingFit, BeyondWhatCanBeFollowedItStops) {
  EXPECT_EQ(fitted(2000.0, 100, [](std::size_t) { return nanoseconds{0}; }).ppm, 500.0);
}

}  // namespace
}  // namespace driveline::ecat_master::dc
