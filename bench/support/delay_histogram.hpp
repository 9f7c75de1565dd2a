#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "driveline/rt/histogram.hpp"
#include "support/samples.hpp"

namespace driveline::bench {

/// A whole distribution of delays in 150 KiB, however many there are: none is left out, the largest is exact, and
/// percentiles are within 0.8 % (rt::Histogram). For pictures each delay is counted twice more: in its microsecond, and
/// in a bin whose width is a part of its decade.
class DelayHistogram {
 public:
  /// Bins of each decade.
  static constexpr int kPerDecade = 20;

  /// A delay of `deadline_us` or more is a period that was missed; 0: there is none.
  explicit DelayHistogram(double deadline_us = 0.0);

  /// Counts a delay, from 0. \rtsafe
  void add(std::chrono::nanoseconds delay) noexcept;
  /// Counts the delay of an event and those of the instants that were missed before it, each by its own time: `late` is
  /// from the first of `missed` + 1 instants. As rt::record_lateness(), but its magnitude. \rtsafe
  void add_late(std::chrono::nanoseconds late, std::int64_t missed, std::chrono::nanoseconds period) noexcept;
  void merge(const DelayHistogram& other) noexcept;
  /// Forgets everything. \rtsafe
  void reset() noexcept;

  [[nodiscard]] Summary summary() const;
  [[nodiscard]] std::uint64_t count() const noexcept { return fine_.count(); }
  [[nodiscard]] double deadline_us() const noexcept { return deadline_us_; }
  /// Delays of at least deadline_us().
  [[nodiscard]] std::uint64_t missed() const noexcept { return missed_; }

  /// First microsecond of a bin and count, of those that are not empty. A bin is a microsecond, from 10.24 ms on a 64th
  /// to a 32nd of what it holds.
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::uint64_t>> microseconds() const;
  /// Number of a bin and count, of those that are not empty: bin k holds delays of 10^(k/20) ns to 10^((k+1)/20) ns.
  /// Shorter ones than resolved_from() are in none of them.
  [[nodiscard]] std::vector<std::pair<int, std::uint64_t>> decades() const;
  /// The first bin of decades(): what is shorter is below what two readings of the clock can tell apart.
  [[nodiscard]] static int resolved_from();
  /// Delays shorter than bin resolved_from().
  [[nodiscard]] std::uint64_t unresolved() const;

 private:
  static constexpr std::size_t kMicroseconds = 10'240;  ///< that have a bin each
  static constexpr std::size_t kMicrosecondOctaves = 27;
  static constexpr std::size_t kPerOctave = 32;
  static constexpr std::size_t kDecadeBins = 12 * kPerDecade;

  double deadline_us_;
  std::uint64_t missed_ = 0;
  rt::Histogram fine_;
  std::vector<std::uint64_t> microseconds_;  ///< then those of kPerOctave each octave
  std::array<std::uint64_t, kDecadeBins> decades_{};
};

}  // namespace driveline::bench
