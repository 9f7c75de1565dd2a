#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "driveline/slaves/esc/event_unit.hpp"
#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/esc/watchdog_unit.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::slaves {

/// The sync managers of a slave controller (registers 0x0800-0x087F, ETG.1000.4 6.6), and all accesses to process RAM.
///
/// An access to the first byte of a buffer opens it, an access to its last byte transfers it; bytes in between are
/// accessible only while it is open. In three-buffer mode neither side ever waits; in mailbox mode the writer is locked
/// out while the mailbox is full, the reader while it is empty. Locked accesses do not change data and working counter.
/// \rtsafe throughout.
class SyncManagerUnit {
 public:
  /// Maximum number of sync managers in the register space.
  static constexpr unsigned kMaxCount = 16;
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// Creates `count` sync managers, at most kMaxCount. The other units must outlive this.
  SyncManagerUnit(EscMemory& memory, EventUnit& events, WatchdogUnit& watchdog, unsigned count) noexcept;

  /// Resets to the power-on state.
  void reset() noexcept;
  /// Returns the number of sync managers; registers of further sync managers do not exist.
  [[nodiscard]] unsigned count() const noexcept { return count_; }

  /// \name Process RAM, EtherCAT side. Ranges may span several sync managers and exceed the RAM. The functions return
  /// true when at least one byte was read or written.
  /// @{

  /// Reads; bytes that a full or closed buffer refuses do not change in `out`.
  bool read(std::size_t address, std::span<std::byte> out) noexcept;
  /// Writes; a write that completes a buffer at `now` transfers it, and triggers the watchdog if the channel's control
  /// byte enables that.
  bool write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// Copies the bytes that a write would replace: the open write buffer or the last written one. For bit-wise writes.
  void peek(std::size_t address, std::span<std::byte> out) const noexcept;
  /// Called after a write to a register that a sync manager covers (digital outputs at 0x0F00).
  void register_written(std::size_t address, std::size_t length, Nanoseconds now) noexcept;
  /// @}

  /// \name Buffer events
  /// An access has completed a buffer of a channel that latches its events (activation bits 6 and 7); true once per
  /// event.
  /// @{

  /// Event of the master.
  bool take_ecat_buffer_event() noexcept { return std::exchange(ecat_buffer_event_, false); }
  /// Event of the application.
  bool take_pdi_buffer_event() noexcept { return std::exchange(pdi_buffer_event_, false); }
  /// @}

  /// Handles an ECAT write to configuration registers (0x0800 and up); returns whether a byte was accepted.
  bool write_registers(std::size_t address, std::span<const std::byte> data) noexcept;

  /// Returns the channel as configured by the master.
  [[nodiscard]] wire::SyncManagerChannel channel(unsigned n) const noexcept;
  /// Whether the master has enabled and the application not deactivated the channel, and its buffers lie in memory.
  [[nodiscard]] bool operational(unsigned n) const noexcept { return channels_[n].usable; }

  /// \name Application side
  /// @{

  /// Whether a complete buffer is available that the application has not read yet (channels that the master writes).
  [[nodiscard]] bool fresh(unsigned n) const noexcept { return channels_[n].usable && channels_[n].fresh; }
  /// Returns the number of complete buffers that the master has written since the channel was enabled.
  [[nodiscard]] std::uint32_t write_count(unsigned n) const noexcept { return channels_[n].writes; }
  /// Returns the time when the last of them was complete.
  [[nodiscard]] Nanoseconds last_write(unsigned n) const noexcept { return channels_[n].last_write; }
  /// Returns the mailbox message that take() would return; empty: none. The master cannot change it before.
  [[nodiscard]] std::span<const std::byte> waiting_mail(unsigned n) const noexcept;
  /// Takes the newest buffer; empty when there is none. Valid until the next access of the master.
  [[nodiscard]] std::span<const std::byte> take(unsigned n) noexcept;
  /// Returns the buffer for the next data to the master; empty: channel not operational or mailbox full.
  [[nodiscard]] std::span<std::byte> begin_publish(unsigned n) noexcept;
  /// Transfers the buffer of begin_publish() to the master.
  void end_publish(unsigned n) noexcept;
  /// Whether the mailbox is full, as in the status register.
  [[nodiscard]] bool full(unsigned n) const noexcept { return channels_[n].full; }
  /// PDI control bit 0: locks or releases the channel for the master and resets its buffers.
  void set_deactivated(unsigned n, bool deactivated) noexcept;
  /// Whether the master has toggled the repeat request and the application has not acknowledged it yet.
  [[nodiscard]] bool repeat_requested(unsigned n) const noexcept;
  /// Acknowledges the repeat request to the master (PDI control bit 1).
  void acknowledge_repeat(unsigned n) noexcept;
  /// @}

 private:
  static constexpr std::uint8_t kNoBuffer = 3;
  struct Channel {
    std::uint16_t begin = 0;
    std::uint16_t length = 0;
    wire::SyncManagerControl control;
    bool enabled = false;  ///< enabled by the master
    bool usable = false;
    bool latch_ecat = false;    ///< buffer events of ECAT are time-stamped
    bool latch_pdi = false;     ///< buffer events of the application are time-stamped
    bool in_registers = false;  ///< area below 0x1000: no buffers, direct access
    bool full = false;          ///< mailbox full
    bool fresh = false;
    bool write_open = false;
    bool read_open = false;
    bool interrupt_write = false;
    bool interrupt_read = false;
    std::uint8_t newest = kNoBuffer;
    std::uint8_t writing = 0;
    std::uint8_t reading = 0;
    std::uint32_t writes = 0;
    Nanoseconds last_write{0};

    [[nodiscard]] std::size_t end() const noexcept { return std::size_t{begin} + length; }
    [[nodiscard]] bool mailbox() const noexcept { return control.mode == wire::SyncManagerMode::kMailbox; }
    [[nodiscard]] bool ecat_writes() const noexcept { return control.direction == wire::SyncManagerDirection::kWrite; }
  };
  /// Bytes from an address on that belong to the same channel, or to none.
  struct Run {
    int channel = -1;
    std::size_t length = 0;
  };

  [[nodiscard]] Run locate(std::size_t address, std::size_t length) const noexcept;
  bool read_channel(unsigned n, std::size_t address, std::span<std::byte> out) noexcept;
  bool write_channel(unsigned n, std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  [[nodiscard]] std::size_t buffer_address(const Channel& c, std::uint8_t buffer) const noexcept;
  bool open_for_read(Channel& c) noexcept;
  void close_read(Channel& c) noexcept;
  bool open_for_write(Channel& c) noexcept;
  void close_write(Channel& c) noexcept;
  void triggered_by_master(unsigned n, Nanoseconds now) noexcept;
  void configure(unsigned n) noexcept;
  void clear_buffers(Channel& c) noexcept;
  void rebuild_active() noexcept;
  void publish_status(unsigned n) noexcept;

  EscMemory& memory_;
  EventUnit& events_;
  WatchdogUnit& watchdog_;
  unsigned count_;
  std::array<Channel, kMaxCount> channels_{};
  std::array<std::uint8_t, kMaxCount> active_{};  ///< numbers of the enabled channels in RAM, ascending
  unsigned active_count_ = 0;
  bool ecat_buffer_event_ = false;
  bool pdi_buffer_event_ = false;
};

}  // namespace driveline::slaves
