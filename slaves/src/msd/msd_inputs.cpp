// Inputs of the drive: terminals, switches of the machine, edges that the touch probe latches.
#include <algorithm>
#include <utility>

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
    const bool inside = position >= s.from_rad && position <= s.to_rad;
    const bool level = inside != s.normally_closed;
    if (level == terminals_.level(s.input)) continue;
    const double edge = inside == upwards ? s.from_rad : s.to_rad;
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

/// `at` lies in the control cycle that has just passed: the shaft was between its places at the cycle's ends.
void MsdDrive::change_between_steps(Input input, bool level, std::chrono::nanoseconds at) noexcept {
  const auto into = at - (*next_step_ - kControlStep);
  const double share =
      std::clamp(static_cast<double>(into.count()) / static_cast<double>(kControlStep.count()), 0.0, 1.0);
  const ServoMotor& motor = motion_.motor();
  change_input(input, level, motor.last_position_rad() + share * (motor.position_rad() - motor.last_position_rad()));
}

/// The first values count from the start on.
void MsdDrive::start_scripts(std::chrono::nanoseconds now) noexcept {
  script_start_ = now;
  script_due_ = parameters_.inputs.empty() ? kNever : now;
  if (script_due_ == now) follow_scripts();
}

/// Everything that scripted inputs have done since script_due_, in order of time.
void MsdDrive::follow_scripts() noexcept {
  while (script_due_ <= *next_step_) {
    const auto at = std::exchange(script_due_, kNever);
    for (const ScriptedSignal& script : parameters_.inputs) {
      const double value = script.signal.at(at - script_start_);
      if (const auto terminal = input_terminal(script.input)) {
        change_between_steps(*terminal, value >= 0.5, at);
      } else {
        set_machine_input(*machine_input(script.input), value);
      }
      if (const auto next = script.signal.next_jump(at - script_start_)) {
        script_due_ = std::min(script_due_, script_start_ + *next);
      }
    }
  }
}

/// Changes within the control cycle that has just passed, at their places between its ends.
void MsdDrive::apply_scheduled_inputs() noexcept {
  std::size_t done = 0;
  for (; done < scheduled_count_ && scheduled_[done].at <= *next_step_; ++done) {
    change_between_steps(scheduled_[done].input, scheduled_[done].level, scheduled_[done].at);
  }
  if (done == 0) return;
  std::move(scheduled_.begin() + static_cast<std::ptrdiff_t>(done),
            scheduled_.begin() + static_cast<std::ptrdiff_t>(scheduled_count_), scheduled_.begin());
  scheduled_count_ -= static_cast<std::uint32_t>(done);
}

/// Before the events of a control cycle: what the controller armed counts for what the axis passes in it.
void MsdDrive::control_touch_probe() noexcept {
  const auto variant = static_cast<TouchProbe::Variant>(dictionary_.get<std::uint16_t>(kTouchProbeVariant));
  probe_.control(variant, dictionary_.get<std::uint16_t>(kTouchProbeFunction));
}

}  // namespace driveline::slaves::msd
