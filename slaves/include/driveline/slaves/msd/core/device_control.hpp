#pragma once

#include <chrono>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/msd/core/brake.hpp"
#include "driveline/slaves/msd/core/mode_control.hpp"
#include "driveline/slaves/msd/core/motion.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Device control (CiA 402): hardware enable, state machine, mode of operation and brake, and their commands to the
/// motion in each process data cycle.
class DeviceControl {
 public:
  /// All must outlive this.
  DeviceControl(const ObjectDictionary& dictionary, const Terminals& terminals, Motion& motion) noexcept
      : dictionary_(&dictionary), terminals_(&terminals), motion_(&motion), brake_(dictionary, terminals) {}

  /// Power-on. The brake keeps its place until follow_brake(). \rtsafe
  void reset() noexcept;

  /// \name One process data cycle, in this order
  /// Times are running times of the drive.
  /// @{

  /// Takes over 6060h. \rtsafe
  void select_mode() noexcept;
  /// The state machine. True: the power has just come on, and with it the units of the factor group come into force.
  /// \rtsafe
  [[nodiscard]] bool step_state(bool dc_link, std::chrono::nanoseconds now) noexcept;
  /// The brake, then the command to the motion. \rtsafe
  void order(std::chrono::nanoseconds now) noexcept;
  /// @}

  /// One control cycle of the homing mode; true when homing has failed in it. \rtsafe
  [[nodiscard]] bool step_homing(std::chrono::nanoseconds time_out) noexcept;
  /// The brake's output may have changed. \rtsafe
  void follow_brake(std::chrono::nanoseconds now) noexcept { brake_.follow(now); }

  /// Setpoints in the dictionary are new: followed from now on, \rtsafe
  void apply_setpoints() noexcept;
  /// or by the mode that is selected next. \rtsafe
  void prepare_setpoints() noexcept;

  /// A fault; `coast`: no reaction but switching off. \rtsafe
  void fault(bool coast) noexcept { power_.fault(option_codes_now(), coast); }
  /// Acknowledges a fault; false: there is none. \rtsafe
  [[nodiscard]] bool acknowledge() noexcept { return power_.acknowledge(); }

  /// The state machine of CiA 402. \rtsafe
  [[nodiscard]] const PowerStateMachine& power() const noexcept { return power_; }
  /// The mode in force. \rtsafe
  [[nodiscard]] OperationMode mode() const noexcept { return modes_.mode(); }
  /// The motor brake. \rtsafe
  [[nodiscard]] const Brake& brake() const noexcept { return brake_; }
  /// Hardware enable and safe torque off permit torque. \rtsafe
  [[nodiscard]] bool enabled_by_hardware() const noexcept {
    return terminals_->level(Input::kEnpo) && terminals_->level(Input::kIsdsh);
  }

  /// Further facts in the status word.
  struct StatusFacts {
    bool dc_link = false;          ///< the power stage has voltage
    bool warning = false;          ///< there is one
    bool following_error = false;  ///< it is too large, or was the cause of the standing fault
  };
  /// 6041h. \rtsafe
  [[nodiscard]] std::uint16_t status_word(const StatusFacts& facts) const noexcept;

 private:
  [[nodiscard]] OptionCodes option_codes_now() const noexcept;
  [[nodiscard]] bool power_ready(bool dc_link) const noexcept;
  [[nodiscard]] bool came_to_rest(std::chrono::nanoseconds now) const noexcept;
  [[nodiscard]] ModeControl::Conditions mode_conditions(std::chrono::nanoseconds now) const noexcept;

  const ObjectDictionary* dictionary_;
  const Terminals* terminals_;
  Motion* motion_;
  PowerStateMachine power_;
  ModeControl modes_{*dictionary_};
  Brake brake_;
};

}  // namespace driveline::slaves::msd
