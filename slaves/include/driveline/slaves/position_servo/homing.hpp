#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/cia402/homing_sequence.hpp"
#include "driveline/slaves/cia402/profile_generator.hpp"
#include "driveline/slaves/position_servo/move.hpp"

namespace driveline::slaves::position_servo {

/// Settings of homing (PositionServo CANopen manual, chapter 9.2, lines 3849-3942).
struct HomingSettings {
  std::int8_t method = 0;         ///< 6098h
  std::int32_t fast = 0;          ///< in 0.1 counts/s (6099h:1): to find the switch; also of the move of method 35
  std::int32_t slow = 0;          ///< in 0.1 counts/s (6099h:2): to find its edge and the index pulse
  std::int32_t acceleration = 0;  ///< in 10 counts/s^2 (609Ah), for starts and stops
  std::int32_t offset = 0;        ///< in counts (607Ch): zero is at the home position plus this
  std::chrono::nanoseconds time_out = std::chrono::seconds{60};  ///< longest homing (ours)
};

/// Homing of the position servo: methods 0-14, 17-19, 21, 23, 25, 27, 29, 33-35. The sequence of edges and pulses is
/// that of CiA 402 (HomingSequence), on which the manual bases its own (lines 3620-3621); the numbers that the drive
/// reserves are refused. Homing counts in the old position until it is attained; shift() then moves the origin.
class Homing {
 public:
  /// State of homing.
  enum class State : std::uint8_t {
    kIdle,       ///< not started, or ended by stop()
    kSearching,  ///< moves, until the home position is found and the axis stands
    kMoving,     ///< method 35: home is set, the axis moves to the new zero
    kAttained,   ///< done
    kFailed,     ///< failed; the axis brakes
  };

  /// Whether the drive has this method (lines 3849-3894). \rtsafe
  [[nodiscard]] static bool supported(std::int8_t method) noexcept;

  /// Starts homing from standstill at inputs.position. Returns false, without effect, if the method is reserved or a
  /// speed or the acceleration is outside its range or 0. \rtsafe
  [[nodiscard]] bool start(const HomingSettings& settings, const HomingInputs& inputs) noexcept;
  /// Ends homing and brakes. \rtsafe
  void stop() noexcept;
  /// Runs one control period. Positions of `inputs` are in the old position while state() is kSearching, and shifted by
  /// shift() afterwards; inputs.standstill is not used. \rtsafe
  void step(const HomingInputs& inputs, std::chrono::nanoseconds period) noexcept;

  /// Returns the state. \rtsafe
  [[nodiscard]] State state() const noexcept { return state_; }
  /// Returns the cause of State::kFailed. \rtsafe
  [[nodiscard]] HomingSequence::Failure failure() const noexcept { return sequence_.failure(); }
  /// Returns the demand: counts, counts/s, counts/s^2; in the new position once home is set. \rtsafe
  [[nodiscard]] const ProfileState& demand() const noexcept { return generator_.state(); }
  /// Returns the counts to be added to an old position to get the new one; 0 until home is set. \rtsafe
  [[nodiscard]] std::int64_t shift() const noexcept { return shift_; }

 private:
  void follow(HomingSequence::Demand demand) noexcept;
  void set_home() noexcept;
  [[nodiscard]] GeneratorLimits limits() const noexcept;

  HomingSettings settings_;
  HomingSequence sequence_;
  ProfileGenerator generator_;
  HomingSequence::Demand demanded_;
  State state_ = State::kIdle;
  std::int64_t shift_ = 0;
};

}  // namespace driveline::slaves::position_servo
