#include "support/delay_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

/// Bin of a number of microseconds, with the five bits after the leading one as resolution; bins are contiguous, as in
/// rt::Histogram.
constexpr std::size_t octave_bin(std::uint64_t us) noexcept {
  const auto shift = static_cast<std::size_t>(std::bit_width(us)) - 6;
  return shift * 32 + static_cast<std::size_t>(us >> shift);
}

/// The first microsecond of such a bin.
constexpr std::int64_t first_of_octave_bin(std::size_t bin) noexcept {
  const std::size_t shift = bin / 32 - 1;
  return static_cast<std::int64_t>((bin - shift * 32) << shift);
}

}  // namespace

DelayHistogram::DelayHistogram(double deadline_us)
    : deadline_us_(deadline_us), microseconds_(kMicroseconds + kMicrosecondOctaves * kPerOctave) {}

void DelayHistogram::add(std::chrono::nanoseconds delay) noexcept {
  fine_.record(delay);
  const auto ns = static_cast<std::uint64_t>(std::max<std::int64_t>(0, delay.count()));
  const auto us = ns / 1000;
  if (deadline_us_ > 0.0 && static_cast<double>(us) >= deadline_us_) ++missed_;
  const auto bin = us < kMicroseconds ? us : kMicroseconds + octave_bin(us) - octave_bin(kMicroseconds);
  ++microseconds_[std::min<std::size_t>(bin, microseconds_.size() - 1)];
  const auto decade = ns == 0 ? 0.0 : std::floor(kPerDecade * std::log10(static_cast<double>(ns)));
  ++decades_[std::min(static_cast<std::size_t>(decade), kDecadeBins - 1)];
}

void DelayHistogram::add_late(std::chrono::nanoseconds late, std::int64_t missed,
                              std::chrono::nanoseconds period) noexcept {
  for (auto before = std::int64_t{0}; before <= missed; ++before) add(std::chrono::abs(late - before * period));
}

void DelayHistogram::merge(const DelayHistogram& other) noexcept {
  fine_.merge(other.fine_);
  missed_ += other.missed_;
  std::transform(microseconds_.begin(), microseconds_.end(), other.microseconds_.begin(), microseconds_.begin(),
                 std::plus<>{});
  std::transform(decades_.begin(), decades_.end(), other.decades_.begin(), decades_.begin(), std::plus<>{});
}

void DelayHistogram::reset() noexcept {
  fine_.reset();
  missed_ = 0;
  std::fill(microseconds_.begin(), microseconds_.end(), 0);
  decades_.fill(0);
}

Summary DelayHistogram::summary() const {
  const auto at = [this](double share) { return static_cast<double>(fine_.percentile(share).count()); };
  return {static_cast<std::size_t>(fine_.count()), at(0.5), at(0.99), at(0.999), at(1.0)};
}

std::vector<std::pair<std::int64_t, std::uint64_t>> DelayHistogram::microseconds() const {
  std::vector<std::pair<std::int64_t, std::uint64_t>> bins;
  for (std::size_t i = 0; i < microseconds_.size(); ++i) {
    if (microseconds_[i] == 0) continue;
    const auto us = i < kMicroseconds ? static_cast<std::int64_t>(i)
                                      : first_of_octave_bin(i - kMicroseconds + octave_bin(kMicroseconds));
    bins.emplace_back(us, microseconds_[i]);
  }
  return bins;
}

int DelayHistogram::resolved_from() {
  static const int kFirst = static_cast<int>(std::ceil(kPerDecade * std::log10(std::max(1.0, reading_cost_ns()))));
  return kFirst;
}

std::uint64_t DelayHistogram::unresolved() const {
  std::uint64_t sum = 0;
  for (int bin = 0; bin < resolved_from(); ++bin) sum += decades_[static_cast<std::size_t>(bin)];
  return sum;
}

std::vector<std::pair<int, std::uint64_t>> DelayHistogram::decades() const {
  std::vector<std::pair<int, std::uint64_t>> bins;
  for (auto bin = static_cast<std::size_t>(resolved_from()); bin < kDecadeBins; ++bin) {
    if (decades_[bin] > 0) bins.emplace_back(static_cast<int>(bin), decades_[bin]);
  }
  return bins;
}

}  // namespace driveline::bench
