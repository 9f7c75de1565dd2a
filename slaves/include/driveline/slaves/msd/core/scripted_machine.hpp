#pragma once

#include <array>
#include <chrono>
#include <vector>

#include "driveline/slaves/msd/core/drive_signals.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves::msd {

/// Who hears what the machine does. \rtsafe
class MachineEvents {
 public:
  virtual ~MachineEvents() = default;
  /// A terminal has another level since the motor shaft was at `position_rad`.
  virtual void terminal_changed(Input input, bool level, double position_rad) noexcept = 0;
  /// What comes from the machine by other ways has another value.
  virtual void machine_input_changed(MachineInput input, double value) noexcept = 0;
};

/// The machine around the drive, as far as it acts by itself: switches on the way of the shaft, inputs that follow a
/// script, changes that somebody has scheduled. It finds where the shaft was when an input changed within a control
/// cycle.
class ScriptedMachine {
 public:
  /// The references must outlive this.
  ScriptedMachine(const MsdParameters& parameters, const Terminals& terminals, const ServoMotor& motor,
                  MachineEvents& events);

  /// Scripts count from here on; their first values are told at once. `cycle_end`: of the control cycle that begins.
  /// \rtsafe
  void start(std::chrono::nanoseconds now, std::chrono::nanoseconds cycle_end) noexcept;
  /// The shaft has moved: switches that it has passed. \rtsafe
  void pass_switches() noexcept {
    for (const MachineSwitch& s : switches_) pass(s);
  }
  /// Everything scheduled and scripted up to `cycle_end`, the end of the control cycle that has passed. \rtsafe
  void pass_time(std::chrono::nanoseconds cycle_end) noexcept {
    if (scheduled_count_ != 0) apply_scheduled(cycle_end);
    if (script_due_ <= cycle_end) follow_scripts(cycle_end);
  }

  /// An input that changes at this time; in order of time; false when too many changes wait. \rtsafe
  [[nodiscard]] bool schedule(Input input, bool level, std::chrono::nanoseconds at) noexcept;
  /// Somebody else sets this input from now on: a number of a SignalPlace. \rtsafe
  void release(std::size_t input) noexcept;

 private:
  static constexpr std::chrono::nanoseconds kNever = std::chrono::nanoseconds::max();
  struct Change {
    Input input = Input::kIsd00;
    bool level = false;
    std::chrono::nanoseconds at{0};
  };

  void pass(const MachineSwitch& s) noexcept;
  void follow_scripts(std::chrono::nanoseconds cycle_end) noexcept;
  void apply_scheduled(std::chrono::nanoseconds cycle_end) noexcept;
  void change_within(const Change& change, std::chrono::nanoseconds cycle_end) noexcept;

  std::vector<MachineSwitch> switches_;
  std::vector<ScriptedSignal> scripts_;
  const Terminals* terminals_;
  const ServoMotor* motor_;
  MachineEvents* events_;
  std::array<Change, 16> scheduled_{};
  std::size_t scheduled_count_ = 0;
  std::chrono::nanoseconds script_due_ = kNever;  ///< when the next scripted input jumps
  std::chrono::nanoseconds script_start_{0};
};

}  // namespace driveline::slaves::msd
