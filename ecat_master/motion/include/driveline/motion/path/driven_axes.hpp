#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "driveline/motion/control/setpoint_source.hpp"

namespace driveline::motion {

/// Handle by which a task of the cycle drives an axis. For the cycle only: \rtsafe.
class DrivenAxis {
 public:
  /// Whether the axis has power and follows its commands. Before that it holds its position, and a controller starts
  /// from there.
  [[nodiscard]] bool followed() const noexcept { return followed_; }
  /// Whether another axis of the line is missing: the task must bring this axis to rest and hold it until this is false
  /// again.
  [[nodiscard]] bool to_rest() const noexcept { return followed_ && to_rest_; }

  /// Commands the axis until the next command. The setpoint of a task that runs in every n-th cycle is reached in n
  /// cycles by linear interpolation, so that the drive sees no steps; a torque acts at once. Setpoints beyond the
  /// limits of the axis and values that are not finite stop the line (MotionFailure). Has no effect while the axis does
  /// not follow.
  void command(const trajectory::AxisSetpoint& setpoint) noexcept;

 private:
  friend class DrivenAxes;

  void hold(double position) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint next(double period_s) noexcept;

  std::uint32_t cycles_ = 1;  ///< cycles between two commands
  std::uint32_t left_ = 0;    ///< cycles left until the commanded position is reached
  double position_ = 0.0;     ///< position of the last setpoint
  trajectory::AxisSetpoint command_{};
  bool followed_ = false;
  bool to_rest_ = false;
};

/// Setpoints of a line whose axes are driven by tasks of the cycle. An axis that no task drives, or that has not been
/// commanded yet, holds the position at which it was enabled.
class DrivenAxes final : public SetpointSource {
 public:
  /// `cycles`: for each axis, cycles between two commands, at least 1.
  explicit DrivenAxes(std::vector<std::uint32_t> cycles, double period_s);

  /// Handle of an axis; valid as long as this object.
  [[nodiscard]] DrivenAxis& axis(std::size_t number) noexcept { return axes_[number]; }

  [[nodiscard]] std::size_t axis_count() const noexcept override { return axes_.size(); }
  void rewind(std::span<trajectory::AxisSetpoint> first) noexcept override;
  void begin(bool running) noexcept override;
  [[nodiscard]] bool next(const SetpointCycle& cycle, std::span<trajectory::AxisSetpoint> setpoints) noexcept override;
  void end() noexcept override;
  void run(bool running) noexcept override;
  void fall_behind(double) noexcept override {}
  [[nodiscard]] double behind_s() const noexcept override { return 0.0; }

 private:
  std::vector<DrivenAxis> axes_;
  double period_s_;
};

}  // namespace driveline::motion
