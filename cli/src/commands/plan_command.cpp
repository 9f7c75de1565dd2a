#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <deque>
#include <fstream>
#include <memory>
#include <sstream>

#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/trajectory/contour_follower.hpp"
#include "driveline/trajectory/contour_planner.hpp"
#include "text/json_text.hpp"
#include "text/move_file.hpp"
#include "text/plan_samples.hpp"

namespace driveline::cli {
namespace {

using trajectory::GroupVector;

struct PlanOptions {
  std::string file;
  std::optional<std::string> share;
  std::optional<std::string> picture;
  std::optional<std::string> samples;
  bool json = false;
};

/// What the axes were asked for, by differences of their positions.
struct PlannedMotion {
  double duration_s = 0.0;
  double length = 0.0;
  std::array<GroupVector, 3> largest{};                ///< velocity, acceleration, jerk
  std::vector<std::pair<GroupVector, double>> points;  ///< place and speed, for the picture
};

/// Collects them cycle by cycle.
class MotionMeter {
 public:
  explicit MotionMeter(double period_s) : period_s_(period_s) {}

  void take(const trajectory::ContourSetpoint& setpoint) {
    last_.push_front(setpoint.position);
    if (last_.size() > 4) last_.pop_back();
    motion_.duration_s += period_s_;
    motion_.length = std::max(motion_.length, setpoint.length);
    constexpr std::size_t kCyclesPerPoint = 16;
    if (count_++ % kCyclesPerPoint == 0) motion_.points.emplace_back(setpoint.position, setpoint.speed);
    for (std::size_t i = 0; last_.size() == 4 && i < trajectory::kMaxGroupAxes; ++i) {
      const double first = last_[0][i] - last_[1][i];
      const double second = first - (last_[1][i] - last_[2][i]);
      const double third = second - (last_[1][i] - 2.0 * last_[2][i] + last_[3][i]);
      raise(0, i, first / period_s_);
      raise(1, i, second / (period_s_ * period_s_));
      raise(2, i, third / (period_s_ * period_s_ * period_s_));
    }
  }
  PlannedMotion result() { return std::move(motion_); }

 private:
  void raise(std::size_t quantity, std::size_t axis, double value) {
    motion_.largest[quantity][axis] = std::max(motion_.largest[quantity][axis], std::abs(value));
  }

