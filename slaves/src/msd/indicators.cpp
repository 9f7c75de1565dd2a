#include "driveline/slaves/msd/indicators.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds kBlink{200};        ///< ETG.1300: on and off time
constexpr milliseconds kSingleFlash{200};  ///< on time, followed by the pause
constexpr milliseconds kSinglePause{1000};
constexpr milliseconds kFlicker{50};

constexpr bool first_half(nanoseconds time, milliseconds half) noexcept {
  return time / half % 2 == 0;
}

}  // namespace

bool run_led(wire::AlState state, nanoseconds time) noexcept {
  switch (state) {
    case wire::AlState::kPreOp:
      return first_half(time, kBlink);
    case wire::AlState::kSafeOp:
      return time % (kSingleFlash + kSinglePause) < kSingleFlash;
    case wire::AlState::kOp:
      return true;
    case wire::AlState::kBootstrap:
      return first_half(time, kFlicker);
    default:
      return false;
  }
}

bool link_activity_led(LinkState link, nanoseconds time) noexcept {
  return link.link && (!link.traffic || first_half(time, kFlicker));
}

bool bottom_led(Series series, Connector connector, LinkState link, wire::AlState state, nanoseconds time) noexcept {
  switch (series) {
    case Series::kCompact:
    case Series::kServoOneJunior:
      return link.link;
    case Series::kServoOne:
      return (connector == Connector::kX15 || link.link) && run_led(state, time);
    case Series::kSingleMultiAxis:
      break;
  }
  return connector == Connector::kX15 && run_led(state, time);
}

ErrorIndication error_indication(wire::AlStatus status, wire::AlStatusCode code) noexcept {
  using enum wire::AlStatusCode;
  if (!status.error || code == kNoError) return ErrorIndication::kNone;
  if (code == kSyncManagerWatchdog) return ErrorIndication::kWatchdog;
  const bool refused = (code >= kInvalidRequestedStateChange && code <= kInvalidSyncManagerConfiguration) ||
                       (code >= kInvalidSyncManagerTypes && code <= kFreeRunNeedsThreeBufferMode) ||
                       (code >= kCycleTimeTooSmall && code <= kInvalidDcLatchConfiguration) ||
                       (code >= kDcInvalidSyncCycleTime && code <= kMailboxVoe);
  return refused ? ErrorIndication::kInvalidConfiguration : ErrorIndication::kLocalError;
}

BicolourLed status_led_h1(wire::AlStatus status, wire::AlStatusCode code, nanoseconds time) noexcept {
  BicolourLed led{run_led(status.state, time), false};
  switch (error_indication(status, code)) {
    case ErrorIndication::kNone:
      break;
    case ErrorIndication::kInvalidConfiguration:
      led.red = first_half(time, kBlink);
      break;
    case ErrorIndication::kLocalError:
      led.red = time % (kSingleFlash + kSinglePause) < kSingleFlash;
      break;
    case ErrorIndication::kWatchdog: {
      const auto into = time % (3 * kSingleFlash + kSinglePause);
      led.red = into < kSingleFlash || (into >= 2 * kSingleFlash && into < 3 * kSingleFlash);
      break;
    }
  }
  return led;
}

}  // namespace driveline::slaves::msd
