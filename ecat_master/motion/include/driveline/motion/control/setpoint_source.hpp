#pragma once

#include <span>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

/// Input of a source of setpoints in a cycle.
struct SetpointCycle {
  /// Time since SetpointSource::begin(), without periods in which the drives got no setpoints.
  double time_s = 0.0;
  std::span<const Axis> axes;  ///< with the inputs() of this cycle
};

/// Source of the setpoints of a Motion: a path, a task in the cycle, a stream. The motion brings the axes to the start
/// of the source, gets one setpoint per axis and cycle from it, keeps the setpoints within the limits of the axes, and
/// supervises drives, losses and stops.
///
/// All functions are for the cycle: \rtsafe.
class SetpointSource {
 public:
  virtual ~SetpointSource() = default;

  /// Number of axes that the source moves. Any thread.
  [[nodiscard]] virtual std::size_t axis_count() const noexcept = 0;
  /// Resets the source to its start. `first` holds the present positions of the axes; the source sets it to those at
  /// begin().
  virtual void rewind(std::span<trajectory::AxisSetpoint> first) noexcept = 0;
  /// The axes are at standstill at the positions set by rewind(). `running` false: they stay there until run(true).
  virtual void begin(bool running) noexcept = 0;
  /// Replaces `setpoints`, which contain those of the previous cycle, by those of this cycle. Returns false if these
  /// are the last ones, which the axes then hold.
  [[nodiscard]] virtual bool next(const SetpointCycle& cycle,
                                  std::span<trajectory::AxisSetpoint> setpoints) noexcept = 0;
  /// The axes no longer follow the source: they were commanded to stop, have failed, or have reached the end.
  virtual void end() noexcept = 0;
  /// Asks the source to come to rest because an axis is missing (false), or to continue (true). A source that cannot
  /// may ignore it: the axes follow anyway.
  virtual void run(bool running) noexcept = 0;
  /// For `lost_s` seconds the drives got no setpoints of this source.
  virtual void fall_behind(double lost_s) noexcept = 0;
  /// Delay of the source, s; 0 if it keeps no time. \rtsafe
  [[nodiscard]] virtual double behind_s() const noexcept = 0;

 protected:
  SetpointSource() = default;
  /// Copying is for implementations only: sources are used by reference.
  SetpointSource(const SetpointSource&) = default;
  SetpointSource& operator=(const SetpointSource&) = default;
};

}  // namespace driveline::motion
