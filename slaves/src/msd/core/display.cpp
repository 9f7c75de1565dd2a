#include "driveline/slaves/msd/core/display.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr char digit(int value) noexcept {
  return static_cast<char>('0' + value % 10);
}

constexpr DisplayFrame number(std::uint8_t value) noexcept {
  return {{digit(value / 10), false}, {digit(value), false}};
}

/// The power stage is active in states 4 to 7 (MSD manual Table 5.6, foot-note 2).
constexpr bool power_stage_active(PowerState state) noexcept {
  return state >= PowerState::kSwitchedOn && state <= PowerState::kFaultReactionActive;
}

}  // namespace

DisplayFrame display_frame(const DisplayContent& content, std::chrono::nanoseconds time) noexcept {
  if (content.reset) return {{'8', true}, {'8', true}};
  if (content.starting) return {{}, {'0', false}};
  if (content.state == PowerState::kFault && content.fault) {
    switch (time / kFaultStep % 3) {
      case 0:
        return {{'E', false}, {'r', content.fault->needs_remedy}};
      case 1:
        return number(content.fault->number);
      default:
        return number(content.fault->location);
    }
  }
  DisplayFrame frame;
  const bool lit = time / kDisplayFlash % 2 == 0;
  if (content.safe_torque_off && lit) frame.first = {'S', true};
  frame.second = {digit(static_cast<int>(content.state)), power_stage_active(content.state) && lit};
  return frame;
}

std::string to_text(const DisplayFrame& frame) {
  std::string text;
  for (const Digit& d : {frame.first, frame.second}) {
    text += d.symbol;
    if (d.point) text += '.';
  }
  return text;
}

}  // namespace driveline::slaves::msd
