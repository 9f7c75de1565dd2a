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

/// The distributed clock unit (registers 0x0900-0x09FF, ETG.1000.4 6.7): a local time that an oscillator of its own
/// drives from power-on and the time control loop speeds up or slows down; the copy of the system time derived from it;
/// receive time stamps of the ports; SYNC signals; latch inputs.
///
/// Times handed in and out are true times on the line's clock, which tests can compare with the slave's own. \rtsafe
/// throughout.
class DistributedClock {
 public:
  /// Times of the line, and of the slave's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// A port in latch() at which the frame did not come in.
  static constexpr Nanoseconds kNoFrame = Nanoseconds::min();
  /// Stands for "no pulse to come" in sync_due().
  static constexpr Nanoseconds kNever = Nanoseconds::max();

  /// `present`: there is a clock at all; `wide`: times have 64 bits, else 32.
  DistributedClock(EscMemory& memory, EventUnit& events, bool present, bool wide, const ClockOptions& options) noexcept;

  /// Switched on at `now`.
  void power_on(Nanoseconds now) noexcept;
  /// Without a clock all its registers read 0 and writes to them are not counted.
  [[nodiscard]] bool present() const noexcept { return present_; }

  /// Local time, in steps of the oscillator. Not cut to 32 bits.
  [[nodiscard]] Nanoseconds local_time(Nanoseconds now) const noexcept;
  /// The local copy of the system time: local time plus offset register. Not cut to 32 bits.
  [[nodiscard]] Nanoseconds system_time(Nanoseconds now) const noexcept;
  /// When the local copy of the system time comes to `system_time`, as things are now; kNever when that is years away.
  [[nodiscard]] Nanoseconds true_time(std::uint64_t system_time) const noexcept;
  /// The oscillator with its real frequency error, for tests.
  [[nodiscard]] const Oscillator& oscillator() const noexcept { return oscillator_; }

  /// \name Registers
  /// @{

  /// To be called before one side reads registers at `address`.
  void refresh(Side side, std::size_t address, std::size_t length, Nanoseconds now) noexcept;
  /// To be called after it: reading the latched times acknowledges them.
  void was_read(Side side, std::size_t address, std::size_t length) noexcept;
  /// A write of one side; true when a byte was accepted.
  bool write_registers(Side side, std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// @}

  /// \name Receive times
  /// @{

  /// Register 0x0900 was written by the frame that is just passing: it asks for its receive times at all ports.
  [[nodiscard]] bool latch_requested() const noexcept { return latch_requested_; }
  /// Ends the request: receive time of that frame per port (kNoFrame: it did not come in there) and at the processing
  /// unit.
  void latch(const std::array<Nanoseconds, 4>& ports, Nanoseconds processing_unit) noexcept;
  /// @}

  /// \name SYNC signals
  /// @{

  /// When the next pulse comes; kNever when none is to come, or none for years.
  [[nodiscard]] Nanoseconds sync_due() const noexcept { return sync_due_; }
  /// A pulse came: which, and when.
  struct Pulse {
    SyncSignal signal;  ///< of the two
    Nanoseconds time;   ///< of its rising edge
  };
  /// Takes the pulse that is due; call again while sync_due() has passed.
  std::optional<Pulse> take_pulse() noexcept;
  /// The application has seen the pulses (acknowledges AL event and status register).
  void acknowledge_sync() noexcept;
  /// Skips the pulses before `time`, while the slave was off.
  void skip_pulses(Nanoseconds time) noexcept;
  /// The signals as registers and system time define them; its times are system times.
  [[nodiscard]] const SyncUnit& sync() const noexcept { return sync_; }
  /// The pulse of SYNC0 that came last.
  [[nodiscard]] const std::optional<Nanoseconds>& last_sync0() const noexcept { return last_sync0_; }
  /// Pulses of SYNC0 since power-on.
  [[nodiscard]] std::uint64_t sync0_count() const noexcept { return sync0_count_; }
  /// @}

  /// The level of a latch input (0 or 1) is `high` from `now` on.
  void set_latch_input(unsigned input, bool high, Nanoseconds now) noexcept;

  /// \name Buffer event times
  /// @{

  /// The master has changed a process data buffer (0x09F0).
  void stamp_ecat_buffer(Nanoseconds now) noexcept { stamp(wire::reg::kEcatBufferChangeTime, now); }
  /// The application has changed one (0x09F8, start and 0x09FC, end; one instant here).
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
