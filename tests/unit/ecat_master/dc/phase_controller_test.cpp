// The phase controller in a closed loop with a model of the line: a frame leaves at the grid instant of the master's
// clock and arrives at a reference clock with another frequency.
//
//   e(k+1) = e(k) + reference's gain per period + shift(k)        e > 0: the frame arrived at the reference clock too
// late
#include "driveline/ecat_master/dc/phase_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "driveline/ecat_master/dc/system_time.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// Grid on the master's clock, reference clock beside it; knows the true error.
class Loop {
 public:
  explicit Loop(PhaseController::Settings settings, double ppm = 0.0, double error_ns = 0.0)
      : settings_(settings), controller_(settings), ppm_(ppm), error_(error_ns) {}

  /// One cycle with a measurement that is `noise` wrong; nothing: the frame was lost.
  nanoseconds cycle(std::optional<double> noise = 0.0) {
    std::optional<nanoseconds> measured;
    if (noise) measured = nanoseconds{std::llround(error_ + *noise)};
    const auto shift = controller_.update(measured);
    const auto period = static_cast<double>(settings_.period.count());
    error_ += (period + static_cast<double>(shift.count())) * (1.0 + ppm_ * 1e-6) - period;
    return shift;
  }
  /// The largest true error during `duration`.
  double run(
      nanoseconds duration, const std::function<std::optional<double>()>& noise = [] { return 0.0; }) {
    double largest = 0.0;
    for (nanoseconds t{0}; t < duration; t += settings_.period) {
      cycle(noise());
      largest = std::max(largest, std::abs(error_));
    }
    return largest;
  }
  nanoseconds time_to_lock(nanoseconds limit) {
    nanoseconds t{0};
    for (; t < limit && !controller_.locked(); t += settings_.period) cycle();
    return t;
  }

  PhaseController& controller() { return controller_; }
  void set_ppm(double ppm) { ppm_ = ppm; }
  void add_error(double ns) { error_ += ns; }
  [[nodiscard]] double error() const { return error_; }

 private:
  PhaseController::Settings settings_;
  PhaseController controller_;
  double ppm_;
  double error_;
};

PhaseController::Settings with_period(nanoseconds period) {
  PhaseController::Settings settings;
  settings.period = period;
  return settings;
}

const std::vector<nanoseconds> kPeriods = {microseconds{125}, microseconds{250}, milliseconds{1}, milliseconds{4},
                                           milliseconds{10}};

TEST(PhaseController, AFrameThatComesLateIsSentEarlier) {
  PhaseController late(with_period(microseconds{125}));
  EXPECT_LT(late.update(nanoseconds{1000}), nanoseconds{0});
  PhaseController early(with_period(microseconds{125}));
  EXPECT_GT(early.update(nanoseconds{-1000}), nanoseconds{0});
}

TEST(PhaseController, AReferenceClockThatRunsFastShortensTheCycle) {
  Loop loop(with_period(microseconds{125}), 100.0);
  loop.run(seconds{1});
  EXPECT_NEAR(loop.controller().ppm(), 100.0, 1.0);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) sum += static_cast<double>(loop.cycle().count());
  EXPECT_NEAR(sum / 1000.0, -0.0125 * 1000.0, 0.05);  // 100 ppm of 125 us
}

TEST(PhaseController, GainsAreThoseOfTheTable) {
  struct Row {
    nanoseconds period;
    double proportional;
    double integral;
  };
  for (const auto& row : {Row{microseconds{125}, 0.020, 0.0001}, Row{microseconds{250}, 0.020, 0.0001},
                          Row{milliseconds{1}, 0.063, 0.0010}, Row{milliseconds{4}, 0.251, 0.0158},
                          Row{milliseconds{10}, 0.500, 0.0625}}) {
    const PhaseController controller(with_period(row.period));
    EXPECT_NEAR(controller.proportional_gain(), row.proportional, 0.0005) << row.period.count();
    EXPECT_NEAR(controller.integral_gain(), row.integral, 0.00005) << row.period.count();
  }
}

