#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::ecat_master {

/// A target for the profile generator of a drive, as bits 4, 5, 10 and 12 of control and status word hand it over and
/// tell that it is reached (CiA 402-2 "Profile position mode", "Profile velocity mode", "Velocity mode"; MSD manual
/// 12.2.1 to 12.2.3).
/// Where the next position is given while the drive moves to one ("set of setpoints"), bit 12 stays until it has begun.
/// Positions are always given as absolute ones: a distance (bit 6) that is handed over a second time, because the
/// answer to the first was lost, would be gone twice. A plain value; everything is \rtsafe.
class ProfileHandshake {
 public:
  /// How far it is.
  enum class State : std::uint8_t {
    kRunning,
    kNext,      ///< the movement before is done, that which was to follow it has begun
    kReached,   ///< as the drive says
    kNotTaken,  ///< the drive does not acknowledge the target
  };
  /// What a new target position does with the movement before it: bit 5.
  enum class Change : std::uint8_t {
    kAtOnce,  ///< ends it, and takes those away that wait in the drive
    kBehind,  ///< waits for its end
  };
  /// In which a drive has seen a new target velocity.
  static constexpr std::chrono::milliseconds kReaction{50};
  /// In which it has taken a target position.
  static constexpr std::chrono::milliseconds kPatience{500};

  /// There is a new target position. kBehind: only when under_way().
  void start_position(Change change) noexcept;
  /// There is a new target velocity; `status_word`: the last one without it. `bits`: what the control word has as long
  /// as it holds (command_bit::kFollowRamp in velocity mode).
  void start_velocity(std::uint16_t status_word, std::uint16_t bits = 0) noexcept;
  /// The last target has been taken, and its movement has begun.
  [[nodiscard]] bool under_way() const noexcept { return step_ == Step::kUnderWay; }
  /// Of the control word (cia402::command_bit), from now on.
  [[nodiscard]] std::uint16_t command_bits() const noexcept;
  /// The status word of an exchange, so long after the start.
  [[nodiscard]] State judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept;

 private:
  enum class Step : std::uint8_t {
    kFreeing,  ///< the acknowledgement of a target before has to go
    kGiving,   ///< bit 4 is set, until the drive acknowledges it
    kTaken,    ///< it is taken back, until the drive has seen that
    kUnderWay,
  };
  void hand_over(bool acknowledged, std::chrono::nanoseconds since) noexcept;
  [[nodiscard]] bool may_wait() const noexcept { return change_ == Change::kBehind && step_ == Step::kTaken; }

  Step step_ = Step::kUnderWay;
  bool position_ = false;
  std::uint16_t velocity_bits_ = 0;
  Change change_ = Change::kAtOnce;
  bool full_ = false;        ///< a target may wait in the drive: bit 12 is set whatever it has seen
  std::uint16_t stale_ = 0;  ///< bit 10 of the target before
};

}  // namespace driveline::ecat_master
