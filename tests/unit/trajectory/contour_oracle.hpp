#pragma once

#include <deque>
#include <optional>
#include <sstream>
#include <string>

#include "driveline/trajectory/contour_follower.hpp"
#include "driveline/trajectory/contour_planner.hpp"
#include "move_oracle.hpp"

namespace driveline::trajectory::test {

/// Judges only the positions from the cycle: differences between cycles against the limits of each axis and of the
/// tool, and the distance of the tool from the moves.
class ContourOracle {
 public:
  ContourOracle(const ContourSettings& settings, const MovePlan& plan) : settings_(settings), plan_(plan) {}

  /// Tolerance of the limits: the effect of rounding positions to 2^-40 m and to a double, and of sampling.
  static constexpr double kMargin = 0.003;

  void take(const ContourSetpoint& setpoint) {
    last_.push_front(setpoint.position);
    tools_.push_front(tool_of(setpoint.position));
    if (last_.size() > 4) {
      last_.pop_back();
      tools_.pop_back();
    }
    if (last_.size() == 4) judge_differences();
    judge_place(setpoint);
  }

  /// The first violation; empty: there is none.
  [[nodiscard]] const std::string& verdict() const { return verdict_; }
  /// The largest used share of each limit: velocity, acceleration, jerk.
  [[nodiscard]] const std::array<double, 3>& used() const { return used_; }

 private:
  /// Position of the tool for positions of the axes.
  [[nodiscard]] GroupVector tool_of(const GroupVector& position) const {
    GroupVector tool = position;
    if (settings_.kinematics != nullptr && !settings_.kinematics->forward(position, tool)) tool[0] = 1e9;
    return tool;
  }

  /// Judges the magnitude of the tool's velocity, acceleration and jerk vectors.
  void judge_tool(double rounding) {
    const double dt = settings_.period_s;
    std::array<double, 3> squares{};
    for (std::size_t i = 0; i < settings_.axes; ++i) {
      const double first = tools_[0][i] - tools_[1][i];
      const double second = first - tools_[1][i] + tools_[2][i];
      const double third = second - tools_[1][i] + 2.0 * tools_[2][i] - tools_[3][i];
      squares[0] += first * first;
      squares[1] += second * second;
      squares[2] += third * third;
    }
    judge(0, kTool, std::sqrt(squares[0]) / dt, settings_.tool.max_velocity, 0.0);
    judge(1, kTool, std::sqrt(squares[1]) / (dt * dt), settings_.tool.max_acceleration, rounding * dt);
    judge(2, kTool, std::sqrt(squares[2]) / (dt * dt * dt), settings_.tool.max_jerk, rounding);
  }

  void judge_differences() {
    const double dt = settings_.period_s;
    double rounding = 2.0 / static_cast<double>(smoothing_cycles(settings_)) + 0.05;  // m/s^3
    // Angles and positions of some m or rad come from formulas with about ten operations.
    if (settings_.kinematics != nullptr) rounding += 64.0 * 2.2e-16 / (dt * dt * dt);
    for (std::size_t i = 0; i < settings_.axes; ++i) {
      const double p0 = last_[0][i];
      const double p1 = last_[1][i];
      const double p2 = last_[2][i];
      const double p3 = last_[3][i];
      judge(0, i, std::abs(p0 - p1) / dt, settings_.limits[i].max_velocity, 0.0);
      judge(1, i, std::abs(p0 - 2.0 * p1 + p2) / (dt * dt), settings_.limits[i].max_acceleration, rounding * dt);
      judge(2, i, std::abs(p0 - 3.0 * p1 + 3.0 * p2 - p3) / (dt * dt * dt), settings_.limits[i].max_jerk, rounding);
    }
    judge_tool(rounding);
    ++cycles_;
  }