TEST(PhaseController, LocksFromAnyPhaseAtEveryPeriod) {
  for (const auto period : kPeriods) {
    for (const double part : {-0.5, -0.1, 0.01, 0.3, 0.5}) {
      for (const double ppm : {-100.0, 0.0, 100.0}) {
        Loop loop(with_period(period), ppm, part * static_cast<double>(period.count()));
        const auto limit = std::max<nanoseconds>(seconds{1}, 500 * period);
        EXPECT_LT(loop.time_to_lock(limit), limit) << period.count() << " ns, " << part << ", " << ppm << " ppm";
        loop.run(std::max<nanoseconds>(seconds{1}, 200 * period));
        EXPECT_LT(std::abs(loop.error()), 30.0) << period.count() << " ns, " << part << ", " << ppm << " ppm";
      }
    }
  }
}

TEST(PhaseController, StepDecaysAsTheTableSaysWithoutOscillating) {
  for (const auto period : kPeriods) {
    Loop loop(with_period(period));
    loop.run(seconds{4});
    ASSERT_TRUE(loop.controller().locked());
    loop.add_error(-static_cast<double>(period.count()) / 200.0);
    double overshoot = 0.0;
    for (nanoseconds t{0}; t < milliseconds{250}; t += period) {
      loop.cycle();
      overshoot = std::max(overshoot, loop.error());
    }
    EXPECT_LT(std::abs(loop.error()), static_cast<double>(period.count()) / 200.0 * 0.02 + 2.0) << period.count();
    // A critically damped loop with an integrator passes zero once, by exp(-2) of the step; a little more where a cycle
    // is a long time.
    EXPECT_LT(overshoot, static_cast<double>(period.count()) / 200.0 * 0.18 + 2.0) << period.count();
    EXPECT_TRUE(loop.controller().locked());
  }
}

TEST(PhaseController, FollowsTheThermalDriftOfAnOscillator) {
  for (const auto period : kPeriods) {
    Loop loop(with_period(period));
    loop.run(seconds{5});
    double largest = 0.0;
    double ppm = 0.0;
    for (nanoseconds t{0}; t < seconds{20}; t += period) {
      ppm += static_cast<double>(period.count()) * 1e-9;  // 1 ppm/s
      loop.set_ppm(ppm);
      loop.cycle();
      if (t > seconds{3}) largest = std::max(largest, std::abs(loop.error()));
    }
    // A ramp of the frequency leaves a constant error of ramp * period / ki.
    const auto period_s = static_cast<double>(period.count()) * 1e-9;
    const double expected = 1e-6 * period_s * period_s / loop.controller().integral_gain() * 1e9;
    EXPECT_LT(largest, expected + 30.0) << period.count();
    EXPECT_TRUE(loop.controller().locked()) << period.count();
  }
}

TEST(PhaseController, NoiseOfTheMeasurementIsSmoothed) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 300.0);
  Loop loop(with_period(microseconds{125}), 50.0);
  loop.run(seconds{1}, [&] { return noise(random); });
  double square = 0.0;
  constexpr int kCycles = 40'000;
  for (int i = 0; i < kCycles; ++i) {
    loop.cycle(noise(random));
    square += loop.error() * loop.error();
  }
  // Noise bandwidth of the loop: about (kp + 2 ki / kp) / 2 of the noise power gets through.
  EXPECT_LT(std::sqrt(square / kCycles), 300.0 * 0.16);
  EXPECT_TRUE(loop.controller().locked());
}

/// Arrival times of frames on a busy machine: most are a little late, some a lot.
class CrowdedMachine {
 public:
  explicit CrowdedMachine(double mean_ns) : late_(1.0 / mean_ns), mean_ns_(mean_ns) {}
  double operator()() { return late_(random_) + (very_late_(random_) ? 8.0 * mean_ns_ : 0.0); }

 private:
  std::mt19937 random_{7};
  std::exponential_distribution<double> late_;
  std::bernoulli_distribution very_late_{0.01};
  double mean_ns_;
};

/// Standard deviation of the true error over four seconds.
double unrest_of_the_grid(Loop& loop, nanoseconds period, const std::function<double()>& noise) {
  const auto cycles = seconds{4} / period;
  double sum = 0.0;
  double square = 0.0;
  for (std::int64_t i = 0; i < cycles; ++i) {
    loop.cycle(noise());
    sum += loop.error();
    square += loop.error() * loop.error();
  }
  const double mean = sum / static_cast<double>(cycles);
  return std::sqrt(square / static_cast<double>(cycles) - mean * mean);
}

