#pragma once

#include <cstdint>
#include <optional>

namespace driveline::slaves::position_servo {

/// Units of the position servo: velocities in 0.1 counts/s, accelerations in 10 counts/s^2 (PositionServo CANopen
/// manual, lines 4274 and 4306).
inline constexpr double kVelocityUnit = 0.1;
/// See kVelocityUnit.
inline constexpr double kAccelerationUnit = 10.0;
/// Largest velocity, in 0.1 counts/s (line 4274).
inline constexpr std::int32_t kMaxVelocity = 500'000'000;
/// Largest acceleration, in 10 counts/s^2 (line 4306).
inline constexpr std::int32_t kMaxAcceleration = 200'000'000;

/// Faults of motion with their numbers. The numbers of the table (lines 2204-2255) are lost in the text; they are
/// reconstructed from the order of its rows.
enum class MotionFault : std::uint8_t {
  kNone = 0,                   ///< no fault
  kQueueOverflow = 23,         ///< a move was added to a full queue
  kQueueUnderflow = 24,        ///< a segment ended with a velocity, and no segment follows
  kDisabled = 27,              ///< a move was added while the drive is disabled
  kAccelerationTooBig = 28,    ///< above kMaxAcceleration, or no acceleration leads to the target
  kAccelerationTooSmall = 29,  ///< not 0 and less than one unit, or 0 where the move needs one
  kVelocityTooBig = 30,        ///< above kMaxVelocity
  kVelocityTooSmall = 31,      ///< negative, or 0 where the move needs one
};

/// Shape of a move (6086h, lines 4367-4377).
enum class MoveType : std::int16_t {
  kSegmentSCurve = -2,  ///< jerk-limited segment: ends with its velocity
  kSegment = -1,        ///< segment of constant acceleration: ends with its velocity
  kTrapezoid = 0,       ///< unlimited jerk, to standstill
  kSCurve = 3,          ///< limited jerk, to standstill; one acceleration for both ends
};

/// A move as it waits in the queue.
struct Move {
  MoveType type = MoveType::kTrapezoid;  ///< shape
  bool relative = false;                 ///< the target is added to the demand position at the start of the move
  std::int32_t target = 0;               ///< in counts (607Ah)
  std::int32_t velocity = 0;             ///< in 0.1 counts/s (6081h); of a segment: its velocity at the end
  std::int32_t acceleration = 0;         ///< in 10 counts/s^2 (6083h); not used by segments
  std::int32_t deceleration = 0;         ///< in 10 counts/s^2 (6084h); of trapezoids, and of the halt of segments
  /// Distance in counts from the registration mark: a mark during the move makes its target. Not of segments.
  std::optional<std::int32_t> beyond_mark = std::nullopt;
};

/// Whether the move is a segment. \rtsafe
[[nodiscard]] constexpr bool is_segment(MoveType type) noexcept {
  return type == MoveType::kSegment || type == MoveType::kSegmentSCurve;
}

/// Returns the fault of a move whose own values contradict each other or their ranges, or kNone. \rtsafe
[[nodiscard]] MotionFault check(const Move& move) noexcept;

}  // namespace driveline::slaves::position_servo
