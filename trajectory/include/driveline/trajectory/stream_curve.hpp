#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/trajectory/interpolation_method.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// Interpolation between setpoints that arrive one after the other.
enum class StreamMethod : std::uint8_t {
  kHold,     ///< each setpoint is held until the next
  kLinear,   ///< straight lines
  kHermite,  ///< cubics through positions and velocities
  kCubic,    ///< cubics through positions, with the velocities of parabolas through three neighbours
  kQuintic,  ///< fifth degree through positions, velocities and accelerations
  kBSpline,  ///< cubic B-spline: approximates the positions
};

/// Setpoint of an axis. Values that the method does not use are ignored.
struct StreamPoint {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
};

/// Properties of a method.
struct StreamMethodFacts {
  Continuity continuity;  ///< continuity of the curve at the setpoints
  std::size_t delay;      ///< number of setpoints after an instant that must be known before the curve reaches it
  std::size_t columns;    ///< number of coefficients per axis
};

/// Properties of `method`. \rtsafe
[[nodiscard]] StreamMethodFacts facts_of(StreamMethod method) noexcept;

/// A curve through setpoints of several axes that is extended while it is evaluated. It stores a fixed number of
/// setpoints; only the constructor allocates. Time steps may differ; a curve starts as if its first straight line
/// extended into the past. One thread.
class StreamCurve {
 public:
  /// `capacity`: number of setpoints that may lie ahead, at least facts_of(method).delay + 1. `hold_s`: how long kHold
  /// holds a setpoint without a successor.
  StreamCurve(StreamMethod method, std::size_t axes, std::size_t capacity, double hold_s);

  /// Removes all setpoints. \rtsafe
  void clear() noexcept;
  /// Whether no more setpoints fit until time has advanced. \rtsafe
  [[nodiscard]] bool full() const noexcept { return end_ - segment_ > capacity_; }
  /// Adds a setpoint; not when full. `time_s` must be later than the previous one. \rtsafe
  void add(double time_s, std::span<const StreamPoint> points) noexcept;
  /// Advances to a time, which must not decrease while there are setpoints. Returns false if the setpoints that
  /// determine the curve there are missing. Cost: the setpoints passed, and the coefficients of a segment. \rtsafe
  bool advance(double time_s) noexcept;
  /// Whether there is a curve to evaluate. \rtsafe
  [[nodiscard]] bool begun() const noexcept { return begun_; }
  /// Evaluates the curve at a time in the current segment of advance(), or beyond it, where the polynomial continues.
  /// Writes one setpoint per axis. Only when begun(). \rtsafe
  void evaluate(double time_s, std::span<AxisSetpoint> out) const noexcept;

  /// Number of axes. \rtsafe
  [[nodiscard]] std::size_t axes() const noexcept { return axes_; }

 private:
  // Values of all axes at one setpoint.
  using Row = std::vector<double>;

  struct Ends {
    Row positions;
    Row derivatives;
  };

  // Control points of a B-spline for all axes: each at a setpoint, or at a fraction of the way to a neighbour.
  struct ControlPoints {
    const double* at;
    const double* beside;
    double weight;
    [[nodiscard]] double of(std::size_t axis) const noexcept { return at[axis] + weight * (beside[axis] - at[axis]); }
  };

  [[nodiscard]] double& time_of(std::uint64_t index) noexcept { return times_s_[index % times_s_.size()]; }
  [[nodiscard]] double* row(Row& rows, std::uint64_t index) noexcept {
    return &rows[(index % times_s_.size()) * axes_];
  }
  [[nodiscard]] bool complete(std::uint64_t segment) const noexcept { return segment + delay_ < end_; }
  void extend_backwards() noexcept;
  void estimate_velocities(std::uint64_t index, Row& velocities) noexcept;
  [[nodiscard]] ControlPoints control_points(std::uint64_t index) noexcept;
  void approximate(std::uint64_t index, Row& positions, Row& accelerations) noexcept;
  void derive(std::uint64_t index, Ends& ends) noexcept;
  void start_segment(bool next_one) noexcept;

  StreamMethod method_;
  std::size_t axes_;
  std::size_t capacity_;
  std::size_t delay_;
  double hold_s_;
  // Rings of setpoints; setpoint i is at index i modulo their size. Two setpoints before the segment are stored.
  std::vector<double> times_s_;
  Row positions_;
  Row velocities_;
  Row accelerations_;
  Ends from_;  // ends of a segment, derived from several setpoints
  Ends to_;
  double start_s_ = 0.0;  // start time of the current segment
  std::vector<double> coefficients_;
  std::uint64_t segment_ = 0;  // setpoint at which the current segment starts
  std::uint64_t end_ = 0;      // one past the newest setpoint
  bool begun_ = false;
};

}  // namespace driveline::trajectory
