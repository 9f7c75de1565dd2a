#pragma once

#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// Handshake of the profile position mode between control word bits 4, 5, 6 and status word bit 12 (MSD manual 12.2.1):
/// the active setpoint and one waiting setpoint.
class SetpointHandshake {
 public:
  /// Target position, taken from control word and 607Ah at the rising edge of bit 4.
  struct Setpoint {
    std::int32_t target = 0;  ///< 607Ah, user units
    bool relative = false;    ///< bit 6: relative to the previous target instead of zero
  };

  /// Discards all setpoints; bit 4 must rise again. \rtsafe
  void reset(std::uint16_t control_word) noexcept;
  /// Evaluates the inputs once. Returns the setpoint that becomes active now, if any; `finished` means that the
  /// movement to the previous setpoint has ended. \rtsafe
  [[nodiscard]] std::optional<Setpoint> step(std::uint16_t control_word, std::int32_t target, bool finished) noexcept;

  /// Returns status word bit 12. \rtsafe
  [[nodiscard]] bool acknowledged() const noexcept { return acknowledged_; }
  /// Whether a setpoint is active or waiting. \rtsafe
  [[nodiscard]] bool busy() const noexcept { return active_ || waiting_.has_value(); }

 private:
  bool bit_ = true;  ///< control word bit 4 in the previous evaluation
  bool active_ = false;
  bool acknowledged_ = false;
  std::optional<Setpoint> waiting_;
};

}  // namespace driveline::slaves
