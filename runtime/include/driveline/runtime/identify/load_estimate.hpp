#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// What an axis has done at one instant, at equal distances in time.
struct LoadSample {
  double time_s = 0.0;    ///< of the record
  double position = 0.0;  ///< rad or m, actual
  double torque = 0.0;    ///< Nm or N, actual
};

/// One figure of a load, and how far it may be off.
struct LoadFigure {
  double value = 0.0;     ///< in the unit that its key has in a line description
  double interval = 0.0;  ///< half the 95 % confidence interval
};

/// One instant of the comparison of measurement and model, each averaged over the same window.
struct LoadRow {
  double time_s = 0.0;
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  double torque = 0.0;        ///< Nm or N, measured
  double model = 0.0;         ///< the same by the figures found
};

/// The load of an axis, as its motion shows it.
struct LoadEstimate {
  LoadFigure inertia;                         ///< kg m^2 or kg
  LoadFigure viscous_friction;                ///< Nm s/rad or N s/m
  LoadFigure coulomb_friction;                ///< Nm or N
  LoadFigure gravity;                         ///< Nm or N
  std::optional<LoadFigure> pendulum{};       ///< Nm; none: it was not asked for
  std::optional<LoadFigure> pendulum_zero{};  ///< rad
  double condition = 0.0;                     ///< condition number of the least squares, its columns scaled alike
  double residual_rms = 0.0;                  ///< of measured torque minus model, Nm or N
  double torque_rms = 0.0;                    ///< of the measured torque
  std::vector<LoadRow> rows{};                ///< what it was found from
};

/// How a load is looked for.
struct LoadSettings {
  double window_s = 0.02;   ///< over which acceleration is taken, the other figures with the same weights
  double standstill = 0.2;  ///< velocities up to it count as standstill, where friction is anything; rad/s or m/s
  bool pendulum = false;    ///< with the torque of a pendulum
};

/// Finds inertia, friction and weight of an axis by least squares of its measured torque.
///
/// All figures are averages over the same window with the same weights, so that what holds at each instant holds for
/// them too: the second difference of the positions, divided by the time, is the average of the acceleration over a
/// triangle of that length. Instants at which the axis stands or turns round within the window are left out.
///
/// Errors (kSetting): too few samples in motion, a torque that is always zero, figures that the motion does not tell
/// apart (the sentence says which and what is missing), an inertia that is not positive.
[[nodiscard]] Result<LoadEstimate> estimate_load(std::span<const LoadSample> samples, const LoadSettings& settings);

}  // namespace driveline::runtime