TEST(PhaseController, OnACrowdedMachineItLocksWithASmallerStepAndTheGridStaysQuiet) {
  for (const auto period : {microseconds{125}, microseconds{250}}) {
    for (const double mean_ns : {3e3, 6e3, 9e3}) {
      CrowdedMachine noise(mean_ns);
      Loop loop(with_period(period), 50.0);
      loop.controller().reset(50.0);
      const double step_when_quiet = loop.controller().proportional_gain();
      loop.run(seconds{2}, [&noise]() -> std::optional<double> { return noise(); });
      ASSERT_TRUE(loop.controller().locked()) << period.count() << " us, " << mean_ns << " ns";
      EXPECT_NEAR(loop.controller().noise_ns(), mean_ns, 0.4 * mean_ns);
      EXPECT_LE(loop.controller().proportional_gain(), step_when_quiet);
      EXPECT_LT(unrest_of_the_grid(loop, period, [&noise] { return noise(); }),
                static_cast<double>(nanoseconds{period}.count()) / 250.0)
          << period.count() << " us, " << mean_ns << " ns";
      EXPECT_TRUE(loop.controller().locked()) << period.count() << " us, " << mean_ns << " ns";
      EXPECT_NEAR(loop.controller().ppm(), 50.0, 20.0) << period.count() << " us, " << mean_ns << " ns";
    }
  }
}

/// Every other frame waits for a sleeping processor: neither kind is an outlier.
TEST(PhaseController, FramesOfTwoKindsAreBothUsual) {
  std::mt19937 random(5);
  std::bernoulli_distribution waits(0.5);
  const auto noise = [&]() -> std::optional<double> { return waits(random) ? 20e3 : 0.0; };
  Loop loop(with_period(microseconds{125}));
  loop.run(seconds{1}, noise);
  const auto outliers = loop.controller().outliers();
  loop.run(seconds{2}, noise);
  EXPECT_EQ(loop.controller().outliers(), outliers);
  EXPECT_TRUE(loop.controller().locked());
  EXPECT_NEAR(loop.controller().noise_ns(), 10e3, 3e3);
}

TEST(PhaseController, TheStepIsTheOldOneAgainWhenTheMachineIsQuiet) {
  CrowdedMachine noise(9e3);
  Loop loop(with_period(microseconds{125}), 20.0);
  const double step_when_quiet = loop.controller().proportional_gain();
  loop.run(seconds{2}, [&noise]() -> std::optional<double> { return noise(); });
  EXPECT_LT(loop.controller().proportional_gain(), step_when_quiet / 5.0);
  loop.run(milliseconds{500});
  EXPECT_DOUBLE_EQ(loop.controller().proportional_gain(), step_when_quiet);
  EXPECT_LT(std::abs(loop.error()), 30.0);
}

TEST(PhaseController, OneWildMeasurementMovesNothing) {
  Loop loop(with_period(microseconds{125}), 20.0);
  loop.run(seconds{1});
  const double before = loop.controller().ppm();
  for (const double wild : {5e3, -40e3, 60e3, -5e4}) {
    loop.cycle(wild);
    EXPECT_LT(loop.run(milliseconds{20}), 20.0) << wild;
  }
  EXPECT_EQ(loop.controller().outliers(), 4U);
  EXPECT_NEAR(loop.controller().ppm(), before, 0.5);
  EXPECT_TRUE(loop.controller().locked());
}

TEST(PhaseController, AStepThatStaysIsBelievedAndFollowed) {
  Loop loop(with_period(microseconds{125}));
  loop.run(seconds{1});
  loop.add_error(20e3);
  loop.run(milliseconds{500});
  EXPECT_LT(std::abs(loop.error()), 20.0);
  EXPECT_EQ(loop.controller().outliers(), 8U);
  EXPECT_TRUE(loop.controller().locked());
}

TEST(PhaseController, LostFramesAreBridgedOnTheLearnedFrequency) {
  Loop loop(with_period(microseconds{125}), -80.0);
  loop.run(seconds{1});
  EXPECT_LT(loop.run(milliseconds{40}, [] { return std::nullopt; }), 60.0);
  EXPECT_TRUE(loop.controller().locked());
  std::mt19937 random(2);
  std::bernoulli_distribution lost(0.3);
  EXPECT_LT(loop.run(seconds{2},
                     [&]() -> std::optional<double> {
                       if (lost(random)) return std::nullopt;
                       return 0.0;
                     }),
            60.0);
  EXPECT_TRUE(loop.controller().locked());
}

