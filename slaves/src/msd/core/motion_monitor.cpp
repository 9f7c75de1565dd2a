#include "driveline/slaves/msd/core/motion_monitor.hpp"

#include <cmath>

#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/drive_settings.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {

using std::chrono::nanoseconds;

bool MotionMonitor::step_following_error() noexcept {
  const auto window = dictionary_->get(kValue.following_error_window);
  const bool outside = window != kWindowOff && motion_->following_error_above(window);
  following_error_time_ = outside ? following_error_time_ + kProcessDataPeriod : nanoseconds{0};
  following_error_ =
      outside && following_error_time_ > std::chrono::milliseconds(dictionary_->get(kValue.following_error_time));
  return following_error_;
}

std::optional<Fault> MotionMonitor::limit_switch(const InputSignals& signals, bool homes) const noexcept {
  if (!signals.positive_limit && !signals.negative_limit) return std::nullopt;
  if (motion_->command() != MotionCommand::kFollow || homes) return std::nullopt;
  const int direction = motion_->direction();
  if (signals.positive_limit && direction > 0) return Fault::kPositiveLimitSwitch;
  if (signals.negative_limit && direction < 0) return Fault::kNegativeLimitSwitch;
  return std::nullopt;
}

bool MotionMonitor::wrong_cycle() const noexcept {
  return rhythm_.wrong() || (motion_->settings().cycle_by_objects && !timing_valid(*dictionary_));
}

/// Setpoints are interpolated over another time than that of their arrival (MSD manual 7.4.2, 11.2).
bool MotionMonitor::follows_wrong_cycle() const noexcept {
  return motion_->follows_cyclic_setpoints() && wrong_cycle();
}

}  // namespace driveline::slaves::msd
