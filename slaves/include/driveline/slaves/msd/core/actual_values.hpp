#pragma once

#include <cmath>
#include <cstdint>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/msd/core/touch_probe.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Publishes the motion in the object dictionary. Faults can make 6064h differ from the position that the drive uses
/// internally: MachineInput::kPositionError, kPositionHeld.
class ActualValues {
 public:
  /// Publishes all actual values and demands of the motion, in units of the bus and of the motor. \rtsafe
  void publish(const DriveMotion& motion, ObjectDictionary& dictionary) const noexcept;

  /// Adds `units` position units to 6064h. \rtsafe
  void set_position_error(double units) noexcept { position_error_ = std::llrint(units); }
  /// \rtsafe
  [[nodiscard]] std::int64_t position_error() const noexcept { return position_error_; }
  /// Freezes 6064h. \rtsafe
  void hold_position(bool held) noexcept { position_held_ = held; }
  /// \rtsafe
  [[nodiscard]] bool position_held() const noexcept { return position_held_; }

 private:
  std::int64_t position_error_ = 0;
  bool position_held_ = false;
};

/// Publishes the images of the terminals: P 121, P 143, 60FDh. \rtsafe
void publish(const Terminals& terminals, ObjectDictionary& dictionary) noexcept;
/// Publishes 60B9h-60BDh. \rtsafe
void publish(const TouchProbe& probe, ObjectDictionary& dictionary) noexcept;

}  // namespace driveline::slaves::msd
