#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "demand_judge.hpp"
#include "drive_line.hpp"
#include "driveline/motion/control/master_absence.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "fault_ports.hpp"
#include "startup_objects.hpp"

namespace driveline::bus_test {

inline constexpr nanoseconds kLatePeriod = microseconds{125};

/// A line on its path; the test can stop its master from cycling and lose its frames.
class LateLine {
 public:
  explicit LateLine(const RunOptions& options = fast_path(), std::size_t axes = 1)
      : drives(axes),
        outwards(drives.line(), LossyPort::Direction::kOut,
                 [this](auto, auto) {
                   drives.leave_alone(std::exchange(hold_up, nanoseconds{0}));
                   return lose_out;
                 }),
        port(outwards, LossyPort::Direction::kBack, [this](auto, auto) { return lose_back; }),
        operation(drives, port, options) {
    for (std::size_t i = 0; i < axes; ++i) judges.emplace_back(drives, i, LineOperation::axis(i, options).limits);
    EXPECT_EQ(sentence(operation.to_motion()), "");
    EXPECT_TRUE(operation.run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{2}));
    settle();
    motion::MasterAbsence before;
    while (operation.master().core()->take_absence(before)) continue;
  }

  /// A path close to the limits of the axes (47 of 50 rad/s, 740 of 1000 rad/s²), and drives that do not stop faster
  /// than the axes may.
  static RunOptions fast_path() {
    RunOptions options;
    options.repeat = true;
    options.amplitude_rad = 6.0;
    limit_quick_stops(options);
    return options;
  }

  /// Advances to a fixed point in the period at which neither a control step of the drives nor a frame is due.
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
  /// Lets `periods` pass without a cycle; the next cycle starts `beyond` after its instant. For more than seven
  /// periods, the timer assumes that the thread has been awake for too long, and rests.
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
  [[nodiscard]] std::vector<motion::MasterAbsence> absences() {
    std::vector<motion::MasterAbsence> all;
    motion::MasterAbsence absence;
    while (operation.master().core()->take_absence(absence)) all.push_back(absence);
    return all;
  }
  void expect_obedience() const {
    for (const auto& judge : judges) judge.expect_obedience();
  }

  bool lose_out = false;
  bool lose_back = false;
  nanoseconds hold_up{0};  ///< delay of the next outgoing frame
  DriveLine drives;
  LossyPort outwards;
  LossyPort port;
  LineOperation operation;
  std::vector<DemandJudge> judges;
};

}  // namespace driveline::bus_test
