#include "driveline/ecat_master/single_axis/profile_handshake.hpp"

#include "driveline/ecat_master/cia402/cia402.hpp"

namespace driveline::ecat_master {

namespace command_bit = cia402::command_bit;
namespace status_bit = cia402::status_bit;

void ProfileHandshake::start_position() noexcept {
  position_ = true;
  step_ = Step::kFreeing;
  stale_ = 0;
}

void ProfileHandshake::start_velocity(std::uint16_t status_word) noexcept {
  position_ = false;
  step_ = Step::kUnderWay;
  stale_ = status_word & status_bit::kTargetReached;
}

std::uint16_t ProfileHandshake::command_bits() const noexcept {
  if (!position_) return 0;
  const unsigned given = step_ == Step::kGiving ? command_bit::kNewSetpoint : 0U;
  return static_cast<std::uint16_t>(command_bit::kImmediately | given);
}

void ProfileHandshake::hand_over(bool acknowledged) noexcept {
  if (step_ == Step::kFreeing && !acknowledged) {
    step_ = Step::kGiving;
  } else if (step_ == Step::kGiving && acknowledged) {
    step_ = Step::kTaken;
  } else if (step_ == Step::kTaken && !acknowledged) {
    step_ = Step::kUnderWay;
  }
}

ProfileHandshake::State ProfileHandshake::judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept {
  if (step_ != Step::kUnderWay) {
    hand_over((status_word & status_bit::kSetpointAcknowledge) != 0);
    if (step_ != Step::kUnderWay) return since > kPatience ? State::kNotTaken : State::kRunning;
  }
  stale_ = since < kReaction ? stale_ & status_word : 0;
  const bool reached = (status_word & ~stale_ & status_bit::kTargetReached) != 0;
  return reached ? State::kReached : State::kRunning;
}

}  // namespace driveline::ecat_master
