#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/trajectory/interpolation_method.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {

/// How setpoints that arrive one after the other are joined.
enum class StreamMethod : std::uint8_t {
  kHold,     ///< each is held until the next
  kLinear,   ///< straight lines
  kHermite,  ///< cubics through positions and velocities
  kCubic,    ///< cubics through positions, with the velocities of the parabolas through three neighbours
  kQuintic,  ///< fifth degree through positions, velocities and accelerations
  kBSpline,  ///< cubic B-spline: approximates the positions
};

/// Setpoint of one axis. What the method does not use is ignored.
struct StreamPoint {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
};

/// What is known of a method.
struct StreamMethodFacts {
  Continuity continuity;  ///< of the curve at the setpoints
  std::size_t delay;      ///< setpoints that must be there beyond an instant before the curve reaches it
  std::size_t columns;    ///< coefficients per axis
};

/// \rtsafe
[[nodiscard]] StreamMethodFacts facts_of(StreamMethod method) noexcept;

/// A curve through setpoints of several axes that is continued while it is evaluated. It has room for a fixed number of
/// setpoints and allocates when it is made only. Their steps may differ; a curve begins as if its first straight line
/// had come from before. One thread.
class StreamCurve {
 public:
  /// `capacity`: setpoints that may lie ahead, at least facts_of(method).delay + 1. `hold_s`: how long kHold holds a
  /// setpoint that no other follows.
  StreamCurve(StreamMethod method, std::size_t axes, std::size_t capacity, double hold_s);

  /// Forgets all setpoints. \rtsafe
  void clear() noexcept;
  /// No more setpoints fit in before time has advanced. \rtsafe
  [[nodiscard]] bool full() const noexcept { return end_ - segment_ > capacity_; }
  /// Adds a setpoint; not when full. `time_s` is later than the last one. \rtsafe
  void add(double time_s, std::span<const StreamPoint> points) noexcept;
  /// Goes on to a time, which never decreases while there are setpoints. False: setpoints that would tell where the
  /// curve is there are missing. Cost: the setpoints on the way, and the coefficients of one segment. \rtsafe
  bool advance(double time_s) noexcept;
  /// There is something to evaluate. \rtsafe
  [[nodiscard]] bool begun() const noexcept { return begun_; }
  /// The curve at a time in the segment that advance() has gone to, or beyond it, where the polynomial goes on. Writes
  /// one setpoint for each axis. Only when begun(). \rtsafe
  void evaluate(double time_s, std::span<AxisSetpoint> out) const noexcept;

  /// \rtsafe
  [[nodiscard]] std::size_t axes() const noexcept { return axes_; }

 private:
  // Values of all axes at one setpoint.
  using Row = std::vector<double>;

  struct Ends {
    Row positions;
    Row derivatives;
  };

  // Control points of a B-spline, of all axes: each at a setpoint, or a part of the way to the one beside it.
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
  // Rings of setpoints; setpoint i is at i modulo their size. Two before the segment are kept.
  std::vector<double> times_s_;
  Row positions_;
  Row velocities_;
  Row accelerations_;
  Ends from_;  // of a segment whose ends are derived from several setpoints
  Ends to_;
  double start_s_ = 0.0;  // of the present segment
  std::vector<double> coefficients_;
  std::uint64_t segment_ = 0;  // setpoint at which the present segment starts
  std::uint64_t end_ = 0;      // one behind the newest
  bool begun_ = false;
};

}  // namespace driveline::trajectory
