#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/rt/shared_layout.hpp"
#include "driveline/rt/shared_ring.hpp"

/// Setpoints that another process streams to the axes of a running line: records in their shared memory. Values are in
/// SI units: rad, rad/s and Nm for rotary axes, m, m/s and N for linear ones.
namespace driveline::stream {

/// Version of greeting and records; both ends must have the same.
inline constexpr std::uint32_t kVersion = 2;
/// Most axes per client.
inline constexpr std::size_t kMaxAxes = 16;

/// Kind of a record of the client.
enum class RecordKind : std::uint32_t {
  kSetpoint = 1,   ///< targets of the axes at `time_ns`
  kHeartbeat = 2,  ///< the client is alive; every other record shows that, too
  kFollow = 3,     ///< axes that do not follow shall follow again, after another motion or a failure; axes that another
                   ///< client has taken over, as soon as they have no owner
  kEnd = 4,        ///< brings the axes to rest; then they are free
};

/// Target of an axis at one instant. docs/motion.md explains which interpolation uses velocity and acceleration.
struct AxisTarget {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
};

/// Record from the client.
struct SetpointRecord {
  std::uint64_t number = 0;  ///< kSetpoint: one more than that of the preceding setpoint, starting with 1
  RecordKind kind = RecordKind::kHeartbeat;  ///< kind of the record
  std::uint32_t axis_count = 0;              ///< kSetpoint: number of axes that the client has requested
  std::int64_t time_ns = 0;  ///< kSetpoint: time on the time axis of the client, whose origin is arbitrary
  std::array<AxisTarget, kMaxAxes> targets{};  ///< kSetpoint: targets of the axes, in the order of the greeting
};

/// Why a setpoint was refused, or accepted with a remark (kGap).
enum class Refusal : std::uint32_t {
  kNotFinite,       ///< a number is infinite or NaN
  kDuplicate,       ///< its number is that of the preceding setpoint
  kOutOfOrder,      ///< its number is lower, or its time not later than that of the preceding setpoint
  kGap,             ///< numbers are missing before it; it was accepted
  kLate,            ///< its time has passed
  kTooFarAhead,     ///< too many setpoints are waiting, or its time is too far ahead
  kTimeGap,         ///< too long after the preceding setpoint, which the axes have not passed yet
  kAxisCount,       ///< the number of axes differs from that requested
  kUnknownKind,     ///< a record of no known kind
  kTooFast,         ///< faster than the limit of an axis, or not reachable from the preceding setpoint within the limit
  kOutsideRange,    ///< a position outside the range of the axis
  kImpossibleIndex  ///< the client has overwritten the indexes of the ring with invalid values; all waiting records are
                    ///< lost
};
/// Number of refusal reasons.
inline constexpr std::size_t kRefusals = 12;

/// Returns the reason in a few words: "later than its time".
[[nodiscard]] constexpr std::string_view to_text(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kNotFinite:
      return "not finite";
    case Refusal::kDuplicate:
      return "sent twice";
    case Refusal::kOutOfOrder:
      return "out of order";
    case Refusal::kGap:
      return "after a gap";
    case Refusal::kLate:
      return "later than its time";
    case Refusal::kTooFarAhead:
      return "too far ahead";
    case Refusal::kTimeGap:
      return "too long after the previous one";
    case Refusal::kAxisCount:
      return "for another number of axes";
    case Refusal::kUnknownKind:
      return "of an unknown kind";
    case Refusal::kTooFast:
      return "too fast for an axis";
    case Refusal::kOutsideRange:
      return "outside the range of an axis";
    case Refusal::kImpossibleIndex:
      return "lost through an invalid index";
  }
  return "refused";
}

/// State of the session of a client.
enum class SessionState : std::uint32_t {
  kWaiting = 0,    ///< there are no setpoints yet
  kStreaming = 1,  ///< there are setpoints; ClientAxisStatus::following shows whether an axis follows them
  kStarved = 2,    ///< no setpoints are left: the axes come to rest, and continue with the next setpoints
  kEnding = 3,     ///< the axes come to rest; no more records are accepted
  kOver = 4,       ///< the axes are free
};

