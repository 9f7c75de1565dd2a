#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/cyclic/master_absence.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {

inline constexpr nanoseconds kLatePeriod = microseconds{125};
inline constexpr double kLateIncrements = 1048576.0 / 6.283185307179586;

/// What a drive demands of its axis, as its objects tell it once per period, against the limits of the axis.
class DemandJudge {
 public:
  DemandJudge(DriveLine& drives, std::size_t drive, trajectory::AxisLimits limits)
      : drives_(drives), drive_(drive), limits_(limits) {}

  void look() {
    const auto& drive = drives_.drive(drive_);
    const auto& dictionary = drive.dictionary();
    const auto mode = dictionary.get(slaves::msd::kValue.mode_display);
    modes_.push_back(mode);
    positions_.push_back(dictionary.get(slaves::msd::kValue.position_demand) / kLateIncrements);
    velocities_.push_back(dictionary.get(slaves::msd::kValue.velocity_demand) / kLateIncrements);
    actual_velocities_.push_back(drive.velocity_rad_s());
    times_.push_back(std::chrono::duration<double>(drives_.clock.now()).count());
  }
  /// What was before does not count.
  void forget() {
    modes_.clear();
    positions_.clear();
    velocities_.clear();
    actual_velocities_.clear();
    times_.clear();
  }
  void expect_obedience() const {
    const auto [speed, speed_at] = largest([this](std::size_t i) { return demanded(i) ? slope(i, kWindow) : 0.0; });
    EXPECT_LE(speed, 1.02 * limits_.max_velocity) << "6062h, at " << speed_at;
    const auto [rate, rate_at] = largest([this](std::size_t i) {
      if (!demanded(i)) return 0.0;
      return (slope(i, kWindow) - slope(i - kWindow, kWindow)) / (0.5 * (times_[i] - times_[i - 2 * kWindow]));
    });
    EXPECT_LE(rate, 1.05 * limits_.max_acceleration) << "6062h, at " << rate_at;
    const auto [demand, demand_at] = largest([this](std::size_t i) { return velocities(i)[i]; });
    EXPECT_LE(demand, 1.05 * limits_.max_velocity) << "606Bh, at " << demand_at;
    const auto [change, change_at] = largest([this](std::size_t i) {
      return (velocities(i)[i] - velocities(i)[i - kShort]) / (times_[i] - times_[i - kShort]);
    });
    EXPECT_LE(change, 1.25 * limits_.max_acceleration) << "606Bh, at " << change_at;
  }

 private:
  /// Positions are whole increments: slopes need some periods to be better than the limits are judged.
  static constexpr std::size_t kWindow = 8;
  static constexpr std::size_t kShort = 2;
  static constexpr std::int8_t kVelocityMode = 9;
  static constexpr std::int8_t kTorqueMode = 10;

  /// In csv the drive demands no positions: 6062h is where the axis gets to by its velocity loop. In cst it is where
  /// the axis gets to by its torque.
  [[nodiscard]] bool demanded(std::size_t at) const {
    const auto mode = modes_[at];
    return mode != kVelocityMode &&
           std::all_of(modes_.begin() + static_cast<std::ptrdiff_t>(at - 2 * kWindow),
                       modes_.begin() + static_cast<std::ptrdiff_t>(at), [mode](auto other) { return other == mode; });
  }
  /// In cst the drive demands no velocity: the axis has one all the same.
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
  std::vector<std::int8_t> modes_;
  std::vector<double> positions_;
  std::vector<double> velocities_;
  std::vector<double> actual_velocities_;
  std::vector<double> times_;
};

/// A line on its path, whose master can be kept from cycling and whose frames can be lost.
class LateLine {
 public:
  explicit LateLine(const RunOptions& options = fast_path(), std::size_t axes = 1)
      : drives(axes),
        outwards(drives.line(), LossyPort::Way::kOut,
                 [this](auto, auto) {
                   drives.leave_alone(std::exchange(hold_up, nanoseconds{0}));
                   return lose_out;
                 }),
        port(outwards, LossyPort::Way::kBack, [this](auto, auto) { return lose_back; }),
        operation(drives, port, options) {
    for (std::size_t i = 0; i < axes; ++i) judges.emplace_back(drives, i, LineOperation::axis(i, options).limits);
    EXPECT_EQ(sentence(operation.to_motion()), "");
    EXPECT_TRUE(operation.run_until(ecat_master::MotionPhase::kFollowing, std::chrono::seconds{2}));
    settle();
    ecat_master::MasterAbsence before;
    while (operation.master().core()->take_absence(before)) continue;
  }

  /// Most of what the axes may (47 of 50 rad/s, 740 of 1000 rad/s²), and drives that stop no faster than the axes may.
  static RunOptions fast_path() {
    RunOptions options;
    options.repeat = true;
    options.amplitude_rad = 6.0;
    const auto rate =
        static_cast<std::uint32_t>(LineOperation::axis(0, options).limits.max_acceleration * kLateIncrements);
    const auto bytes = wire::to_le_bytes(rate);
    options.startup = {{0x6085, 0, {bytes.begin(), bytes.end()}}};
    return options;
  }

  /// To the same place within the period, in which no control step of the drives and no frame is due.
  void settle() {
    const auto place = drives.clock.now() / kLatePeriod * kLatePeriod + microseconds{110};
    drives.leave_alone(std::max(place - drives.clock.now(), nanoseconds{0}));
  }
  void look() {
    for (auto& judge : judges) judge.look();
  }
  void cycle() {
    operation.cycle();
    settle();
    look();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// `periods` go by without a cycle; the next one begins `beyond` its instant. More than seven, and the timer takes
  /// the time for one that the thread has spent awake, and rests.
  void stall(int periods, nanoseconds beyond = nanoseconds{0}) {
    for (int i = 0; i < periods; ++i) {
      drives.leave_alone(kLatePeriod);
      look();
    }
    drives.leave_alone(microseconds{15} + beyond);
    cycle();
  }
  void lose(int frames, bool out) {
    (out ? lose_out : lose_back) = true;
    cycles(frames);
    lose_out = lose_back = false;
  }
  [[nodiscard]] std::vector<ecat_master::MasterAbsence> absences() {
    std::vector<ecat_master::MasterAbsence> all;
    ecat_master::MasterAbsence absence;
    while (operation.master().core()->take_absence(absence)) all.push_back(absence);
    return all;
  }
  void expect_obedience() const {
    for (const auto& judge : judges) judge.expect_obedience();
  }

  bool lose_out = false;
  bool lose_back = false;
  nanoseconds hold_up{0};  ///< the next frame, on its way out
  DriveLine drives;
  LossyPort outwards;
  LossyPort port;
  LineOperation operation;
  std::vector<DemandJudge> judges;
};

}  // namespace driveline::bus_test
