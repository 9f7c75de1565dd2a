#pragma once

#include <array>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace driveline::rt {

/// Histogram of durations from 0 to 1 s in 12.5 KiB of fixed memory: exact up to 127 ns, then 64 equal buckets per
/// octave, so that a bucket is at most 1/64 of its values wide and its middle at most 0.8 % off any of them.
///
/// One writer; to look at it from another thread, copy it while the writer rests.
class Histogram {
 public:
  /// Longer times are counted as overflows.
  static constexpr std::chrono::nanoseconds kLargest = std::chrono::seconds{1};

  /// A non-empty class of values: lower <= value < upper.
  struct Bucket {
    std::chrono::nanoseconds lower;  ///< smallest time in it
    std::chrono::nanoseconds upper;  ///< smallest time of the next one
    std::uint64_t count;             ///< times that fell into it
  };

  /// Counts one value (or the same one `times`, at least 1), in constant time. Values outside 0 .. 1 s go to the
  /// nearest bucket and are counted as underflow or overflow as well; min(), max() and mean() take them as they are.
  /// \rtsafe
  void record(std::chrono::nanoseconds value, std::uint64_t times = 1) noexcept;

  /// The value that the fraction `quantile` (clamped to 0 .. 1) of all values does not exceed: the value of rank
  /// ceil(quantile * count), at least the first, within 0.8 %. 0 gives min(), 1 gives max(), exactly. Beyond 1 s only
  /// the maximum is known: a rank among the overflows reports 1 s or a little more. 0 ns if empty.
  [[nodiscard]] std::chrono::nanoseconds percentile(double quantile) const noexcept;

  /// Times recorded, those out of range included. \rtsafe
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// Negative times; they count in the first bucket as well. \rtsafe
  [[nodiscard]] std::uint64_t underflows() const noexcept { return underflows_; }
  /// Times above kLargest; they count in the last bucket as well. \rtsafe
  [[nodiscard]] std::uint64_t overflows() const noexcept { return overflows_; }
  /// Smallest value, exact; 0 ns if empty.
  [[nodiscard]] std::chrono::nanoseconds min() const noexcept { return min_; }
  /// Largest value, exact; 0 ns if empty.
  [[nodiscard]] std::chrono::nanoseconds max() const noexcept { return max_; }
  /// Arithmetic mean in nanoseconds, from the values themselves; 0 if empty.
  [[nodiscard]] double mean_ns() const noexcept;

  /// Adds everything `other` has counted.
  void merge(const Histogram& other) noexcept;
  /// Forgets everything. \rtsafe
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

  // A value keeps its 7 leading bits: below 128 that is the value itself, above, 64 .. 127 shifted right as often as
  // needed. Each shift starts where the one before ends, so the index is continuous.
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
  double sum_ns_ = 0.0;  // not an integer: sums of wild values cannot overflow
};

}  // namespace driveline::rt