  void judge(std::size_t quantity, std::size_t axis, double value, double limit, double rounding) {
    constexpr std::array<const char*, 3> kNames{"velocity", "acceleration", "jerk"};
    used_[quantity] = std::max(used_[quantity], (value - rounding) / limit);
    if (value <= limit * (1.0 + kMargin) + rounding || !verdict_.empty()) return;
    std::ostringstream text;
    text << "cycle " << cycles_ << ": " << kNames[quantity] << " of axis " << axis << " is " << value << ", "
         << value / limit << " of the limit";
    verdict_ = text.str();
  }

  void judge_place(const ContourSetpoint& setpoint) {
    const auto tool = tool_of(setpoint.position);
    double nearest = distance_from_move(tool, plan_, setpoint.move);
    double tolerance = 0.0;
    if (setpoint.move > 0) {
      nearest = std::min(nearest, distance_from_move(tool, plan_, setpoint.move - 1));
      tolerance = plan_.moves[setpoint.move - 1].tolerance;
    }
    if (nearest <= tolerance + 1e-9 || !verdict_.empty()) return;
    std::ostringstream text;
    text << "cycle " << cycles_ << ": " << nearest << " m from move " << setpoint.move << ", with a tolerance of "
         << tolerance;
    verdict_ = text.str();
  }

  static constexpr std::size_t kTool = kMaxGroupAxes;  ///< represents the tool in verdicts

  const ContourSettings& settings_;
  const MovePlan& plan_;
  std::deque<GroupVector> last_;
  std::deque<GroupVector> tools_;
  std::size_t cycles_ = 0;
  std::array<double, 3> used_{};
  std::string verdict_;
};

/// A planner and a follower that take turns, as the two threads do.
class ContourRun {
 public:
  ContourRun(const ContourSettings& settings, const MovePlan& plan)
      : plan_(plan), track_(settings, plan.start), planner_(track_), follower_(track_) {}

  /// Plans as much as there is room for.
  void plan() {
    while (planner_.flush() && next_ <= plan_.moves.size()) {
      if (next_ == plan_.moves.size()) {
        planner_.finish();
      } else if (const auto added = planner_.add(plan_.moves[next_]); !added) {
        throw std::runtime_error(added.error().reason);
      }
      ++next_;
    }
  }

  [[nodiscard]] ContourFollower& follower() { return follower_; }
  [[nodiscard]] bool planned() const { return next_ > plan_.moves.size(); }
  /// Continues until the axes are at rest at the end, for at least `least` cycles; empty: they never are.
  template <typename Each>
  std::optional<double> to_end(double period_s, std::size_t most, Each each, std::size_t least = 0) {
    for (std::size_t cycle = 0; cycle < most; ++cycle) {
      if (cycle % 64 == 0) plan();
      const auto setpoint = follower_.step();
      each(setpoint);
      if (setpoint.at_end && planned() && cycle > least) return static_cast<double>(cycle) * period_s;
    }
    return std::nullopt;
  }

 private:
  const MovePlan& plan_;
  ContourTrack track_;
  ContourPlanner planner_;
  ContourFollower follower_;
  std::size_t next_ = 0;
};

/// Whether the shaper accepts the moves.
inline bool can_be_shaped(std::size_t axes, const MovePlan& plan) {
  PathShaper shaper(axes, plan.start);
  std::vector<ShapedPiece> out;
  return std::all_of(plan.moves.begin(), plan.moves.end(),
                     [&](const PathMove& move) { return shaper.add(move, out).has_value(); });
}

inline ContourSettings random_settings(Random& random, std::size_t axes) {
  ContourSettings settings;
  settings.axes = axes;
  settings.capacity = 256;
  for (std::size_t i = 0; i < axes; ++i) {
    auto& limits = settings.limits[i];
    limits.max_velocity = random.magnitude(0.1, 2.0);
    limits.max_acceleration = random.magnitude(1.0, 20.0);
    limits.max_jerk = limits.max_acceleration / random.magnitude(1e-3, 0.03);
  }
  return settings;
}

}  // namespace driveline::trajectory::test