  double period_s_;
  std::deque<GroupVector> last_;
  std::size_t count_ = 0;
  PlannedMotion motion_;
};

/// Follows the moves as the cycle would, as fast as this machine can.
Outcome<PlannedMotion> follow(const MoveFile& file, const std::string& name, double share, PlanSamples* samples) {
  trajectory::ContourTrack track(file.settings, file.start);
  trajectory::ContourPlanner planner(track);
  trajectory::ContourFollower follower(track);
  if (!follower.set_override(share)) return misused("--override is a percentage above 0 and up to 200");
  MotionMeter meter(file.settings.period_s);
  const auto longest = static_cast<std::size_t>(4.0 * 3600.0 / file.settings.period_s);
  std::size_t next = 0;
  for (std::size_t cycle = 0; cycle < longest; ++cycle) {
    while (cycle % 64 == 0 && planner.flush() && next <= file.moves.size()) {
      if (next == file.moves.size()) {
        planner.finish();
      } else if (const auto added = planner.add(file.moves[next].move); !added) {
        return misused(fmt::format("{}:{}: {}", name, file.moves[next].line, added.error().reason));
      }
      ++next;
    }
    const auto setpoint = follower.step();
    meter.take(setpoint);
    if (samples != nullptr) samples->take(setpoint);
    if (setpoint.at_end && next > file.moves.size()) return meter.result();
  }
  return failed("the motion takes longer than four hours");
}

double limit_of(const MoveFile& file, std::size_t axis, std::size_t quantity) {
  const auto& limits = file.settings.limits[axis];
  return quantity == 0 ? limits.max_velocity : quantity == 1 ? limits.max_acceleration : limits.max_jerk;
}

constexpr std::array<const char*, 3> kQuantities{"velocity", "acceleration", "jerk"};

std::string plan_text(const MoveFile& file, const PlannedMotion& motion) {
  const auto& unit = *file.axes.front().unit;
  std::string text = fmt::format("{} moves, {:.6g} {} long, {:.4f} s\n", file.moves.size(), unit.from_si(motion.length),
                                 unit.name, motion.duration_s);
  for (std::size_t i = 0; i < file.axes.size(); ++i) {
    text += file.axes[i].name;
    for (std::size_t k = 0; k < kQuantities.size(); ++k) {
      const double largest = motion.largest[k][i];
      constexpr std::array<const char*, 3> kPer{"/s", "/s^2", "/s^3"};
      text += fmt::format("{} {} {:.6g} {}{} ({:.1f} % of its limit)", k == 0 ? ":" : ",", kQuantities[k],
                          file.axes[i].unit->from_si(largest), file.axes[i].unit->name, kPer[k],
                          100.0 * largest / limit_of(file, i, k));
    }
    text += "\n";
  }
  return text;
}

nlohmann::json plan_json(const MoveFile& file, const PlannedMotion& motion) {
  nlohmann::json document{{"moves", file.moves.size()}, {"duration_s", motion.duration_s}, {"length", motion.length}};
  document["axes"] = nlohmann::json::array();
  for (std::size_t i = 0; i < file.axes.size(); ++i) {
    nlohmann::json axis{{"name", file.axes[i].name}};
    for (std::size_t k = 0; k < kQuantities.size(); ++k) {
      axis[kQuantities[k]] = {{"largest", motion.largest[k][i]}, {"limit", limit_of(file, i, k)}};
    }
    document["axes"].push_back(axis);
  }
  return document;
}

/// A curve scaled into a box of the picture.
std::string curve(const std::vector<std::pair<double, double>>& points, double top, double height, bool is_square) {
  constexpr double kWidth = 760.0;
  constexpr double kMargin = 20.0;
  auto [x0, x1] = std::pair{points.front().first, points.front().first};
  auto [y0, y1] = std::pair{points.front().second, points.front().second};
  for (const auto& [x, y] : points) {
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  double scale_x = kWidth / std::max(x1 - x0, 1e-12);
  double scale_y = height / std::max(y1 - y0, 1e-12);
  if (is_square) scale_x = scale_y = std::min(scale_x, scale_y);
  std::string text = "<polyline fill=\"none\" stroke=\"#1f5fa8\" points=\"";
  for (const auto& [x, y] : points) {
    text += fmt::format("{:.2f},{:.2f} ", kMargin + (x - x0) * scale_x, top + height - (y - y0) * scale_y);
  }
  return text + "\"/>\n";
}

/// The way of the first two axes (or of the one over time), and the speed along it over time.
std::string picture_of(const MoveFile& file, const PlannedMotion& motion) {
  std::vector<std::pair<double, double>> way;
  std::vector<std::pair<double, double>> speed;
  const bool is_plane = file.axes.size() > 1;
  for (std::size_t k = 0; k < motion.points.size(); ++k) {
    const auto& [place, along] = motion.points[k];
    const auto time = static_cast<double>(k);
    way.emplace_back(is_plane ? place[0] : time, is_plane ? place[1] : place[0]);
    speed.emplace_back(time, along);
  }
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"760\" font-family=\"sans-serif\" "
         "font-size=\"13\">\n<rect width=\"800\" height=\"760\" fill=\"white\"/>\n" +
         fmt::format("<text x=\"20\" y=\"18\">{}</text>\n",
                     is_plane ? file.axes[0].name + " and " + file.axes[1].name : file.axes[0].name) +
         curve(way, 30.0, 460.0, is_plane) +
         fmt::format("<text x=\"20\" y=\"520\">speed along the path, {:.4f} s</text>\n", motion.duration_s) +
         curve(speed, 530.0, 210.0, false) + "</svg>\n";
}

Outcome<double> share_of(const std::optional<std::string>& text) {
  if (!text) return 1.0;
  double percent = 0.0;
  const auto [end, fault] = std::from_chars(text->data(), text->data() + text->size(), percent);
  if (fault != std::errc{} || end != text->data() + text->size() || !(percent > 0.0 && percent <= 200.0)) {
    return misused("--override is a percentage above 0 and up to 200");
  }
  return percent / 100.0;
}

Outcome<int> plan(const PlanOptions& options) {
  const auto share = share_of(options.share);
  if (!share) return tl::unexpected(share.error());
  std::ifstream stream(options.file, std::ios::binary);
  std::stringstream text;
  if (!stream || !(text << stream.rdbuf())) return misused(fmt::format("{} cannot be read, or is empty", options.file));
  const auto file = parse_moves(text.str(), options.file);
  if (!file) return misused(file.error());
  std::optional<PlanSamples> samples;
  if (options.samples) samples.emplace(*options.samples, *file);
  const auto motion = follow(*file, options.file, *share, samples ? &*samples : nullptr);
  if (!motion) return tl::unexpected(motion.error());
  if (samples) {
    if (auto written = samples->complete(); !written) return tl::unexpected(Failure(written.error()));
  }
  if (options.picture) {
    if (auto written = runtime::write_file(*options.picture, picture_of(*file, *motion)); !written) {
      return tl::unexpected(Failure(written.error()));
    }
  }
  print_out("{}", options.json ? json_text(plan_json(*file, *motion)) : plan_text(*file, *motion));
  return 0;
}

}  // namespace

Execute prepare_plan(Arguments& to) {
  auto options = std::make_shared<PlanOptions>();
  to.required(&options->file, Value::file(), "Moves as JSON lines");
  to.option("--override", &options->share, Value::text("PERCENT"), "Of the feed, up to 200; default: 100");
  to.option("--picture", &options->picture, Value::file(), "Draw way and speed into this SVG file");
  to.option("--samples", &options->samples, Value::file(), "Write the setpoints of every cycle into this CSV file");
  add_json_flag(to, options->json);
  return [options] { return plan(*options); };
}

}  // namespace driveline::cli
