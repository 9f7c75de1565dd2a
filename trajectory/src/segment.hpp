#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "driveline/trajectory/setpoint.hpp"

/// Segments of a curve between two instants, for all axes. The coefficients of a segment are a structure of arrays: one
/// column per power of the time since the segment's start, one row per axis.
namespace driveline::trajectory::segment_detail {

/// Positions and their derivatives of all axes at one instant; each pointer refers to one value per axis.
struct Knot {
  const double* position;
  const double* velocity;
  const double* acceleration = nullptr;
};

/// Evaluates the first out.size() axes at `t` after the segment's start; polynomials of degree kColumns - 1. `axes` is
/// the length of a column. \rtsafe
template <std::size_t kColumns>
inline void evaluate_polynomial(const double* c, std::size_t axes, double t, std::span<AxisSetpoint> out) noexcept {
  const auto column = [c, axes](std::size_t power) { return c + power * axes; };
  for (std::size_t i = 0; i < out.size(); ++i) {
    if constexpr (kColumns == 1) {
      out[i] = {c[i], 0.0, 0.0};
    } else if constexpr (kColumns == 2) {
      const double c1 = column(1)[i];
      out[i] = {c[i] + t * c1, c1, 0.0};
    } else if constexpr (kColumns == 4) {
      const double c1 = column(1)[i];
      const double c2 = column(2)[i];
      const double c3 = column(3)[i];
      out[i] = {c[i] + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3), 2.0 * c2 + 6.0 * t * c3};
    } else {
      static_assert(kColumns == 6);
      const double c1 = column(1)[i];
      const double c2 = column(2)[i];
      const double c3 = column(3)[i];
      const double c4 = column(4)[i];
      const double c5 = column(5)[i];
      out[i] = {c[i] + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
                c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + 5.0 * t * c5))),
                2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + 20.0 * t * c5))};
    }
  }
}

/// Like evaluate_polynomial(); the columns are the position and the rise during half a period of a cosine of duration
/// `step`. \rtsafe
inline void evaluate_cosine(const double* c, std::size_t axes, double t, double step,
                            std::span<AxisSetpoint> out) noexcept {
  const double w = std::numbers::pi / step;
  const double cosine = std::cos(w * t);
  const double position = 0.5 * (1.0 - cosine);
  const double velocity = 0.5 * w * std::sin(w * t);
  const double acceleration = 0.5 * w * w * cosine;
  const double* const rise = c + axes;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = {c[i] + position * rise[i], velocity * rise[i], acceleration * rise[i]};
  }
}

/// Computes a straight line. \rtsafe
inline void fill_line(double* c, std::size_t axes, double step, const double* from, const double* to) noexcept {
  for (std::size_t i = 0; i < axes; ++i) {
    c[i] = from[i];
    c[axes + i] = (to[i] - from[i]) / step;
  }
}

/// Computes the cubic with these positions and velocities at its ends. \rtsafe
inline void fill_cubic(double* c, std::size_t axes, double step, const Knot& from, const Knot& to) noexcept {
  for (std::size_t i = 0; i < axes; ++i) {
    const double slope = (to.position[i] - from.position[i]) / step;
    const double v0 = from.velocity[i];
    const double v1 = to.velocity[i];
    c[i] = from.position[i];
    c[axes + i] = v0;
    c[2 * axes + i] = (3.0 * slope - 2.0 * v0 - v1) / step;
    c[3 * axes + i] = (v0 + v1 - 2.0 * slope) / (step * step);
  }
}

/// Computes the fifth-degree polynomial with these positions, velocities and accelerations at its ends. \rtsafe
inline void fill_quintic(double* c, std::size_t axes, double step, const Knot& from, const Knot& to) noexcept {
  for (std::size_t i = 0; i < axes; ++i) {
    const double v0 = from.velocity[i];
    const double a0 = from.acceleration[i];
    // Remainders after the parabola of the start state, each as a velocity.
    const double rise = (to.position[i] - from.position[i]) / step - v0 - 0.5 * step * a0;
    const double gain = to.velocity[i] - v0 - step * a0;
    const double bend = step * (to.acceleration[i] - a0);
    c[i] = from.position[i];
    c[axes + i] = v0;
    c[2 * axes + i] = 0.5 * a0;
    c[3 * axes + i] = (10.0 * rise - 4.0 * gain + 0.5 * bend) / (step * step);
    c[4 * axes + i] = (-15.0 * rise + 7.0 * gain - bend) / (step * step * step);
    c[5 * axes + i] = (6.0 * rise - 3.0 * gain + 0.5 * bend) / (step * step * step * step);
  }
}

/// Computes the cubic with these positions and accelerations at its ends. \rtsafe
inline void fill_moments(double* c, std::size_t axes, double step, const Knot& from, const Knot& to) noexcept {
  for (std::size_t i = 0; i < axes; ++i) {
    const double here = from.acceleration[i];
    const double next = to.acceleration[i];
    c[i] = from.position[i];
    c[axes + i] = (to.position[i] - from.position[i]) / step - (step / 6.0) * (2.0 * here + next);
    c[2 * axes + i] = here / 2.0;
    c[3 * axes + i] = (next - here) / (6.0 * step);
  }
}

}  // namespace driveline::trajectory::segment_detail
