#pragma once

#include <array>
#include <cstdint>

#include "driveline/slaves/esc/event_unit.hpp"
#include "driveline/slaves/esc/memory.hpp"

namespace driveline::slaves {

/// The two latch inputs (registers 0x09A8-0x09CF, ESC data sheet I, LatchSignals): system time of their edges, the
/// first one or the latest one. \rtsafe throughout.
class LatchUnit {
 public:
  /// Latch inputs, numbered from 0.
  static constexpr unsigned kInputs = 2;

  /// The registers are in `memory`; both must outlive this.
  LatchUnit(EscMemory& memory, EventUnit& events) noexcept : memory_(memory), events_(events) {}

  /// Power-on state: both inputs low.
  void reset() noexcept { levels_ = {}; }
  /// The level of an input is `high` from system time `time` on.
  void set_input(unsigned input, bool high, std::uint64_t time) noexcept;
  /// The latched times at `address` were read by the side that controls the input: events are acknowledged.
  void acknowledge(std::size_t address, std::size_t length) noexcept;

 private:
  EscMemory& memory_;
  EventUnit& events_;
  std::array<bool, kInputs> levels_{};
};

}  // namespace driveline::slaves
