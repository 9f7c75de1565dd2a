#include "driveline/motion/path/driven_axes.hpp"

#include <algorithm>

namespace driveline::motion {

void DrivenAxis::command(const trajectory::AxisSetpoint& setpoint) noexcept {
  if (!followed_) return;
  command_ = setpoint;
  left_ = cycles_;
}

void DrivenAxis::hold(double position) noexcept {
  command_ = {position, 0.0, 0.0};
  position_ = position;
  left_ = 0;
}

trajectory::AxisSetpoint DrivenAxis::next(double period_s) noexcept {
  auto setpoint = command_;
  if (cycles_ > 1 && left_ > 0) {
    const double step = (command_.position - position_) / left_;
    setpoint.position = left_ == 1 ? command_.position : position_ + step;
    setpoint.velocity = step / period_s;
  } else if (cycles_ > 1) {
    setpoint.velocity = 0.0;
  }
  left_ -= std::min(left_, 1U);
  position_ = setpoint.position;
  return setpoint;
}

DrivenAxes::DrivenAxes(std::vector<std::uint32_t> cycles, double period_s) : axes_(cycles.size()), period_s_(period_s) {
  for (std::size_t i = 0; i < axes_.size(); ++i) axes_[i].cycles_ = cycles[i];
}

void DrivenAxes::rewind(std::span<trajectory::AxisSetpoint> first) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    axes_[i].followed_ = false;
    axes_[i].hold(first[i].position);
  }
}

void DrivenAxes::begin(bool running) noexcept {
  for (auto& axis : axes_) axis.followed_ = true;
  run(running);
}

bool DrivenAxes::next(const SetpointCycle&, std::span<trajectory::AxisSetpoint> setpoints) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) setpoints[i] = axes_[i].next(period_s_);
  return true;
}

void DrivenAxes::end() noexcept {
  for (auto& axis : axes_) axis.followed_ = false;
}

void DrivenAxes::run(bool running) noexcept {
  for (auto& axis : axes_) axis.to_rest_ = !running;
}

}  // namespace driveline::motion
