#pragma once

#include <cstdint>

namespace driveline::slaves {

/// A positive fraction of whole numbers in lowest terms; its conversions are exact to the last increment, no matter how
/// far the axis has travelled.
class Ratio {
 public:
  /// Integer that can hold the product of two 64-bit factors.
  using Wide = unsigned __int128;

  constexpr Ratio() noexcept = default;
  /// Returns numerator / divisor; zeros count as 1. Terms that do not fit in 63 bits after reduction are halved until
  /// they do, which no factor group of practical size needs. \rtsafe
  [[nodiscard]] static Ratio of(Wide numerator, Wide divisor) noexcept;

  /// Returns value * numerator / divisor, rounded, halves away from zero; limited to 64 bits. \rtsafe
  [[nodiscard]] std::int64_t apply(std::int64_t value) const noexcept {
    return numerator_ == divisor_ ? value : multiplied(value);
  }
  /// \rtsafe
  [[nodiscard]] Ratio inverse() const noexcept;
  /// Returns the fraction as a floating-point number, for values that need not be exact. \rtsafe
  [[nodiscard]] double value() const noexcept {
    return static_cast<double>(numerator_) / static_cast<double>(divisor_);
  }
  /// Returns the numerator, above 0, in lowest terms. \rtsafe
  [[nodiscard]] std::int64_t numerator() const noexcept { return numerator_; }
  /// Returns the divisor, above 0, in lowest terms. \rtsafe
  [[nodiscard]] std::int64_t divisor() const noexcept { return divisor_; }

 private:
  Ratio(std::int64_t numerator, std::int64_t divisor) noexcept;
  [[nodiscard]] std::int64_t multiplied(std::int64_t value) const noexcept;

  std::int64_t numerator_ = 1;
  std::int64_t divisor_ = 1;
  std::int64_t short_way_ = INT64_MAX - 1;  ///< largest magnitude for which 64 bits hold the product
};

/// Position range of an axis (607Bh), with the permitted directions of a rotary table (60F2h).
class PositionRangeLimit {
 public:
  /// Direction to an absolute target, numbered as in bits 7 and 6 of 60F2h (MSD manual Table 14.8).
  enum class Direction : std::uint8_t { kLinear = 0, kNegative = 1, kPositive = 2, kShortest = 3 };

  /// Creates the full 32-bit range.
  constexpr PositionRangeLimit() noexcept = default;
  /// Creates the range `minimum` to `maximum`, which wraps around; 32-bit range unless minimum < maximum. \rtsafe
  PositionRangeLimit(std::int32_t minimum, std::int32_t maximum) noexcept;

  /// Whether the range is smaller than 32 bits, so that wrap() does more than truncate. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return size_ != kFullSize; }
  /// Returns the displayed position, within the range. \rtsafe
  [[nodiscard]] std::int32_t wrap(std::int64_t position) const noexcept {
    return static_cast<std::int32_t>(minimum_ + positive_distance(minimum_, position));
  }
  /// Returns the unwrapped destination of a movement from `position` (not wrapped) to the displayed position `target`.
  /// kShortest prefers the positive direction when both distances are equal. \rtsafe
  [[nodiscard]] std::int64_t destination(std::int64_t position, std::int32_t target,
                                         Direction direction) const noexcept;
  /// Returns destination() by the shortest way, which every cyclic setpoint takes. \rtsafe
  [[nodiscard]] std::int64_t nearest(std::int64_t position, std::int32_t target) const noexcept {
    const std::int64_t up = positive_distance(position, target);
    return position + (up <= size_ - up ? up : up - size_);
  }

 private:
  static constexpr std::int64_t kFullSize = std::int64_t{1} << 32;
  /// Returns the distance between two positions in positive direction, less than the range.
  [[nodiscard]] std::int64_t positive_distance(std::int64_t from, std::int64_t to) const noexcept {
    const std::int64_t way = to - from;
    if (way >= 0 && way < size_) return way;  // usual case: saves the division
    const std::int64_t rest = way % size_;
    return rest < 0 ? rest + size_ : rest;
  }

  std::int64_t minimum_ = INT32_MIN;
  std::int64_t size_ = kFullSize;
};

}  // namespace driveline::slaves
