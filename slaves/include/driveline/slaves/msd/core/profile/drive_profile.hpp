#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <variant>

#include "driveline/slaves/msd/core/cia402/cia402_profile.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_profile.hpp"

namespace driveline::slaves::msd {

/// The drive profile: what a drive makes of the objects with which a controller commands it, and what it shows. A
/// closed set of types, so that the control cycle makes no virtual call: CiA 402 and SERCOS. The rest of the core knows
/// no word, mode or unit of a profile.
///
/// Everything but the constructor is \rtsafe.
class DriveProfile {
 public:
  using Effect = ProfileEffect;          ///< effect of a written object
  using Conditions = ProfileConditions;  ///< conditions of the state machine

  /// `dictionary` contains the objects of the profile and must outlive this.
  DriveProfile(ObjectDictionary& dictionary, ProfileKind kind) noexcept : profile_(Cia402Profile(dictionary)) {
    if (kind == ProfileKind::kSercos) profile_.emplace<SercosProfile>(dictionary);
  }

  /// Returns the profile SERCOS; null in a drive with another one.
  [[nodiscard]] SercosProfile* sercos() noexcept { return std::get_if<SercosProfile>(&profile_); }

  /// Power-on.
  void reset() noexcept {
    visit([](auto& profile) { profile.reset(); });
  }

  /// \name Objects
  /// @{

  /// Whether an object of a profile can have this value; true for other objects.
  [[nodiscard]] static bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept {
    return Cia402Profile::possible_value(row, raw) && SercosProfile::possible_value(row, raw);
  }
  /// Units of the objects in effect from now on, calculated from their settings; sets the factors that the profile
  /// shows. `encoder_increments`: of the motor, per revolution.
  [[nodiscard]] Scaling initialise_units(std::uint32_t encoder_increments) noexcept {
    return visit([=](auto& profile) { return profile.initialise_units(encoder_increments); });
  }
  /// Sets what the profile has instead of objects that the drive's settings are read from.
  void complete(MotionSettings& settings) noexcept {
    visit([&](auto& profile) { profile.complete(settings); });
  }
  /// Effect of a write to the object in this slot.
  [[nodiscard]] Effect written(std::uint16_t slot) noexcept {
    return visit([=](auto& profile) { return profile.written(slot); });
  }
  /// Whether the setpoints of the bus are selected (P 165).
  [[nodiscard]] bool setpoints_from_bus() const noexcept {
    return look([](const auto& profile) { return profile.setpoints_from_bus(); });
  }
  /// Setpoints in the objects, in the units of these settings.
  [[nodiscard]] Setpoints setpoints(const MotionSettings& settings) const noexcept {
    return look([&](const auto& profile) { return profile.setpoints(settings); });
  }
  /// The command objects as one number, for comparison.
  [[nodiscard]] std::uint64_t commands() const noexcept {
    return look([](const auto& profile) { return profile.commands(); });
  }
  /// Whether the objects reset a fault since the last call: the reset acts on an edge.
  [[nodiscard]] bool takes_fault_reset() noexcept {
    return visit([](auto& profile) { return profile.takes_fault_reset(); });
  }
  /// @}

  /// \name One process data cycle, in this order
  /// @{

  /// Selects the mode in the objects. Returns whether it has changed: setpoints are then those of the new mode.
  [[nodiscard]] bool select_mode() noexcept {
    return visit([](auto& profile) { return profile.select_mode(); });
  }
  /// Steps the state machine.
  void step_state(const Conditions& conditions) noexcept {
    visit([&](auto& profile) { profile.step_state(conditions); });
  }
  /// Commands the motion. `released`: the brake is open.
  void order(bool released, const InputSignals& inputs, DriveMotion& motion) noexcept {
    visit([&](auto& profile) { profile.order(released, inputs, motion); });
  }
  /// Returns a fault that order() has found, once.
  [[nodiscard]] std::optional<Fault> takes_fault() noexcept {
    return visit([](auto& profile) { return profile.takes_fault(); });
  }
  /// @}

