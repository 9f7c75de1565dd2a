#pragma once

#include <span>

#include "driveline/ecat_master/cyclic/master_absence.hpp"
#include "driveline/ecat_master/cyclic/setpoint_source.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path_clock.hpp"

namespace driveline::ecat_master {

/// The setpoints of a path.
class PathSource final : public SetpointSource {
 public:
  /// `limits`, one for each axis of the path, say how fast it comes to rest and, where it may, catches up. Evaluates
  /// the path at some thousand points; for start-up.
  PathSource(trajectory::Interpolator path, std::span<const trajectory::AxisLimits> limits, LatePolicy late);

  [[nodiscard]] std::size_t axis_count() const noexcept override { return path_.axes().size(); }
  void rewind(std::span<trajectory::AxisSetpoint> first) noexcept override;
  void begin(bool running) noexcept override;
  [[nodiscard]] bool next(const SetpointCycle& cycle, std::span<trajectory::AxisSetpoint> setpoints) noexcept override;
  void end() noexcept override {}
  void run(bool running) noexcept override { clock_.run(running); }
  void fall_behind(double lost_s) noexcept override { clock_.fall_behind(lost_s); }
  [[nodiscard]] double behind_s() const noexcept override { return clock_.behind_s(); }

 private:
  trajectory::Interpolator path_;
  trajectory::PathClock clock_;
};

}  // namespace driveline::ecat_master
