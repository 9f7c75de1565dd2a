#pragma once

#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// The handshake of the profile position mode between control word bits 4, 5, 6 and status word bit 12 (MSD manual
/// 12.2.1): the active setpoint and one more that waits for its end.
class SetpointHandshake {
 public:
  /// One position to go to, as control word and 607Ah gave it when bit 4 rose.
  struct Setpoint {
    std::int32_t target = 0;  ///< 607Ah, user units
    bool relative = false;    ///< bit 6: counts from the target before, not from zero
  };

  /// Forgets all setpoints; bit 4 must rise again. \rtsafe
  void reset(std::uint16_t control_word) noexcept;
  /// One evaluation. Returns the setpoint to go to from now on, if one begins: `finished` tells that the movement of
  /// the one before has come to its end. \rtsafe
  [[nodiscard]] std::optional<Setpoint> step(std::uint16_t control_word, std::int32_t target, bool finished) noexcept;

  /// Status word bit 12. \rtsafe
  [[nodiscard]] bool acknowledged() const noexcept { return acknowledged_; }
  /// Whether a setpoint is active or waits. \rtsafe
  [[nodiscard]] bool busy() const noexcept { return active_ || waiting_.has_value(); }

 private:
  bool bit_ = true;  ///< control word bit 4, one evaluation ago
  bool active_ = false;
  bool acknowledged_ = false;
  std::optional<Setpoint> waiting_;
};

}  // namespace driveline::slaves
