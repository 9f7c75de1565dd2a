#pragma once

#include <optional>

#include "driveline/slaves/cia402/homing_sequence.hpp"
#include "driveline/slaves/cia402/setpoint_handshake.hpp"
#include "driveline/slaves/cia402/words.hpp"
#include "driveline/slaves/msd/core/motion.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// The modes of operation (MSD manual 12): the active one, its meaning of control word bits 4, 5, 6 and 8, the
/// movements it commands, and its bits of the status word.
class ModeControl {
 public:
  /// The dictionary holds the settings of the modes and must outlive this.
  explicit ModeControl(const ObjectDictionary& dictionary) noexcept : dictionary_(&dictionary) {}

  /// Inputs of the modes in one process data cycle.
  struct Conditions {
    std::uint16_t control_word = 0;  ///< 6040h
    bool enabled = false;            ///< the setpoints of the bus are to be followed
    InputSignals inputs;             ///< limit and home switches, for homing
  };

  /// Takes over 6060h if it is a mode of this drive. \rtsafe
  void select() noexcept;
  /// The mode in force, 6061h.
  [[nodiscard]] OperationMode mode() const noexcept { return mode_; }
  /// Modes of CiA 402 that 6060h takes; kNone is one of them. \rtsafe
  [[nodiscard]] static bool supported(OperationMode mode) noexcept;

  /// Source of the setpoints for motion. \rtsafe
  [[nodiscard]] MotionSource source(const Conditions& conditions) const noexcept;
  /// kFollow unless the drive is halted. \rtsafe
  [[nodiscard]] MotionCommand command(const Conditions& conditions) const noexcept;

  /// One process data cycle, after motion has been told source and command. \rtsafe
  void step(const Conditions& conditions, Motion& motion) noexcept;
  /// One control cycle of the homing mode; true when homing has failed in it. While the axis is halted it follows
  /// switches and index pulse all the same, only the time-out stands still. \rtsafe
  [[nodiscard]] bool step_homing(const InputSignals& inputs, Motion& motion,
                                 std::chrono::nanoseconds time_out) noexcept;

  /// Bits 10, 12 and 13 of the status word as far as the mode decides about them. \rtsafe
  [[nodiscard]] std::uint16_t status_bits(const Motion& motion) const noexcept;
  /// A target or a speed had to be cut. \rtsafe
  [[nodiscard]] bool limited() const noexcept { return limited_; }
  /// For its state and its failure. \rtsafe
  [[nodiscard]] const HomingSequence& homing() const noexcept { return homing_; }
  /// Operation with positions in which the following error counts. \rtsafe
  [[nodiscard]] bool positioning() const noexcept;
  /// Back to no mode; the drive was switched off. \rtsafe
  void reset() noexcept;

 private:
  void enter(const Conditions& conditions, Motion& motion) noexcept;
  void step_profile_position(const Conditions& conditions, Motion& motion, bool resume) noexcept;
  void step_profile_velocity(Motion& motion, bool resume) noexcept;
  void step_velocity(std::uint16_t control_word, Motion& motion, bool resume) noexcept;
  [[nodiscard]] double velocity_mode_unit(const Motion& motion) const noexcept;
  void start_homing(const Conditions& conditions, Motion& motion) noexcept;
  void update_reached(const Motion& motion) noexcept;
  [[nodiscard]] std::int64_t destination(const SetpointHandshake::Setpoint& setpoint, const Motion& motion) noexcept;
  [[nodiscard]] HomingInputs homing_inputs(const InputSignals& inputs, const Motion& motion) const noexcept;
  [[nodiscard]] ProfileLimits profile_limits(const Motion& motion) const noexcept;
  [[nodiscard]] double value(Slot<std::uint32_t> slot) const noexcept { return dictionary_->get(slot); }

  const ObjectDictionary* dictionary_;
  OperationMode mode_ = OperationMode::kNone;
  OperationMode entered_ = OperationMode::kNone;  ///< mode that has been entered, enabled
  bool halted_ = false;
  bool limited_ = false;
  bool in_window_ = false;
  bool reached_ = false;
  bool speed_zero_ = false;
  bool slipping_ = false;
  bool homing_failed_ = false;
  bool start_bit_ = true;  ///< homing: control word bit 4, one cycle ago
  std::chrono::nanoseconds window_time_{0};
  std::chrono::nanoseconds speed_time_{0};
  SetpointHandshake handshake_;
  std::int64_t target_ = 0;  ///< profile position, not wrapped
  std::optional<std::int32_t> ordered_velocity_;
  double ordered_speed_ = 0.0;   ///< of ordered_velocity_, within its limit
  ProfileLimits ordered_ramps_;  ///< on the way there
  HomingSequence homing_;
  HomingSequence::Demand ordered_homing_;
};

}  // namespace driveline::slaves::msd
