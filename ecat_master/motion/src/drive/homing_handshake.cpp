#include "driveline/motion/drive/homing_handshake.hpp"

#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion {

namespace status_bit = cia402::status_bit;

void HomingHandshake::start(std::uint16_t status_word) noexcept {
  stale_ = status_word & (status_bit::kHomingAttained | status_bit::kHomingError);
}

HomingHandshake::State HomingHandshake::judge(std::uint16_t status_word, std::chrono::nanoseconds since) noexcept {
  stale_ = since < kReaction ? stale_ & status_word : 0;
  const auto reported = static_cast<std::uint16_t>(status_word & ~stale_);
  if ((reported & status_bit::kHomingError) != 0) return State::kFailed;
  constexpr std::uint16_t kDone = status_bit::kHomingAttained | status_bit::kTargetReached;
  return (reported & kDone) == kDone ? State::kAttained : State::kRunning;
}

}  // namespace driveline::motion
