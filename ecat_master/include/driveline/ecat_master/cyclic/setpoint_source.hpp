#pragma once

#include <span>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

/// What a source of setpoints is given in a cycle.
struct SetpointCycle {
  /// Since SetpointSource::begin(), without the time for which the drives were given no setpoints.
  double time_s = 0.0;
  std::span<const Axis> axes;  ///< their inputs() are those of this cycle
};

/// Where the setpoints of a Motion come from: a path, a task in the cycle, a stream. The motion brings the axes to
/// where the source begins, asks it for one setpoint of every axis per cycle, keeps what it gives within the limits of
/// the axes, and looks after drives, losses and stops.
///
/// All functions belong to the cycle: \rtsafe.
class SetpointSource {
 public:
  virtual ~SetpointSource() = default;

  /// How many axes it moves. Any thread.
  [[nodiscard]] virtual std::size_t axis_count() const noexcept = 0;
  /// Back to the beginning. `first` comes with where the axes stand, and goes with where they are to be at begin().
  virtual void rewind(std::span<trajectory::AxisSetpoint> first) noexcept = 0;
  /// The axes are where rewind() wanted them, at standstill. `running` false: they stay there until run(true).
  virtual void begin(bool running) noexcept = 0;
  /// The setpoints of this cycle; `setpoints` comes with those of the cycle before, as
  /// it has given them. False: these are the last ones, the
  /// axes hold them.
  [[nodiscard]] virtual bool next(const SetpointCycle& cycle,
                                  std::span<trajectory::AxisSetpoint> setpoints) noexcept = 0;
  /// The axes follow it no longer: they have been told to stop, have failed, or have arrived at the end.
  virtual void end() noexcept = 0;
  /// To come to rest where it is, because an axis is missing, or to go on. A source that cannot goes on as it likes:
  /// the axes follow.
  virtual void run(bool running) noexcept = 0;
  /// For `lost_s` the drives were given nothing of it.
  virtual void fall_behind(double lost_s) noexcept = 0;
  /// By how much it is late; 0 for one that keeps no time. \rtsafe
  [[nodiscard]] virtual double behind_s() const noexcept = 0;

 protected:
  SetpointSource() = default;
  /// A source is used where it is.
  SetpointSource(const SetpointSource&) = default;
  SetpointSource& operator=(const SetpointSource&) = default;
};

}  // namespace driveline::ecat_master
