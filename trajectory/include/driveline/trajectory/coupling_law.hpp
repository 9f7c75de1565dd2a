#pragma once

#include <array>

#include "driveline/trajectory/cam.hpp"
#include "driveline/trajectory/gear_ratio.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Where a slave belongs while its master is somewhere: by a gear or by a cam. A plain value; everything is \rtsafe.
class CouplingLaw {
 public:
  /// A gear of 1 : 1 through zero.
  CouplingLaw() = default;
  /// A gear: the slave is at `slave` when the master is at `master`, both in rad or m.
  [[nodiscard]] static CouplingLaw gear(const GearRatio& ratio, double master, double slave) noexcept;
  /// A cam, which must outlive it, moved: its zeros of master and slave are at these positions, in rad or m.
  [[nodiscard]] static CouplingLaw cam(const Cam& cam, double master, double slave) noexcept;

  /// The slave and its derivatives by the position of the master. \rtsafe
  [[nodiscard]] Cam::Value at(double master) const noexcept;
  /// The slave moves by this much, for every position of the master. \rtsafe
  void shift(double slave) noexcept { slave_ += slave; }

 private:
  const Cam* cam_ = nullptr;
  GearRatio ratio_{};
  double master_ = 0.0;
  double slave_ = 0.0;
};

/// The slave at rest until its master comes to a place, and from there to where a law has it in a polynomial of the
/// fifth degree of the position of the master: whatever the master's velocity is, the slave is in synchronism at the
/// same place. A plain value; everything is \rtsafe.
class RunIn {
 public:
  /// At rest at zero for ever.
  RunIn() = default;
  /// `rest`: position of the slave before; `sync`: position of the master from which on the law holds, with `end`,
  /// which it has there; `distance`: of the master from the begin to `sync`, with the sign of its direction, not zero.
  RunIn(double rest, double sync, double distance, const Cam::Value& end) noexcept;

  /// Which part of it a position of the master is in: below 0 before, above 1 behind. \rtsafe
  [[nodiscard]] double part(double master) const noexcept { return (master - begin_) / distance_; }
  /// The slave before the end. \rtsafe
  [[nodiscard]] Cam::Value at(double master) const noexcept;
  /// The largest magnitudes of velocity, acceleration and jerk of the slave when the master passes at a velocity.
  /// \rtsafe
  struct Demand {
    double velocity = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
  };
  /// See Demand; `velocity` of the master, rad/s or m/s. \rtsafe
  [[nodiscard]] Demand demand(double velocity) const noexcept;

 private:
  double begin_ = 0.0;
  double distance_ = 1.0;
  double rest_ = 0.0;
  std::array<double, 3> powers_{};  // 3rd to 5th of the part
};

/// What a slave does when its master moves: a law's value by the chain rule. \rtsafe
[[nodiscard]] AxisSetpoint along(const Cam::Value& value, const AxisSetpoint& master) noexcept;

}  // namespace driveline::trajectory
