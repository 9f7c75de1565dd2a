#include "driveline/slaves/msd/core/fine_interpolator.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace driveline::slaves::msd {
namespace {

using Method = FineInterpolator::Method;
constexpr double kStep = 62.5e-6;
constexpr std::uint32_t kSteps = 8;
constexpr double kPeriod = kSteps * kStep;
constexpr std::array kSmooth = {Method::kLinear, Method::kSpline, Method::kApproximation};

FineInterpolator make_interpolator(Method method, double value = 0.0, double velocity = 0.0) {
  FineInterpolator f;
  f.configure(method, kSteps, kStep);
  f.reset(value, velocity);
  return f;
}

void run(FineInterpolator& f, std::uint32_t steps = kSteps) {
  for (std::uint32_t i = 0; i < steps; ++i) f.step();
}

TEST(FineInterpolator, NoneJumpsWithTheSample) {
  auto f = make_interpolator(Method::kNone);
  f.push(5.0);
  f.step();
  EXPECT_DOUBLE_EQ(f.value(), 5.0);
  EXPECT_DOUBLE_EQ(f.velocity(), 0.0);
}

TEST(FineInterpolator, LinearReachesTheSampleAfterOnePeriod) {
  auto f = make_interpolator(Method::kLinear, 1.0);
  f.push(9.0);
  for (std::uint32_t i = 1; i <= kSteps; ++i) {
    f.step();
    EXPECT_NEAR(f.value(), 1.0 + i, 1e-12);
    EXPECT_NEAR(f.velocity(), 8.0 / kPeriod, 1e-6);
    EXPECT_EQ(f.acceleration(), 0.0);
  }
}

TEST(FineInterpolator, ExternalPassesThroughSamplesWithTheirSpeeds) {
  auto f = make_interpolator(Method::kExternal);
  const std::array<std::pair<double, double>, 3> samples = {{{1.0, 500.0}, {2.0, -300.0}, {2.0, 0.0}}};
  for (const auto& [value, velocity] : samples) {
    f.push(value, velocity);
    run(f);
    EXPECT_NEAR(f.value(), value, 1e-12);
    EXPECT_NEAR(f.velocity(), velocity, 1e-8);
  }
}

TEST(FineInterpolator, CosineStandsStillAtEverySample) {
  auto f = make_interpolator(Method::kCosine, 1.0);
  for (const double sample : {3.0, -2.0, -2.0, 5.0}) {
    const double before = f.value();
    f.push(sample);
    run(f, kSteps / 2);
    EXPECT_NEAR(f.value(), 0.5 * (before + sample), 1e-12);
    EXPECT_NEAR(f.velocity(), 0.5 * (sample - before) * 3.14159265358979 / kPeriod, 1e-6);
    run(f, kSteps / 2);
    EXPECT_NEAR(f.value(), sample, 1e-12);
    EXPECT_NEAR(f.velocity(), 0.0, 1e-9);
  }
}

TEST(FineInterpolator, SplinePassesThroughTheSamplesTwoPeriodsLate) {
  auto f = make_interpolator(Method::kSpline);
  const std::array samples = {0.0, 1.0, 4.0, -2.0, 7.0, 7.0, 7.0};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    f.push(samples[i]);
    run(f);
    EXPECT_NEAR(f.value(), samples[i == 0 ? 0 : i - 1], 1e-12) << i;
  }
}

TEST(FineInterpolator, ApproximationIsTheUniformCubicBSpline) {
  auto f = make_interpolator(Method::kApproximation);
  const std::array p = {0.0, 0.0, 0.0, 3.0, -1.0, 2.0, 8.0};
  for (std::size_t k = 0; k < p.size(); ++k) {
    f.push(p[k]);
    for (std::uint32_t i = 1; i <= kSteps; ++i) {
      f.step();
      if (k < 3) continue;
      const double u = static_cast<double>(i) / kSteps;  // basis functions of the textbook
      const double expected = ((1 - u) * (1 - u) * (1 - u) * p[k - 3] + (3 * u * u * u - 6 * u * u + 4) * p[k - 2] +
                               (-3 * u * u * u + 3 * u * u + 3 * u + 1) * p[k - 1] + u * u * u * p[k]) /
                              6.0;
      ASSERT_NEAR(f.value(), expected, 1e-12);
    }
  }
}

