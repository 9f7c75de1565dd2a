#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/record/run_report.hpp"
#include "text/picture_scale.hpp"

namespace driveline::cli {

/// An event, drawn as a vertical line in the pictures of the axes.
struct PlotMark {
  double time_s = 0.0;  ///< time in operation
  bool missed = false;  ///< the master was away: periods without a cycle
  std::string text{};   ///< sentence below the picture; not shown for missed periods
};

/// The gnuplot scripts of the pictures of the axes. Their data are the columns of axes.csv.
class AxisPlots {
 public:
  /// `ranges`: ranges of the columns of axes.csv; marks before the first row are left out. `increments`: adds
  /// a second axis in drive increments to each panel.
  AxisPlots(std::vector<runtime::AxisRunReport> axes, bool increments, const std::vector<PlotMark>& marks,
            std::vector<ValueRange> ranges);

  /// Draws positions.png: commanded position, demand of the drive and actual position, and the following error below.
  [[nodiscard]] std::string positions() const;
  /// Draws following_error.png.
  [[nodiscard]] std::string errors() const;

 private:
  [[nodiscard]] std::string head(std::size_t panels_per_axis, std::string_view output, std::string_view title) const;
  [[nodiscard]] bool is_before_picture(const PlotMark& mark) const;
  [[nodiscard]] std::string marks() const;
  [[nodiscard]] std::string position_panel(std::size_t axis) const;
  [[nodiscard]] std::string error_panel(std::size_t axis, bool by_drive) const;
  [[nodiscard]] std::string legend(std::size_t panels_per_axis, const std::string& entries) const;
  [[nodiscard]] PictureScale scale(std::size_t axis, const std::vector<std::size_t>& columns) const;
  [[nodiscard]] std::string vertical_axis(std::size_t axis, std::string_view quantity, const PictureScale& scale) const;
  [[nodiscard]] std::size_t rows(std::size_t panels_per_axis) const;
  [[nodiscard]] double height(std::size_t panels_per_axis) const;
  /// Whether no other axis is below `axis`.
  [[nodiscard]] bool is_last(std::size_t axis) const;

  std::vector<runtime::AxisRunReport> axes_;
  bool increments_;
  std::vector<PlotMark> missed_;
  std::vector<PlotMark> events_;  ///< all other marks; their numbers are their positions, from 1
  std::vector<ValueRange> ranges_;
};

}  // namespace driveline::cli
