#include "driveline/rt/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <ostream>
#include <random>
#include <string>
#include <vector>

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

TEST(Histogram, EmptyReportsZeros) {
  const Histogram histogram;
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.percentile(0.5), 0ns);
  EXPECT_EQ(histogram.min(), 0ns);
  EXPECT_EQ(histogram.max(), 0ns);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
  histogram.for_each_bucket([](const Histogram::Bucket&) { FAIL() << "there is no value"; });
}

TEST(Histogram, EveryValueFallsIntoABucketThatHoldsItAndIsNarrow) {
  for (std::int64_t value = 0; value <= 1'000'000'000; value += 1 + value / 700) {
    Histogram histogram;
    histogram.record(nanoseconds{value});
    int buckets = 0;
    histogram.for_each_bucket([&](const Histogram::Bucket& bucket) {
      ++buckets;
      EXPECT_LE(bucket.lower.count(), value);
      EXPECT_GT(bucket.upper.count(), value);
      EXPECT_LE((bucket.upper - bucket.lower).count(), std::max<std::int64_t>(1, bucket.lower.count() / 64));
      EXPECT_EQ(bucket.count, 1u);
    });
    ASSERT_EQ(buckets, 1) << value;
  }
}

TEST(Histogram, BucketsFollowEachOtherWithoutGap) {
  Histogram histogram;
  for (std::int64_t value = 0; value <= 1'000'000'000; value += 1 + value / 200) {
    histogram.record(nanoseconds{value});
  }
  nanoseconds expected = 0ns;
  std::uint64_t total = 0;
  histogram.for_each_bucket([&](const Histogram::Bucket& bucket) {
    EXPECT_EQ(bucket.lower, expected);
    expected = bucket.upper;
    total += bucket.count;
  });
  EXPECT_GT(expected, 1s);
  EXPECT_EQ(total, histogram.count());
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram histogram;
  for (int value = 1; value <= 100; ++value) {
    histogram.record(nanoseconds{value});
  }
  EXPECT_EQ(histogram.percentile(0.0), 1ns);
  EXPECT_EQ(histogram.percentile(0.01), 1ns);
  EXPECT_EQ(histogram.percentile(0.5), 50ns);
  EXPECT_EQ(histogram.percentile(0.501), 51ns);
  EXPECT_EQ(histogram.percentile(0.99), 99ns);
  EXPECT_EQ(histogram.percentile(1.0), 100ns);
  EXPECT_DOUBLE_EQ(histogram.mean_ns(), 50.5);
}

TEST(Histogram, ValuesOutsideAreClampedAndCountedButExtremesStayExact) {
  Histogram histogram;
  histogram.record(-5ns);
  histogram.record(0ns);
  histogram.record(1s);
  histogram.record(1s + 1ns);
  histogram.record(1h);
  EXPECT_EQ(histogram.underflows(), 1u);
  EXPECT_EQ(histogram.overflows(), 2u);
  EXPECT_EQ(histogram.count(), 5u);
  EXPECT_EQ(histogram.min(), -5ns);
  EXPECT_EQ(histogram.max(), 1h);
  EXPECT_EQ(histogram.percentile(0.0), -5ns);
  EXPECT_EQ(histogram.percentile(1.0), 1h);
  EXPECT_EQ(histogram.percentile(0.3), 0ns);
  EXPECT_NEAR(static_cast<double>(histogram.percentile(0.9).count()), 1e9, 1e7);
}

TEST(Histogram, ExtremeInputsAreSafe) {
  Histogram histogram;
  histogram.record(nanoseconds::min());
  histogram.record(nanoseconds::max());
  EXPECT_EQ(histogram.min(), nanoseconds::min());
  EXPECT_EQ(histogram.max(), nanoseconds::max());
  EXPECT_NEAR(histogram.mean_ns(), 0.0, 1024.0);
  EXPECT_EQ(histogram.percentile(-1.0), nanoseconds::min());
  EXPECT_EQ(histogram.percentile(2.0), nanoseconds::max());
  EXPECT_EQ(histogram.percentile(std::nan("")), nanoseconds::min());
}

