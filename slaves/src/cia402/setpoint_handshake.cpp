#include "driveline/slaves/cia402/setpoint_handshake.hpp"

#include <utility>

#include "driveline/slaves/cia402/words.hpp"

namespace driveline::slaves {

void SetpointHandshake::reset(std::uint16_t control_word) noexcept {
  *this = SetpointHandshake{};
  bit_ = (control_word & control_word::kNewSetpoint) != 0;
}

std::optional<SetpointHandshake::Setpoint> SetpointHandshake::step(std::uint16_t control_word, std::int32_t target,
                                                                   bool finished) noexcept {
  const bool bit = (control_word & control_word::kNewSetpoint) != 0;
  const bool rising = bit && !bit_;
  bit_ = bit;
  if (finished) active_ = false;
  std::optional<Setpoint> begins;
  if (!active_ && waiting_) {
    begins = std::exchange(waiting_, std::nullopt);
    active_ = true;
  }
  if (rising) {
    const Setpoint setpoint{target, (control_word & control_word::kRelative) != 0};
    if ((control_word & control_word::kChangeImmediately) != 0 || !active_) {
      begins = setpoint;
      active_ = true;
      waiting_.reset();
      acknowledged_ = true;
    } else if (!waiting_) {
      waiting_ = setpoint;
      acknowledged_ = true;
    }
  }
  // Cleared when the master has cleared its bit and the next setpoint can be accepted.
  if (!bit && !waiting_) acknowledged_ = false;
  return begins;
}

}  // namespace driveline::slaves
