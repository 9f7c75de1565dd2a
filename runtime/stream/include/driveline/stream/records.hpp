#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/rt/shared_layout.hpp"
#include "driveline/rt/shared_ring.hpp"

/// Setpoints that another process streams into the axes of a running line: the records in the shared memory between
/// them. Values are in SI units: rad, rad/s and Nm for rotary axes, m, m/s and N for linear ones.
namespace driveline::stream {

/// Of greeting and records; both ends must be of the same.
inline constexpr std::uint32_t kVersion = 1;
/// Axes of one client.
inline constexpr std::size_t kMaxAxes = 16;

/// What a record of the client says.
enum class RecordKind : std::uint32_t {
  kSetpoint = 1,   ///< where the axes shall be at `time_ns`
  kHeartbeat = 2,  ///< the client is alive; every other record says so as well
  kFollow = 3,     ///< axes that do not follow are to do so again, after a motion by hand or a failure; those that
                   ///< somebody has taken over as soon as nobody commands them
  kEnd = 4,        ///< the axes are to come to rest, and are free then
};

/// What an axis shall do at one instant. Which interpolation uses velocity and acceleration: docs/motion.md.
struct AxisTarget {
  double position = 0.0;      ///< rad or m
  double velocity = 0.0;      ///< rad/s or m/s
  double acceleration = 0.0;  ///< rad/s^2 or m/s^2
};

/// From the client.
struct SetpointRecord {
  std::uint64_t number = 0;                    ///< of setpoints: one more than that of the setpoint before, from 1 on
  RecordKind kind = RecordKind::kHeartbeat;    ///< what it is
  std::uint32_t axis_count = 0;                ///< kSetpoint: as many as the client has asked for
  std::int64_t time_ns = 0;                    ///< kSetpoint: on the time axis of the client, which may begin anywhere
  std::array<AxisTarget, kMaxAxes> targets{};  ///< kSetpoint: of the axes, in the order of the greeting
};

/// Why a setpoint was not taken, or was taken with a remark (kGap).
enum class Refusal : std::uint32_t {
  kNotFinite,       ///< a number is infinite or NaN
  kDuplicate,       ///< its number is that of the setpoint before
  kOutOfOrder,      ///< its number is lower, or its time not later than that of the setpoint before
  kGap,             ///< numbers are missing before it; it was taken
  kLate,            ///< its time is over
  kTooFarAhead,     ///< more setpoints than can wait, or its time is too far away
  kTimeGap,         ///< too long after the setpoint before, which the axes have not passed yet
  kAxisCount,       ///< other axes than the client has asked for
  kUnknownKind,     ///< a record of no known kind
  kTooFast,         ///< faster than the limit of an axis, or not to be reached from the setpoint before within it
  kOutsideRange,    ///< a position that the axis cannot have
  kImpossibleIndex  ///< the client has written nonsense over the indexes of the ring; all that waited is lost
};
/// How many there are.
inline constexpr std::size_t kRefusals = 12;

/// The reason in a few words: "later than its time".
[[nodiscard]] constexpr std::string_view to_text(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kNotFinite:
      return "not finite";
    case Refusal::kDuplicate:
      return "sent twice";
    case Refusal::kOutOfOrder:
      return "out of order";
    case Refusal::kGap:
      return "behind a gap";
    case Refusal::kLate:
      return "later than its time";
    case Refusal::kTooFarAhead:
      return "too far ahead";
    case Refusal::kTimeGap:
      return "too long after the one before";
    case Refusal::kAxisCount:
      return "of another number of axes";
    case Refusal::kUnknownKind:
      return "of no known kind";
    case Refusal::kTooFast:
      return "too fast for an axis";
    case Refusal::kOutsideRange:
      return "outside the range of an axis";
    case Refusal::kImpossibleIndex:
      return "lost by an impossible index";
  }
  return "refused";
}

/// What has become of a client.
enum class SessionState : std::uint32_t {
  kWaiting = 0,    ///< there are no setpoints yet
  kStreaming = 1,  ///< there are; whether an axis follows them: AxisStatus::following
  kStarved = 2,    ///< the setpoints are used up: the axes come to rest where they are, and go on with the next ones
  kEnding = 3,     ///< the axes come to rest; no more is taken
  kOver = 4,       ///< the axes are free
};

