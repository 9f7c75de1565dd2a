#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/slaves/esc/clock_options.hpp"
#include "driveline/slaves/esc/event_unit.hpp"
#include "driveline/slaves/esc/latch_unit.hpp"
#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/esc/oscillator.hpp"
#include "driveline/slaves/esc/random_source.hpp"
#include "driveline/slaves/esc/register_access.hpp"
#include "driveline/slaves/esc/sync_unit.hpp"
#include "driveline/slaves/esc/time_loop.hpp"

namespace driveline::slaves {

/// The distributed clock unit (registers 0x0900-0x09FF, ETG.1000.4 6.7): a local time that runs from power-on with its
/// own oscillator and is corrected by the time control loop; the copy of the system time derived from it; receive time
/// stamps of the ports; SYNC signals; latch inputs.
///
/// Times in parameters and results are true times on the line's clock, so that tests can compare them with the slave's
/// own. \rtsafe throughout.
class DistributedClock {
 public:
  /// Times of the line and of the slave's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Value in latch() of a port that did not receive the frame.
  static constexpr Nanoseconds kNoFrame = Nanoseconds::min();
  /// Value of sync_due() when no pulse is due.
  static constexpr Nanoseconds kNever = Nanoseconds::max();

  /// `present`: the controller has a clock; `wide`: times have 64 bits, else 32.
  DistributedClock(EscMemory& memory, EventUnit& events, bool present, bool wide, const ClockOptions& options) noexcept;

  /// Starts the clock at `now`.
  void power_on(Nanoseconds now) noexcept;
  /// Whether there is a clock. Without one, its registers read 0 and do not accept writes.
  [[nodiscard]] bool present() const noexcept { return present_; }

  /// Returns the local time, in steps of the oscillator. Not truncated to 32 bits.
  [[nodiscard]] Nanoseconds local_time(Nanoseconds now) const noexcept;
  /// Returns the local copy of the system time: local time plus offset register. Not truncated to 32 bits.
  [[nodiscard]] Nanoseconds system_time(Nanoseconds now) const noexcept;
  /// Returns the time when the local copy of the system time reaches `system_time` at the current rate; kNever when
  /// that is years away.
  [[nodiscard]] Nanoseconds true_time(std::uint64_t system_time) const noexcept;
  /// Returns the oscillator with its actual frequency error, for tests.
  [[nodiscard]] const Oscillator& oscillator() const noexcept { return oscillator_; }

  /// \name Registers
  /// @{

  /// Updates the registers at `address`; to be called before either side reads them.
  void refresh(Side side, std::size_t address, std::size_t length, Nanoseconds now) noexcept;
  /// To be called after the read: reading the latched times acknowledges them.
  void was_read(Side side, std::size_t address, std::size_t length) noexcept;
  /// Handles a write of either side; returns true when at least one byte was accepted.
  bool write_registers(Side side, std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// @}

  /// \name Receive times
  /// @{

  /// Whether the current frame has written register 0x0900: this requests its receive times at all ports.
  [[nodiscard]] bool latch_requested() const noexcept { return latch_requested_; }
  /// Completes the request with the receive times of the frame at each port (kNoFrame: not received there) and at the
  /// processing unit.
  void latch(const std::array<Nanoseconds, 4>& ports, Nanoseconds processing_unit) noexcept;
  /// @}

  /// \name SYNC signals
  /// @{

  /// Returns the time of the next pulse; kNever when there is none, or none for years.
  [[nodiscard]] Nanoseconds sync_due() const noexcept { return sync_due_; }
  /// A SYNC pulse.
  struct Pulse {
    SyncSignal signal;  ///< SYNC0 or SYNC1
    Nanoseconds time;   ///< time of the rising edge
  };
  /// Takes the pulse that is due; to be repeated while sync_due() has passed.
  std::optional<Pulse> take_pulse() noexcept;
  /// Acknowledges the pulses for the application (AL event and status register).
  void acknowledge_sync() noexcept;
  /// Skips the pulses before `time`, e.g. while the slave was off.
  void skip_pulses(Nanoseconds time) noexcept;
  /// Returns the SYNC out unit; its times are system times.
  [[nodiscard]] const SyncUnit& sync() const noexcept { return sync_; }
  /// Returns the time of the last SYNC0 pulse; nullopt before the first one.
  [[nodiscard]] const std::optional<Nanoseconds>& last_sync0() const noexcept { return last_sync0_; }
  /// Returns the number of SYNC0 pulses since power-on.
  [[nodiscard]] std::uint64_t sync0_count() const noexcept { return sync0_count_; }
  /// @}

  /// Sets the level of a latch input (0 or 1) from `now` on.
  void set_latch_input(unsigned input, bool high, Nanoseconds now) noexcept;

  /// \name Buffer event times
  /// @{

  /// Stamps a change of a process data buffer by the master (0x09F0).
  void stamp_ecat_buffer(Nanoseconds now) noexcept { stamp(wire::reg::kEcatBufferChangeTime, now); }
  /// Stamps a change by the application (start 0x09F8 and end 0x09FC, equal here).
  void stamp_pdi_buffer(Nanoseconds now) noexcept {
    stamp(wire::reg::kPdiBufferStartTime, now);
    stamp(wire::reg::kPdiBufferChangeTime, now);
  }
  /// @}

 private:
  [[nodiscard]] Nanoseconds stamped(Nanoseconds now) noexcept;
  [[nodiscard]] std::uint64_t system_count(Nanoseconds now) const noexcept;
  [[nodiscard]] std::uint64_t cut(std::uint64_t time) const noexcept { return wide_ ? time : time & 0xFFFFFFFFU; }
  [[nodiscard]] bool writable(Side side, std::size_t address) const noexcept;
  void stamp(const wire::reg::U32& target, Nanoseconds now) noexcept;
  void compare(std::uint32_t received, Nanoseconds now) noexcept;
  void restart_filter(Nanoseconds now) noexcept;
  bool store(Side side, std::size_t address, std::span<const std::byte> data) noexcept;
  void extend_start_time(std::size_t address, std::size_t length, Nanoseconds now) noexcept;
  void plan_sync() noexcept;

  EscMemory& memory_;
  EventUnit& events_;
  bool present_;
  bool wide_;
  bool latch_requested_ = false;
  Nanoseconds sync_due_ = kNever;
  std::int64_t start_;
  std::int64_t jitter_;
  std::uint64_t seed_;
  Oscillator oscillator_;
  TimeLoop loop_;
  SyncUnit sync_;
  LatchUnit latches_;
  RandomSource random_;
  double mean_difference_ns_ = 0.0;
  std::optional<Nanoseconds> last_sync0_;
  std::uint64_t sync0_count_ = 0;
};

}  // namespace driveline::slaves
