#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace driveline::rt {

/// Histogram of durations from 0 to 1 s in 12.5 KiB of fixed memory: exact up to 127 ns, then 64 equal buckets per
/// octave, so that a bucket is at most 1/64 of its values wide and its middle is at most 0.8 % off any of them.
///
/// One writer. To read it from another thread, copy it while the writer is inactive.
class Histogram {
 public:
  /// Longer times are counted as overflows.
  static constexpr std::chrono::nanoseconds kLargest = std::chrono::seconds{1};

  /// A non-empty class of values: lower <= value < upper.
  struct Bucket {
    std::chrono::nanoseconds lower;  ///< smallest duration in the bucket
    std::chrono::nanoseconds upper;  ///< smallest duration of the next bucket
    std::uint64_t count;             ///< number of durations in the bucket
  };

  /// Counts `value` (`times` times, at least 1) in constant time. Values outside 0 .. 1 s go to the nearest bucket and
  /// also count as underflow or overflow; min(), max() and mean_ns() use the unclamped values. \rtsafe
  void record(std::chrono::nanoseconds value, std::uint64_t times = 1) noexcept;

  /// Returns the value that the fraction `quantile` (clamped to 0 .. 1) of all values does not exceed: the value of
  /// rank ceil(quantile * count), at least the first, within 0.8 %. 0 gives min() and 1 gives max(), exactly. Above 1 s
  /// only the maximum is known: a rank among the overflows returns 1 s or slightly more. 0 ns if empty.
  [[nodiscard]] std::chrono::nanoseconds percentile(double quantile) const noexcept;

  /// Number of recorded values, out-of-range values included. \rtsafe
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// Number of negative values; they also count in the first bucket. \rtsafe
  [[nodiscard]] std::uint64_t underflows() const noexcept { return underflows_; }
  /// Number of values above kLargest; they also count in the last bucket. \rtsafe
  [[nodiscard]] std::uint64_t overflows() const noexcept { return overflows_; }
  /// Smallest value, exact; 0 ns if empty.
  [[nodiscard]] std::chrono::nanoseconds min() const noexcept { return min_; }
  /// Largest value, exact; 0 ns if empty.
  [[nodiscard]] std::chrono::nanoseconds max() const noexcept { return max_; }
  /// Arithmetic mean in nanoseconds, computed from the exact values; 0 if empty.
  [[nodiscard]] double mean_ns() const noexcept;

  /// Adds all counts of `other`.
  void merge(const Histogram& other) noexcept;
  /// Clears all counts. \rtsafe
  void reset() noexcept { *this = Histogram{}; }

  /// Calls `visit(Bucket)` for every non-empty bucket in ascending order.
  template <typename Visitor>
  void for_each_bucket(Visitor&& visit) const {
    for (std::size_t i = 0; i < kBuckets; ++i) {
      if (counts_[i] != 0) {
        visit(Bucket{lower_bound(i), lower_bound(i + 1), counts_[i]});
      }
    }
  }

 private:
  static constexpr std::size_t kPerOctave = 64;

  // The bucket index uses the 7 leading bits of a value: below 128 the value itself, above, 64 .. 127 after shifting
  // right. The buckets of each shift start where those of the previous shift end, so the index is continuous.
  static constexpr std::size_t bucket_of(std::uint64_t value) noexcept {
    const auto width = static_cast<std::size_t>(std::bit_width(value));
    const std::size_t shift = width > 7 ? width - 7 : 0;
    return shift * kPerOctave + static_cast<std::size_t>(value >> shift);
  }
  static constexpr std::chrono::nanoseconds lower_bound(std::size_t bucket) noexcept {
    const std::size_t shift = bucket < 2 * kPerOctave ? 0 : bucket / kPerOctave - 1;
    return std::chrono::nanoseconds{static_cast<std::int64_t>(bucket - shift * kPerOctave) << shift};
  }
  // bucket_of(kLargest) + 1, spelled out because a class may not call its own functions before it is complete.
  static constexpr auto kLargestNs = static_cast<std::uint64_t>(kLargest.count());
  static constexpr auto kLargestShift = static_cast<std::size_t>(std::bit_width(kLargestNs)) - 7;
  static constexpr std::size_t kBuckets = kLargestShift * kPerOctave + (kLargestNs >> kLargestShift) + 1;

  std::array<std::uint64_t, kBuckets> counts_{};
  std::uint64_t count_ = 0;
  std::uint64_t underflows_ = 0;
  std::uint64_t overflows_ = 0;
  std::chrono::nanoseconds min_{};
  std::chrono::nanoseconds max_{};
  double sum_ns_ = 0.0;  // floating point: sums of extreme values cannot overflow
};

}  // namespace driveline::rt