TEST(PhaseController, ASilentReferenceIsReportedAndFoundAgain) {
  Loop loop(with_period(microseconds{125}), 100.0);
  loop.run(seconds{1});
  loop.run(milliseconds{100}, [] { return std::nullopt; });
  EXPECT_FALSE(loop.controller().locked());
  EXPECT_EQ(loop.controller().cause(), PhaseController::Cause::kNoReference);
  // The grid has not drifted meanwhile.
  EXPECT_LT(std::abs(loop.error()), 150.0);
  EXPECT_LT(loop.time_to_lock(seconds{1}), milliseconds{100});
  EXPECT_EQ(loop.controller().cause(), PhaseController::Cause::kNone);
}

TEST(PhaseController, NothingEverHeardIsNoReference) {
  Loop loop(with_period(microseconds{125}));
  loop.run(milliseconds{100}, [] { return std::nullopt; });
  EXPECT_FALSE(loop.controller().locked());
  EXPECT_EQ(loop.controller().cause(), PhaseController::Cause::kNoReference);
  EXPECT_EQ(loop.controller().coasted(), 800U);
}

TEST(LockDetector, HasHysteresis) {
  const auto settings = LockDetector::Settings::for_period(microseconds{125});
  LockDetector lock(settings);
  auto feed = [&lock](double error, unsigned cycles) {
    for (unsigned i = 0; i < cycles; ++i) lock.update(error);
  };
  feed(2500.0, 1000);
  EXPECT_FALSE(lock.locked()) << "twice the window: nobody locks there";
  EXPECT_EQ(lock.cause(), LockCause::kAcquiring);
  feed(1000.0, 300);
  EXPECT_TRUE(lock.locked());
  feed(2500.0, 1000);
  EXPECT_TRUE(lock.locked()) << "twice the window: nobody loses the lock there";
  feed(6000.0, 200);
  EXPECT_FALSE(lock.locked());
  EXPECT_EQ(lock.cause(), LockCause::kPhaseError);
}

TEST(LockDetector, SmoothsNoisyMeasurementsForLonger) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 10e3);
  LockDetector told(LockDetector::Settings::for_period(microseconds{125}));
  LockDetector not_told(LockDetector::Settings::for_period(microseconds{125}));
  for (int i = 0; i < 8000; ++i) {
    const double error = noise(random);
    told.update(error, 10e3);
    not_told.update(error);
  }
  EXPECT_TRUE(told.locked());
  EXPECT_FALSE(not_told.locked());
  for (int i = 0; i < 4000; ++i) told.update(20e3 + noise(random), 10e3);
  EXPECT_FALSE(told.locked()) << "a real error is seen all the same";
}

TEST(LockDetector, AnExcursionStartsTheTimeToLockAnew) {
  LockDetector detector(LockDetector::Settings::for_period(microseconds{125}));  // 200 cycles within 1250 ns
  const auto feed = [&detector](int cycles, double error_ns) {
    for (int i = 0; i < cycles; ++i) detector.update(error_ns);
  };
  feed(150, 0.0);
  feed(40, 4000.0);
  feed(150, 0.0);
  EXPECT_FALSE(detector.locked());
  feed(100, 0.0);
  EXPECT_TRUE(detector.locked());
}

TEST(LockDetector, NeedsTimeNotOnlyCycles) {
  EXPECT_EQ(LockDetector::Settings::for_period(microseconds{125}).lock_cycles, 200U);
  EXPECT_EQ(LockDetector::Settings::for_period(milliseconds{1}).lock_cycles, 100U);
  EXPECT_EQ(LockDetector::Settings::for_period(milliseconds{10}).lock_cycles, 20U);
}

TEST(PhaseController, AClockThatCannotBeDisciplinedIsNamed) {
  for (const double ppm : {-700.0, 700.0}) {
    Loop loop(with_period(microseconds{125}), ppm);
    loop.run(seconds{3});
    EXPECT_LE(std::abs(loop.controller().ppm()), PhaseController::kMaxPpm);
    EXPECT_FALSE(loop.controller().locked());
    EXPECT_EQ(loop.controller().cause(), PhaseController::Cause::kFrequencyLimit);
  }
  Loop near(with_period(microseconds{125}), 480.0);
  near.run(seconds{3});
  EXPECT_TRUE(near.controller().locked());
  EXPECT_NEAR(near.controller().ppm(), 480.0, 2.0);
}

