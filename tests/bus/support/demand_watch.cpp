#include "demand_watch.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::bus_test {

using slaves::MotionCommand;
using slaves::msd::MotionSource;

namespace {

/// Time until an axis that could not follow has recovered.
constexpr std::chrono::milliseconds kRecovers{60};

bool demands_position(MotionCommand command, MotionSource source) {
  return command == MotionCommand::kFollow &&
         (source == MotionSource::kCyclicPosition || source == MotionSource::kProfilePosition);
}

}  // namespace

void DemandWatch::look(std::chrono::nanoseconds now) {
  const auto& motion = drive_.motion();
  const auto& settings = motion.settings();
  newest_ = (newest_ + 1) % kKept;
  auto& sample = samples_[newest_];
  sample.time_s = std::chrono::duration<double>(now).count();
  // Homing renames positions, but moves nothing.
  sample.position = motion.position_demand() * settings.scaling.position_rad +
                    static_cast<double>(motion.zero()) * motion.motor().radians_per_increment();
  sample.velocity = motion.velocity_demand() * settings.scaling.velocity_rad_s;
  sample.moved_at = drive_.velocity_rad_s();
  trace_.add(sample.time_s, sample.position, sample.velocity, sample.moved_at);
  sample.by_torque = motion.source() == MotionSource::kCyclicTorque && motion.command() == MotionCommand::kFollow;
  sample.acceleration = motion.command() == MotionCommand::kSlowDownRamp    ? settings.slow_down_rad_s2
                        : motion.command() == MotionCommand::kQuickStopRamp ? settings.quick_stop_rad_s2
                                                                            : limits_.max_acceleration;
  const bool off = motion.command() == MotionCommand::kOff || motion.command() == MotionCommand::kTorqueLimit;
  if (!sample.by_torque && motion.controller().limited()) disturb(now + kRecovers);
  const bool same = motion.source() == source_;
  // A motion source that starts now takes over a state that was not commanded.
  lost_ = now < disturbed_ && (lost_ || !same);
  source_ = motion.source();
  positions_ = lost_ || !demands_position(motion.command(), source_) ? 0 : same ? positions_ + 1 : 1;
  // The initial state of the drive's own ramp is no demand of its master.
  const bool ramp =
      motion.command() == MotionCommand::kQuickStopRamp || motion.command() == MotionCommand::kSlowDownRamp;
  const bool begins = ramp && motion.command() != command_;
  command_ = motion.command();
  velocities_ = off || now < disturbed_ ? 0 : begins ? 1 : velocities_ + 1;
  judged_ += positions_ > 0 || velocities_ > 0 ? 1U : 0U;
  if (!finding_.empty()) return;
  if (velocities_ > 0) {
    const double most = (kVelocityDemand + margins_.velocity) * limits_.max_velocity;
    const double velocity = std::abs(sample.by_torque ? sample.moved_at : sample.velocity);
    if (velocity > most) find("606Bh: velocity", velocity, most);
  }
  for (const auto& window : kWindows) {
    judge_position(window);
    judge_velocity(window);
  }
}

double DemandWatch::allowed(std::size_t periods) const {
  double most = 0.0;
  for (std::size_t i = 0; i <= periods; ++i) most = std::max(most, ago(i).acceleration);
  return most;
}

void DemandWatch::judge_position(const Window& window) {
  const auto n = window.periods;
  const auto slope = [this, n](std::size_t from) {
    return (ago(from).position - ago(from + n).position) / (ago(from).time_s - ago(from + n).time_s);
  };
  if (positions_ <= n) return;
  const double velocity = slope(0);
  if (std::abs(velocity) > (window.velocity + margins_.position) * limits_.max_velocity)
    find("6062h: velocity", velocity, (window.velocity + margins_.position) * limits_.max_velocity);
  if (positions_ <= 2 * n) return;
  const double rate = (velocity - slope(n)) / (0.5 * (ago(0).time_s - ago(2 * n).time_s));
  const double most = window.acceleration * allowed(2 * n);
  if (std::abs(rate) > most) find("6062h: acceleration", rate, most);
}

/// In torque mode the drive demands no velocity, so the actual velocity is judged.
void DemandWatch::judge_velocity(const Window& window) {
  const auto n = window.periods;
  if (velocities_ <= n) return;
  bool by_torque = false;
  for (std::size_t i = 0; i <= n; ++i) by_torque = by_torque || ago(i).by_torque;
  const auto velocity = [this, by_torque](std::size_t i) { return by_torque ? ago(i).moved_at : ago(i).velocity; };
  const double rate = (velocity(0) - velocity(n)) / (ago(0).time_s - ago(n).time_s);
  const double most = (by_torque ? kByTorque : window.change) * allowed(n);
  if (std::abs(rate) > most) find(by_torque ? "606Ch: acceleration" : "606Bh: acceleration", rate, most);
}

void DemandWatch::find(const char* what, double value, double allowed) {
  if (!finding_.empty()) return;
  finding_ = std::string(what) + " " + std::to_string(value) + ", " + std::to_string(allowed) + " allowed, at " +
             std::to_string(ago(0).time_s) + " s, in mode " + std::to_string(static_cast<int>(source_)) + ", " +
             drive_.display();
}

}  // namespace driveline::bus_test
