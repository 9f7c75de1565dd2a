#pragma once

#include <chrono>
#include <string_view>
#include <vector>

#include "driveline/runtime/devices/drive_rules.hpp"

namespace driveline::runtime {

/// Properties of a Moog MSD servo drive that the master needs.
class MsdRules : public DriveRules {
 public:
  /// Sets the setpoint cycle in both objects where it takes effect (MSD manual 7.4.2: P 306 and 60C2h), and, in CSP,
  /// cubic spline interpolation between the setpoints (P 370 = 3) and, if known, the inertia for the drive's own torque
  /// feed-forward (P 1516). If the master has a feed-forward of friction or gravity as well, the drive takes the whole
  /// torque from 60B2h (P 379 sub 2 = 1).
  [[nodiscard]] std::vector<motion::StartupSdo> startup_sdos(const motion::AxisConfig& axis,
                                                             std::chrono::nanoseconds period) const override;
  /// Monitors SYNC in Operational (P 2061 = 0, P 2062; MSD manual 8.5).
  [[nodiscard]] std::vector<motion::StartupSdo> sync_watch_sdos(std::chrono::milliseconds limit) const override;
  [[nodiscard]] unsigned interpolation_exchanges() const noexcept override { return motion::kSplinePeriods; }
  /// MSD manual 9.1: the cycle time is a multiple of 125 us.
  [[nodiscard]] std::chrono::nanoseconds clock_base() const noexcept override { return std::chrono::microseconds{125}; }
  /// MSD manual Tables 12.20, 12.22, 12.24: bit 12 reports whether the target is used; 12.2.2: units of the velocity
  /// mode.
  [[nodiscard]] AxisDefaults axis_defaults() const override {
    AxisDefaults defaults;
    defaults.follow_bit = true;
    defaults.velocity_by_factors = true;
    return defaults;
  }
};

/// Rules of a ServoOne, which differs in that it uses 60B2h with P 370 = 2 only (ServoOne manual 12.4).
class ServoOneRules final : public MsdRules {
 public:
  [[nodiscard]] std::string_view why_no_torque_offset() const noexcept override {
    return "accepts torque offsets only with an interpolation that driveline does not use (P 370 = 2)";
  }
  /// The ServoOne has no 1016h.
  [[nodiscard]] bool consumes_heartbeat() const noexcept override { return false; }
};

}  // namespace driveline::runtime