TEST(Histogram, MergeIsLikeRecordingEverythingInOne) {
  Histogram first;
  Histogram second;
  Histogram both;
  std::mt19937_64 random{7};
  std::uniform_int_distribution<std::int64_t> value_ns{-10, 2'000'000'000};
  for (int i = 0; i < 10'000; ++i) {
    const nanoseconds value{value_ns(random)};
    (i % 3 == 0 ? first : second).record(value);
    both.record(value);
  }
  first.merge(second);
  first.merge(Histogram{});
  EXPECT_EQ(first.count(), both.count());
  EXPECT_EQ(first.underflows(), both.underflows());
  EXPECT_EQ(first.overflows(), both.overflows());
  EXPECT_EQ(first.min(), both.min());
  EXPECT_EQ(first.max(), both.max());
  EXPECT_NEAR(first.mean_ns(), both.mean_ns(), 1e-3);
  for (int percent = 0; percent <= 100; ++percent) {
    EXPECT_EQ(first.percentile(percent / 100.0), both.percentile(percent / 100.0));
  }
  Histogram empty;
  empty.merge(both);
  EXPECT_EQ(empty.min(), both.min());
}

TEST(Histogram, ResetForgetsEverything) {
  Histogram histogram;
  histogram.record(2s);
  histogram.reset();
  histogram.record(50ns);
  EXPECT_EQ(histogram.count(), 1u);
  EXPECT_EQ(histogram.overflows(), 0u);
  EXPECT_EQ(histogram.max(), 50ns);
  EXPECT_EQ(histogram.percentile(0.5), 50ns);
}

struct Distribution {
  std::string name;
  std::function<double(std::mt19937_64&)> draw_ns;

  friend std::ostream& operator<<(std::ostream& out, const Distribution& distribution) {
    return out << distribution.name;
  }
};

class HistogramPercentiles : public testing::TestWithParam<Distribution> {};

// Compared with the definition of a percentile, applied to the sorted values.
TEST_P(HistogramPercentiles, AreWithinOnePercentOfTheExactOnes) {
  for (const std::uint64_t seed : {1U, 22U, 333U}) {
    for (const std::size_t count : {1U, 2U, 10U, 1'000U, 50'000U}) {
      std::mt19937_64 random{seed};
      auto histogram = std::make_unique<Histogram>();
      std::vector<std::int64_t> exact;
      for (std::size_t i = 0; i < count; ++i) {
        exact.push_back(static_cast<std::int64_t>(std::clamp(GetParam().draw_ns(random), 1.0, 1e9)));
        histogram->record(nanoseconds{exact.back()});
      }
      std::sort(exact.begin(), exact.end());
      for (int step = 0; step <= 1024; ++step) {
        const double q = step / 1024.0;  // binary fractions: the rank has no rounding error
        const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(count)));
        const auto expected = static_cast<double>(exact[std::max<std::size_t>(rank, 1) - 1]);
        const auto found = static_cast<double>(histogram->percentile(q).count());
        ASSERT_LE(std::abs(found - expected), 0.01 * expected) << "seed " << seed << ", n " << count << ", q " << q;
      }
      ASSERT_EQ(histogram->min().count(), exact.front());
      ASSERT_EQ(histogram->max().count(), exact.back());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Distributions, HistogramPercentiles,
    testing::Values(Distribution{"uniform",
                                 [](auto& r) {
                                   return std::uniform_real_distribution<>{1.0, 1e9}(r);
                                 }},
                    Distribution{"small",
                                 [](auto& r) {
                                   return std::uniform_real_distribution<>{1.0, 300.0}(r);
                                 }},
                    Distribution{"log_uniform",
                                 [](auto& r) {
                                   return std::exp(std::uniform_real_distribution<>{0.0, 20.7}(r));
                                 }},
                    Distribution{"exponential",
                                 [](auto& r) { return std::exponential_distribution<>{1.0 / 30'000.0}(r); }},
                    Distribution{"log_normal",
                                 [](auto& r) {
                                   return std::lognormal_distribution<>{9.0, 2.0}(r);
                                 }},
                    Distribution{"two_peaks",
                                 [](auto& r) {
                                   const bool rare = std::bernoulli_distribution{0.001}(r);
                                   return std::normal_distribution<>{rare ? 5e6 : 2'000.0, 100.0}(r);
                                 }},
                    Distribution{"powers_of_two",
                                 [](auto& r) {
                                   return std::exp2(std::uniform_int_distribution<>{0, 29}(r));
                                 }}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace driveline::rt
