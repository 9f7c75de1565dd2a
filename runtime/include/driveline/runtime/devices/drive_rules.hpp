#pragma once

#include <chrono>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/ecat_master/axis/startup_sdos.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::runtime {

/// What an axis is taken to be where the line file leaves it out.
struct AxisDefaults {
  double increments_per_revolution = 1048576.0;  ///< of the position objects
  double rated_torque = 2.4;                     ///< Nm or N that 1000 per mille stand for (6076h)
  trajectory::AxisLimits limits{200.0, 2000.0};  ///< of approaches and stops; rad/s or m/s, rad/s^2 or m/s^2
};

/// What the master must know of a drive that it is to move. As it stands: a drive that follows CiA 402, goes to each
/// setpoint on a line, and takes any cycle. A DeviceFamily derives from it for what its drives want beside that.
///
/// Immutable; any thread.
class DriveRules {
 public:
  DriveRules() = default;
  DriveRules(const DriveRules&) = delete;
  DriveRules& operator=(const DriveRules&) = delete;
  virtual ~DriveRules() = default;

  /// What the drive must be told in PREOP before it follows the setpoints of `axis`, of which one comes every `period`.
  /// @throws std::invalid_argument if the drive cannot be told the period; the reader of a line file has refused it
  /// before.
  [[nodiscard]] virtual std::vector<ecat_master::StartupSdo> startup_sdos(const ecat_master::AxisConfig& axis,
                                                                          std::chrono::nanoseconds period) const;

  /// Exchanges until the drive has arrived at a position setpoint that it has got: 1 on a line,
  /// ecat_master::kSplinePeriods on a spline. For the following error.
  [[nodiscard]] virtual unsigned interpolation_exchanges() const noexcept { return 1; }

  /// The cycle of SYNC0 must be a multiple of it; 0: any.
  [[nodiscard]] virtual std::chrono::nanoseconds clock_base() const noexcept { return {}; }

  /// Of an axis that such a drive moves.
  [[nodiscard]] virtual AxisDefaults axis_defaults() const { return {}; }
};

}  // namespace driveline::runtime
