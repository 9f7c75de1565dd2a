#include "driveline/motion/drive/profile_handshake.hpp"

#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion {

namespace command_bit = cia402::command_bit;
namespace status_bit = cia402::status_bit;

void ProfileHandshake::start_position(Change change) noexcept {
  full_ = position_ && change_ == Change::kBehind && !under_way();
  position_ = true;
  change_ = change;
  step_ = Step::kFreeing;
  stale_ = 0;
}

void ProfileHandshake::start_velocity(std::uint16_t status_word, std::uint16_t bits) noexcept {
  position_ = false;
  velocity_bits_ = bits;
  step_ = Step::kUnderWay;
  stale_ = status_word & status_bit::kTargetReached;
}

std::uint16_t ProfileHandshake::command_bits() const noexcept {
  if (!position_) return velocity_bits_;
  const unsigned given = step_ == Step::kGiving ? command_bit::kNewSetpoint : 0U;
  const unsigned immediately = change_ == Change::kAtOnce ? command_bit::kImmediately : 0U;
  return static_cast<std::uint16_t>(immediately | given);
}

/// A drive whose target buffer is full shows by bit 12 neither that it has seen bit 4 cleared nor that it has taken the
/// target, so it is given time for both.
void ProfileHandshake::hand_over(bool acknowledged, std::chrono::nanoseconds since) noexcept {
  if (step_ == Step::kFreeing && (!acknowledged || (full_ && since >= kReaction))) {
    full_ = acknowledged;
    step_ = Step::kGiving;
  } else if (step_ == Step::kGiving && acknowledged && (!full_ || since >= 2 * kReaction)) {
    step_ = Step::kTaken;
  } else if (step_ == Step::kTaken && !acknowledged) {
    step_ = Step::kUnderWay;
  }
}

ProfileHandshake::State ProfileHandshake::judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept {
  if (step_ != Step::kUnderWay) {
    hand_over((status_word & status_bit::kSetpointAcknowledge) != 0, since);
    if (step_ != Step::kUnderWay) return since > kTimeout && !may_wait() ? State::kNotTaken : State::kRunning;
    if (change_ == Change::kBehind) {
      stale_ = status_word & status_bit::kTargetReached;
      return State::kNext;
    }
  }
  stale_ = since < kReaction ? stale_ & status_word : 0;
  const bool reached = (status_word & ~stale_ & status_bit::kTargetReached) != 0;
  return reached ? State::kReached : State::kRunning;
}

}  // namespace driveline::motion
