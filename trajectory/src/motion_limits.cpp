#include "driveline/trajectory/motion_limits.hpp"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

using Quantity = LimitViolation::Quantity;

bool exceeds(double value, double limit) {
  constexpr double kRounding = 1e-9;
  return std::abs(value) > limit * (1.0 + kRounding);
}

void require_valid(const Interpolator& interpolator, std::span<const AxisLimits> limits, double period_s) {
  if (limits.size() != interpolator.axes().size()) {
    throw std::invalid_argument("one pair of limits per axis is needed");
  }
  for (const AxisLimits& limit : limits) {
    if (!(limit.max_velocity > 0.0) || !(limit.max_acceleration > 0.0)) {
      throw std::invalid_argument("limits must be positive");
    }
  }
  constexpr double kMinPeriodS = 1e-6;
  if (!(period_s >= kMinPeriodS) || !std::isfinite(period_s)) {
    throw std::invalid_argument("the period must be finite and at least 1 us");
  }
}

/// Value of the limited quantity in one sample.
double demand(const AxisSetpoint& now, double previous_velocity, Quantity quantity, double period_s) {
  if (quantity == Quantity::kVelocity) {
    return now.velocity;
  }
  const double mean_acceleration = (now.velocity - previous_velocity) / period_s;
  return std::abs(mean_acceleration) > std::abs(now.acceleration) ? mean_acceleration : now.acceleration;
}

double limit_of(const AxisLimits& limits, Quantity quantity) {
  return quantity == Quantity::kVelocity ? limits.max_velocity : limits.max_acceleration;
}

/// If positions jump, the velocity that a drive sees is the change from one sample to the next.
void set_mean_velocities(std::span<AxisSetpoint> now, std::span<const AxisSetpoint> previous, double period_s) {
  for (std::size_t i = 0; i < now.size(); ++i) {
    now[i].velocity = (now[i].position - previous[i].position) / period_s;
  }
}

/// The limit that is exceeded in a sample, if any.
std::optional<Quantity> find_excess(const AxisSetpoint& now, double previous_velocity, const AxisLimits& limits,
                                    double period_s) {
  for (const Quantity quantity : {Quantity::kVelocity, Quantity::kAcceleration}) {
    if (exceeds(demand(now, previous_velocity, quantity, period_s), limit_of(limits, quantity))) {
      return quantity;
    }
  }
  return std::nullopt;
}

}  // namespace

std::string LimitViolation::message() const {
  const bool is_velocity = quantity == Quantity::kVelocity;
  const PositionUnit& position_unit = unit_or_si(axis.unit, axis.kind);
  const std::string unit = std::string(position_unit.name) + (is_velocity ? "/s" : "/s^2");
  return "axis " + in_quotes(axis.name) + (jumps ? " would jump from point to point and need " : " would need ") +
         (is_velocity ? "a velocity" : "an acceleration") + " of " + to_short_text(position_unit.from_si(value)) + " " +
         unit + " at " + to_short_text(time_s) + " s; its limit is " + to_short_text(position_unit.from_si(limit)) +
         " " + unit;
}

tl::expected<void, LimitViolation> check_limits(Interpolator& interpolator, std::span<const AxisLimits> limits,
                                                double period_s) {
  require_valid(interpolator, limits, period_s);
  std::vector<AxisSetpoint> now(interpolator.axes().size());
  std::vector<AxisSetpoint> previous(now.size());
  std::optional<LimitViolation> violation;
  const bool jumps = facts_of(interpolator.method()).continuity == Continuity::kNone;
  // Multiplying instead of accumulating keeps the grid exact; the last sample is the first one after the end.
  for (double sample = 0.0;; sample += 1.0) {
    const double time_s = interpolator.start_s() + sample * period_s;
    interpolator.evaluate(time_s, now);
    if (jumps && sample > 0.0) set_mean_velocities(now, previous, period_s);
    for (std::size_t i = 0; i < now.size() && !violation; ++i) {
      if (const auto quantity = find_excess(now[i], previous[i].velocity, limits[i], period_s)) {
        violation.emplace();
        violation->axis = interpolator.axes()[i];
        violation->axis_index = i;
        violation->quantity = *quantity;
        violation->limit = limit_of(limits[i], *quantity);
        violation->jumps = jumps;
      }
    }
    // Axis and quantity are known; find the largest value.
    if (violation) {
      const auto i = violation->axis_index;
      const double value = demand(now[i], previous[i].velocity, violation->quantity, period_s);
      if (std::abs(value) > std::abs(violation->value)) {
        violation->value = value;
        violation->time_s = time_s;
      }
    }
    if (interpolator.finished(time_s)) {
      break;
    }
    now.swap(previous);
  }
  if (violation) {
    return tl::unexpected(*violation);
  }
  return {};
}

}  // namespace driveline::trajectory
