#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "driveline/rt/histogram.hpp"
#include "support/samples.hpp"

namespace driveline::bench {

/// A complete distribution of delays in 150 KiB, for any number of them: none is omitted, the largest is exact, and
/// percentiles are within 0.8 % (rt::Histogram). For pictures each delay is also counted in a bin of its microsecond
/// and in a logarithmic bin.
class DelayHistogram {
 public:
  /// Logarithmic bins per decade.
  static constexpr int kPerDecade = 20;

  /// A delay of `deadline_us` or more is a missed period; 0: there is no deadline.
  explicit DelayHistogram(double deadline_us = 0.0);

  /// Counts a delay, from 0 on. \rtsafe
  void add(std::chrono::nanoseconds delay) noexcept;
  /// Counts the delay of an event and of the instants missed before it, each with its own time: `late` counts from the
  /// first of `missed` + 1 instants. Like rt::record_lateness(), but counts magnitudes. \rtsafe
  void add_late(std::chrono::nanoseconds late, std::int64_t missed, std::chrono::nanoseconds period) noexcept;
  void merge(const DelayHistogram& other) noexcept;
  /// Clears all counts. \rtsafe
  void reset() noexcept;

  [[nodiscard]] Summary summary() const;
  [[nodiscard]] std::uint64_t count() const noexcept { return fine_.count(); }
  [[nodiscard]] double deadline_us() const noexcept { return deadline_us_; }
  /// Number of delays of at least deadline_us().
  [[nodiscard]] std::uint64_t missed() const noexcept { return missed_; }

  /// First microsecond and count of the bins that are not empty. A bin is a microsecond wide; from 10.24 ms on, 1/64 to
  /// 1/32 of its value.
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::uint64_t>> microseconds() const;
  /// Number and count of the bins that are not empty: bin k contains delays of 10^(k/20) ns to 10^((k+1)/20) ns. Delays
  /// shorter than resolved_from() are in none of them.
  [[nodiscard]] std::vector<std::pair<int, std::uint64_t>> decades() const;
  /// The first bin of decades(): shorter delays are below the resolution of two readings of the clock.
  [[nodiscard]] static int resolved_from();
  /// Number of delays shorter than bin resolved_from().
  [[nodiscard]] std::uint64_t unresolved() const;

 private:
  static constexpr std::size_t kMicroseconds = 10'240;  ///< with a bin each
  static constexpr std::size_t kMicrosecondOctaves = 27;
  static constexpr std::size_t kPerOctave = 32;
  static constexpr std::size_t kDecadeBins = 12 * kPerDecade;

  double deadline_us_;
  std::uint64_t missed_ = 0;
  rt::Histogram fine_;
  std::vector<std::uint64_t> microseconds_;  ///< bins of a microsecond, then kPerOctave bins per octave
  std::array<std::uint64_t, kDecadeBins> decades_{};
};

}  // namespace driveline::bench