TEST(FineInterpolator, ConstantSpeedIsReproducedExactly) {
  for (const auto method : kSmooth) {
    auto f = make_interpolator(method, 0.0, 2.0 / kPeriod);
    double last = 0.0;
    const double first = method == Method::kLinear ? 2.0 : 4.0;
    for (int k = 0; k < 20; ++k) {
      f.push(first + 2.0 * k);
      for (std::uint32_t i = 0; i < kSteps; ++i) {
        f.step();
        ASSERT_NEAR(f.value() - last, 2.0 / kSteps, 1e-12);
        ASSERT_NEAR(f.velocity(), 2.0 / kPeriod, 1e-7);
        last = f.value();
      }
    }
  }
}

TEST(FineInterpolator, VelocityIsTheDerivativeOfTheValue) {
  for (const auto method : {Method::kSpline, Method::kApproximation}) {
    auto f = make_interpolator(method);
    double before = 0.0;
    double speed_before = 0.0;
    for (int k = 0; k < 50; ++k) {
      f.push(std::sin(0.3 * k));
      for (std::uint32_t i = 0; i < kSteps; ++i) {
        f.step();
        // exact for a cubic: mean of the speeds, corrected by the change of acceleration, is about the difference
        ASSERT_NEAR((f.value() - before) / kStep, 0.5 * (f.velocity() + speed_before), 2.0 / kPeriod / kSteps);
        before = f.value();
        speed_before = f.velocity();
      }
    }
  }
}

TEST(FineInterpolator, LateSampleIsBridgedWithTheLastSpeedThenStops) {
  auto f = make_interpolator(Method::kLinear);
  f.push(8.0);
  run(f);
  run(f);
  EXPECT_NEAR(f.value(), 16.0, 1e-9);
  run(f, 100);
  EXPECT_NEAR(f.value(), 16.0, 1e-9);
  EXPECT_EQ(f.velocity(), 0.0);
}

TEST(FineInterpolator, MissingSamplesSlowItDownAtItsRate) {
  FineInterpolator f;
  f.configure(FineInterpolator::Method::kLinear, 2, 0.5);  // samples every second
  f.set_limits(1, 4.0);
  f.reset(0.0, 10.0);
  f.push(10.0);
  for (int i = 0; i < 4; ++i) f.step();  // the sample and a bridged period
  EXPECT_DOUBLE_EQ(f.value(), 20.0);
  EXPECT_DOUBLE_EQ(f.velocity(), 10.0);
  double expected = 20.0;
  for (const double speed : {8.0, 6.0, 4.0, 2.0, 0.0, 0.0}) {
    f.step();
    expected += 0.5 * speed;
    EXPECT_DOUBLE_EQ(f.velocity(), speed);
    EXPECT_DOUBLE_EQ(f.value(), expected);
  }
}

TEST(FineInterpolator, SamplesThatDoNotComeLeaveNoTraceAtConstantSpeed) {
  for (const auto method : kSmooth) {
    auto f = make_interpolator(method);
    f.set_limits(8, 100.0);
    f.reset(0.0, 1.0 / kPeriod);
    double last = 0.0;
    for (int k = 1; k < 100; ++k) {
      if (k % 12 < 4 || k < 5) f.push(method == Method::kLinear ? k : k + 1.0);
      for (std::uint32_t i = 0; i < kSteps; ++i) {
        f.step();
        ASSERT_NEAR(f.value() - last, 1.0 / kSteps, 1e-9) << "period " << k;
        ASSERT_NEAR(f.velocity(), 1.0 / kPeriod, 1e-6);
        last = f.value();
      }
    }
  }
}

/// Whatever happens to late samples, the output changes its speed within the limit.
TEST(FineInterpolator, PursuesACurveThatItCouldMeetOnlyByALeap) {
  constexpr double kRate = 1000.0;
  for (const auto method : kSmooth) {
    for (const double stays_behind : {0.0, 0.03, -0.05}) {
      auto f = make_interpolator(method);
      f.set_limits(8, kRate, 200.0);
      const double speed = 20.0;
      f.reset(0.0, speed);
      double sample = 0.0;
      const auto next = [&] { f.push(sample += speed * kPeriod); };
      for (int k = 0; k < 10; ++k, run(f)) next();
      run(f, 20 * kSteps);
      sample += stays_behind;  // of the distance that the samples would have covered
      double before = f.velocity();
      for (int k = 0; k < 800; ++k) {
        next();
        for (std::uint32_t i = 0; i < kSteps; ++i) {
          const double place = f.value();
          f.step();
          ASSERT_LE(std::abs(f.velocity() - before), 1.001 * kRate * kStep) << "sample " << k;
          ASSERT_NEAR(f.value() - place, f.velocity() * kStep, kRate * kStep * kStep) << "sample " << k;
          before = f.velocity();
        }
      }
      EXPECT_NEAR(f.value(), method == Method::kLinear ? sample : sample - speed * kPeriod, 1e-6);
    }
  }
}

