#pragma once

#include <array>
#include <cstdint>

#include "driveline/slaves/esc/event_unit.hpp"
#include "driveline/slaves/esc/memory.hpp"

namespace driveline::slaves {

/// The two latch inputs (registers 0x09A8-0x09CF, ESC data sheet I, LatchSignals): they latch the system time of the
/// first or the latest edge. \rtsafe throughout.
class LatchUnit {
 public:
  /// Number of latch inputs.
  static constexpr unsigned kInputs = 2;

  /// `memory` holds the registers; both references must outlive this.
  LatchUnit(EscMemory& memory, EventUnit& events) noexcept : memory_(memory), events_(events) {}

  /// Resets to the power-on state: both inputs low.
  void reset() noexcept { levels_ = {}; }
  /// Sets the level of an input from system time `time` on.
  void set_input(unsigned input, bool high, std::uint64_t time) noexcept;
  /// Acknowledges the events after the latched times at `address` were read by the side that controls the input.
  void acknowledge(std::size_t address, std::size_t length) noexcept;

 private:
  EscMemory& memory_;
  EventUnit& events_;
  std::array<bool, kInputs> levels_{};
};

}  // namespace driveline::slaves
