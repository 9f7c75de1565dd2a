#include "text/plan_picture.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "text/picture_scale.hpp"

namespace driveline::cli {
namespace {

// Sizes in pixels.
constexpr double kPictureWidth = 800.0;
constexpr double kPictureHeight = 790.0;
constexpr double kChartLeft = 64.0;    // ticks left of a chart
constexpr double kChartWidth = 716.0;  // of a chart
constexpr double kPlaneTop = 32.0;
constexpr double kPlaneHeight = 430.0;
constexpr double kSpeedTop = 540.0;
constexpr double kSpeedHeight = 200.0;

std::string text_at(double left, double down, std::string_view anchor, std::string_view text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", left, down, anchor, text);
}

std::string grid_line(double x1, double y1, double x2, double y2) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#dddddd\"/>\n", x1, y1, x2,
                     y2);
}

/// A chart in the picture: maps values to positions, and has a frame with ticks.
class Chart {
 public:
  /// `is_square`: both axes have the same scale.
  Chart(double top, double height, const ValueRange& x, const ValueRange& y, bool is_square)
      : top_(top), height_(height), x_(scale_of(x, 0.0, 8)), y_(scale_of(y)) {
    if (!is_square) return;
    const double unit = std::max((x_.high - x_.low) / kChartWidth, (y_.high - y_.low) / height_);
    widen(x_, unit * kChartWidth);
    widen(y_, unit * height_);
    x_.step = y_.step = std::max(x_.step, y_.step);
    x_.power = y_.power = std::max(x_.power, y_.power);
  }

  /// Frame, grid and ticks. The label of the upward axis is above it.
  [[nodiscard]] std::string frame(std::string_view x_label, std::string_view x_unit, std::string_view y_label,
                                  std::string_view y_unit) const {
    std::string text;
    for (const double value : ticks(x_)) {
      const double left = place(value, y_.low).first;
      text +=
          grid_line(left, top_, left, top_ + height_) + text_at(left, top_ + height_ + 16.0, "middle", tick(x_, value));
    }
    for (const double value : ticks(y_)) {
      const double down = place(x_.low, value).second;
      text += grid_line(kChartLeft, down, kChartLeft + kChartWidth, down) +
              text_at(kChartLeft - 6.0, down + 4.0, "end", tick(y_, value));
    }
    return text +
           fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#606060\"/>\n",
                       kChartLeft, top_, kChartWidth, height_) +
           text_at(kChartLeft + 0.5 * kChartWidth, top_ + height_ + 34.0, "middle",
                   fmt::format("{} in {}", x_label, x_.unit(x_unit))) +
           text_at(kChartLeft, top_ - 8.0, "start", fmt::format("{} in {}", y_label, y_.unit(y_unit)));
  }
  [[nodiscard]] std::string curve(const std::vector<std::pair<double, double>>& points) const {
    std::string text = "<polyline fill=\"none\" stroke=\"#1f5fa8\" stroke-width=\"1.3\" points=\"";
    for (const auto& [at_x, at_y] : points) {
      const auto [left, down] = place(at_x, at_y);
      text += fmt::format("{:.2f},{:.2f} ", left, down);
    }
    return text + "\"/>\n";
  }
  [[nodiscard]] std::string mark(double at_x, double at_y) const {
    const auto [left, down] = place(at_x, at_y);
    return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"4\" fill=\"#c0392b\"/>\n", left, down);
  }
  /// A vertical line with a word beside it, in one of three rows.
  [[nodiscard]] std::string flag(double at_x, const std::string& word, std::size_t number) const {
    const double left = place(at_x, y_.low).first;
    constexpr std::size_t kRows = 3;
    constexpr double kRow = 14.0;
    return fmt::format(
        "<line x1=\"{0:.2f}\" y1=\"{1:.2f}\" x2=\"{0:.2f}\" y2=\"{2:.2f}\" stroke=\"#c0392b\" "
        "stroke-dasharray=\"3 3\"/>\n<text x=\"{3:.2f}\" y=\"{4:.2f}\" font-size=\"11\" "
        "fill=\"#c0392b\">{5}</text>\n",
        left, top_, top_ + height_, left + 3.0, top_ + kRow * static_cast<double>(1 + number % kRows), word);
  }

 private:
  static void widen(PictureScale& scale, double range) {
    const double middle = 0.5 * (scale.low + scale.high);
    scale.low = middle - 0.5 * range;
    scale.high = middle + 0.5 * range;
  }
  /// Multiples of the step within the range.
  static std::vector<double> ticks(const PictureScale& scale) {
    std::vector<double> values;
    const auto last = static_cast<std::int64_t>(std::floor(scale.high / scale.step));
    for (auto k = static_cast<std::int64_t>(std::ceil(scale.low / scale.step)); k <= last; ++k) {
      values.push_back(static_cast<double>(k) * scale.step);
    }
    return values;
  }
  static std::string tick(const PictureScale& scale, double value) {
    return fmt::format("{:.6g}", scale.labelled(value));
  }
  [[nodiscard]] std::pair<double, double> place(double at_x, double at_y) const {
    return {kChartLeft + (at_x - x_.low) / (x_.high - x_.low) * kChartWidth,
            top_ + height_ - (at_y - y_.low) / (y_.high - y_.low) * height_};
  }

  double top_;
  double height_;
  PictureScale x_;
  PictureScale y_;
};