/// Why a session ends.
enum class EndReason : std::uint32_t {
  kNone = 0,    ///< it does not
  kEnded = 1,   ///< the client wants it so
  kSilent = 2,  ///< no record for longer than the keep-alive time
  kGone = 3,    ///< the client has closed its connection, or died
  kLine = 4,    ///< the line ends
};

/// The reason as the end of a sentence: "it has ended the session".
[[nodiscard]] constexpr std::string_view to_text(EndReason reason) noexcept {
  switch (reason) {
    case EndReason::kNone:
      return "it goes on";
    case EndReason::kEnded:
      return "it has ended the session";
    case EndReason::kSilent:
      return "it was silent for longer than the keep-alive time";
    case EndReason::kGone:
      return "its connection is gone";
    case EndReason::kLine:
      return "the line ends";
  }
  return "its session is over";
}

/// State of an axis, as PLCopen motion control part 1 names it.
enum class AxisState : std::uint32_t {
  kDisabled,            ///< without power
  kStandstill,          ///< it holds its position
  kHoming,              ///< the drive looks for its home
  kStopping,            ///< it was stopped, and the stop was not released yet
  kDiscreteMotion,      ///< to a position, or to rest
  kContinuousMotion,    ///< at a velocity
  kSynchronizedMotion,  ///< it follows the stream
  kErrorStop,           ///< it has failed, and waits for a reset
};

/// An axis of the client in one cycle.
struct AxisStatus {
  AxisState state = AxisState::kDisabled;  ///< of this cycle
  std::uint32_t error = 0;                 ///< of ErrorStop: ecat_master::AxisError
  std::uint32_t following = 0;             ///< 1: it follows the stream
  std::uint32_t leased = 0;                ///< 1: the client may command it; 0: somebody else has taken it over
  double setpoint = 0.0;                   ///< what the drive is given, rad or m
  double position = 0.0;                   ///< actual one
  double velocity = 0.0;                   ///< actual one
  double torque = 0.0;                     ///< actual one, Nm or N
};

/// To the client, in every cycle.
struct StatusRecord {
  std::int64_t cycle = 0;      ///< number on the grid
  std::int64_t grid_ns = 0;    ///< grid time of the cycle: CLOCK_MONOTONIC, or virtual time
  std::int64_t stream_ns = 0;  ///< where the line is on the time axis of the client; kStreaming and kStarved
  std::int64_t newest_ns = 0;  ///< time of the newest setpoint that was taken
  std::uint64_t taken = 0;     ///< setpoints
  SessionState state = SessionState::kWaiting;     ///< of the session
  EndReason reason = EndReason::kNone;             ///< of kEnding and kOver
  std::array<std::uint64_t, kRefusals> refused{};  ///< by Refusal
  std::uint64_t starved = 0;                       ///< how often the setpoints were used up in motion
  std::uint64_t detours = 0;                       ///< how often an axis left the curve to keep its limits
  std::uint32_t axis_count = 0;                    ///< of `axes`
  std::uint32_t reserved = 0;                      ///< 0
  std::array<AxisStatus, kMaxAxes> axes{};         ///< in the order of the greeting

  /// How often setpoints were refused for this reason.
  [[nodiscard]] constexpr std::uint64_t count(Refusal refusal) const noexcept {
    return refused[static_cast<std::size_t>(refusal)];
  }
};

/// Layout of the ring to the line; only its maker gives a capacity.
[[nodiscard]] constexpr rt::SharedLayout setpoint_ring(std::uint64_t capacity = 0) noexcept {
  return rt::shared_ring<SetpointRecord>(0x5354'5250, kVersion, capacity);
}
/// Layout of the broadcast from the line; only its maker gives a capacity.
[[nodiscard]] constexpr rt::SharedLayout status_broadcast(std::uint64_t capacity = 0) noexcept {
  return rt::shared_broadcast<StatusRecord>(0x5354'5354, kVersion, capacity);
}

}  // namespace driveline::stream
