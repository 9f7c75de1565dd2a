#pragma once

#include <chrono>

#include "driveline/slaves/esc/event_unit.hpp"
#include "driveline/slaves/esc/memory.hpp"

namespace driveline::slaves {

/// The two watchdogs of a slave controller (registers 0x0400-0x0443, ETG.1000.4 6.3). \rtsafe throughout.
///
/// Process data: triggered by complete writes to sync managers whose control byte enables it; runs from the first
/// trigger on. PDI: triggered by every access of the application, which an emulated one makes permanently; so it runs
/// only while the application is stopped.
class WatchdogUnit {
 public:
  /// Time of a watchdog that does not run.
  static constexpr std::chrono::nanoseconds kNever = std::chrono::nanoseconds::max();

  /// `memory` holds the registers; both references must outlive this. Disabled until configure().
  WatchdogUnit(EscMemory& memory, EventUnit& events) noexcept : memory_(memory), events_(events) {}

  /// Resets to the power-on state: not running.
  void reset() noexcept;
  /// To be called after a write to the divider or a watchdog time.
  void configure() noexcept;
  /// Starts or restarts the watchdog at `now`, unless it is disabled. Ends an expiry.
  void trigger(std::chrono::nanoseconds now) noexcept;

  /// Returns the time when the watchdog expires unless it is triggered again; kNever when it does not run.
  [[nodiscard]] std::chrono::nanoseconds expiry() const noexcept { return expiry_; }
  /// Expires the watchdog: clears the status bit, counts, raises the AL event.
  void expire() noexcept;

  /// Whether the watchdog has expired and was not triggered since.
  [[nodiscard]] bool expired() const noexcept { return expired_; }
  /// Whether the watchdog time is not zero.
  [[nodiscard]] bool enabled() const noexcept { return timeout_ > std::chrono::nanoseconds::zero(); }
  /// Returns the time from a trigger to expiry: increment (0x0400) times 0x0420; 0 when disabled.
  [[nodiscard]] std::chrono::nanoseconds timeout() const noexcept { return timeout_; }

  /// \name PDI watchdog
  /// @{

  /// Called when the application has stopped; its last access was at `since`.
  void pdi_silent(std::chrono::nanoseconds since) noexcept;
  /// Called when the application continues.
  void pdi_alive() noexcept;
  /// Returns the time when the PDI watchdog expires unless pdi_alive() is called before; kNever when it does not run.
  [[nodiscard]] std::chrono::nanoseconds pdi_expiry() const noexcept { return pdi_expiry_; }
  /// Expires the PDI watchdog: counts (0x0443).
  void expire_pdi() noexcept;
  /// Whether the PDI watchdog has expired, until pdi_alive().
  [[nodiscard]] bool pdi_expired() const noexcept { return pdi_expired_; }
  /// @}

  /// Clears both counters; called after a write to either of them.
  void clear_counters() noexcept;

 private:
  [[nodiscard]] std::chrono::nanoseconds unit() const noexcept;
  void count(const wire::reg::U8& counter) noexcept;
  void set_status(bool ok) noexcept { memory_.set(wire::reg::kWatchdogStatusProcessData, ok ? 1 : 0); }

  EscMemory& memory_;
  EventUnit& events_;
  std::chrono::nanoseconds timeout_{0};
  std::chrono::nanoseconds last_trigger_{0};
  std::chrono::nanoseconds expiry_ = kNever;
  bool expired_ = false;
  std::chrono::nanoseconds pdi_expiry_ = kNever;
  bool pdi_expired_ = false;
};

}  // namespace driveline::slaves