ValueRange range_of(const PlannedMotion& motion, std::size_t coordinate) {
  ValueRange range;
  for (const auto& point : motion.points) range.include(point.tool[coordinate]);
  return range;
}

/// The two coordinates of the same kind with the largest range, in their order.
std::array<std::size_t, 2> plane_of(const MoveFile& file, const PlannedMotion& motion) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < file.coordinates.size(); ++i) {
    if (file.coordinates[i].unit->kind == file.coordinates.front().unit->kind) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return range_of(motion, a).size() > range_of(motion, b).size();
  });
  if (order.size() < 2) return {0, 1};
  return {std::min(order[0], order[1]), std::max(order[0], order[1])};
}

}  // namespace

std::string picture_of(const MoveFile& file, const PlannedMotion& motion) {
  const bool is_plane = file.coordinates.size() > 1;
  const auto [first, second] = is_plane ? plane_of(file, motion) : std::array<std::size_t, 2>{0, 0};
  const auto& unit = *file.coordinates[second].unit;
  const auto& first_unit = *file.coordinates[first].unit;
  const bool is_square = is_plane && first_unit.kind == unit.kind;
  const auto& across_unit = is_square ? unit : first_unit;
  std::vector<std::pair<double, double>> path;
  std::vector<std::pair<double, double>> speed;
  ValueRange across;
  ValueRange up;
  ValueRange speeds{0.0, 0.0};
  const auto at = [&, x = first, y = second](double time_s, const trajectory::GroupVector& tool) {
    return std::pair{is_plane ? across_unit.from_si(tool[x]) : time_s, unit.from_si(tool[y])};
  };
  for (const auto& point : motion.points) {
    path.push_back(at(point.time_s, point.tool));
    across.include(path.back().first);
    up.include(path.back().second);
    speed.emplace_back(point.time_s, unit.from_si(point.speed));
    speeds.include(speed.back().second);
  }
  const Chart plane(kPlaneTop, kPlaneHeight, across, up, is_square);
  const Chart over_time(kSpeedTop, kSpeedHeight, {0.0, motion.duration_s}, speeds, false);
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" "
      "font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kPictureWidth, kPictureHeight);
  text += plane.frame(is_plane ? std::string_view(file.coordinates[first].name) : "time",
                      is_plane ? across_unit.name : "s", file.coordinates[second].name, unit.name) +
          plane.curve(path) + over_time.frame("time", "s", "speed along the path", fmt::format("{}/s", unit.name)) +
          over_time.curve(speed);
  constexpr std::size_t kMaxFlags = 60;
  for (std::size_t k = 0; k < std::min(motion.outputs.size(), kMaxFlags); ++k) {
    const auto& output = motion.outputs[k];
    const auto [x, y] = at(output.time_s, output.tool);
    text += plane.mark(x, y);
    text += over_time.flag(output.time_s,
                           fmt::format("{}={:g}", file.outputs[output.change.output], output.change.value), k);
  }
  return text + "</svg>\n";
}

}  // namespace driveline::cli
