#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>

namespace driveline::trajectory {

/// Largest magnitude of numerator and denominator.
inline constexpr std::int64_t kMaxGearNumber = std::int64_t{1} << 31;

/// Two numbers that are not a valid gear ratio.
struct GearError {
  std::int64_t numerator = 0;    ///< numerator as given
  std::int64_t denominator = 0;  ///< denominator as given

  /// The error as one sentence.
  [[nodiscard]] std::string message() const;
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const GearError& error) {
  return error.message();
}

/// Ratio of an electronic gear: the slave moves numerator / denominator times as far as the master, two integers, or by
/// the distances of of_travel(), such as 10 mm for each 360 deg of the master. A plain value.
///
/// Both forms of travel() start from the total displacement of the master, so no error accumulates from cycle to cycle:
/// the slave follows the ratio exactly after any number of turns.
class GearRatio {
 public:
  /// Whole increments and the remaining fraction.
  struct Increments {
    std::int64_t whole = 0;      ///< whole increments, rounded down
    std::int64_t remainder = 0;  ///< fraction in 1 / denominator() of an increment, 0 to denominator() - 1

    /// \rtsafe
    friend bool operator==(const Increments&, const Increments&) noexcept = default;
  };

  /// The ratio 1 : 1.
  GearRatio() = default;
  /// Reduces the ratio to lowest terms. Error: one of the numbers is zero, or beyond +-kMaxGearNumber.
  [[nodiscard]] static tl::expected<GearRatio, GearError> make(std::int64_t numerator, std::int64_t denominator);

  /// Ratio of two distances, which may have different kinds: the slave moves by `slave` while the master moves by
  /// `master`, rad or m. None: a distance is zero or not finite, or the ratio or its inverse is beyond kMaxGearNumber.
  [[nodiscard]] static std::optional<GearRatio> of_travel(double slave, double master);

  /// Numerator, with the sign of the ratio; 1 for a ratio of_travel(). \rtsafe
  [[nodiscard]] std::int64_t numerator() const noexcept { return numerator_; }
  /// Denominator, positive; 1 for a ratio of_travel(). \rtsafe
  [[nodiscard]] std::int64_t denominator() const noexcept { return denominator_; }
  /// The ratio as the nearest floating-point number. \rtsafe
  [[nodiscard]] double factor() const noexcept {
    return static_cast<double>(numerator_) * slave_ / (static_cast<double>(denominator_) * master_);
  }
  /// Displacement of the slave for a displacement of the master, rad or m; relative error within 3e-16, of a ratio
  /// of_travel() within 4e-16. \rtsafe
  [[nodiscard]] double travel(double master) const noexcept;
  /// Exact displacement of the slave in increments, for whole increments of the master; for a ratio of two integers.
  /// The result must fit into 63 bits. \rtsafe
  [[nodiscard]] Increments travel(std::int64_t master) const noexcept;

 private:
  GearRatio(std::int64_t numerator, std::int64_t denominator) noexcept
      : numerator_(numerator), denominator_(denominator) {}

  std::int64_t numerator_ = 1;
  std::int64_t denominator_ = 1;
  double slave_ = 1.0;   ///< distance of the slave, rad or m; 1 for a ratio of two integers
  double master_ = 1.0;  ///< distance of the master in that time, positive
};

}  // namespace driveline::trajectory
