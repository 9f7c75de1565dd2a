#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "drive_line.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::bus_test {

/// Increments of the simulated drives per rad.
inline constexpr double kDemandIncrements = 1048576.0 / 6.283185307179586;

/// What a drive demands of its axis, as its objects tell it once per period, against the limits of the axis.
class DemandJudge {
 public:
  DemandJudge(DriveLine& drives, std::size_t drive, trajectory::AxisLimits limits)
      : drives_(drives), drive_(drive), limits_(limits) {}

  void look() {
    const auto& dictionary = drives_.drive(drive_).dictionary();
    positions_.push_back(dictionary.get(slaves::msd::kValue.position_demand) / kDemandIncrements);
    velocities_.push_back(dictionary.get(slaves::msd::kValue.velocity_demand) / kDemandIncrements);
    times_.push_back(std::chrono::duration<double>(drives_.clock.now()).count());
  }
  /// What was so far is not judged.
  void forget() {
    positions_.clear();
    velocities_.clear();
    times_.clear();
  }
  /// `spare`: by how much the acceleration of the position may be above the limit, for the interpolation of the drive.
  void expect_obedience(double spare = 1.05) const {
    const auto [speed, speed_at] = largest([this](std::size_t i) { return slope(i, kWindow); });
    EXPECT_LE(speed, 1.02 * limits_.max_velocity) << "6062h, at " << speed_at;
    const auto [rate, rate_at] = largest([this](std::size_t i) {
      return (slope(i, kWindow) - slope(i - kWindow, kWindow)) / (0.5 * (times_[i] - times_[i - 2 * kWindow]));
    });
    EXPECT_LE(rate, spare * limits_.max_acceleration) << "6062h, at " << rate_at;
    const auto [demand, demand_at] = largest([this](std::size_t i) { return velocities_[i]; });
    EXPECT_LE(demand, 1.05 * limits_.max_velocity) << "606Bh, at " << demand_at;
    const auto [change, change_at] = largest([this](std::size_t i) {
      return (velocities_[i] - velocities_[i - kShort]) / (times_[i] - times_[i - kShort]);
    });
    EXPECT_LE(change, 1.25 * limits_.max_acceleration) << "606Bh, at " << change_at;
  }

 private:
  /// Positions are whole increments: slopes need some periods to be better than the limits are judged.
  static constexpr std::size_t kWindow = 8;
  static constexpr std::size_t kShort = 2;

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
  std::vector<double> positions_;
  std::vector<double> velocities_;
  std::vector<double> times_;
};

}  // namespace driveline::bus_test
