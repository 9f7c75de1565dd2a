#pragma once

#include <cstdint>

#include "driveline/slaves/esc/memory.hpp"

namespace driveline::slaves {

/// Bits of the ECAT event request 0x0210 (ETG.1000.4 Table 40).
namespace ecat_event {
inline constexpr std::uint16_t kDcLatch = 0x0001;   ///< edge at a latch input
inline constexpr std::uint16_t kDlStatus = 0x0004;  ///< DL status changed
inline constexpr std::uint16_t kAlStatus = 0x0008;  ///< AL status changed
/// Sync manager 0; the next seven sync managers have the next bits.
inline constexpr std::uint16_t kSyncManager0 = 0x0010;
inline constexpr unsigned kSyncManagers = 8;  ///< number of sync managers that have a bit
}  // namespace ecat_event

/// Bits of the AL event request 0x0220 (ETG.1000.4 Table 39).
namespace al_event {
inline constexpr std::uint32_t kAlControl = 0x00000001;            ///< AL control was written
inline constexpr std::uint32_t kDcLatch = 0x00000002;              ///< edge at a latch input
inline constexpr std::uint32_t kSync0 = 0x00000004;                ///< SYNC0 occurred
inline constexpr std::uint32_t kSync1 = 0x00000008;                ///< SYNC1 occurred
inline constexpr std::uint32_t kSyncManagerChanged = 0x00000010;   ///< activation of a sync manager was written
inline constexpr std::uint32_t kWatchdogProcessData = 0x00000040;  ///< process data watchdog expired
/// Sync manager 0; the next 15 sync managers have the next bits.
inline constexpr std::uint32_t kSyncManager0 = 0x00000100;
}  // namespace al_event

/// Event requests of a slave controller: to the master (ORed into the IRQ field of every passing datagram, filtered by
/// the event mask) and to the application. \rtsafe throughout.
class EventUnit {
 public:
  /// `memory` holds the event registers and must outlive this.
  explicit EventUnit(EscMemory& memory) noexcept : memory_(memory) {}

  /// Sets or clears `bits` (ecat_event) of 0x0210 and updates irq().
  void set_ecat(std::uint16_t bits, bool pending) noexcept {
    const auto old = memory_.get(wire::reg::kEcatEventRequest);
    const auto requests = static_cast<std::uint16_t>(pending ? old | bits : old & ~bits);
    // Common case: every access to a sync manager buffer calls this.
    if (requests == old) return;
    memory_.set(wire::reg::kEcatEventRequest, requests);
    refresh();
  }
  /// Sets or clears `bits` (al_event) of 0x0220.
  void set_al(std::uint32_t bits, bool pending) noexcept {
    const auto old = memory_.get(wire::reg::kAlEventRequest);
    const auto requests = pending ? old | bits : old & ~bits;
    if (requests != old) memory_.set(wire::reg::kAlEventRequest, requests);
  }
  /// Whether at least one of `bits` (al_event) is requested.
  [[nodiscard]] bool al_pending(std::uint32_t bits) const noexcept {
    return (memory_.get(wire::reg::kAlEventRequest) & bits) != 0;
  }

  /// To be called after a write to the event mask register.
  void refresh() noexcept { irq_ = memory_.get(wire::reg::kEcatEventRequest) & memory_.get(wire::reg::kEcatEventMask); }
  /// Returns the bits that this slave ORs into the IRQ field of a datagram.
  [[nodiscard]] std::uint16_t irq() const noexcept { return irq_; }

  /// Reports an event that the slave's firmware must handle before its next regular step.
  void call_firmware() noexcept { firmware_called_ = true; }
  /// Whether call_firmware() was called since the last firmware_answered().
  [[nodiscard]] bool firmware_called() const noexcept { return firmware_called_; }
  /// Called when the slave's firmware has handled the events.
  void firmware_answered() noexcept { firmware_called_ = false; }

 private:
  EscMemory& memory_;
  std::uint16_t irq_ = 0;
  bool firmware_called_ = false;
};

}  // namespace driveline::slaves
