#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "support/motion_trace.hpp"

namespace driveline::bus_test {

/// Judges the demands of a simulated drive (6062h and 606Bh, but not rounded to increments) as they come. For campaigns
/// of many runs; DemandJudge checks a complete run at its end.
///
/// The limits are those of the axis as long as the drive follows its master, also by its profile generator, which gets
/// velocity and ramps from the master. Motions of the drive on its own, after a fault or when the master has commanded
/// a stop, follow the drive's own ramps: 6085h for quick stop and fault reaction, 6084h for the slow down ramp.
///
/// Not judged are: a motor without power, a stop at the highest torque (605Ah = 3, 4: no ramp), and the velocity while
/// the axis cannot follow, and shortly afterwards (blocked axis, torque at its limit). 606Bh is then the response of a
/// controller to an error, and the drive restarts from measured values. The demanded position is still judged.
class DemandWatch {
 public:
  /// How far velocities may exceed the limit of the axis beyond the reasons below, as shares of it.
  struct Margins {
    double position = 0.0;  ///< 6062h
    double velocity = 0.0;  ///< 606Bh
  };
  DemandWatch(const slaves::msd::DriveCore& drive, trajectory::AxisLimits limits) : DemandWatch(drive, limits, {}) {}
  DemandWatch(const slaves::msd::DriveCore& drive, trajectory::AxisLimits limits, const Margins& margins)
      : drive_(drive), limits_(limits), margins_(margins) {}

  /// To be called once per period, at the same point in it.
  void look(std::chrono::nanoseconds now);
  /// The axis cannot follow until `until`.
  void disturb(std::chrono::nanoseconds until) { disturbed_ = std::max(disturbed_, until); }
  /// The first violation; empty: there is none.
  [[nodiscard]] const std::string& finding() const noexcept { return finding_; }
  /// Number of periods in which a position or a velocity was judged.
  [[nodiscard]] std::uint64_t judged() const noexcept { return judged_; }

  /// Periods over which slopes are taken, and how far they may exceed the limits. Targets are whole increments: over
  /// two periods the rounding is up to 38 % of an acceleration, and a spline rounds the remaining corners; over eight
  /// periods it is 2.4 %. 606Bh also contains the response of the position loop to a following error, and in CSV that
  /// of the master's position loop. A step shows over two periods, a slightly exceeded limit over eight.
  struct Window {
    std::size_t periods;
    double velocity;      ///< 6062h, share of the highest velocity
    double acceleration;  ///< 6062h, share of the highest acceleration
    double change;        ///< 606Bh, share of the highest acceleration
  };
  static constexpr std::array<Window, 3> kWindows{{{2, 1.03, 1.8, 1.8}, {4, 1.03, 1.25, 1.35}, {8, 1.02, 1.06, 1.15}}};
  /// Acceleration of the shaft in torque mode, as a share of the highest acceleration: no demand, but the response of a
  /// loop over the bus with a dead time of three cycles, longer if frames are lost.
  static constexpr double kByTorque = 2.5;
  static constexpr double kVelocityDemand = 1.05;  ///< 606Bh, share of the highest velocity

 private:
  struct Sample {
    double time_s = 0.0;
    double position = 0.0;      ///< demanded position, rad
    double velocity = 0.0;      ///< demanded velocity, rad/s
    double moved_at = 0.0;      ///< velocity of the shaft, rad/s
    double acceleration = 0.0;  ///< allowed acceleration, rad/s^2
    bool by_torque = false;
  };
  static constexpr std::size_t kKept = 32;

  [[nodiscard]] const Sample& ago(std::size_t periods) const { return samples_[(newest_ + kKept - periods) % kKept]; }
  [[nodiscard]] double allowed(std::size_t periods) const;
  void judge_position(const Window& window);
  void judge_velocity(const Window& window);
  void find(const char* what, double value, double allowed);

  MotionTrace trace_;
  const slaves::msd::DriveCore& drive_;
  trajectory::AxisLimits limits_;
  Margins margins_;
  std::array<Sample, kKept> samples_{};
  std::size_t newest_ = 0;
  std::size_t positions_ = 0;   ///< consecutive samples from the same source
  std::size_t velocities_ = 0;  ///< consecutive samples
  std::chrono::nanoseconds disturbed_{0};
  bool lost_ = false;  ///< the drive has taken over from a motion that the axis could not follow
  slaves::msd::MotionSource source_{};
  slaves::MotionCommand command_{};
  std::uint64_t judged_ = 0;
  std::string finding_;
};

}  // namespace driveline::bus_test
