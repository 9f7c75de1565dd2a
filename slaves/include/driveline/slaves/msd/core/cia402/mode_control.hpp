#pragma once

#include <optional>

#include "driveline/slaves/cia402/homing_sequence.hpp"
#include "driveline/slaves/cia402/setpoint_handshake.hpp"
#include "driveline/slaves/cia402/words.hpp"
#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// The modes of operation (MSD manual 12): the active mode, its meaning of control word bits 4, 5, 6 and 8, the
/// movements that it commands, and its bits of the status word.
class ModeControl {
 public:
  /// The dictionary contains the settings of the modes and must outlive this.
  explicit ModeControl(const ObjectDictionary& dictionary) noexcept : dictionary_(&dictionary) {}

  /// Inputs of the modes in one process data cycle.
  struct Conditions {
    std::uint16_t control_word = 0;  ///< 6040h
    bool enabled = false;            ///< the setpoints of the bus are to be followed
    InputSignals inputs;             ///< limit and home switches, for homing
  };

  /// Selects the mode in 6060h if this drive has it. \rtsafe
  void select() noexcept;
  /// Returns the active mode, 6061h.
  [[nodiscard]] OperationMode mode() const noexcept { return mode_; }
  /// Whether 6060h accepts this mode of CiA 402; kNone is accepted. \rtsafe
  [[nodiscard]] static bool supported(OperationMode mode) noexcept;

  /// Returns the source of the setpoints for the motion. \rtsafe
  [[nodiscard]] MotionSource source(const Conditions& conditions) const noexcept;
  /// Returns kFollow unless the drive is halted. \rtsafe
  [[nodiscard]] MotionCommand command(const Conditions& conditions) const noexcept;

  /// Runs one process data cycle, after source and command were set in the motion. \rtsafe
  void step(const Conditions& conditions, DriveMotion& motion) noexcept;
  /// Finds whether the target is reached: the end of step(), and all of it that a mode needs while it follows cyclic
  /// setpoints. \rtsafe
  void update_reached(const DriveMotion& motion) noexcept;
  /// Runs one control cycle of the homing mode; returns true when homing has failed in it. While the axis is halted,
  /// homing still evaluates switches and index pulse, but its time-out does not advance. \rtsafe
  [[nodiscard]] bool step_homing(const InputSignals& inputs, DriveMotion& motion,
                                 std::chrono::nanoseconds time_out) noexcept;

  /// Returns bits 10, 12 and 13 of the status word, where the mode determines them. \rtsafe
  [[nodiscard]] std::uint16_t status_bits(const DriveMotion& motion) const noexcept {
    // Cyclic modes come first: most drives follow them.
    if (mode_ < OperationMode::kCyclicSynchronousPosition || halted_) return status_bits_otherwise(motion);
    return static_cast<std::uint16_t>((reached_ ? status_word::kTargetReached : 0U) |
                                      (entered_ != OperationMode::kNone ? status_word::kTargetUsed : 0U));
  }
  /// Whether a target or a speed was limited. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return limited_; }
  /// Returns the homing, for its state and failure. \rtsafe
  [[nodiscard]] const HomingSequence& homing() const noexcept { return homing_; }
  /// Whether the mode controls positions, so that the following error is monitored. \rtsafe
  [[nodiscard]] bool positioning() const noexcept;
  /// Resets to no mode, after the drive was switched off. \rtsafe
  void reset() noexcept;

 private:
  void enter(const Conditions& conditions, DriveMotion& motion) noexcept;
  void count_window(bool inside, std::uint16_t time_ms) noexcept;
  // Not inlined: the registers that it needs would be saved in every cycle.
  [[gnu::noinline]] void update_reached_otherwise(const DriveMotion& motion) noexcept;
  [[nodiscard]] std::uint16_t status_bits_otherwise(const DriveMotion& motion) const noexcept;
  void step_profile_position(const Conditions& conditions, DriveMotion& motion, bool resume) noexcept;
  void step_profile_velocity(DriveMotion& motion, bool resume) noexcept;
  void step_velocity(std::uint16_t control_word, DriveMotion& motion, bool resume) noexcept;
  [[nodiscard]] double velocity_mode_unit(const DriveMotion& motion) const noexcept;
  void start_homing(const Conditions& conditions, DriveMotion& motion) noexcept;
  [[nodiscard]] std::int64_t destination(const SetpointHandshake::Setpoint& setpoint,
                                         const DriveMotion& motion) noexcept;
  [[nodiscard]] HomingInputs homing_inputs(const InputSignals& inputs, const DriveMotion& motion) const noexcept;
  [[nodiscard]] GeneratorLimits profile_limits(const DriveMotion& motion) const noexcept;
  [[nodiscard]] double value(Slot<std::uint32_t> slot) const noexcept { return dictionary_->get(slot); }

  const ObjectDictionary* dictionary_;
  OperationMode mode_ = OperationMode::kNone;
  OperationMode entered_ = OperationMode::kNone;  ///< mode in which the drive is enabled; kNone: not enabled
  bool halted_ = false;
  bool limited_ = false;
  bool reached_ = false;
  bool speed_zero_ = false;
  bool slipping_ = false;
  bool homing_failed_ = false;
  bool start_bit_ = true;  ///< homing: control word bit 4 in the previous cycle
  std::chrono::nanoseconds window_time_{0};
  std::chrono::nanoseconds speed_time_{0};
  SetpointHandshake handshake_;
  std::int64_t target_ = 0;  ///< profile position, not wrapped
  std::optional<std::int32_t> ordered_velocity_;
  double ordered_speed_ = 0.0;     ///< ordered_velocity_ within its limit
  GeneratorLimits ordered_ramps_;  ///< limits of the ramp to ordered_speed_
  HomingSequence homing_;
  HomingSequence::Demand ordered_homing_;
};

}  // namespace driveline::slaves::msd
