#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "driveline/slaves/cia402/power_state_machine.hpp"

/// The seven-segment display of the drive (MSD manual 4.7, 5.6), as a function of time.
namespace driveline::slaves::msd {

/// Content of the display.
struct DisplayContent {
  PowerState state = PowerState::kNotReadyToSwitchOn;  ///< shown when nothing below applies
  bool reset = false;                                  ///< the processor is in reset
  bool starting = false;                               ///< initialisation
  bool safe_torque_off = false;                        ///< STO is active
  /// Code of a fault on the display.
  struct FaultCode {
    std::uint8_t number = 0;    ///< FaultFacts::number
    std::uint8_t location = 0;  ///< FaultFacts::location
    bool needs_remedy = false;  ///< can only be acknowledged when its cause is gone
  };
  std::optional<FaultCode> fault{};  ///< the fault that is there
};

/// One lit digit or blank, with its point.
struct Digit {
  char symbol = ' ';   ///< as the segments can draw it; ' ': dark
  bool point = false;  ///< point behind it
  friend bool operator==(const Digit&, const Digit&) = default;
};
/// Both digits, left to right.
struct DisplayFrame {
  Digit first;   ///< D1
  Digit second;  ///< D2
  friend bool operator==(const DisplayFrame&, const DisplayFrame&) = default;
};

/// Times of flashing and of the steps; the manual gives the sequence, not the times (ours).
inline constexpr std::chrono::milliseconds kDisplayFlash{500};  ///< half a period
inline constexpr std::chrono::milliseconds kFaultStep{1000};    ///< Er, number, location

/// What is lit `time` after the content began to be shown. \rtsafe
[[nodiscard]] DisplayFrame display_frame(const DisplayContent& content, std::chrono::nanoseconds time) noexcept;
/// The frame as text: "S.2", " 5.", "Er", "14".
[[nodiscard]] std::string to_text(const DisplayFrame& frame);

/// The display in operation, with the time since which it shows its content.
class Display {
 public:
  /// Restarts the content at power-on, \rtsafe
  void restart(std::chrono::nanoseconds now) noexcept { since_ = now; }
  /// and with every state that is shown. \rtsafe
  void follow(PowerState state, std::chrono::nanoseconds now) noexcept {
    if (state == state_) return;
    state_ = state;
    since_ = now;
  }
  /// What is lit. \rtsafe
  [[nodiscard]] DisplayFrame frame(const DisplayContent& content, std::chrono::nanoseconds now) const noexcept {
    return display_frame(content, now - since_);
  }

 private:
  PowerState state_ = PowerState::kNotReadyToSwitchOn;
  std::chrono::nanoseconds since_{0};
};

}  // namespace driveline::slaves::msd
