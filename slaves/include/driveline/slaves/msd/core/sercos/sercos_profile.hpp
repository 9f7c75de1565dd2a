#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/profile/profile_types.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_modes.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_scale.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_states.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_values.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/msd/core/touch_probe.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// The profile SERCOS (ServoOne SERCOS manual): state machine by S-0-0134, modes by S-0-0032 to S-0-0035, status word
/// S-0-0135. DriveProfile describes the functions. The control word counts in phase 4 alone, with P 159 = 6 and
/// P 165 = 8. Its front end raises a fault before it leaves phase 4 with the power on. \rtsafe throughout.
///
/// Procedure commands other than S-0-0099, homing and probes among them, are not part of it.
class SercosProfile {
 public:
  /// `dictionary` has the values SercosValues and must outlive this.
  explicit SercosProfile(ObjectDictionary& dictionary) noexcept : dictionary_(&dictionary), modes_(dictionary) {}

  /// Power-on.
  void reset() noexcept;

  /// Sets the conversion of the operation data; it takes effect with the next initialise_units(). Without one it is the
  /// preferred rotary weighting.
  void use(const SercosScale& scale) noexcept { next_scale_ = scale; }
  /// Returns the conversion in effect.
  [[nodiscard]] const SercosScale& scale() const noexcept { return scale_; }
  /// See SercosModes::carry_positioning().
  void carry_positioning(bool carried) noexcept { modes_.carry_positioning(carried); }

  /// S-0-0032 to S-0-0035 accept 0 and the modes that the drive has.
  [[nodiscard]] static bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept;
  /// Takes the scale of use().
  [[nodiscard]] Scaling initialise_units(std::uint32_t encoder_increments) noexcept;
  /// Sets what SERCOS has instead of objects of CiA 402: cycle, limits, stops, range, feed-forward.
  void complete(MotionSettings& settings) noexcept;
  /// Control words, setpoints; other values are settings.
  [[nodiscard]] ProfileEffect written(std::uint16_t slot) noexcept;
  /// Whether P 165 selects SERCOS.
  [[nodiscard]] bool setpoints_from_bus() const noexcept {
    return dictionary_->get(kValue.reference_source) == kReferenceSourceSercos;
  }
  /// Setpoints of all modes.
  [[nodiscard]] Setpoints setpoints(const MotionSettings& settings) const noexcept;
  /// S-0-0134, S-0-0346 and S-0-0099.
  [[nodiscard]] std::uint64_t commands() const noexcept {
    return std::uint64_t{dictionary_->get(kSercosValue.reset_class_1)} << 32U |
           std::uint64_t{dictionary_->get(kSercosValue.positioning_control)} << 16U |
           dictionary_->get(kSercosValue.control_word);
  }
  /// S-0-0099, set and enabled.
  [[nodiscard]] bool takes_fault_reset() noexcept;

  /// Takes the mode that S-0-0134 chooses.
  [[nodiscard]] bool select_mode() noexcept { return modes_.select(control_word(), live()); }
  /// Evaluates bits 15 and 14 of S-0-0134.
  void step_state(const ProfileConditions& conditions) noexcept;
  /// Runs state 4, or the mode, or the halt of bit 13.
  void order(bool released, const InputSignals& inputs, DriveMotion& motion) noexcept;
  /// Sets S-0-0336 and S-0-0430.
  void watch_target(const DriveMotion& motion) noexcept { modes_.watch_target(motion); }
  /// There is no homing.
  [[nodiscard]] static bool step_homing(const InputSignals& /*inputs*/, DriveMotion& /*motion*/,
                                        std::chrono::nanoseconds /*time_out*/) noexcept {
    return false;
  }
  /// There are no probes.
  static void control(TouchProbe& probe) noexcept { probe.control(TouchProbe::Variant::kOff, 0); }
  /// There are no probes.
  [[nodiscard]] static bool rests(const TouchProbe& probe) noexcept {
    return probe.rests(TouchProbe::Variant::kOff, 0);
  }
  /// Returns a fault that order() has found in state 4: the axis is too far from the setpoint (P 743), or the mode asks
  /// for another position encoder than P 522.
  [[nodiscard]] std::optional<Fault> takes_fault() noexcept { return std::exchange(found_fault_, std::nullopt); }

  /// Reaction by P 2222.
  void fault(bool coast) noexcept { states_.fault(option_codes(), coast); }
  /// Only S-0-0099 resets faults (lines 646-648).
  [[nodiscard]] bool acknowledge() noexcept { return std::exchange(reset_asked_, false) && states_.acknowledge(); }
  /// State of the drive.
  [[nodiscard]] PowerState state() const noexcept { return states_.state(); }
  /// Command of the state machine.
  [[nodiscard]] MotionCommand command() const noexcept { return states_.command(); }
  /// See SercosStates.
  [[nodiscard]] bool powers_off_at_standstill() const noexcept { return states_.powers_off_at_standstill(); }
  /// There is no homing.
  [[nodiscard]] static bool homes() noexcept { return false; }

  /// Finds the bits of S-0-0135 that remain, and P 377.
  void publish_state(bool dc_link) noexcept;
  /// The whole of S-0-0135, and S-0-0084.
  void publish_motion(const StatusFacts& facts, const DriveMotion& motion) noexcept;
  /// S-0-0135.
  [[nodiscard]] std::uint16_t status() const noexcept { return dictionary_->get(kSercosValue.status_word); }
  /// Whether a setpoint was limited when S-0-0135 was published; the word has no bit for it.
  [[nodiscard]] bool shows_limit() const noexcept { return limited_; }

 private:
  static constexpr std::uint16_t kControlLocationSercos = 6;  // P 159
  static constexpr std::uint16_t kReferenceSourceSercos = 8;  // P 165

  [[nodiscard]] bool live() const noexcept;
  [[nodiscard]] std::uint16_t control_word() const noexcept {
    return live() ? dictionary_->get(kSercosValue.control_word) : std::uint16_t{0};
  }
  [[nodiscard]] bool halted() const noexcept { return states_.in_control() && (control_word() & kStartBit) == 0; }
  [[nodiscard]] MotionCommand halt_command() const noexcept;
  [[nodiscard]] OptionCodes option_codes() const noexcept;
  /// Share of a feed-forward in the mode in force, 0 to 1.
  [[nodiscard]] double share(Slot<float> percent) const noexcept {
    return modes_.mode().feed_forward ? dictionary_->get(percent) * 1e-2 : 0.0;
  }
  void order_start(bool released, DriveMotion& motion) noexcept;
  void move_to_setpoint(DriveMotion& motion) noexcept;

  static constexpr std::uint16_t kStartBit = 0x2000;  // bit 13 of S-0-0134

  ObjectDictionary* dictionary_;
  SercosStates states_;
  SercosModes modes_;
  SercosScale scale_;
  std::optional<SercosScale> next_scale_;
  std::optional<Fault> found_fault_;
  std::optional<std::int64_t> start_target_;  ///< state 4: where MOVE_COMMAND moves the axis
  std::uint16_t state_bits_ = 0;              ///< bits of S-0-0135 that publish_state() has found
  double halt_rad_s2_ = 0.0;                  ///< deceleration of a halt; 0: P 2242
  bool in_place_ = false;                     ///< state 4 has ended
  bool limited_ = false;
  bool reset_asked_ = false;
  bool reset_was_set_ = false;  ///< S-0-0099 at the last takes_fault_reset()
};

}  // namespace driveline::slaves::msd