  /// Finds whether the target is reached: the end of order(), and all of it that a drive needs while it follows cyclic
  /// setpoints.
  void watch_target(const DriveMotion& motion) noexcept {
    visit([&](auto& profile) { profile.watch_target(motion); });
  }
  /// Runs one control cycle of homing; returns true when homing has failed in it.
  [[nodiscard]] bool step_homing(const InputSignals& inputs, DriveMotion& motion,
                                 std::chrono::nanoseconds time_out) noexcept {
    return visit([&](auto& profile) { return profile.step_homing(inputs, motion, time_out); });
  }
  /// Arms and reads the touch probe; to be called before the events of a control cycle, so that its edges find the
  /// armed latches.
  void control(TouchProbe& probe) const noexcept {
    look([&](const auto& profile) { profile.control(probe); });
  }
  /// Whether control() would change nothing.
  [[nodiscard]] bool rests(const TouchProbe& probe) const noexcept {
    return look([&](const auto& profile) { return profile.rests(probe); });
  }

  /// \name State
  /// @{

  /// Reports a fault; `coast`: no reaction but switching off.
  void fault(bool coast) noexcept {
    visit([=](auto& profile) { profile.fault(coast); });
  }
  /// Acknowledges a fault; returns false when there is none.
  [[nodiscard]] bool acknowledge() noexcept {
    return visit([](auto& profile) { return profile.acknowledge(); });
  }
  /// State of the drive.
  [[nodiscard]] PowerState state() const noexcept {
    return look([](const auto& profile) { return profile.state(); });
  }
  /// Command of the state machine for the motor.
  [[nodiscard]] MotionCommand command() const noexcept {
    return look([](const auto& profile) { return profile.command(); });
  }
  /// Whether the motor is under control.
  [[nodiscard]] bool power_on() const noexcept { return command() != MotionCommand::kOff; }
  /// Whether the controlled stop in progress ends with the power stage off.
  [[nodiscard]] bool powers_off_at_standstill() const noexcept {
    return look([](const auto& profile) { return profile.powers_off_at_standstill(); });
  }
  /// Whether homing is selected, which uses the limit switches itself.
  [[nodiscard]] bool homes() const noexcept {
    return look([](const auto& profile) { return profile.homes(); });
  }
  /// @}

  /// \name What the drive shows
  /// @{

  /// Publishes what changes with state, mode, setting or DC link: in a drive that only follows its setpoints it
  /// remains.
  void publish_state(bool dc_link) noexcept {
    visit([=](auto& profile) { profile.publish_state(dc_link); });
  }
  /// Publishes what changes with the motion, after publish_state().
  void publish_motion(const StatusFacts& facts, const DriveMotion& motion) noexcept {
    visit([&](auto& profile) { profile.publish_motion(facts, motion); });
  }
  /// The status as last published; CiA 402: 6041h.
  [[nodiscard]] std::uint16_t status() const noexcept {
    return look([](const auto& profile) { return profile.status(); });
  }
  /// Whether the status shows that a setpoint is limited.
  [[nodiscard]] bool shows_limit() const noexcept {
    return look([](const auto& profile) { return profile.shows_limit(); });
  }
  /// @}

 private:
  // A branch that is predicted, instead of the table of std::visit(); CiA 402 is the usual profile.
  template <typename Action>
  std::invoke_result_t<const Action&, Cia402Profile&> visit(const Action& action) noexcept {
    if (auto* sercos = std::get_if<SercosProfile>(&profile_)) [[unlikely]]
      return action(*sercos);
    return action(*std::get_if<Cia402Profile>(&profile_));
  }
  template <typename Action>
  std::invoke_result_t<const Action&, const Cia402Profile&> look(const Action& action) const noexcept {
    if (const auto* sercos = std::get_if<SercosProfile>(&profile_)) [[unlikely]]
      return action(*sercos);
    return action(*std::get_if<Cia402Profile>(&profile_));
  }

  std::variant<Cia402Profile, SercosProfile> profile_;
};

}  // namespace driveline::slaves::msd
