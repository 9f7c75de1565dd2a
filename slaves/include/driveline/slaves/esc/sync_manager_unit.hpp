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

/// The sync managers of a slave controller (registers 0x0800-0x087F, ETG.1000.4 6.6) and with them all accesses to
/// process RAM.
///
/// A buffer is opened by an access to its first byte and handed over by an access to its last one; bytes in between
/// are accessible only while it is open. In three-buffer mode neither side ever waits; in mailbox mode the writer is
/// locked out while the mailbox is full and the reader while it is empty. Locked accesses leave data and working
/// counter alone. \rtsafe throughout.
class SyncManagerUnit {
 public:
  /// Highest number of sync managers; the registers have room for no more.
  static constexpr unsigned kMaxCount = 16;
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// `count` sync managers, at most kMaxCount. The other units must outlive this.
  SyncManagerUnit(EscMemory& memory, EventUnit& events, WatchdogUnit& watchdog, unsigned count) noexcept;

  /// Power-on state.
  void reset() noexcept;
  /// Sync managers that exist; registers of others are not there.
  [[nodiscard]] unsigned count() const noexcept { return count_; }

  /// \name Process RAM as EtherCAT sees it. Ranges may extend over several sync managers and beyond the RAM.
  /// True when at least one byte was read or written.
  /// @{

  /// Bytes that a full or closed buffer refuses stay as they are in `out`.
  bool read(std::size_t address, std::span<std::byte> out) noexcept;
  /// A write that completes a buffer at `now` hands it over, and triggers the watchdog where the channel asks for it.
  bool write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// The bytes that a write would replace: the open write buffer or the last one written. For bit-wise writes.
  void peek(std::size_t address, std::span<std::byte> out) const noexcept;
  /// A register that a sync manager covers (digital outputs at 0x0F00) was written.
  void register_written(std::size_t address, std::size_t length, Nanoseconds now) noexcept;
  /// @}

  /// \name Buffer events
  /// A buffer of a channel that latches its events (activation bits 6 and 7) has changed hands, seen from either side;
  /// true once per event.
  /// @{

  /// Of the master.
  bool take_ecat_buffer_event() noexcept { return std::exchange(ecat_buffer_event_, false); }
  /// Of the application.
  bool take_pdi_buffer_event() noexcept { return std::exchange(pdi_buffer_event_, false); }
  /// @}

  /// ECAT writes configuration registers at `address` (0x0800 and up); true when a byte was accepted.
  bool write_registers(std::size_t address, std::span<const std::byte> data) noexcept;

  /// The channel as the master has set it up.
  [[nodiscard]] wire::SyncManagerChannel channel(unsigned n) const noexcept;
  /// Enabled by the master, not deactivated by the application, and its buffers lie inside the memory.
  [[nodiscard]] bool operational(unsigned n) const noexcept { return channels_[n].usable; }

  /// \name The application's side.
  /// @{

  /// A complete buffer waits that the application has not read yet (channels the master writes).
  [[nodiscard]] bool fresh(unsigned n) const noexcept { return channels_[n].usable && channels_[n].fresh; }
  /// Complete buffers the master has written since the channel was enabled.
  [[nodiscard]] std::uint32_t write_count(unsigned n) const noexcept { return channels_[n].writes; }
  /// When the last of them was complete.
  [[nodiscard]] Nanoseconds last_write(unsigned n) const noexcept { return channels_[n].last_write; }
  /// The mailbox that take() would hand over; empty when there is none. The master cannot change it before.
  [[nodiscard]] std::span<const std::byte> waiting_mail(unsigned n) const noexcept;
  /// Hands over the newest buffer; empty when there is none. Valid until the next access of the master.
  [[nodiscard]] std::span<const std::byte> take(unsigned n) noexcept;
  /// Buffer for the next data to the master; empty when the channel is not operational or its mailbox is full.
  [[nodiscard]] std::span<std::byte> begin_publish(unsigned n) noexcept;
  /// Hands the buffer of begin_publish() over to the master.
  void end_publish(unsigned n) noexcept;
  /// Mailbox full, as the status register shows it.
  [[nodiscard]] bool full(unsigned n) const noexcept { return channels_[n].full; }
  /// PDI control bit 0: locks the channel for the master (or releases it) and resets its buffers.
  void set_deactivated(unsigned n, bool deactivated) noexcept;
  /// The master has toggled the repeat request and the application has not acknowledged it yet.
  [[nodiscard]] bool repeat_requested(unsigned n) const noexcept;
  /// Shows the master that its repeat request was seen (PDI control bit 1).
  void acknowledge_repeat(unsigned n) noexcept;
  /// @}

 private:
  static constexpr std::uint8_t kNoBuffer = 3;
  struct Channel {
    std::uint16_t begin = 0;
    std::uint16_t length = 0;
    wire::SyncManagerControl control;
    bool enabled = false;  ///< by the master
    bool usable = false;
    bool latch_ecat = false;    ///< ECAT buffer events are time-stamped
    bool latch_pdi = false;     ///< those of the application
    bool in_registers = false;  ///< area below 0x1000: no buffers, direct access
    bool full = false;          ///< mailbox
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
  /// Bytes from an address on that belong to the same channel (or to none).
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
