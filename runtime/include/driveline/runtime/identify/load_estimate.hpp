#pragma once

#include <optional>
#include <span>
#include <vector>

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// State of an axis at one instant; samples are equidistant in time.
struct LoadSample {
  double time_s = 0.0;    ///< time in the record
  double position = 0.0;  ///< actual position, rad or m
  double torque = 0.0;    ///< actual torque, Nm or N
};

/// One parameter of a load, with its uncertainty.
struct LoadFigure {
  double value = 0.0;     ///< in the unit of its key in a line description
  double interval = 0.0;  ///< half the 95 % confidence interval
};

/// One instant of the comparison between measurement and model, all values averaged over the same window.
struct LoadRow {
  double time_s = 0.0;
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
  double torque = 0.0;        ///< measured torque, Nm or N
  double model = 0.0;         ///< torque of the model with the estimated parameters, Nm or N
};

/// Load of an axis, estimated from its motion.
struct LoadEstimate {
  LoadFigure inertia;                         ///< kg m^2 or kg
  LoadFigure viscous_friction;                ///< Nm s/rad or N s/m
  LoadFigure coulomb_friction;                ///< Nm or N
  LoadFigure gravity;                         ///< Nm or N
  std::optional<LoadFigure> pendulum{};       ///< Nm; none: not requested
  std::optional<LoadFigure> pendulum_zero{};  ///< rad; angle of the pendulum
  double condition = 0.0;       ///< condition number of the least squares, after scaling the columns to equal length
  double residual_rms = 0.0;    ///< RMS of measured torque minus model, Nm or N
  double torque_rms = 0.0;      ///< RMS of the measured torque, Nm or N
  std::vector<LoadRow> rows{};  ///< data of the estimate
};

/// Settings of the estimate of a load.
struct LoadSettings {
  double window_s = 0.02;   ///< window for the acceleration; the other values are averaged with the same weights
  double standstill = 0.2;  ///< velocities up to it count as standstill, where friction is undefined; rad/s or m/s
  bool pendulum = false;    ///< estimates the torque of a pendulum, too
};

/// Estimates inertia, friction and weight of an axis by least squares of its measured torque.
///
/// All values are averages over the same window with the same weights, so that a relation that holds at each instant
/// also holds for the averages: the second difference of the positions, divided by the squared time between them, is
/// the average of the acceleration over a triangle of that length. Instants at which the axis stands still or reverses
/// within the window are left out.
///
/// Errors (kSetting): too few samples in motion, a torque that is always zero, parameters that the motion cannot
/// distinguish (the sentence says which and what is missing), an inertia that is not positive.
[[nodiscard]] Result<LoadEstimate> estimate_load(std::span<const LoadSample> samples, const LoadSettings& settings);

}  // namespace driveline::runtime
