#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/cia402/profile_generator.hpp"
#include "driveline/slaves/position_servo/move.hpp"
#include "driveline/slaves/position_servo/move_queue.hpp"
#include "driveline/slaves/position_servo/segment.hpp"

namespace driveline::slaves::position_servo {

/// The native motion of the position servo: a queue of moves, and the demand that follows from them, once per control
/// period. Independent of any bus. Source: PositionServo CANopen manual, chapter 10.1; decisions in
/// docs/position_servo.md.
///
/// A discrete move begins at standstill and ends there. Segments follow each other without a stop. A fault brakes the
/// axis, empties the queue, and remains until clear_fault().
class Motion {
 public:
  /// Sets the demand at standstill and removes all moves; the drive keeps its other states. \rtsafe
  void reset(double position) noexcept;
  /// Enables or disables the drive. Disabled, the demand stands still and no move waits. \rtsafe
  void enable(bool on) noexcept;
  /// Deceleration in 10 counts/s^2 with which a fault brakes the axis; values below 1 count as 1. \rtsafe
  void set_fault_deceleration(std::int32_t deceleration) noexcept { fault_deceleration_ = deceleration; }

  /// Adds a move; it begins when all moves before it have ended. Returns kNone, or the fault that now stops the axis,
  /// or an earlier fault that is not cleared yet. \rtsafe
  MotionFault add(const Move& move) noexcept;
  /// Suspends motion: moves wait and none begins from standstill; a motion that runs goes on (lines 4096-4099). \rtsafe
  void suspend(bool on) noexcept { suspended_ = on; }
  /// Interrupts the motion; released, the axis goes on to the same target (line 4102). \rtsafe
  void halt(bool on) noexcept;
  /// Brakes to standstill and removes all moves. Deceleration in 10 counts/s^2; another call during the stop changes
  /// it at once (lines 4071-4074). \rtsafe
  void stop(std::int32_t deceleration) noexcept;
  /// Removes the moves that wait; the motion that runs goes on. \rtsafe
  void flush() noexcept { queue_.clear(); }
  /// Registration input at this position in counts: a move with a distance beyond the mark turns to its new target;
  /// later marks of the same move have no effect. \rtsafe
  void mark(double position) noexcept;
  /// Runs one control period. \rtsafe
  void step(std::chrono::nanoseconds period) noexcept;

  /// Returns the demand: counts, counts/s, counts/s^2. \rtsafe
  [[nodiscard]] const ProfileState& demand() const noexcept { return demand_; }
  /// Returns the fault that is not cleared yet. \rtsafe
  [[nodiscard]] MotionFault fault() const noexcept { return fault_; }
  /// Clears the fault. \rtsafe
  void clear_fault() noexcept { fault_ = MotionFault::kNone; }
  /// Whether a motion runs, also while it is halted (status word, bit 14, lines 1911-1912). \rtsafe
  [[nodiscard]] bool moving() const noexcept { return phase_ != Phase::kIdle; }
  /// Whether motion is suspended (1002h bit 22). \rtsafe
  [[nodiscard]] bool suspended() const noexcept { return suspended_; }
  /// Whether motion is complete and the queue is empty (1002h bit 25). \rtsafe
  [[nodiscard]] bool done() const noexcept { return !moving() && queue_.empty(); }
  /// Whether a mark has changed the target of the current or last move (1002h bit 19). \rtsafe
  [[nodiscard]] bool marked() const noexcept { return marked_; }
  /// Returns the moves that wait; the move that runs is not among them. \rtsafe
  [[nodiscard]] const MoveQueue& queue() const noexcept { return queue_; }

 private:
  enum class Phase : std::uint8_t { kIdle, kDiscrete, kSegment, kHalt, kStop };
  void take_next() noexcept;
  void begin_discrete() noexcept;
  bool begin_segment(const ProfileState& start) noexcept;
  void run_segment(double period_s) noexcept;
  void resume() noexcept;
  void brake(double deceleration, double jerk_time_s, Phase phase) noexcept;
  void fail(MotionFault fault) noexcept;

  MoveQueue queue_;
  Move move_;
  double target_ = 0.0;
  Segment segment_;
  double elapsed_s_ = 0.0;  ///< since the start of the segment
  ProfileGenerator generator_;
  ProfileState demand_;
  Phase phase_ = Phase::kIdle;
  MotionFault fault_ = MotionFault::kNone;
  std::int32_t fault_deceleration_ = kMaxAcceleration;
  bool enabled_ = false;
  bool suspended_ = false;
  bool halted_ = false;
  bool marked_ = false;
};

}  // namespace driveline::slaves::position_servo
