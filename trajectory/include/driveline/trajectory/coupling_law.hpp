#pragma once

#include <array>

#include "driveline/trajectory/cam.hpp"
#include "driveline/trajectory/gear_ratio.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Position of a slave as a function of the position of its master: a gear or a cam. A plain value; everything is
/// \rtsafe.
class CouplingLaw {
 public:
  /// A 1 : 1 gear through zero.
  CouplingLaw() = default;
  /// A gear: the slave is at `slave` when the master is at `master`, both in rad or m.
  [[nodiscard]] static CouplingLaw gear(const GearRatio& ratio, double master, double slave) noexcept;
  /// A cam, which must outlive the law, shifted: its zeros of master and slave are at `master` and `slave`, in rad or
  /// m.
  [[nodiscard]] static CouplingLaw cam(const Cam& cam, double master, double slave) noexcept;

  /// Slave position and its derivatives with respect to the position of the master. \rtsafe
  [[nodiscard]] Cam::Value at(double master) const noexcept;
  /// Shifts the slave by `slave` for all positions of the master. \rtsafe
  void shift(double slave) noexcept { slave_ += slave; }

 private:
  const Cam* cam_ = nullptr;
  GearRatio ratio_{};
  double master_ = 0.0;
  double slave_ = 0.0;
};

/// Run-in of a slave: at rest until its master reaches a position, then to the position of a law by a fifth-degree
/// polynomial of the position of the master. Whatever the master's velocity is, the slave is in synchronism at the same
/// position. A plain value; everything is \rtsafe.
class RunIn {
 public:
  /// Remains at rest at zero.
  RunIn() = default;
  /// `rest`: position of the slave before the run-in; `sync`: position of the master from which the law applies; `end`:
  /// value of the law there; `distance`: displacement of the master from the start of the run-in to `sync`, signed, not
  /// zero.
  RunIn(double rest, double sync, double distance, const Cam::Value& end) noexcept;

  /// Fraction of the run-in at a position of the master: below 0 before it, above 1 after it. \rtsafe
  [[nodiscard]] double part(double master) const noexcept { return (master - begin_) / distance_; }
  /// Slave position and derivatives before the end of the run-in. \rtsafe
  [[nodiscard]] Cam::Value at(double master) const noexcept;
  /// Largest magnitudes of velocity, acceleration and jerk of the slave if the master passes at a constant velocity.
  /// \rtsafe
  struct Demand {
    double velocity = 0.0;
    double acceleration = 0.0;
    double jerk = 0.0;
  };
  /// Demand if the master passes at `velocity`, rad/s or m/s. \rtsafe
  [[nodiscard]] Demand demand(double velocity) const noexcept;

 private:
  double begin_ = 0.0;
  double distance_ = 1.0;
  double rest_ = 0.0;
  std::array<double, 3> powers_{};  // 3rd to 5th power of the fraction
};

/// Setpoint of a slave for the motion of its master: applies the chain rule to the value of a law. \rtsafe
[[nodiscard]] AxisSetpoint along(const Cam::Value& value, const AxisSetpoint& master) noexcept;

}  // namespace driveline::trajectory
