#pragma once

#include <cstdint>

namespace driveline::slaves {

/// A positive fraction of whole numbers, kept in lowest terms: conversions by it are exact to the last increment
/// however far the axis has travelled.
class Ratio {
 public:
  /// Holds the product of two 64-bit factors.
  using Wide = unsigned __int128;

  constexpr Ratio() noexcept = default;
  /// numerator / divisor; zeros count as 1. Terms that do not fit in 63 bits after reduction are halved until they do,
  /// which no factor group of practical size needs. \rtsafe
  [[nodiscard]] static Ratio of(Wide numerator, Wide divisor) noexcept;

  /// value * numerator / divisor, rounded to the nearest whole number, halves away from zero; limited to 64 bits.
  /// \rtsafe
  [[nodiscard]] std::int64_t apply(std::int64_t value) const noexcept;
  /// \rtsafe
  [[nodiscard]] Ratio inverse() const noexcept;
  /// The fraction as a floating-point number, for values that need not be exact. \rtsafe
  [[nodiscard]] double value() const noexcept {
    return static_cast<double>(numerator_) / static_cast<double>(divisor_);
  }
  /// Above 0, in lowest terms. \rtsafe
  [[nodiscard]] std::int64_t numerator() const noexcept { return numerator_; }
  /// Above 0, in lowest terms. \rtsafe
  [[nodiscard]] std::int64_t divisor() const noexcept { return divisor_; }

 private:
  Ratio(std::int64_t numerator, std::int64_t divisor) noexcept;

  std::int64_t numerator_ = 1;
  std::int64_t divisor_ = 1;
  std::int64_t short_way_ = INT64_MAX - 1;  ///< up to here 64 bits are enough for the product
};

/// The range in which an axis counts (607Bh), and the directions in which a rotary table may turn (60F2h).
class PositionRange {
 public:
  /// Ways to an absolute target, numbers as in bits 7 and 6 of 60F2h (MSD manual Table 14.8).
  enum class Direction : std::uint8_t { kLinear = 0, kNegative = 1, kPositive = 2, kShortest = 3 };

  /// All 32 bits.
  constexpr PositionRange() noexcept = default;
  /// From `minimum` to `maximum` and then on with `minimum`; the 32-bit range unless minimum < maximum. \rtsafe
  PositionRange(std::int32_t minimum, std::int32_t maximum) noexcept;

  /// Whether the range is smaller than 32 bits, so that wrap() is more than a truncation. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return size_ != kFullSize; }
  /// The position as it is shown. \rtsafe
  [[nodiscard]] std::int32_t wrap(std::int64_t position) const noexcept;
  /// The unwrapped position to move to from `position` (not wrapped) to reach the shown position `target`. Of two ways
  /// of the same length the shortest way takes the positive one. \rtsafe
  [[nodiscard]] std::int64_t destination(std::int64_t position, std::int32_t target,
                                         Direction direction) const noexcept;

 private:
  static constexpr std::int64_t kFullSize = std::int64_t{1} << 32;
  [[nodiscard]] std::int64_t positive_way(std::int64_t from, std::int64_t to) const noexcept;

  std::int64_t minimum_ = INT32_MIN;
  std::int64_t size_ = kFullSize;
};

}  // namespace driveline::slaves
