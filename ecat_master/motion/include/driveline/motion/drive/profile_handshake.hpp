#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::motion {

/// Hands a target to the profile generator of a drive and reports when it is reached, by bits 4, 5, 10 and 12 of
/// control and status word (CiA 402-2 "Profile position mode", "Profile velocity mode", "Velocity mode"; MSD manual
/// 12.2.1 to 12.2.3).
/// If the next position is given while the drive moves to another one ("set of setpoints"), bit 12 stays set until the
/// drive has started it. Positions are always given as absolute ones: a distance (bit 6) that is handed over twice,
/// because the answer to the first was lost, would be travelled twice. A plain value; everything is \rtsafe.
class ProfileHandshake {
 public:
  /// Progress of a target.
  enum class State : std::uint8_t {
    kRunning,
    kNext,      ///< the previous movement is done, and the one waiting in the drive has started
    kReached,   ///< the drive reports the target as reached
    kNotTaken,  ///< the drive does not acknowledge the target
  };
  /// Effect of a new target position on the previous movement: bit 5.
  enum class Change : std::uint8_t {
    kAtOnce,  ///< ends it, and discards targets that wait in the drive
    kBehind,  ///< waits for its end
  };
  /// Time within which a drive sees a new target velocity.
  static constexpr std::chrono::milliseconds kReaction{50};
  /// Time within which a drive accepts a target position.
  static constexpr std::chrono::milliseconds kTimeout{500};

  /// Starts the handover of a new target position. kBehind: only when under_way().
  void start_position(Change change) noexcept;
  /// Starts the handover of a new target velocity; `status_word`: the last one before it. `bits`: bits of the control
  /// word while the target is in force (command_bit::kFollowRamp in velocity mode).
  void start_velocity(std::uint16_t status_word, std::uint16_t bits = 0) noexcept;
  /// Whether the drive has taken the last target and started its movement.
  [[nodiscard]] bool under_way() const noexcept { return step_ == Step::kUnderWay; }
  /// Bits of the control word (cia402::command_bit) from now on.
  [[nodiscard]] std::uint16_t command_bits() const noexcept;
  /// Evaluates the status word of an exchange; `since`: time since the start.
  [[nodiscard]] State judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept;

 private:
  enum class Step : std::uint8_t {
    kFreeing,  ///< waiting until the acknowledgement of the previous target is cleared
    kGiving,   ///< bit 4 is set, until the drive acknowledges it
    kTaken,    ///< bit 4 is cleared again, until the drive has seen that
    kUnderWay,
  };
  void hand_over(bool acknowledged, std::chrono::nanoseconds since) noexcept;
  [[nodiscard]] bool may_wait() const noexcept { return change_ == Change::kBehind && step_ == Step::kTaken; }

  Step step_ = Step::kUnderWay;
  bool position_ = false;
  std::uint16_t velocity_bits_ = 0;
  Change change_ = Change::kAtOnce;
  bool full_ = false;        ///< a target may wait in the drive: bit 12 is set regardless of what the drive has seen
  std::uint16_t stale_ = 0;  ///< bit 10 of the previous target
};

}  // namespace driveline::motion