/// After a gap the path continues differently than extrapolated: the axis without samples has slowed down meanwhile, as
/// its master knows, is slightly displaced, and accelerates at once.
TEST(FineInterpolator, GoesOverFromSamplesThatWereMadeUpWithoutAKink) {
  constexpr double kRate = 1000.0;
  constexpr int kBridged = 8;
  constexpr int kGapBegins = 20;
  constexpr double kMaxAcceleration = 1.25 * kRate;
  for (const auto method : kSmooth) {
    for (int gap = 1; gap < 24; ++gap) {
      for (int beside = -20; beside <= 20; ++beside) {
        SCOPED_TRACE(testing::Message() << "gap of " << gap << ", beside by " << beside);
        auto f = make_interpolator(method);
        f.set_limits(kBridged, kRate, 200.0);
        double speed = 20.0;
        f.reset(0.0, speed);
        double sample = 0.0;
        std::array<double, 60> output{};
        for (int k = 0; k < 60; ++k, run(f)) {
          if (k >= kGapBegins + kBridged && k < kGapBegins + gap) speed -= kRate * kPeriod;
          if (k >= kGapBegins + gap) speed -= 0.9 * kRate * kPeriod;
          sample += speed * kPeriod;
          if (k < kGapBegins) f.push(sample);
          if (k >= kGapBegins + gap) f.push(sample + 2e-5 * beside);
          output[static_cast<std::size_t>(k)] = f.value();
        }
        // Differences over two periods each, from where samples have led the output.
        for (std::size_t k = 14; k < output.size(); ++k) {
          const double change = output[k] - 2.0 * output[k - 2] + output[k - 4];
          ASSERT_LE(std::abs(change), kMaxAcceleration * 4.0 * kPeriod * kPeriod) << "sample " << k;
        }
      }
    }
  }
}

TEST(FineInterpolator, EarlyAndLateSamplesCauseNoJump) {
  for (const auto method : kSmooth) {
    auto f = make_interpolator(method);
    double last = 0.0;
    for (int k = 1; k < 400; ++k) {
      f.push(k);  // one unit per period, arriving up to three steps early or late
      const auto steps = kSteps + static_cast<std::uint32_t>(k * 7 % 7) - 3U;
      for (std::uint32_t i = 0; i < steps; ++i) {
        f.step();
        ASSERT_LT(std::abs(f.value() - last), 3.0 / kSteps);
        last = f.value();
      }
      ASSERT_NEAR(f.value(), k, 3.0);
    }
  }
}

/// Frames that arrive close to the sampling instant: just after it for a long time, so that all appear to be in time,
/// and occasionally just before it. Such a sample overwrites the previous one, and none arrives in the next period.
TEST(FineInterpolator, SamplesThatAreWrittenOverAreNoLeap) {
  constexpr int kSpeed = 130;
  constexpr int kRate = 2500;
  constexpr std::uint16_t kBridged = 8;
  for (const auto method : kSmooth) {
    for (const std::uint32_t steps : {4U, 8U, 16U}) {
      for (int late = 1; late <= 3; ++late) {
        SCOPED_TRACE(testing::Message() << steps << " steps, " << late << " periods late");
        const double period = steps * kStep;
        FineInterpolator f;
        f.configure(method, steps, kStep);
        f.set_limits(kBridged, kRate, 600.0);
        f.reset(0.0, kSpeed);
        int taken = -1;
        double speed = kSpeed;
        for (int now = 0; now < 5000; ++now) {
          // Each 997th one is on time.
          const int newest = now < 20 || now % 997 == 0 ? now : std::max(taken, now - late);
          if (newest > taken) f.push((newest + f.periods_ahead()) * kSpeed * period);
          taken = newest;
          for (std::uint32_t step = 0; step < steps; ++step) {
            f.step();
            ASSERT_LE(std::abs(f.velocity() - speed), 1.001 * kRate * kStep) << "period " << now;
            speed = f.velocity();
          }
          const double ideal = (now + 1) * kSpeed * period;
          ASSERT_NEAR(f.value(), ideal, (late + 0.5) * kSpeed * period) << "period " << now;
        }
      }
    }
  }
}

