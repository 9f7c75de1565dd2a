#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "driveline/ecat_master/cyclic/setpoint_source.hpp"

namespace driveline::ecat_master {

/// The handle by which a task of the cycle drives one axis. Belongs to the cycle: \rtsafe.
class DrivenAxis {
 public:
  /// The axis has power and follows what it is commanded. Before that it holds its place, and a controller begins from
  /// where it stands.
  [[nodiscard]] bool followed() const noexcept { return followed_; }
  /// Another axis of the line is missing: the task is to bring this one to rest, and to hold it until this is over.
  [[nodiscard]] bool to_rest() const noexcept { return followed_ && to_rest_; }

  /// What the axis is to do from now on, until the next command. The command of a task that runs in every n-th cycle is
  /// arrived at in n cycles, on a straight line, so that the drive sees no steps; a torque counts at once. Setpoints
  /// that the limits of the axis do not allow, or that are no numbers, stop the line (MotionFailure). Without effect
  /// while the axis does not follow.
  void command(const trajectory::AxisSetpoint& setpoint) noexcept;

 private:
  friend class DrivenAxes;

  void hold(double position) noexcept;
  [[nodiscard]] trajectory::AxisSetpoint next(double period_s) noexcept;

  std::uint32_t cycles_ = 1;  ///< from one command to the next
  std::uint32_t left_ = 0;    ///< until the axis is where the command wants it
  double position_ = 0.0;     ///< of the last setpoint
  trajectory::AxisSetpoint command_{};
  bool followed_ = false;
  bool to_rest_ = false;
};

/// The setpoints of a line whose axes are driven by tasks of the cycle. An axis that no task drives, or that has not
/// been commanded yet, holds the place where it was enabled.
class DrivenAxes final : public SetpointSource {
 public:
  /// `cycles`: by axis, how many cycles lie between two commands, 1 at least.
  explicit DrivenAxes(std::vector<std::uint32_t> cycles, double period_s);

  /// Lives as long as this.
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

}  // namespace driveline::ecat_master
