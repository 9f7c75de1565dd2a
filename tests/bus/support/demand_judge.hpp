#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "drive_line.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::bus_test {

/// Increments of the simulated drives per rad.
inline constexpr double kDemandIncrements = 1048576.0 / 6.283185307179586;

/// Compares the demands of a drive, read from its objects once per period, with the limits of the axis.
class DemandJudge {
 public:
  /// `range`: increments until positions wrap around.
  DemandJudge(DriveLine& drives, std::size_t drive, trajectory::AxisLimits limits, double range = 4294967296.0)
      : drives_(drives), drive_(drive), limits_(limits), range_rad_(range / kDemandIncrements) {}

  void look() {
    const auto& drive = drives_.drive(drive_);
    const auto& dictionary = drive.dictionary();
    const auto mode = dictionary.get(slaves::msd::kValue.mode_display);
    modes_.push_back(mode);
    positions_.push_back(unwrapped(dictionary.get(slaves::msd::kValue.position_demand) / kDemandIncrements));
    velocities_.push_back(dictionary.get(slaves::msd::kValue.velocity_demand) / kDemandIncrements);
    actual_velocities_.push_back(drive.velocity_rad_s());
    times_.push_back(std::chrono::duration<double>(drives_.clock.now()).count());
  }
  /// Drops all samples so far.
  void forget() {
    modes_.clear();
    positions_.clear();
    velocities_.clear();
    actual_velocities_.clear();
    times_.clear();
  }
  /// `spare`: factor by which the acceleration of the position may exceed the limit, for the interpolation of the
  /// drive.
  void expect_obedience(double spare = 1.05) const {
    const auto [speed, speed_at] = largest([this](std::size_t i) { return demanded(i) ? slope(i, kWindow) : 0.0; });
    EXPECT_LE(speed, 1.02 * limits_.max_velocity) << "6062h, at " << speed_at;
    const auto [rate, rate_at] = largest([this, spare](std::size_t i) {
      if (!demanded(i)) return 0.0;
      const double gained = slope(i, kWindow) - slope(i - kWindow, kWindow);
      return gained / (0.5 * (times_[i] - times_[i - 2 * kWindow])) / (modes_[i] == kTorqueMode ? kChange : spare);
    });
    EXPECT_LE(rate, limits_.max_acceleration) << "6062h by what it may be beyond the limit, at " << rate_at;
    const auto [demand, demand_at] = largest([this](std::size_t i) { return velocities(i)[i]; });
    EXPECT_LE(demand, 1.05 * limits_.max_velocity) << "606Bh, at " << demand_at;
    const auto [change, change_at] = largest([this](std::size_t i) {
      return (velocities(i)[i] - velocities(i)[i - kShort]) / (times_[i] - times_[i - kShort]);
    });
    EXPECT_LE(change, kChange * limits_.max_acceleration) << "606Bh, at " << change_at;
  }

 private:
  /// Positions are whole increments: the slope needs several periods to be more precise than the limits.
  static constexpr std::size_t kWindow = 8;
  static constexpr std::size_t kShort = 2;
  /// Highest slope of 606Bh, relative to the highest acceleration.
  static constexpr double kChange = 1.25;
  static constexpr std::int8_t kHomingMode = 6;
  static constexpr std::int8_t kVelocityMode = 9;
  static constexpr std::int8_t kTorqueMode = 10;

  /// The position next to the last one, without the wrap-around.
  [[nodiscard]] double unwrapped(double position) const {
    if (positions_.empty()) return position;
    return position + range_rad_ * std::round((positions_.back() - position) / range_rad_);
  }
  /// In CSV the drive demands no position: 6062h is the result of its velocity loop. In CST it results from the torque
  /// under load, and is judged like the velocity. Homing shifts the zero.
  [[nodiscard]] bool demanded(std::size_t at) const {
    const auto mode = modes_[at];
    return mode != kVelocityMode && mode != kHomingMode &&
           std::all_of(modes_.begin() + static_cast<std::ptrdiff_t>(at - 2 * kWindow),
                       modes_.begin() + static_cast<std::ptrdiff_t>(at), [mode](auto other) { return other == mode; });
  }
  /// In CST the drive demands no velocity, so the actual velocity is judged.
  [[nodiscard]] const std::vector<double>& velocities(std::size_t at) const {
    return std::any_of(modes_.begin() + static_cast<std::ptrdiff_t>(at - kShort),
                       modes_.begin() + static_cast<std::ptrdiff_t>(at + 1),
                       [](auto mode) { return mode == kTorqueMode; })
               ? actual_velocities_
               : velocities_;
  }
  [[nodiscard]] double slope(std::size_t at, std::size_t periods) const {
    return (positions_[at] - positions_[at - periods]) / (times_[at] - times_[at - periods]);
  }
  template <typename Value>
  [[nodiscard]] std::pair<double, std::size_t> largest(Value&& value) const {
    std::pair<double, std::size_t> found{0.0, 0};
    for (std::size_t i = 2 * kWindow; i < positions_.size(); ++i) {
      if (const double magnitude = std::abs(value(i)); magnitude > found.first) found = {magnitude, i};
    }
    return found;
  }

  DriveLine& drives_;
  std::size_t drive_;
  trajectory::AxisLimits limits_;
  double range_rad_;
  std::vector<std::int8_t> modes_;
  std::vector<double> positions_;
  std::vector<double> velocities_;
  std::vector<double> actual_velocities_;
  std::vector<double> times_;
};

}  // namespace driveline::bus_test
