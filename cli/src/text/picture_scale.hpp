#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::cli {

/// Values from `low` to `high`; none if `high` is below `low`.
struct ValueRange {
  double low = 1.0;
  double high = 0.0;

  [[nodiscard]] bool empty() const noexcept { return high < low; }
  [[nodiscard]] double size() const noexcept { return high - low; }
  /// Extends the range to `value`; NaN and infinities are ignored.
  void include(double value) noexcept;
};

/// One axis of a panel: its range, and its ticks at multiples of a round step.
struct PictureScale {
  double low = -1.0;
  double high = 1.0;
  double step = 1.0;  ///< distance between ticks: 1, 2 or 5 times a power of ten
  int power = 0;      ///< the labels are in units of ten to this power, a multiple of 3, so that they stay short

  /// A value as the labels show it.
  [[nodiscard]] double labelled(double value) const;
  /// The unit of the labels: "rad", "1e-6 rad".
  [[nodiscard]] std::string unit(std::string_view name) const;
};

/// Returns the scale of `values` with a margin on either side, and about `intervals` intervals between ticks.
/// `resolution`: least step of the values, in their unit: a value that does not change has one step on either side;
/// 0: unknown.
[[nodiscard]] PictureScale scale_of(const ValueRange& values, double resolution = 0.0, int intervals = 5);

/// Returns the ranges of the columns of a CSV file, without its first line. Fields that are no numbers are ignored; a
/// file that cannot be read has no columns.
[[nodiscard]] std::vector<ValueRange> column_ranges(const std::filesystem::path& file);

}  // namespace driveline::cli
