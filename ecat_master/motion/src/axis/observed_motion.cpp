#include "driveline/motion/axis/observed_motion.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace driveline::motion {
namespace {

constexpr double kForgotten = 1.0 - ObservedMotion::kMemory;
constexpr double kPositionGain = 1.0 - ObservedMotion::kMemory * ObservedMotion::kMemory * ObservedMotion::kMemory;
constexpr double kVelocityGain = 1.5 * kForgotten * kForgotten * (1.0 + ObservedMotion::kMemory);
constexpr double kAccelerationGain = kForgotten * kForgotten * kForgotten;
/// Shares of a torque change that take effect in each of the three cycles after it was commanded.
constexpr double kTorqueArrives[] = {0.3, 0.4, 0.3};

}  // namespace

void ObservedMotion::start(const trajectory::AxisSetpoint& motion, double torque) noexcept {
  motion_ = motion;
  std::fill(std::begin(commanded_), std::end(commanded_), torque);
  on_its_way_ = 0.0;
}

void ObservedMotion::pass(double time_s) noexcept {
  motion_.position += time_s * (motion_.velocity + 0.5 * time_s * motion_.acceleration);
  motion_.velocity += time_s * motion_.acceleration;
}

void ObservedMotion::correct(double position) noexcept {
  const double deviation = position - motion_.position;
  motion_.position += kPositionGain * deviation;
  motion_.velocity += kVelocityGain * deviation / period_s_;
  motion_.acceleration += kAccelerationGain * deviation / (period_s_ * period_s_);
}

void ObservedMotion::command(double torque) noexcept {
  if (!(inertia_ > 0.0)) return;
  double arrives = 0.0;
  for (std::size_t i = 0; i < 3; ++i) arrives += kTorqueArrives[i] * (commanded_[i] - commanded_[i + 1]);
  motion_.acceleration += arrives / inertia_;
  const double rest =
      kTorqueArrives[2] * (commanded_[1] - commanded_[2]) + (1.0 - kTorqueArrives[0]) * (commanded_[0] - commanded_[1]);
  on_its_way_ = (torque - commanded_[0] + rest) / inertia_;
  std::copy_backward(std::begin(commanded_), std::end(commanded_) - 1, std::end(commanded_));
  commanded_[0] = torque;
}

void ObservedMotion::hold_torque() noexcept {
  if (!(inertia_ > 0.0)) return;
  const double arrives =
      (1.0 - kTorqueArrives[0]) * (commanded_[1] - commanded_[2]) + kTorqueArrives[2] * (commanded_[2] - commanded_[3]);
  motion_.acceleration += arrives / inertia_;
  on_its_way_ = 0.0;
  std::fill(std::begin(commanded_), std::end(commanded_), commanded_[1]);
}

}  // namespace driveline::motion