TEST(PhaseController, AKnownFrequencySavesTheStartUp) {
  Loop loop(with_period(milliseconds{10}), 90.0);
  loop.controller().reset(90.0);
  EXPECT_LT(loop.run(seconds{1}), 20.0);
}

/// The 32-bit system time of the reference clock as a frame brings it, from any start time on.
TEST(PhaseController, HoldsAcrossTheWrapAroundOfA32BitReferenceClock) {
  constexpr auto kCycle = microseconds{125};
  for (const std::uint64_t start : {std::uint64_t{0}, std::uint64_t{0x7FFF'FF00}, std::uint64_t{0xFFFF'0000},
                                    std::uint64_t{0x1234'5678'FFFF'FF00}, ~std::uint64_t{0} - 1'000'000}) {
    PhaseController controller(with_period(kCycle));
    double reference = 0.0;  // since start
    double grid = 0.0;       // master's clock
    std::uint64_t last = start;
    double largest = 0.0;
    const auto first = static_cast<double>(start % 125'000);
    for (int i = 0; i < 40'000; ++i) {  // 5 s
      reference = grid * (1.0 + 60e-6);
      const auto low = static_cast<std::uint32_t>(start + static_cast<std::uint64_t>(std::llround(reference)));
      const auto time = extend(low, last + 125'000);
      last = time;
      // Phase from the start of the reference clock on: it need not be a multiple of the cycle.
      const auto error = wrap_to_cycle(difference(time, start), kCycle);
      grid += 125'000.0 + static_cast<double>(controller.update(error).count());
      if (i > 8000) largest = std::max(largest, std::abs(static_cast<double>(error.count())));
    }
    EXPECT_TRUE(controller.locked()) << start << ' ' << first;
    EXPECT_LT(largest, 5.0) << start;
  }
}

TEST(SystemTime, ExtendsTheLowHalfAcrossBothEdges) {
  EXPECT_EQ(extend(0x0000'0005, 0x1'FFFF'FFF0), 0x2'0000'0005U);
  EXPECT_EQ(extend(0xFFFF'FFF0, 0x2'0000'0005), 0x1'FFFF'FFF0U);
  EXPECT_EQ(extend(0x8000'0001, 0x7'7FFF'FFFF), 0x7'8000'0001U);
  EXPECT_EQ(extend(0x7FFF'FFFF, 0x7'8000'0001), 0x7'7FFF'FFFFU);
  EXPECT_EQ(extend(0x0000'0001, ~std::uint64_t{0}), 1U);
  EXPECT_EQ(difference(5, ~std::uint64_t{0}), nanoseconds{6});
}

TEST(SystemTime, WrapsToHalfACycle) {
  EXPECT_EQ(wrap_to_cycle(nanoseconds{0}, microseconds{125}), nanoseconds{0});
  EXPECT_EQ(wrap_to_cycle(nanoseconds{62'500}, microseconds{125}), nanoseconds{62'500});
  EXPECT_EQ(wrap_to_cycle(nanoseconds{62'501}, microseconds{125}), nanoseconds{-62'499});
  EXPECT_EQ(wrap_to_cycle(nanoseconds{-1}, microseconds{125}), nanoseconds{-1});
  EXPECT_EQ(wrap_to_cycle(nanoseconds{-62'500}, microseconds{125}), nanoseconds{62'500});
  EXPECT_EQ(wrap_to_cycle(nanoseconds{-1'000'000'001}, microseconds{125}), nanoseconds{-1});
}

TEST(SystemTime, DifferenceRegisterIsSignAndMagnitude) {
  EXPECT_EQ(decode_difference(0x0000'0010), nanoseconds{16});
  EXPECT_EQ(decode_difference(0x8000'0010), nanoseconds{-16});
  EXPECT_EQ(decode_difference(0x8000'0000), nanoseconds{0});
}

TEST(SystemTime, MappingTellsWhenAFrameMeetsTheReferenceClock) {
  const ClockMapping mapping{seconds{10}, 0xFFFF'FFFF'FFFF'FF00U, 100.0};
  EXPECT_EQ(mapping.at(seconds{10}), 0xFFFF'FFFF'FFFF'FF00U);
  EXPECT_EQ(mapping.at(seconds{11}), 0xFFFF'FFFF'FFFF'FF00U + 1'000'100'000U);
  EXPECT_EQ(mapping.at(seconds{9}), 0xFFFF'FFFF'FFFF'FF00U - 1'000'100'000U);
}

}  // namespace
}  // namespace driveline::ecat_master::dc
