#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/motion/control/master_absence.hpp"
#include "driveline/motion/control/setpoint_source.hpp"
#include "driveline/motion/path/path_leads.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path_clock.hpp"

namespace driveline::motion {

/// The setpoints of a path.
class PathSource final : public SetpointSource {
 public:
  /// `limits`, one for each axis of the path, apply when the path stops and when it catches up. Evaluates the path at
  /// some thousand points, so use it at start-up only. `dead_times`, in cycles and one for each axis, are compensated
  /// (PathLeads); empty: setpoints are those of the path at this instant.
  PathSource(trajectory::Interpolator path, std::span<const trajectory::AxisLimits> limits, LatePolicy late,
             std::span<const double> dead_times = {});

  [[nodiscard]] std::size_t axis_count() const noexcept override { return path_.axes().size(); }
  void rewind(std::span<trajectory::AxisSetpoint> first) noexcept override;
  void begin(bool running) noexcept override;
  [[nodiscard]] bool next(const SetpointCycle& cycle, std::span<trajectory::AxisSetpoint> setpoints) noexcept override;
  void end() noexcept override {}
  void run(bool running) noexcept override { clock_.run(running); }
  void fall_behind(double lost_s) noexcept override { clock_.fall_behind(lost_s); }
  [[nodiscard]] double behind_s() const noexcept override { return clock_.behind_s(); }

 private:
  [[nodiscard]] bool next_ahead(std::span<trajectory::AxisSetpoint> setpoints) noexcept;

  trajectory::Interpolator path_;
  trajectory::PathClock clock_;
  std::optional<PathLeads> leads_;
  std::vector<trajectory::AxisSetpoint> at_delay_;  ///< setpoints of all axes at one of the delays
};

}  // namespace driveline::motion
