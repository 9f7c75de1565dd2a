#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/slaves/esc/memory.hpp"

namespace driveline::slaves {

/// How the oscillator of an emulated slave differs from the line's clock.
struct ClockOptions {
  std::chrono::nanoseconds start{0};  ///< local time at time zero of the line's clock
  double drift_ppm = 0.0;             ///< how much too fast the oscillator runs
};

/// The distributed clock unit (registers 0x0900-0x09FF, ETG.1000.4 6.7): a local clock that runs from power-on, the
/// copy of the system time derived from it, receive time stamps of the ports and the control loop that follows the
/// system time the reference clock's frames bring.
///
/// Times handed in are on the line's clock. \rtsafe throughout.
class DistributedClock {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  static constexpr Nanoseconds kNoFrame = Nanoseconds::min();

  DistributedClock(EscMemory& memory, bool present, const ClockOptions& options) noexcept
      : memory_(memory), present_(present), options_(options) {}

  /// Power-on state of everything but the oscillator.
  void reset() noexcept;
  [[nodiscard]] bool present() const noexcept { return present_; }

  /// Local time: the oscillator since power-on, sped up or slowed down by the control loop.
  [[nodiscard]] Nanoseconds local_time(Nanoseconds now) const noexcept;
  /// The local copy of the system time: local time plus offset register.
  [[nodiscard]] Nanoseconds system_time(Nanoseconds now) const noexcept;

  /// To be called before ECAT or PDI reads the system time register.
  void refresh(Nanoseconds now) noexcept {
    memory_.set(wire::reg::kSystemTime, static_cast<std::uint64_t>(system_time(now).count()));
  }
  /// ECAT writes registers at `address`; true when a byte was accepted.
  bool write_registers(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;

  /// Register 0x0900 was written by the frame that is just passing: it asks for its receive times at all ports.
  [[nodiscard]] bool latch_requested() const noexcept { return latch_requested_; }
  /// Ends the request: receive time of that frame per port (kNoFrame: it did not come in there) and at the processing
  /// unit.
  void latch(const std::array<Nanoseconds, 4>& ports, Nanoseconds processing_unit) noexcept;

 private:
  void follow(Nanoseconds difference, Nanoseconds now) noexcept;

  EscMemory& memory_;
  bool present_;
  ClockOptions options_;
  bool latch_requested_ = false;
  Nanoseconds correction_{0};
  double mean_difference_ns_ = 0.0;
  std::optional<Nanoseconds> last_follow_;  ///< when the reference time came in last
};

}  // namespace driveline::slaves
