#include "driveline/slaves/msd/can/can_indicators.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::chrono::milliseconds kInitialisingCycle{100};
constexpr std::chrono::milliseconds kStoppedCycle{800};
constexpr std::chrono::milliseconds kPreOperationalCycle{1600};

}  // namespace

bool network_led_h14(canopen::NmtState state, std::chrono::nanoseconds time) noexcept {
  const auto lit = [time](std::chrono::milliseconds cycle) { return time % cycle < cycle / 2; };
  switch (state) {
    case canopen::NmtState::kInitialising:
      return lit(kInitialisingCycle);
    case canopen::NmtState::kStopped:
      return lit(kStoppedCycle);
    case canopen::NmtState::kPreOperational:
      return lit(kPreOperationalCycle);
    case canopen::NmtState::kOperational:
      break;
  }
  return true;
}

}  // namespace driveline::slaves::msd
