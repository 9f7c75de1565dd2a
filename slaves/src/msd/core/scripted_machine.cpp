// The simulated machine: position switches, scripted and scheduled inputs.
#include "driveline/slaves/msd/core/scripted_machine.hpp"

#include <algorithm>
#include <utility>

#include "driveline/slaves/msd/core/control_clock.hpp"

namespace driveline::slaves::msd {

using std::chrono::nanoseconds;

ScriptedMachine::ScriptedMachine(const MsdParameters& parameters, const Terminals& terminals, const ServoMotor& motor,
                                 MachineEvents& events)
    : scripts_(parameters.inputs),
      terminals_(&terminals),
      motor_(&motor),
      events_(&events),
      switches_(parameters.switches) {}

void ScriptedMachine::pass(const MachineSwitch& s) noexcept {
  const double position = motor_->position_rad();
  const double last = motor_->last_position_rad();
  const bool upwards = position > last;
  const bool inside = position >= s.from_rad && position <= s.to_rad;
  const bool level = inside != s.normally_closed;
  if (level == terminals_->level(s.input)) return;
  const double edge = inside == upwards ? s.from_rad : s.to_rad;
  // At the start no edge has been passed.
  const bool passed = std::min(position, last) <= edge && edge <= std::max(position, last);
  events_->terminal_changed(s.input, level, passed ? edge : position);
}

bool ScriptedMachine::schedule(Input input, bool level, nanoseconds at) noexcept {
  if (scheduled_count_ == scheduled_.size()) return false;
  auto place = scheduled_.begin() + static_cast<std::ptrdiff_t>(scheduled_count_++);
  *place = {input, level, at};
  for (; place != scheduled_.begin() && (place - 1)->at > at; --place) std::swap(*place, *(place - 1));
  find_due();
  return true;
}

void ScriptedMachine::release(std::size_t input) noexcept {
  std::erase_if(scripts_, [input](const ScriptedSignal& script) { return script.input == input; });
  if (const auto terminal = input_terminal(input)) {
    std::erase_if(switches_, [&](const MachineSwitch& s) { return s.input == *terminal; });
  }
}

/// Interpolates the shaft position within the elapsed control cycle from its positions at the ends of the cycle.
void ScriptedMachine::change_within(const Change& change, nanoseconds cycle_end) noexcept {
  const auto into = change.at - (cycle_end - kControlStep);
  const double share =
      std::clamp(static_cast<double>(into.count()) / static_cast<double>(kControlStep.count()), 0.0, 1.0);
  const double last = motor_->last_position_rad();
  events_->terminal_changed(change.input, change.level, last + share * (motor_->position_rad() - last));
}

void ScriptedMachine::start(nanoseconds now, nanoseconds cycle_end) noexcept {
  script_start_ = now;
  script_due_ = scripts_.empty() ? kNever : now;
  if (script_due_ == now) follow_scripts(cycle_end);
  find_due();
}

void ScriptedMachine::find_due() noexcept {
  due_ = scheduled_count_ == 0 ? script_due_ : std::min(script_due_, scheduled_.front().at);
}

void ScriptedMachine::pass_due(nanoseconds cycle_end) noexcept {
  apply_scheduled(cycle_end);
  follow_scripts(cycle_end);
  find_due();
}

/// Reports all changes of scripted inputs since script_due_, in order of time.
void ScriptedMachine::follow_scripts(nanoseconds cycle_end) noexcept {
  while (script_due_ <= cycle_end) {
    const auto at = std::exchange(script_due_, kNever);
    for (const ScriptedSignal& script : scripts_) {
      const double value = script.signal.at(at - script_start_);
      if (const auto terminal = input_terminal(script.input)) {
        change_within({*terminal, value >= 0.5, at}, cycle_end);
      } else {
        events_->machine_input_changed(*machine_input(script.input), value);
      }
      if (const auto next = script.signal.next_jump(at - script_start_)) {
        script_due_ = std::min(script_due_, script_start_ + *next);
      }
    }
  }
}

void ScriptedMachine::apply_scheduled(nanoseconds cycle_end) noexcept {
  std::size_t done = 0;
  for (; done < scheduled_count_ && scheduled_[done].at <= cycle_end; ++done) {
    change_within(scheduled_[done], cycle_end);
  }
  if (done == 0) return;
  std::move(scheduled_.begin() + static_cast<std::ptrdiff_t>(done),
            scheduled_.begin() + static_cast<std::ptrdiff_t>(scheduled_count_), scheduled_.begin());
  scheduled_count_ -= done;
}

}  // namespace driveline::slaves::msd
