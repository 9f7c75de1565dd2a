#include "text/plan_picture.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace driveline::cli {
namespace {

constexpr double kWidth = 760.0;
constexpr double kMargin = 20.0;

struct Range {
  double low = 0.0;
  double high = 0.0;

  [[nodiscard]] double size() const { return high - low; }
};

Range range_of(const PlannedMotion& motion, std::size_t coordinate) {
  Range range{motion.points.front().tool[coordinate], motion.points.front().tool[coordinate]};
  for (const auto& point : motion.points) {
    range.low = std::min(range.low, point.tool[coordinate]);
    range.high = std::max(range.high, point.tool[coordinate]);
  }
  return range;
}

/// A part of the picture: maps values to positions in it.
struct Box {
  double top;
  double height;
  Range x;
  Range y;
  double scale_x;
  double scale_y;

  Box(double box_top, double box_height, Range range_x, Range range_y, bool is_square)
      : top(box_top), height(box_height), x(range_x), y(range_y) {
    constexpr double kLeastRange = 1e-12;
    scale_x = kWidth / std::max(x.size(), kLeastRange);
    scale_y = height / std::max(y.size(), kLeastRange);
    if (is_square) scale_x = scale_y = std::min(scale_x, scale_y);
  }
  [[nodiscard]] std::pair<double, double> place(double at_x, double at_y) const {
    return {kMargin + (at_x - x.low) * scale_x, top + height - (at_y - y.low) * scale_y};
  }
  [[nodiscard]] std::string curve(const std::vector<std::pair<double, double>>& points) const {
    std::string text = "<polyline fill=\"none\" stroke=\"#1f5fa8\" points=\"";
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
    const double left = place(at_x, y.low).first;
    constexpr std::size_t kRows = 3;
    constexpr double kRow = 14.0;
    return fmt::format(
        "<line x1=\"{0:.2f}\" y1=\"{1:.2f}\" x2=\"{0:.2f}\" y2=\"{2:.2f}\" stroke=\"#c0392b\" "
        "stroke-dasharray=\"3 3\"/>\n<text x=\"{3:.2f}\" y=\"{4:.2f}\" font-size=\"11\" "
        "fill=\"#c0392b\">{5}</text>\n",
        left, top, top + height, left + 3.0, top + kRow * static_cast<double>(1 + number % kRows), word);
  }
};

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
  std::vector<std::pair<double, double>> way;
  std::vector<std::pair<double, double>> speed;
  const bool is_plane = file.coordinates.size() > 1;
  const auto [first, second] = is_plane ? plane_of(file, motion) : std::array<std::size_t, 2>{0, 0};
  Range speeds;
  for (const auto& point : motion.points) {
    way.emplace_back(is_plane ? point.tool[first] : point.time_s, point.tool[second]);
    speed.emplace_back(point.time_s, point.speed);
    speeds.low = std::min(speeds.low, point.speed);
    speeds.high = std::max(speeds.high, point.speed);
  }
  const Range times{0.0, motion.duration_s};
  const Box plane(30.0, 460.0, is_plane ? range_of(motion, first) : times, range_of(motion, second), is_plane);
  const Box over_time(530.0, 210.0, times, speeds, false);
  const auto& unit = *file.coordinates.front().unit;
  std::string text =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"760\" font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"800\" height=\"760\" fill=\"white\"/>\n" +
      fmt::format("<text x=\"20\" y=\"18\">{}</text>\n",
                  is_plane ? file.coordinates[first].name + " and " + file.coordinates[second].name
                           : file.coordinates[0].name) +
      plane.curve(way) +
      fmt::format("<text x=\"20\" y=\"520\">speed along the path, up to {:.4g} {}/s, over {:.4f} s</text>\n",
                  unit.from_si(speeds.high), unit.name, motion.duration_s) +
      over_time.curve(speed);
  constexpr std::size_t kMaxFlags = 60;
  for (std::size_t k = 0; k < std::min(motion.outputs.size(), kMaxFlags); ++k) {
    const auto& output = motion.outputs[k];
    text += plane.mark(is_plane ? output.tool[first] : output.time_s, output.tool[second]);
    text += over_time.flag(output.time_s,
                           fmt::format("{}={:g}", file.outputs[output.change.output], output.change.value), k);
  }
  return text + "</svg>\n";
}

}  // namespace driveline::cli
