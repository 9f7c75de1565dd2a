#pragma once

#include <array>
#include <chrono>
#include <vector>

#include "driveline/slaves/msd/core/drive_signals.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"

namespace driveline::slaves::msd {

/// Receives the events of the machine. \rtsafe
class MachineEvents {
 public:
  virtual ~MachineEvents() = default;
  /// Called when a terminal has changed its level while the motor shaft was at `position_rad`.
  virtual void terminal_changed(Input input, bool level, double position_rad) noexcept = 0;
  /// Called when an input that is not a terminal has changed.
  virtual void machine_input_changed(MachineInput input, double value) noexcept = 0;
};

/// The simulated machine: position switches on the shaft, inputs that follow a script, scheduled changes. It determines
/// the shaft position when an input changed within a control cycle.
class ScriptedMachine {
 public:
  /// All references must outlive this.
  ScriptedMachine(const MsdParameters& parameters, const Terminals& terminals, const ServoMotor& motor,
                  MachineEvents& events);

  /// Starts the scripts and reports their first values. `cycle_end`: end of the control cycle that starts. \rtsafe
  void start(std::chrono::nanoseconds now, std::chrono::nanoseconds cycle_end) noexcept;
  /// Reports the switches that the shaft has passed. \rtsafe
  void pass_switches() noexcept {
    for (const MachineSwitch& s : switches_) pass(s);
  }
  /// Reports all scheduled and scripted changes up to `cycle_end`, the end of the elapsed control cycle. \rtsafe
  void pass_time(std::chrono::nanoseconds cycle_end) noexcept {
    if (due_ <= cycle_end) pass_due(cycle_end);
  }

  /// Schedules a change of an input at this time; returns false when too many changes wait. \rtsafe
  [[nodiscard]] bool schedule(Input input, bool level, std::chrono::nanoseconds at) noexcept;
  /// Ends the script or switches of this input (number of a SignalId), so that it can be set from outside. \rtsafe
  void release(std::size_t input) noexcept;

 private:
  static constexpr std::chrono::nanoseconds kNever = std::chrono::nanoseconds::max();
  struct Change {
    Input input = Input::kIsd00;
    bool level = false;
    std::chrono::nanoseconds at{0};
  };

  [[gnu::cold]] void pass(const MachineSwitch& s) noexcept;  // few machines have switches
  [[gnu::cold]] void pass_due(std::chrono::nanoseconds cycle_end) noexcept;
  void find_due() noexcept;
  void follow_scripts(std::chrono::nanoseconds cycle_end) noexcept;
  void apply_scheduled(std::chrono::nanoseconds cycle_end) noexcept;
  void change_within(const Change& change, std::chrono::nanoseconds cycle_end) noexcept;

  std::vector<ScriptedSignal> scripts_;
  const Terminals* terminals_;
  const ServoMotor* motor_;
  MachineEvents* events_;
  std::chrono::nanoseconds script_due_ = kNever;  ///< time of the next jump of a scripted input
  std::size_t scheduled_count_ = 0;
  std::array<Change, 16> scheduled_{};  ///< in order of time
  std::chrono::nanoseconds script_start_{0};
  // Every cycle uses these two.
  std::vector<MachineSwitch> switches_;
  std::chrono::nanoseconds due_ = kNever;  ///< time of the next change of any kind
};

}  // namespace driveline::slaves::msd
