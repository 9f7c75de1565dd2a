#include "driveline/trajectory/gear_ratio.hpp"

#include <cmath>
#include <numeric>

namespace driveline::trajectory {
namespace {

bool is_gear_number(std::int64_t number) {
  return number >= -kMaxGearNumber && number <= kMaxGearNumber;
}

}  // namespace

std::string GearError::message() const {
  const std::string what = "a gear ratio of " + std::to_string(numerator) + " : " + std::to_string(denominator) +
                           " is not possible: both numbers must be ";
  return what + (numerator == 0 || denominator == 0 ? "other than 0" : "within +-2147483648");
}

tl::expected<GearRatio, GearError> GearRatio::make(std::int64_t numerator, std::int64_t denominator) {
  const bool zero = numerator == 0 || denominator == 0;
  if (zero || !is_gear_number(numerator) || !is_gear_number(denominator))
    return tl::unexpected(GearError{numerator, denominator});
  const std::int64_t common = std::gcd(numerator, denominator) * (denominator < 0 ? -1 : 1);
  return GearRatio(numerator / common, denominator / common);
}

std::optional<GearRatio> GearRatio::of_travel(double slave, double master) {
  constexpr auto kMost = static_cast<double>(kMaxGearNumber);
  const double factor = std::abs(slave / master);
  // A zero or a value that is not finite makes the factor 0, infinite or NaN.
  if (!std::isfinite(slave) || !(factor >= 1.0 / kMost && factor <= kMost)) return std::nullopt;
  GearRatio ratio;
  ratio.slave_ = master < 0.0 ? -slave : slave;
  ratio.master_ = std::abs(master);
  return ratio;
}

double GearRatio::travel(double master) const noexcept {
  // One of the two pairs is 1 : 1, so only two operations round.
  return master * static_cast<double>(numerator_) * slave_ / (static_cast<double>(denominator_) * master_);
}

/// Split into whole turns of the denominator and a remainder, whose product is below 2^62.
GearRatio::Increments GearRatio::travel(std::int64_t master) const noexcept {
  std::int64_t turns = master / denominator_;
  std::int64_t rest = master % denominator_;
  if (rest < 0) {
    rest += denominator_;
    --turns;
  }
  const std::int64_t product = rest * numerator_;
  std::int64_t whole = product / denominator_;
  std::int64_t remainder = product % denominator_;
  if (remainder < 0) {
    remainder += denominator_;
    --whole;
  }
  return {turns * numerator_ + whole, remainder};
}

}  // namespace driveline::trajectory