/// Motion commanded by the controller is followed as it is: steps, and accelerations up to twice the rate limit.
TEST(FineInterpolator, SamplesOnTimeAreFollowedHoweverTheyLeap) {
  constexpr double kRate = 2500.0;
  auto f = make_interpolator(Method::kLinear);
  f.set_limits(8, kRate);
  const auto follows = [&f](double sample) {
    f.push(sample);
    run(f);
    EXPECT_NEAR(f.value(), sample, 1e-12);
  };
  for (const double sample : {0.0, 0.1, 0.3, 0.6, 1.0, 1.25, 1.5, 1.5, 2.0, 2.0, 2.0}) follows(sample);
  for (const double share : {0.5, 1.0, 1.4, 2.0}) {
    double sample = 2.0;
    f.reset(sample, 0.0);
    double rise = 0.0;
    for (int i = 0; i < 30; ++i) {
      rise += share * kRate * kPeriod * kPeriod;
      sample += rise;
      follows(sample);
    }
  }
}

TEST(FineInterpolator, ReconfigurationKeepsTheOutput) {
  auto f = make_interpolator(Method::kLinear);
  f.push(8.0);
  run(f, 4);
  f.configure(Method::kSpline, 2, kStep);
  EXPECT_NEAR(f.value(), 4.0, 1e-12);
  f.step();
  EXPECT_NEAR(f.value(), 4.0 + 1.0, 1e-9);  // continues with its speed
  f.configure(Method::kSpline, 0, kStep);   // zero steps count as one
  f.push(5.0);
  f.step();
  EXPECT_TRUE(std::isfinite(f.value()));
}

// At 2 ms; the SYNC of the fifth sample is held up by a frame for two control cycles. A period that is as much longer
// would have 9 % more speed.
TEST(FineInterpolator, JitterOfTheBusDoesNotChangeTheSpeed) {
  constexpr std::uint32_t kLong = 32;
  constexpr double kSpeed = 50.0;
  constexpr double kRise = kSpeed * kLong * kStep;
  for (const auto method : {Method::kLinear, Method::kSpline}) {
    FineInterpolator f;
    f.set_limits(8, 1000.0);
    f.configure(method, kLong, kStep);
    f.reset(0.0, kSpeed);
    double sample = f.periods_ahead() * kRise;
    for (int n = 0; n < 12; ++n, sample += kRise) {
      const std::uint32_t late = n == 5 ? 2 : 0;
      for (std::uint32_t i = 0; i < late; ++i) f.step();
      f.push(sample);
      for (std::uint32_t i = late; i < kLong; ++i) {
        f.step();
        ASSERT_NEAR(f.velocity(), kSpeed, 1e-6) << static_cast<int>(method) << ", sample " << n << ", cycle " << i;
      }
    }
  }
}

// A controller that uses all of the rate limit behind a sample that was missing, with targets that are whole
// increments, from constant speed and from a weak braking, with which the extrapolated sample is not exact: nothing
// pursues the curve at its own rate, which would stay behind.
TEST(FineInterpolator, AllOfTheRateLimitIsNoLeap) {
  constexpr std::uint32_t kLong = 32;
  constexpr double kRate = 1000.0;
  constexpr double kLongPeriod = kLong * kStep;
  constexpr double kIncrement = 6.283185307179586 / 1048576.0;
  for (const double braking : {0.0, 16.0}) {
    for (int part = 0; part < 16; ++part) {
      SCOPED_TRACE(testing::Message() << part << "/16 of an increment, braking with " << braking);
      const auto position = [part, braking](int n) {
        const double weak = std::min(n - 7, 0) * kLongPeriod;
        const double strong = std::max(n - 7, 0) * kLongPeriod;
        const double exact = 20.0 * n * kLongPeriod - 0.5 * braking * weak * weak + 0.5 * kRate * strong * strong;
        return std::round(exact / kIncrement + part / 16.0) * kIncrement;
      };
      FineInterpolator f;
      f.set_limits(8, kRate);
      f.configure(Method::kSpline, kLong, kStep);
      f.reset(position(0), 20.0);
      FineInterpolator all = f;
      for (int n = 0; n < 24; ++n) {
        all.push(position(n + 2));
        if (n != 5) f.push(position(n + 2));  // the last one before the acceleration
        run(f, kLong);
        run(all, kLong);
      }
      EXPECT_NEAR(f.value(), all.value(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