/// Why a session ends.
enum class EndReason : std::uint32_t {
  kNone = 0,    ///< it does not end
  kEnded = 1,   ///< the client has requested it
  kSilent = 2,  ///< no record for longer than the keep-alive time
  kGone = 3,    ///< the client has closed its connection, or died
  kLine = 4,    ///< the line ends
};

/// Returns the reason as the end of a sentence: "it has ended the session".
[[nodiscard]] constexpr std::string_view to_text(EndReason reason) noexcept {
  switch (reason) {
    case EndReason::kNone:
      return "it continues";
    case EndReason::kEnded:
      return "it has ended the session";
    case EndReason::kSilent:
      return "it was silent for longer than the keep-alive time";
    case EndReason::kGone:
      return "its connection is closed";
    case EndReason::kLine:
      return "the line ends";
  }
  return "its session is over";
}

/// State of an axis, with the names of PLCopen motion control part 1.
enum class MotionState : std::uint32_t {
  kDisabled,            ///< no power
  kStandstill,          ///< holds its position
  kHoming,              ///< the drive is homing
  kStopping,            ///< was stopped, and the stop is not released yet
  kDiscreteMotion,      ///< moves to a position, or to rest
  kContinuousMotion,    ///< moves at a velocity
  kSynchronizedMotion,  ///< follows the stream
  kErrorStop,           ///< has failed, and waits for a reset
};

/// State of an axis of the client in one cycle.
struct ClientAxisStatus {
  MotionState state = MotionState::kDisabled;  ///< state in this cycle
  std::uint32_t error = 0;                     ///< error in ErrorStop: motion::AxisError
  std::uint32_t following = 0;                 ///< 1: follows the stream
  std::uint32_t leased = 0;                    ///< 1: the client may command it; 0: another client has taken it over
  double setpoint = 0.0;                       ///< setpoint sent to the drive, rad or m
  double position = 0.0;                       ///< actual position, rad or m
  double velocity = 0.0;                       ///< actual velocity, rad/s or m/s
  double torque = 0.0;                         ///< actual torque, Nm or N
};

/// Record to the client, one per cycle.
struct StatusRecord {
  std::int64_t cycle = 0;    ///< number of the cycle on the grid
  std::int64_t grid_ns = 0;  ///< grid time of the cycle: CLOCK_MONOTONIC, or virtual time
  /// Present time of the line on the time axis of the client; valid in kStreaming and kStarved.
  std::int64_t stream_ns = 0;
  std::int64_t newest_ns = 0;                      ///< time of the newest accepted setpoint
  std::uint64_t taken = 0;                         ///< accepted setpoints
  SessionState state = SessionState::kWaiting;     ///< state of the session
  EndReason reason = EndReason::kNone;             ///< reason in kEnding and kOver
  std::array<std::uint64_t, kRefusals> refused{};  ///< refused setpoints, indexed by Refusal
  std::uint64_t starved = 0;                       ///< number of times the setpoints ran out in motion
  std::uint64_t detours = 0;                       ///< number of times an axis left the curve to keep its limits
  std::uint32_t axis_count = 0;                    ///< number of valid `axes`
  std::uint32_t reserved = 0;                      ///< 0
  std::array<ClientAxisStatus, kMaxAxes> axes{};   ///< in the order of the greeting

  /// Returns how often setpoints were refused for this reason.
  [[nodiscard]] constexpr std::uint64_t count(Refusal refusal) const noexcept {
    return refused[static_cast<std::size_t>(refusal)];
  }
};

/// Layout of the ring to the line; only the side that creates it passes a capacity.
[[nodiscard]] constexpr rt::SharedLayout setpoint_ring(std::uint64_t capacity = 0) noexcept {
  return rt::shared_ring<SetpointRecord>(0x5354'5250, kVersion, capacity);
}
/// Layout of the broadcast from the line; only the side that creates it passes a capacity.
[[nodiscard]] constexpr rt::SharedLayout status_broadcast(std::uint64_t capacity = 0) noexcept {
  return rt::shared_broadcast<StatusRecord>(0x5354'5354, kVersion, capacity);
}

}  // namespace driveline::stream
