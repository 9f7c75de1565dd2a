// Inputs of the drive: terminals, switches of the machine, edges that the touch probe latches.
#include <algorithm>

#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {

std::int32_t MsdDrive::shown_position(std::int64_t increments) const noexcept {
  return motion_.settings().range.wrap(motion_.position_at(increments));
}

void MsdDrive::set_input(Input input, bool level) noexcept {
  change_input(input, level, motion_.motor().position_rad());
}

/// `position_rad`: where the motor shaft was when the input changed.
void MsdDrive::change_input(Input input, bool level, double position_rad) noexcept {
  if (terminals_.level(input) == level) return;
  const InputSignals before = terminals_.signals();
  terminals_.set(input, level);
  const InputSignals& now = terminals_.signals();
  for (std::size_t i = 0; i < now.probe.size(); ++i) {
    if (now.probe[i] == before.probe[i]) continue;
    probe_.edge(i, now.probe[i], shown_position(motion_.motor().encoder_count(position_rad)));
  }
  if ((input == Input::kEnpo && level) || (now.fault_reset && !before.fault_reset)) acknowledge();
}

void MsdDrive::evaluate_switches() noexcept {
  const double position = motion_.motor().position_rad();
  const bool upwards = position > motion_.motor().last_position_rad();
  for (const MachineSwitch& s : parameters_.switches) {
    const bool level = position >= s.from_rad && position <= s.to_rad;
    if (level == terminals_.level(s.input)) continue;
    const double edge = level == upwards ? s.from_rad : s.to_rad;
    // At the start there is no way that could have led over an edge.
    const bool passed = std::min(position, motion_.motor().last_position_rad()) <= edge &&
                        edge <= std::max(position, motion_.motor().last_position_rad());
    change_input(s.input, level, passed ? edge : position);
  }
}

bool MsdDrive::schedule_input(Input input, bool level, std::chrono::nanoseconds at) noexcept {
  if (scheduled_count_ == scheduled_.size()) return false;
  auto place = scheduled_.begin() + static_cast<std::ptrdiff_t>(scheduled_count_++);
  *place = {input, level, at};
  for (; place != scheduled_.begin() && (place - 1)->at > at; --place) std::swap(*place, *(place - 1));
  return true;
}

/// Changes within the control cycle that has just passed, at their places between its ends.
void MsdDrive::apply_scheduled_inputs() noexcept {
  std::size_t done = 0;
  for (; done < scheduled_count_ && scheduled_[done].at <= *next_step_; ++done) {
    const ScheduledInput& change = scheduled_[done];
    const auto into = change.at - (*next_step_ - kControlStep);
    const double share =
        std::clamp(static_cast<double>(into.count()) / static_cast<double>(kControlStep.count()), 0.0, 1.0);
    const ServoMotor& motor = motion_.motor();
    change_input(change.input, change.level,
                 motor.last_position_rad() + share * (motor.position_rad() - motor.last_position_rad()));
  }
  if (done == 0) return;
  std::move(scheduled_.begin() + static_cast<std::ptrdiff_t>(done),
            scheduled_.begin() + static_cast<std::ptrdiff_t>(scheduled_count_), scheduled_.begin());
  scheduled_count_ -= done;
}

void MsdDrive::step_touch_probe() noexcept {
  const auto variant = static_cast<TouchProbe::Variant>(dictionary_.get<std::uint16_t>(kTouchProbeVariant));
  probe_.control(variant, dictionary_.get<std::uint16_t>(kTouchProbeFunction));
  if (const auto index = motion_.motor().index_pulse()) probe_.zero_pulse(shown_position(*index));
}

}  // namespace driveline::slaves::msd
