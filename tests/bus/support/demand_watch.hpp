#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/trajectory/motion_limits.hpp"

namespace driveline::bus_test {

/// What a simulated drive demands of its motor, judged as it comes: what 6062h and 606Bh tell, not rounded to
/// increments. For campaigns of many runs; DemandJudge looks at a whole run in the end.
///
/// The limits are those of the axis as long as the drive follows its master, also by its profile generator, which has
/// its velocity and ramps from the master. What a drive does by itself after a fault, or when its master has told it to
/// stop, obeys the drive's own ramps: 6085h for its quick stop and its fault reaction, 6084h for the slow down ramp.
///
/// Not judged is what is no demand: a motor without power, a stop at the highest torque (605Ah = 3, 4: no ramp), and
/// the velocity while, and a little after, the axis cannot do what it is told (an axis that is blocked; torque at its
/// limit): then 606Bh is the answer of a controller to an error, and a drive begins anew with what it measures. The
/// position that is demanded is judged then as always.
class DemandWatch {
 public:
  DemandWatch(const slaves::msd::DriveCore& drive, trajectory::AxisLimits limits) : drive_(drive), limits_(limits) {}

  /// Once per period, at the same place in it.
  void look(std::chrono::nanoseconds now);
  /// The axis cannot follow until then.
  void disturb(std::chrono::nanoseconds until) { disturbed_ = std::max(disturbed_, until); }
  /// The first thing that was wrong; empty: nothing.
  [[nodiscard]] const std::string& finding() const noexcept { return finding_; }
  /// Periods in which a position, or a velocity, was judged.
  [[nodiscard]] std::uint64_t judged() const noexcept { return judged_; }

  /// Periods over which slopes are taken, and what they may be beyond the limits. Targets are whole increments: over
  /// two periods that is as much as 38 % of an acceleration, and a spline rounds the corners that are left; over eight
  /// it is 2.4 %. 606Bh has, besides, what the position loop makes of a following error, and in CSV what that of the
  /// master does. A leap is seen over two periods, a limit that is not kept over eight.
  struct Window {
    std::size_t periods;
    double velocity;      ///< 6062h, share of the highest velocity
    double acceleration;  ///< 6062h, share of the highest acceleration
    double change;        ///< 606Bh, the same
  };
  static constexpr std::array<Window, 3> kWindows{{{2, 1.03, 1.8, 1.8}, {4, 1.03, 1.25, 1.35}, {8, 1.02, 1.06, 1.15}}};
  /// Of the shaft under a torque, share of the highest acceleration: no demand, but the answer of a loop over the bus,
  /// with a dead time of three cycles, longer where frames are lost.
  static constexpr double kByTorque = 2.5;
  static constexpr double kVelocityDemand = 1.05;  ///< 606Bh, share of the highest velocity

 private:
  struct Sample {
    double time_s = 0.0;
    double position = 0.0;      ///< demanded, rad
    double velocity = 0.0;      ///< demanded, rad/s
    double moved_at = 0.0;      ///< velocity of the shaft, rad/s
    double acceleration = 0.0;  ///< allowed, rad/s^2
    bool by_torque = false;
  };
  static constexpr std::size_t kKept = 32;

  [[nodiscard]] const Sample& ago(std::size_t periods) const { return samples_[(newest_ + kKept - periods) % kKept]; }
  [[nodiscard]] double allowed(std::size_t periods) const;
  void judge_position(const Window& window);
  void judge_velocity(const Window& window);
  void find(const char* what, double value, double allowed);

  const slaves::msd::DriveCore& drive_;
  trajectory::AxisLimits limits_;
  std::array<Sample, kKept> samples_{};
  std::size_t newest_ = 0;
  std::size_t positions_ = 0;   ///< in a row, of one source
  std::size_t velocities_ = 0;  ///< in a row
  std::chrono::nanoseconds disturbed_{0};
  bool lost_ = false;  ///< it has taken over from a motion that it could not follow
  slaves::msd::MotionSource source_{};
  slaves::MotionCommand command_{};
  std::uint64_t judged_ = 0;
  std::string finding_;
};

}  // namespace driveline::bus_test
