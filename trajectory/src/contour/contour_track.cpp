#include "driveline/trajectory/contour_track.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "contour/joint_path.hpp"
#include "driveline/trajectory/path_check.hpp"

namespace driveline::trajectory {
namespace {

bool is_positive(double value) {
  return value > 0.0 && std::isfinite(value);
}

ContourSettings valid(const ContourSettings& settings) {
  if (const auto wrong = check_settings(settings); !wrong.empty()) throw std::invalid_argument(wrong);
  return settings;
}

std::string fault_of_ranges(const ContourSettings& settings) {
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& limits = settings.limits[i];
    if (limits.min_position < limits.max_position) continue;
    return "the lowest position of axis " + std::to_string(i + 1) + " must be below its highest one";
  }
  return "";
}

std::string fault_of_tool(const ContourSettings& settings) {
  const auto& [velocity, acceleration, jerk] = settings.tool;
  if (!(velocity > 0.0 && acceleration > 0.0 && jerk > 0.0)) return "the limits of the tool must be above 0";
  if (settings.kinematics == nullptr) return "";
  if (settings.kinematics->coordinates().size() > settings.axes) {
    return "the machine has " + std::to_string(settings.kinematics->coordinates().size()) + " joints, the group " +
           std::to_string(settings.axes) + " axes";
  }
  return std::isfinite(velocity) ? "" : "a machine with kinematics needs a velocity limit of its tool";
}

GroupVector joints_at(const ContourSettings& settings, const GroupVector& place) {
  if (auto wrong = PathCheck(settings).fault_at(place); !wrong.empty()) throw std::invalid_argument(wrong);
  PathGeometry tool;
  tool.position = place;
  PathGeometry joints;
  to_joints(settings, tool, joints);
  return joints.position;
}

/// Time from standstill to the highest acceleration, or to the highest velocity if that comes first.
double rise_s(double velocity, double acceleration, double jerk) noexcept {
  return std::min(acceleration / jerk, std::sqrt(velocity / jerk));
}

}  // namespace

std::string check_settings(const ContourSettings& settings) {
  constexpr double kShortestPeriod = 10e-6;
  constexpr double kLongestPeriod = 0.1;
  if (settings.axes == 0 || settings.axes > kMaxGroupAxes) return "a group has 1 to 8 axes";
  if (!(settings.period_s >= kShortestPeriod && settings.period_s <= kLongestPeriod)) {
    return "the period of the cycle must be from 10 us to 0.1 s";
  }
  constexpr std::size_t kSmallest = 256;
  constexpr std::size_t kLargest = std::size_t{1} << 20;
  if (!std::has_single_bit(settings.capacity) || settings.capacity < kSmallest || settings.capacity > kLargest) {
    return "the capacity must be a power of two from 256 to 1048576";
  }
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& limits = settings.limits[i];
    if (!is_positive(limits.max_velocity) || !is_positive(limits.max_acceleration) || !is_positive(limits.max_jerk)) {
      return "axis " + std::to_string(i + 1) + " needs a positive and finite velocity, acceleration and jerk limit";
    }
  }
  // Higher values mean "no limit"; but lengths are counted in steps of 2^-40 m in 64 bits.
  constexpr double kFastest = 1e6;
  for (std::size_t i = 0; i < settings.axes; ++i) {
    if (settings.limits[i].max_velocity > kFastest) {
      return "the velocity limit of axis " + std::to_string(i + 1) + " is above 1e6 m/s or rad/s";
    }
  }
  if (auto wrong = fault_of_ranges(settings); !wrong.empty()) return wrong;
  if (auto wrong = fault_of_tool(settings); !wrong.empty()) return wrong;
  if (top_speed(settings) > kFastest * kMaxGroupAxes) return "the velocity limit of the tool is above 1e6 m/s";
  constexpr double kMaxCycles = 65536.0;
  for (std::size_t i = 0; i < settings.axes; ++i) {
    if (settings.limits[i].max_acceleration / settings.limits[i].max_jerk > kMaxCycles * settings.period_s) {
      return "axis " + std::to_string(i + 1) + " takes more than 65536 cycles to reach its acceleration limit";
    }
  }
  if (static_cast<double>(smoothing_cycles(settings)) > kMaxCycles) {
    return "the tool takes more than 65536 cycles to reach its acceleration limit";
  }
  // Largest sum of the lags of all averaged positions, with a safety factor of two.
  constexpr double kLargestSum = 8388608.0;  // 2^63 steps of 2^-40 m
  const auto cycles = static_cast<double>(smoothing_cycles(settings));
  if (2.0 * top_speed(settings) * cycles * cycles * settings.period_s >= kLargestSum) {
    return "the axes are too fast for an averaging over " + std::to_string(smoothing_cycles(settings)) +
           " cycles; lower velocity limits or higher jerk limits are needed";
  }
  return "";
}

double top_speed(const ContourSettings& settings) noexcept {
  if (settings.kinematics != nullptr) return settings.tool.max_velocity;
  double fastest = 0.0;
  for (std::size_t i = 0; i < settings.axes; ++i) fastest = std::hypot(fastest, settings.limits[i].max_velocity);
  return std::min(fastest, settings.tool.max_velocity);
}

std::size_t smoothing_cycles(const ContourSettings& settings) noexcept {
  double longest_s = 0.0;
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& limits = settings.limits[i];
    longest_s = std::max(longest_s, rise_s(limits.max_velocity, limits.max_acceleration, limits.max_jerk));
  }
  // A tool without a jerk limit does not contribute; with a jerk limit alone, the acceleration limits of the axes apply
  // to the tool.
  const auto& tool = settings.tool;
  if (std::isfinite(tool.max_jerk)) {
    const double rise = rise_s(top_speed(settings), tool.max_acceleration, tool.max_jerk);
    if (std::isfinite(rise)) longest_s = std::max(longest_s, rise);
  }
  constexpr double kRounding = 1e-9;
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(longest_s / settings.period_s - kRounding)));
}

ContourTrack::ContourTrack(const ContourSettings& settings, const GroupVector& start)
    : settings_(valid(settings)),
      start_(start),
      start_joints_(joints_at(settings_, start)),
      smoothing_(smoothing_cycles(settings)),
      mask_(settings.capacity - 1),
      pieces_(std::make_unique<Piece[]>(settings.capacity)),
      cells_(std::make_unique<Cell[]>(settings.capacity)),
      events_(std::make_unique<Event[]>(settings.capacity)) {}

}  // namespace driveline::trajectory
