#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/control/master_absence.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Moves the axes of a line in its cycle: all together along a path (Motion), or each by its own requests (SingleAxes).
/// All functions are for the cycle: \rtsafe.
class MotionControl {
 public:
  virtual ~MotionControl() = default;

  /// Reads the inputs of all axes. Arguments by slave position: `valid`: its process data are valid; `operational`: it
  /// also takes its outputs, otherwise the axis is unavailable; `fresh`: its inputs are from this cycle, not from an
  /// earlier one in which its group was due (empty: all are fresh). `took`: time from the start of the cycle to the
  /// arrival of the inputs. `late`: time by which the frames left after the grid instant; 0 or less: on time.
  virtual void read_inputs(std::span<const std::byte> image, std::span<const bool> valid,
                           std::span<const bool> operational, std::span<const bool> fresh,
                           std::chrono::nanoseconds took, std::chrono::nanoseconds late = {}) noexcept = 0;
  /// Advances the setpoints to grid cycle `cycle` and writes all outputs.
  virtual void update(std::int64_t cycle, std::span<std::byte> image) noexcept = 0;
  /// To be called before the outputs of grid cycle `cycle` are sent if `missed` periods before it were skipped:
  /// replaces the outputs prepared for the first of them by setpoints that the drives, which got none since then, can
  /// follow. After too long an absence it stops the axes.
  virtual AbsenceEffect resume(std::int64_t cycle, std::int64_t missed, std::span<std::byte> image) noexcept = 0;

  /// Delay of the path; 0 without a path.
  [[nodiscard]] virtual std::chrono::nanoseconds path_late() const noexcept = 0;
  /// Whether an axis has failed since the last start or reset.
  [[nodiscard]] virtual bool failed() const noexcept = 0;
  /// The axes, in the order of the line description.
  [[nodiscard]] virtual std::span<const Axis> axes() const noexcept = 0;
  /// Fills the sample of an axis, except cycle, time and axis number.
  virtual void fill(std::size_t axis, snapshot::AxisSample& sample) const noexcept { axes()[axis].fill(sample); }
  /// The setpoints of the last update(), one for each axis.
  [[nodiscard]] virtual std::span<const trajectory::AxisSetpoint> setpoints() const noexcept = 0;

 protected:
  MotionControl() = default;
  /// Copying is for implementations only.
  MotionControl(const MotionControl&) = default;
  MotionControl& operator=(const MotionControl&) = default;
};

}  // namespace driveline::motion
