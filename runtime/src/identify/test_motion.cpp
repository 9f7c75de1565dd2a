#include "driveline/runtime/identify/test_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/trajectory/path.hpp"

namespace driveline::runtime {
namespace {

/// Fractions of the highest speed. Slow motions show friction and weight, fast ones the inertia.
constexpr std::array kSpeeds{1.0, 0.7, 0.45, 0.25};
constexpr double kRestS = 0.1;
constexpr double kLongestS = 600.0;
/// Points of a motion. The minimum-jerk profile, 10 t^3 - 15 t^4 + 6 t^5, has its highest velocity and acceleration at
/// these multiples of mean velocity and of mean velocity per duration.
constexpr int kPoints = 200;
constexpr double kPeakVelocity = 1.875;
constexpr double kPeakAcceleration = 5.773502691896258;

double least_jerk(double t) noexcept {
  return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

/// Returns the duration of the fastest motion in s.
double quickest_s(const TestMotion& motion) {
  const double distance = std::abs(motion.distance);
  return std::max(kPeakVelocity * distance / motion.velocity,
                  std::sqrt(kPeakAcceleration * distance / motion.acceleration));
}

Result<void> check(const TestMotion& motion, const motion::AxisConfig& axis) {
  const auto& unit = motion::position_unit(axis);
  const auto beyond = [&](std::string_view what, double asked, double limit, std::string_view per) -> Result<void> {
    if (asked > 0.0 && asked <= limit) return {};
    return fail(ErrorKind::kSetting,
                fmt::format("axis {}: {} {:.6g} {}{} is not within its limit of {:.6g} {}{}", axis.name, what,
                            unit.from_si(asked), unit.name, per, unit.from_si(limit), unit.name, per));
  };
  if (auto done = beyond("a velocity of", motion.velocity, axis.limits.max_velocity, "/s"); !done) return done;
  if (auto done = beyond("an acceleration of", motion.acceleration, axis.limits.max_acceleration, "/s²"); !done)
    return done;
  const double most = std::numeric_limits<std::int32_t>::max() / axis.increments_per_unit;
  const double distance = std::abs(motion.distance);
  if (!(distance > 0.0 && distance < most)) {
    return fail(ErrorKind::kSetting,
                fmt::format("axis {}: a distance of {:.6g} {} is not above 0 and below {:.6g}", axis.name,
                            unit.from_si(motion.distance), unit.name, unit.from_si(most)));
  }
  double all_s = 0.0;
  for (const double speed : kSpeeds) all_s += 2.0 * (quickest_s(motion) / speed + kRestS);
  if (all_s <= kLongestS) return {};
  return fail(ErrorKind::kSetting, fmt::format("axis {}: the test motion would take {:.3g} s, at most {:.0f} s are "
                                               "expected: a shorter distance or a higher velocity is needed",
                                               axis.name, all_s, kLongestS));
}

/// Adds points to a path; only the first refusal is reported, at the end.
class Points {
 public:
  explicit Points(const motion::AxisConfig& axis) { keep(builder_.add_axis({axis.name, axis.kind, axis.unit})); }

  void add(double after_s, double position) {
    time_s_ += after_s;
    keep(builder_.add_point(time_s_, std::array{position}));
  }
  [[nodiscard]] Result<trajectory::Interpolator> finish() {
    auto path = builder_.build();
    if (!path) keep(tl::unexpected(path.error()));
    if (refused_) return fail(ErrorKind::kSetting, *refused_);
    return trajectory::Interpolator::clamped_spline(*path);
  }

 private:
  void keep(const tl::expected<void, trajectory::PathError>& added) {
    if (!added && !refused_) refused_ = added.error().message();
  }

  trajectory::PathBuilder builder_;
  double time_s_ = 0.0;
  std::optional<std::string> refused_;
};

void add_way(Points& points, double from, double to, double seconds) {
  for (int point = 1; point <= kPoints; ++point) {
    const double t = static_cast<double>(point) / kPoints;
    points.add(seconds / kPoints, from + (to - from) * least_jerk(t));
  }
  // Start the pause with points as close as those of the motion: a spline would oscillate between distant points.
  double rest_s = 0.0;
  for (double step_s = seconds / kPoints; rest_s + step_s < kRestS; step_s *= 2.0) {
    points.add(step_s, to);
    rest_s += step_s;
  }
  points.add(kRestS - rest_s, to);
}

}  // namespace

Result<trajectory::Interpolator> make_test_path(const TestMotion& motion, const motion::AxisConfig& axis) {
  if (auto done = check(motion, axis); !done) return tl::unexpected(done.error());
  Points points(axis);
  points.add(0.0, 0.0);
  for (const double speed : kSpeeds) {
    add_way(points, 0.0, motion.distance, quickest_s(motion) / speed);
    add_way(points, motion.distance, 0.0, quickest_s(motion) / speed);
  }
  return points.finish();
}

}  // namespace driveline::runtime
