#include "text/picture_scale.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <system_error>

namespace driveline::cli {
namespace {

/// Labels between these bounds are short without a power of ten.
constexpr double kLeastPlain = 0.01;
constexpr double kGreatestPlain = 1e5;
/// Least range of an axis as a share of its values: ticks of six digits still differ.
constexpr double kLeastShare = 1e-3;

/// Space between the greatest value and the frame, as a share of the range.
constexpr double kScaleMargin = 0.04;

double round_step(double raw) {
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  constexpr double kRounding = 1e-9;
  const double digit = raw / power - kRounding;
  return (digit <= 1.0 ? 1.0 : digit <= 2.0 ? 2.0 : digit <= 5.0 ? 5.0 : 10.0) * power;
}

int power_of(double magnitude) {
  if (magnitude >= kLeastPlain && magnitude < kGreatestPlain) return 0;
  return 3 * static_cast<int>(std::floor(std::log10(magnitude) / 3.0));
}

}  // namespace

void ValueRange::include(double value) noexcept {
  if (!std::isfinite(value)) return;
  const bool first = empty();
  low = first ? value : std::min(low, value);
  high = first ? value : std::max(high, value);
}

double PictureScale::labelled(double value) const {
  return value / std::pow(10.0, power);
}

std::string PictureScale::unit(std::string_view name) const {
  return power == 0 ? std::string(name) : fmt::format("1e{} {}", power, name);
}

PictureScale scale_of(const ValueRange& values, double resolution, int intervals) {
  if (values.empty()) return {};
  const double magnitude = std::max(std::abs(values.low), std::abs(values.high));
  const double span = std::max({values.size(), 2.0 * resolution, kLeastShare * magnitude});
  if (!(span > 0.0)) return {};
  const double middle = 0.5 * (values.low + values.high);
  PictureScale scale;
  scale.low = middle - (0.5 + kScaleMargin) * span;
  scale.high = middle + (0.5 + kScaleMargin) * span;
  scale.step = round_step(span / intervals);
  scale.power = power_of(std::max(magnitude, 0.5 * span));
  return scale;
}

std::vector<ValueRange> column_ranges(const std::filesystem::path& file) {
  std::vector<ValueRange> ranges;
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    const char* at = line.data();
    const char* const end = at + line.size();
    for (std::size_t column = 0; at < end; ++column) {
      if (column == ranges.size()) ranges.emplace_back();
      double value = 0.0;
      const auto [behind, error] = std::from_chars(at, end, value);
      if (error == std::errc{}) ranges[column].include(value);
      at = std::find(at, end, ',');
      if (at != end) ++at;
    }
  }
  return ranges;
}

}  // namespace driveline::cli
