#pragma once

#include <algorithm>
#include <cstdint>

namespace driveline::slaves::can {

/// Fault confinement states of a controller (ISO 11898-1, 12.1.4).
enum class ErrorState : std::uint8_t {
  kActive,   ///< signals errors by a dominant flag, which destroys the frame for all
  kPassive,  ///< signals errors by a recessive flag, which disturbs nobody
  kBusOff,   ///< takes no part in the bus
};

/// Transmit and receive error counter of a controller (ISO 11898-1, 12.1.4.2). \rtsafe throughout.
class ErrorCounters {
 public:
  static constexpr unsigned kWarning = 96;   ///< error warning limit
  static constexpr unsigned kPassive = 128;  ///< from here on error passive
  static constexpr unsigned kBusOff = 256;   ///< transmit errors from here on: bus off

  /// TEC, 0 to 255; larger in bus off.
  [[nodiscard]] unsigned transmit() const noexcept { return transmit_; }
  /// REC, 0 to 255.
  [[nodiscard]] unsigned receive() const noexcept { return receive_; }
  /// State that follows from both.
  [[nodiscard]] ErrorState state() const noexcept {
    if (transmit_ >= kBusOff) return ErrorState::kBusOff;
    return std::max(transmit_, receive_) >= kPassive ? ErrorState::kPassive : ErrorState::kActive;
  }
  /// Whether one of them has reached the warning limit.
  [[nodiscard]] bool warning() const noexcept { return transmit_ >= kWarning || receive_ >= kWarning; }

  /// An error in a frame of this controller: TEC + 8.
  void transmit_error() noexcept { transmit_ += 8; }
  /// An error in a frame of another: REC + 1, or more where the controller was the first to signal it.
  void receive_error(unsigned amount) noexcept;
  /// A frame was sent and acknowledged: TEC - 1.
  void sent() noexcept { transmit_ -= transmit_ > 0 ? 1 : 0; }
  /// A frame was received: REC - 1, from the passive range to 127.
  void received() noexcept {
    if (receive_ > 0) receive_ = std::min(receive_, kPassive) - 1;
  }
  /// Both are 0, after a restart or the recovery from bus off.
  void reset() noexcept { transmit_ = receive_ = 0; }

 private:
  unsigned transmit_ = 0;
  unsigned receive_ = 0;
};

}  // namespace driveline::slaves::can
