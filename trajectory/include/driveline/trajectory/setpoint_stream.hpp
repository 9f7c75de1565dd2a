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

/// What became of a setpoint that was pushed.
enum class StreamVerdict : std::uint8_t {
  kAccepted,
  kWrongCount,   ///< not one value per axis
  kNotFinite,    ///< its time, or a value
  kOutOfRange,   ///< a value is beyond what a path may have (path.hpp)
  kDuplicate,    ///< less than 1 ns from the newest setpoint
  kOutOfOrder,   ///< before the newest setpoint
  kTooLate,      ///< for an instant that has passed
  kTooFarAhead,  ///< further in the future than the settings allow
  kGapTooLarge,  ///< further from the newest setpoint than the settings allow, while that one is still ahead
  kOverrun,      ///< there is no room
};
/// How many verdicts there are.
inline constexpr std::size_t kStreamVerdicts = 10;

/// What a stream does.
enum class StreamState : std::uint8_t {
  kAtRest,     ///< nothing has come yet, or all axes have come to rest
  kFollowing,  ///< the curve
  kCoasting,   ///< setpoints are missing: on along the last polynomial
  kStopping,   ///< with bounded jerk
};

/// How a stream treats its setpoints.
struct StreamSettings {
  StreamMethod method = StreamMethod::kCubic;
  double period_s = 125e-6;  ///< from evaluate() to evaluate()
  /// From the time of a setpoint to the demand: what a sender is not ahead of time by itself. To be at least
  /// facts_of(method).delay steps of the sender and the time that setpoints take here; nothing else delays.
  double delay_s = 0.0;
  double max_gap_s = 0.1;          ///< between two setpoints that are joined; and how long kHold holds the last one
  double max_ahead_s = 1.0;        ///< of the time of evaluate()
  std::size_t capacity = 64;       ///< setpoints ahead
  std::uint32_t coast_cycles = 8;  ///< along the last polynomial, when setpoints are missing
};

/// Counts since construction.
struct StreamCounters {
  std::array<std::uint64_t, kStreamVerdicts> verdicts{};  ///< by StreamVerdict
  std::uint64_t underruns = 0;                            ///< times that setpoints were missing
  std::uint64_t stops = 0;                                ///< underruns that were not over when coasting was
  std::uint64_t detours = 0;                              ///< times that an axis left the curve to keep its limits
};

/// Turns setpoints of a group of axes that arrive on a grid of their own, with jitter and losses, into one setpoint per
/// axis and cycle. The demand keeps the limits of velocity and acceleration of every axis whatever arrives, or does
/// not.
///
/// * Time: stamps and evaluate() are on one time axis; the setpoint for time t is demanded at t + delay_s, a constant.
/// * Underrun: when the curve does not reach the present, all axes go on along its last polynomial for coast_cycles,
///   then they stop with bounded jerk. Setpoints that return are taken up at once: where the axes can be on the curve
///   within their limits they are, otherwise they approach it (Rejoin).
/// * Gap: setpoints further apart than max_gap_s are not joined. While the older one is still ahead the newer one is
///   refused; once the axes have run out of setpoints it begins a new curve.
/// * Overrun: the newest setpoint is refused; those that are there stay as they are.
///
/// It allocates when it is made only. All other functions belong to one real-time thread.
class SetpointStream {
 public:
  /// One limit per axis. Throws std::invalid_argument for settings or limits that cannot be: no axes or more than a
  /// path has, limits that are not positive and finite (the jerk may be infinite), times that are not finite and
  /// positive (the delay: negative), fewer setpoints than the method needs.
  SetpointStream(const StreamSettings& settings, std::span<const FollowLimits> limits);

  /// Begins anew at a time, without setpoints, with all axes at rest at `positions` (one per axis, rad or m); all
  /// finite. \rtsafe
  void begin(double now_s, std::span<const double> positions) noexcept;
  /// Takes a setpoint of all axes for `time_s`. \rtsafe
  StreamVerdict push(double time_s, std::span<const StreamPoint> points) noexcept;
  /// The setpoints of the cycle at `now_s`, one per axis; a time before the last one, or NaN, counts as the last one.
  /// One call per period. \rtsafe
  StreamState evaluate(double now_s, std::span<AxisSetpoint> out) noexcept;
  /// False: the axes come to rest while time goes on and setpoints are taken and passed; true: they follow again.
  /// \rtsafe
  void run(bool running) noexcept { running_ = running; }

  /// \rtsafe
  [[nodiscard]] StreamState state() const noexcept { return state_; }
  /// All axes were on the curve in the last cycle, none on a detour. \rtsafe
  [[nodiscard]] bool on_curve() const noexcept;
  /// \rtsafe
  [[nodiscard]] const StreamCounters& counters() const noexcept { return counters_; }
  /// \rtsafe
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
  std::uint32_t coasted_ = 0;  // cycles
  bool running_ = true;
  double now_s_ = 0.0;
  double newest_s_ = -std::numeric_limits<double>::infinity();  // of the setpoints that were taken
};

}  // namespace driveline::trajectory
