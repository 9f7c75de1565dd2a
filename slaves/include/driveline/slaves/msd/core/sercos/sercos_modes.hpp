#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_mode.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_values.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// The operation modes of a ServoOne with SERCOS (manual, chapter 6): the mode in force, and the movements that it
/// commands where the drive generates the profile. \rtsafe throughout.
class SercosModes {
 public:
  /// The dictionary contains the values of the modes and must outlive this.
  explicit SercosModes(ObjectDictionary& dictionary) noexcept : dictionary_(&dictionary) {}

  /// Power-on.
  void reset() noexcept { *this = SercosModes(*dictionary_); }

  /// Takes the mode that the control word chooses. `live`: the control word is obeyed. A mode that is not set up sets
  /// bit 9 of S-0-0014, and the mode before stays (ours). Returns whether the mode has changed.
  [[nodiscard]] bool select(std::uint16_t control_word, bool live) noexcept;
  /// Returns the mode in force.
  [[nodiscard]] const SercosMode& mode() const noexcept { return mode_; }
  /// Returns which of S-0-0032 to S-0-0035 the mode in force is: 0 to 3.
  [[nodiscard]] std::uint8_t number() const noexcept { return number_; }

  /// Says whether the telegrams carry S-0-0346: then the drive's profile is positioning (ours, the manual has one code
  /// for both). Without it, positioning begins when S-0-0346 is written while the mode is in force.
  void carry_positioning(bool carried) noexcept { carried_ = carried; }
  /// Called when S-0-0346 was written.
  void positioning_written() noexcept { written_ = mode_.kind == SercosModeKind::kInterpolation; }

  /// Returns the source of the setpoints in the mode in force; kNone unless `enabled`.
  [[nodiscard]] MotionSource source(bool enabled) const noexcept;
  /// Runs one process data cycle, after command and source were set in the motion. `enabled`: the mode acts; `halted`:
  /// bit 13 of the control word holds the axis meanwhile.
  void step(bool enabled, bool halted, DriveMotion& motion) noexcept;
  /// Returns the deceleration of a drive halt: that of the movement in progress, P 2242 where the mode has none.
  [[nodiscard]] double halt_rad_s2(const DriveMotion& motion) const noexcept;
  /// Sets S-0-0336, and S-0-0430 in the modes that go to a target.
  void watch_target(const DriveMotion& motion) noexcept;

 private:
  enum class Order : std::uint8_t { kNone, kPosition, kSpeed };

  void enter(bool enabled, DriveMotion& motion) noexcept;
  void step_ramps(DriveMotion& motion) noexcept;
  void step_interpolation(DriveMotion& motion) noexcept;
  void step_positioning(DriveMotion& motion) noexcept;
  void take_target(std::uint16_t control, const DriveMotion& motion) noexcept;
  [[nodiscard]] std::int64_t destination(std::int32_t target, const DriveMotion& motion) const noexcept;
  [[nodiscard]] GeneratorLimits limits(const DriveMotion& motion) const noexcept;
  void order_position(const GeneratorLimits& limits, DriveMotion& motion) noexcept;
  void order_speed(double velocity_rad_s, const GeneratorLimits& limits, DriveMotion& motion) noexcept;
  [[nodiscard]] double value(Slot<std::uint32_t> slot) const noexcept { return dictionary_->get(slot); }

  ObjectDictionary* dictionary_;
  SercosMode mode_;
  std::uint8_t number_ = 0;
  bool carried_ = false;     ///< a telegram carries S-0-0346
  bool written_ = false;     ///< S-0-0346 was written in this mode
  bool entered_ = false;     ///< the mode acts
  bool take_bit_ = true;     ///< bit 0 of S-0-0346 in the cycle before
  bool has_target_ = false;  ///< target_ was taken in this mode
  Order ordered_ = Order::kNone;
  std::int32_t taken_ = 0;   ///< S-0-0258 that target_ is from
  std::int64_t target_ = 0;  ///< position units, not wrapped
  std::int64_t ordered_position_ = 0;
  double ordered_speed_ = 0.0;
  GeneratorLimits ordered_limits_;
};

}  // namespace driveline::slaves::msd
