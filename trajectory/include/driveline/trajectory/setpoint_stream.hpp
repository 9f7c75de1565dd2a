#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "driveline/trajectory/limited_axis.hpp"
#include "driveline/trajectory/setpoint.hpp"
#include "driveline/trajectory/stream_curve.hpp"

namespace driveline::trajectory {

/// Result of pushing a setpoint.
enum class StreamVerdict : std::uint8_t {
  kAccepted,
  kWrongCount,   ///< the number of values differs from the number of axes
  kNotFinite,    ///< its time or a value is not finite
  kOutOfRange,   ///< a value exceeds the limits of a path (path.hpp)
  kDuplicate,    ///< less than 1 ns from the newest setpoint
  kOutOfOrder,   ///< before the newest setpoint
  kTooLate,      ///< its time has passed
  kTooFarAhead,  ///< farther in the future than max_ahead_s
  kGapTooLarge,  ///< farther from the newest setpoint than max_gap_s, while the newest setpoint is still in the future
  kOverrun,      ///< the buffer is full
};
/// Number of verdicts.
inline constexpr std::size_t kStreamVerdicts = 10;

/// State of a stream.
enum class StreamState : std::uint8_t {
  kAtRest,     ///< no setpoint has arrived, or all axes have come to rest
  kFollowing,  ///< following the curve
  kCoasting,   ///< setpoints are missing; continuing along the last polynomial
  kStopping,   ///< stopping with bounded jerk
};

/// Settings of a stream.
struct StreamSettings {
  StreamMethod method = StreamMethod::kCubic;
  double period_s = 125e-6;  ///< time between calls of evaluate()
  /// Delay from the time of a setpoint to its demand, for senders that do not send ahead of time. It must cover at
  /// least facts_of(method).delay steps of the sender plus the transfer time of setpoints; there is no other delay.
  double delay_s = 0.0;
  double max_gap_s = 0.1;     ///< longest time between two joined setpoints; also how long kHold holds the last one
  double max_ahead_s = 1.0;   ///< longest time of a setpoint ahead of evaluate()
  std::size_t capacity = 64;  ///< maximum number of setpoints ahead
  std::uint32_t coast_cycles = 8;  ///< number of cycles along the last polynomial when setpoints are missing
};

/// Counts since construction.
struct StreamCounters {
  std::array<std::uint64_t, kStreamVerdicts> verdicts{};  ///< indexed by StreamVerdict
  std::uint64_t underruns = 0;                            ///< number of times that setpoints were missing
  std::uint64_t stops = 0;                                ///< underruns that lasted longer than coasting
  std::uint64_t detours = 0;  ///< number of times that an axis left the curve to keep its limits
};

/// Turns setpoints of a group of axes that arrive on a time grid of their own, with jitter and losses, into one
/// setpoint per axis and cycle. The demand keeps the limits of velocity and acceleration of every axis whatever arrives
/// or fails to arrive.
///
/// * Time: time stamps and evaluate() use one time axis; the setpoint for time t is demanded at t + delay_s, a
///   constant.
/// * Underrun: when the curve does not reach the present, all axes continue along its last polynomial for coast_cycles,
///   then they stop with bounded jerk. When setpoints arrive again they are used at once: axes that can be on the curve
///   within their limits are on it, others approach it (Rejoin).
/// * Gap: setpoints farther apart than max_gap_s are not joined. While the older one is still ahead the newer one is
///   refused; once the axes have run out of setpoints it starts a new curve.
/// * Overrun: the newest setpoint is refused; the stored ones are unchanged.
///
/// Only the constructor allocates. All other functions belong to one real-time thread.
class SetpointStream {
 public:
  /// One limit per axis. Throws std::invalid_argument for invalid settings or limits: no axes or more than a path
  /// allows, limits that are not positive and finite (the jerk may be infinite), times that are not finite and positive
  /// (the delay: negative), fewer setpoints than the method needs.
  SetpointStream(const StreamSettings& settings, std::span<const FollowLimits> limits);

  /// Restarts at time `now_s` without setpoints, with all axes at rest at `positions` (one per axis, rad or m, all
  /// finite). \rtsafe
  void begin(double now_s, std::span<const double> positions) noexcept;
  /// Adds a setpoint of all axes for `time_s`. \rtsafe
  StreamVerdict push(double time_s, std::span<const StreamPoint> points) noexcept;
  /// Computes the setpoints of the cycle at `now_s`, one per axis; a time before that of the previous call, or NaN,
  /// repeats the previous time. Call it once per period. \rtsafe
  StreamState evaluate(double now_s, std::span<AxisSetpoint> out) noexcept;
  /// false: the axes come to rest while time advances and setpoints are accepted and discarded; true: the axes follow
  /// again. \rtsafe
  void run(bool running) noexcept { running_ = running; }

  /// Current state. \rtsafe
  [[nodiscard]] StreamState state() const noexcept { return state_; }
  /// Whether all axes were on the curve in the last cycle. \rtsafe
  [[nodiscard]] bool on_curve() const noexcept;
  /// Counts since construction. \rtsafe
  [[nodiscard]] const StreamCounters& counters() const noexcept { return counters_; }
  /// Number of axes. \rtsafe
  [[nodiscard]] std::size_t axes() const noexcept { return axes_.size(); }

 private:
  [[nodiscard]] StreamVerdict judge(double time_s, std::span<const StreamPoint> points) const noexcept;
  [[nodiscard]] StreamVerdict judge_time(double time_s) const noexcept;
  [[nodiscard]] bool leaves_gap(double time_s) const noexcept { return time_s - newest_s_ > settings_.max_gap_s; }
  [[nodiscard]] bool follows() const noexcept {
    return state_ == StreamState::kFollowing || state_ == StreamState::kCoasting;
  }
  [[nodiscard]] StreamState next_state(bool reached) noexcept;

  StreamSettings settings_;
  StreamCurve curve_;
  std::vector<LimitedAxis> axes_;
  std::vector<AxisSetpoint> targets_;
  StreamCounters counters_;
  StreamState state_ = StreamState::kAtRest;
  std::uint32_t coasted_ = 0;  // cycles of coasting so far
  bool running_ = true;
  double now_s_ = 0.0;
  double newest_s_ = -std::numeric_limits<double>::infinity();  // time of the newest accepted setpoint
};

}  // namespace driveline::trajectory
