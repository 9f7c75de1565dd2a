#pragma once

#include "driveline/runtime/devices/drive_rules.hpp"

namespace driveline::runtime {

/// What a master must know of a Moog MSD servo drive.
class MsdRules final : public DriveRules {
 public:
  /// The setpoint cycle in both places where it counts (MSD manual 7.4.2: P 306 and 60C2h), and, in CSP, cubic spline
  /// interpolation between the setpoints (P 370 = 3) and the inertia for the drive's own torque feed-forward (P 1516)
  /// when it is known.
  [[nodiscard]] std::vector<ecat_master::StartupSdo> startup_sdos(const ecat_master::AxisConfig& axis,
                                                                  std::chrono::nanoseconds period) const override;
  [[nodiscard]] unsigned interpolation_exchanges() const noexcept override { return ecat_master::kSplinePeriods; }
  /// MSD manual 9.1: the cycle time is a multiple of 125 us.
  [[nodiscard]] std::chrono::nanoseconds clock_base() const noexcept override { return std::chrono::microseconds{125}; }
};

}  // namespace driveline::runtime
