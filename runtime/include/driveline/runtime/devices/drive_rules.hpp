#pragma once

#include <chrono>
#include <string_view>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/axis/startup_sdos.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::runtime {

/// Values of an axis that a line description may leave out.
struct AxisDefaults {
  double increments_per_revolution = 1048576.0;  ///< increments of the position objects
  double rated_torque = 2.4;                     ///< Nm or N, 1000 per mille (6076h)
  trajectory::AxisLimits limits{200.0, 2000.0};  ///< limits of approaches and stops; rad/s or m/s, rad/s^2 or m/s^2
  bool follow_bit = false;                       ///< AxisConfig::follow_bit
  bool velocity_by_factors = false;              ///< AxisConfig::velocity_by_factors
};

/// Properties of a drive that the master needs to move it. The defaults describe a drive that follows CiA 402,
/// interpolates linearly and accepts any cycle; a DeviceFamily derives from it for other drives.
///
/// Immutable; any thread.
class DriveRules {
 public:
  DriveRules() = default;
  DriveRules(const DriveRules&) = delete;
  DriveRules& operator=(const DriveRules&) = delete;
  virtual ~DriveRules() = default;

  /// Returns the start-up SDOs with which the drive follows the setpoints of `axis`, one every `period`.
  /// @throws std::invalid_argument if the drive cannot represent the period; line descriptions with such a period are
  /// refused when they are read.
  [[nodiscard]] virtual std::vector<motion::StartupSdo> startup_sdos(const motion::AxisConfig& axis,
                                                                     std::chrono::nanoseconds period) const;

  /// Returns the exchanges until the drive reaches a received position setpoint: 1 with linear interpolation,
  /// motion::kSplinePeriods on a spline. Used for the following error.
  [[nodiscard]] virtual unsigned interpolation_exchanges() const noexcept { return 1; }

  /// Returns why the drive cannot use torque offsets (60B2h) in CSP and CSV, as the end of a sentence about it; empty:
  /// it can.
  [[nodiscard]] virtual std::string_view why_no_torque_offset() const noexcept { return {}; }

  /// Returns the time of which the cycle of SYNC0 must be a multiple; 0: any cycle.
  [[nodiscard]] virtual std::chrono::nanoseconds clock_base() const noexcept { return {}; }

  /// Whether the drive consumes the heartbeat of a CANopen master (1016h).
  [[nodiscard]] virtual bool consumes_heartbeat() const noexcept { return true; }

  /// Returns the start-up SDOs with which a drive on a CAN bus stops after `limit` without SYNC; empty: it has no such
  /// watch.
  [[nodiscard]] virtual std::vector<motion::StartupSdo> sync_watch_sdos(std::chrono::milliseconds /*limit*/) const {
    return {};
  }

  /// Returns the defaults of an axis with such a drive.
  [[nodiscard]] virtual AxisDefaults axis_defaults() const { return {}; }
};

}  // namespace driveline::runtime
