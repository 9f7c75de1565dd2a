#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

namespace driveline::trajectory {

/// Largest magnitude of the two numbers of a ratio.
inline constexpr std::int64_t kMaxGearNumber = std::int64_t{1} << 31;

/// Why two numbers are no ratio of a gear.
struct GearError {
  std::int64_t numerator = 0;    ///< as it was given
  std::int64_t denominator = 0;  ///< as it was given

  /// One sentence.
  [[nodiscard]] std::string message() const;
};

/// The ratio of an electronic gear, two whole numbers: the slave goes numerator / denominator as far as the master. A
/// plain value.
///
/// Both ways of applying it begin with the whole way of the master, so nothing adds up from cycle to cycle: after any
/// number of turns the slave is where the ratio has it.
class GearRatio {
 public:
  /// Whole increments and what is left of one.
  struct Increments {
    std::int64_t whole = 0;      ///< rounded down
    std::int64_t remainder = 0;  ///< in 1 / denominator() of an increment, 0 to denominator() - 1

    /// \rtsafe
    friend bool operator==(const Increments&, const Increments&) noexcept = default;
  };

  /// 1 : 1.
  GearRatio() = default;
  /// Reduced to lowest terms. Error: one of the numbers is zero, or beyond +-kMaxGearNumber.
  [[nodiscard]] static tl::expected<GearRatio, GearError> make(std::int64_t numerator, std::int64_t denominator);

  /// With the sign of the ratio. \rtsafe
  [[nodiscard]] std::int64_t numerator() const noexcept { return numerator_; }
  /// Positive. \rtsafe
  [[nodiscard]] std::int64_t denominator() const noexcept { return denominator_; }
  /// The nearest number. \rtsafe
  [[nodiscard]] double factor() const noexcept {
    return static_cast<double>(numerator_) / static_cast<double>(denominator_);
  }
  /// The way of the slave for one of the master, both in rad or m: within 3e-16 of it. \rtsafe
  [[nodiscard]] double travel(double master) const noexcept;
  /// The way of the slave in increments, exactly, for whole increments of the master. The result must be within 63
  /// bits. \rtsafe
  [[nodiscard]] Increments travel(std::int64_t master) const noexcept;

 private:
  GearRatio(std::int64_t numerator, std::int64_t denominator) noexcept
      : numerator_(numerator), denominator_(denominator) {}

  std::int64_t numerator_ = 1;
  std::int64_t denominator_ = 1;
};

}  // namespace driveline::trajectory
