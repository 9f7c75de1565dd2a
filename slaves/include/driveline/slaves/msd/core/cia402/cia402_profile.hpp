#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/msd/core/cia402/mode_control.hpp"
#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/profile/profile_types.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/msd/core/touch_probe.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// The profile CiA 402 (IEC 61800-7-201): state machine by the control word 6040h, modes of operation, units of the
/// factor group, status word 6041h. DriveProfile describes the functions. \rtsafe throughout.
class Cia402Profile {
 public:
  /// `dictionary` must outlive this.
  explicit Cia402Profile(ObjectDictionary& dictionary) noexcept : dictionary_(&dictionary), modes_(dictionary) {}

  /// Power-on.
  void reset() noexcept;

  /// 6060h accepts the modes that the drive has, 6098h its homing methods.
  [[nodiscard]] static bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept;
  /// Calculates the scaling from 607Eh, 6089h-608Dh, 608Fh and 6090h-6092h; sets the factors 6093h, 6094h and 6097h.
  [[nodiscard]] Scaling initialise_units(std::uint32_t encoder_increments) noexcept;
  /// The objects of the drive have everything.
  static void complete(const MotionSettings& /*settings*/) noexcept {}
  /// Control word, targets, offsets, and the interpolation sub mode 60C0h, which is P 370 with other numbers.
  [[nodiscard]] ProfileEffect written(std::uint16_t slot) noexcept;
  /// Whether P 165 selects CiA 402.
  [[nodiscard]] bool setpoints_from_bus() const noexcept {
    return dictionary_->get(kValue.reference_source) == kReferenceSourceCia402;
  }
  /// Setpoints for the mode in 6060h, or for the active mode when the drive does not have that one: setpoints sent
  /// together with a new mode are for this mode.
  [[nodiscard]] Setpoints setpoints(const MotionSettings& settings) const noexcept;
  /// 6040h, 6060h and 60B8h.
  [[nodiscard]] std::uint64_t commands() const noexcept {
    const auto mode = static_cast<std::uint8_t>(dictionary_->get(kValue.mode));
    return std::uint64_t{dictionary_->get(kValue.touch_probe_function)} << 32U | std::uint64_t{mode} << 16U |
           dictionary_->get(kValue.control_word);
  }
  /// Bit 7 of 6040h: an edge counts even if both levels occur between two evaluations.
  [[nodiscard]] bool takes_fault_reset() noexcept {
    const auto word = dictionary_->get(kValue.control_word);
    const bool rising = (word & ~last_control_word_ & control_word::kFaultReset) != 0;
    last_control_word_ = word;
    return rising && remote();
  }

  /// Takes the mode in 6060h.
  [[nodiscard]] bool select_mode() noexcept;
  /// Evaluates the control word.
  void step_state(const ProfileConditions& conditions) noexcept;
  /// Runs the mode of operation.
  void order(bool released, const InputSignals& inputs, DriveMotion& motion) noexcept;
  /// Evaluates windows and times of the mode.
  void watch_target(const DriveMotion& motion) noexcept { modes_.update_reached(motion); }
  /// Runs the homing mode.
  [[nodiscard]] bool step_homing(const InputSignals& inputs, DriveMotion& motion,
                                 std::chrono::nanoseconds time_out) noexcept {
    return modes_.step_homing(inputs, motion, time_out);
  }
  /// There are none.
  [[nodiscard]] static std::optional<Fault> takes_fault() noexcept { return std::nullopt; }
  /// 60B8h, in the variant of P 2285.
  void control(TouchProbe& probe) const noexcept;
  /// Whether 60B8h and P 2285 are those of the last control().
  [[nodiscard]] bool rests(const TouchProbe& probe) const noexcept;

  /// Reaction by 605Eh.
  void fault(bool coast) noexcept;
  /// Transition 15.
  [[nodiscard]] bool acknowledge() noexcept { return power_.acknowledge(); }
  /// State of the power drive system.
  [[nodiscard]] PowerState state() const noexcept { return power_.state(); }
  /// Command of the state machine.
  [[nodiscard]] MotionCommand command() const noexcept { return power_.motion(); }
  /// By state and 605Ah.
  [[nodiscard]] bool powers_off_at_standstill() const noexcept;
  /// Whether the homing mode is active.
  [[nodiscard]] bool homes() const noexcept { return modes_.mode() == OperationMode::kHoming; }

  /// 6061h, and the bits of 6041h that remain.
  void publish_state(bool dc_link) noexcept;
  /// The whole of 6041h.
  void publish_motion(const StatusFacts& facts, const DriveMotion& motion) noexcept;
  /// 6041h.
  [[nodiscard]] std::uint16_t status() const noexcept { return dictionary_->get(kValue.status_word); }
  /// Bit 11 of 6041h.
  [[nodiscard]] bool shows_limit() const noexcept { return (status() & status_word::kInternalLimit) != 0; }

 private:
  static constexpr std::uint16_t kControlLocationCia402 = 5;  // P 159
  static constexpr std::uint16_t kReferenceSourceCia402 = 7;  // P 165

  [[nodiscard]] bool remote() const noexcept {
    return dictionary_->get(kValue.control_location) == kControlLocationCia402;
  }
  [[nodiscard]] std::uint16_t control_word() const noexcept;
  [[nodiscard]] OptionCodes option_codes() const noexcept;
  [[nodiscard]] std::uint16_t motion_bits(const StatusFacts& facts, const DriveMotion& motion) const noexcept;

  ObjectDictionary* dictionary_;
  PowerStateMachine power_;
  ModeControl modes_;
  std::uint16_t state_bits_ = 0;         ///< bits of 6041h that publish_state() has found
  std::uint16_t last_control_word_ = 0;  ///< 6040h at the last takes_fault_reset()
};

inline Setpoints Cia402Profile::setpoints(const MotionSettings& settings) const noexcept {
  constexpr auto kInterpolated = OperationMode::kInterpolatedPosition;
  const auto wanted = static_cast<OperationMode>(dictionary_->get(kValue.mode));
  const bool interpolated =
      wanted == kInterpolated || (modes_.mode() == kInterpolated && !ModeControl::supported(wanted));
  const auto velocity = [&](std::int32_t units) { return units * settings.scaling.velocity_rad_s; };
  const auto torque = [&](double permille) { return permille * 1e-3 * settings.rated_torque_nm; };
  Setpoints setpoints;
  setpoints.position = dictionary_->get(interpolated ? kValue.interpolation_data : kValue.target_position);
  setpoints.velocity_rad_s = velocity(dictionary_->get(kValue.target_velocity));
  setpoints.torque_nm = torque(dictionary_->get(kValue.target_torque));
  setpoints.velocity_offset_rad_s = velocity(dictionary_->get(kValue.velocity_offset));
  setpoints.torque_offset_nm = torque(dictionary_->get(kValue.torque_offset));
  return setpoints;
}

}  // namespace driveline::slaves::msd
