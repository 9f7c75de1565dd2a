#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/esc/datagram.hpp"
#include "driveline/slaves/esc/distributed_clock.hpp"
#include "driveline/slaves/esc/event_unit.hpp"
#include "driveline/slaves/esc/fmmu_unit.hpp"
#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/esc/register_access.hpp"
#include "driveline/slaves/esc/sii_interface.hpp"
#include "driveline/slaves/esc/sync_manager_unit.hpp"
#include "driveline/slaves/esc/watchdog_unit.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::slaves {

/// Properties of a slave controller.
struct EscOptions {
  unsigned fmmu_count = 8;              ///< at most 16
  unsigned sync_manager_count = 8;      ///< at most 16
  unsigned ram_kib = 8;                 ///< process RAM from 0x1000 on, in KiB; at most 60
  bool distributed_clock = true;        ///< the controller has a DC unit
  bool distributed_clock_64bit = true;  ///< the DC unit's times have 64 bits, else 32
  bool logical_read_write = true;       ///< LRW is supported, else only LRD and LWR
  SiiOptions sii;                       ///< behaviour of the EEPROM
  ClockOptions clock;                   ///< oscillator and time stamps of the DC unit
};

enum class RegisterBlock : std::uint8_t;

/// An EtherCAT slave controller of the ET1100 class (ETG.1000.4): registers, process RAM and units. One side is
/// accessed by the datagrams of passing frames, the other by the slave's application over the process data interface
/// (PDI). It has neither thread nor clock: the caller passes the time.
///
/// All functions except the constructor are \rtsafe.
class Esc {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// `sii_image`: EEPROM content, see SiiInterface. Powers the controller on at time 0.
  Esc(const EscOptions& options, std::vector<std::byte> sii_image);
  Esc(const Esc&) = delete;
  Esc& operator=(const Esc&) = delete;

  /// Resets everything to the state after power-on at `now`, except the EEPROM content and the links of the ports.
  void power_on(Nanoseconds now = {}) noexcept;

  /// \name EtherCAT side
  /// @{

  /// Starts a frame; `serial` must differ from that of the previous frame.
  void begin_frame(std::uint64_t serial) noexcept { frame_serial_ = serial; }
  /// Processes a datagram of the passing frame: data, address, working counter and IRQ field.
  void process(Datagram& datagram, Nanoseconds now) noexcept;
  /// Reads physical memory like a datagram; returns true when at least one byte was accessible.
  bool ecat_read(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept;
  /// Writes physical memory, see ecat_read(). A range that starts in the registers may end in process RAM.
  bool ecat_write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// Counts a frame with a broken datagram structure (0x030C).
  void count_malformed_frame() noexcept;
  /// Counts a frame with a wrong frame check sequence that `port` received: damaged on the cable of this port (0x0300),
  /// or earlier and marked by the slave that detected it (0x0308).
  void count_damaged_frame(unsigned port, bool forwarded) noexcept;
  /// Whether frames that are not EtherCAT are forwarded unchanged; else they are destroyed (DL control bit 0).
  [[nodiscard]] bool forwards_foreign_frames() const noexcept;
  /// @}

  /// \name The controller's own time
  /// @{

  /// Returns the time of the next call of on_time(); Nanoseconds::max() when nothing is pending.
  [[nodiscard]] Nanoseconds due() const noexcept {
    return std::min({loops_revert_at_, watchdog_.expiry(), watchdog_.pdi_expiry()});
  }
  /// Handles due events: watchdogs expire, temporary loop settings end.
  void on_time(Nanoseconds now) noexcept;
  /// @}

  /// \name Ports
  /// @{

  /// Returns the setting of the loop at `port` (0 to 3): DL control bits 8 to 15.
  [[nodiscard]] wire::LoopControl loop_control(unsigned port) const noexcept;
  /// Whether DL control was written since take_loop_control_change().
  [[nodiscard]] bool loop_control_changed() const noexcept { return loop_control_changed_; }
  /// Returns loop_control_changed() and resets it.
  [[nodiscard]] bool take_loop_control_change() noexcept;
  /// Sets the state of a port: updates DL status, counts a lost link.
  void set_port(unsigned port, const wire::DlStatus::Port& state) noexcept;
  /// Returns the state of port `number` (0 to 3) in DL status.
  [[nodiscard]] const wire::DlStatus::Port& port(unsigned number) const noexcept { return dl_status_.ports[number]; }
  /// @}

  /// \name PDI side
  /// @{

  /// Reads as the application; this acknowledges latched times. Returns false and reads nothing when the range exceeds
  /// the memory.
  bool pdi_read(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept;
  /// Writes registers as the application; returns true when at least one byte was accepted. Not for process RAM, see
  /// sync_managers().
  bool pdi_write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  /// A write to AL control that the state machine has not handled yet.
  struct AlRequest {
    wire::AlControl control;  ///< as written, bits 0 to 4 decoded
    Nanoseconds time;         ///< time of the write
  };
  /// Returns AL control after a write of the master; nullopt when there was none since the last call.
  [[nodiscard]] std::optional<AlRequest> take_al_request() noexcept;
  /// Sets AL status and AL status code (0x0130, 0x0134), raises the event, and sets the RUN and ERR indicators to
  /// match.
  void set_al_status(wire::AlStatus status, std::uint16_t code) noexcept;
  /// Returns register 0x0130.
  [[nodiscard]] wire::AlStatus al_status() const noexcept;
  /// Whether AL status follows AL control without an application (ESC configuration bit 0, from the EEPROM).
  [[nodiscard]] bool device_emulation() const noexcept;
  /// Whether the process data interface is operational: the EEPROM was loaded.
  [[nodiscard]] bool pdi_operational() const noexcept { return sii_.loaded(); }
  /// Whether the reset sequence 'R' 'E' 'S' was written to 0x0040 (or 0x0041).
  [[nodiscard]] bool reset_requested() const noexcept { return reset_requested_; }
  /// @}

  /// Returns registers and process RAM without side effects.
  [[nodiscard]] const EscMemory& memory() const noexcept { return memory_; }
  /// Returns the event requests to master and application.
  [[nodiscard]] EventUnit& events() noexcept { return events_; }
  /// Returns the sync managers, also the application's access to process data and mailboxes.
  [[nodiscard]] SyncManagerUnit& sync_managers() noexcept { return sync_managers_; }
  /// Returns the sync managers, read only.
  [[nodiscard]] const SyncManagerUnit& sync_managers() const noexcept { return sync_managers_; }
  /// Returns the FMMUs with the active logical mappings.
  [[nodiscard]] const FmmuUnit& fmmus() const noexcept { return fmmus_; }
  /// Returns the process data and PDI watchdogs.
  [[nodiscard]] WatchdogUnit& watchdog() noexcept { return watchdog_; }
  /// Returns the watchdogs, read only.
  [[nodiscard]] const WatchdogUnit& watchdog() const noexcept { return watchdog_; }
  /// Returns the EEPROM interface, also for faults.
  [[nodiscard]] SiiInterface& sii() noexcept { return sii_; }
  /// Returns the EEPROM interface, read only.
  [[nodiscard]] const SiiInterface& sii() const noexcept { return sii_; }
  /// Returns the DC unit; if the controller has none, it is not present().
  [[nodiscard]] DistributedClock& clock() noexcept { return clock_; }
  /// Returns the DC unit, read only.
  [[nodiscard]] const DistributedClock& clock() const noexcept { return clock_; }

 private:
  static constexpr std::uint64_t kNoFrame = ~std::uint64_t{0};
  struct ResetSequence {
    std::uint8_t step = 0;
    bool write(std::byte value) noexcept;
  };

  [[nodiscard]] bool at_station(std::uint16_t address) const noexcept {
    return address == station_address_ || (alias_enabled_ && address == station_alias_);
  }
  void process_addressed(Datagram& datagram, Nanoseconds now) noexcept;
  void process_broadcast(Datagram& datagram, Nanoseconds now) noexcept;
  void process_logical(Datagram& datagram, Nanoseconds now) noexcept;
  void read_into(Datagram& datagram, Nanoseconds now) noexcept;
  void write_from(Datagram& datagram, Nanoseconds now) noexcept;
  void exchange(Datagram& datagram, bool merge, Nanoseconds now) noexcept;
  bool read_logical(const LogicalMapping& mapping, std::uint32_t logical, std::span<std::byte> data,
                    Nanoseconds now) noexcept;
  bool write_logical(const LogicalMapping& mapping, std::uint32_t logical, std::span<const std::byte> data,
                     Nanoseconds now) noexcept;

  bool read_ram(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept;
  bool write_ram(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  bool read_registers(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept;
  bool write_registers(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  bool write_block(RegisterBlock block, std::size_t address, std::span<const std::byte> part, Nanoseconds now) noexcept;
  void plain_written(RegisterBlock block, std::size_t address, std::size_t length, Nanoseconds now) noexcept;
  bool write_plain(std::size_t address, std::span<const std::byte> data, const RegisterAccessMap& access) noexcept;
  bool write_protection(std::size_t address, std::span<const std::byte> data) noexcept;
  bool write_al_control(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  bool write_error_counters(std::size_t address, std::size_t length) noexcept;
  bool write_reset(std::byte value, ResetSequence& sequence, const wire::reg::U8& target) noexcept;
  bool write_dl_control(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept;
  [[nodiscard]] bool write_allowed(std::size_t address) const noexcept;
  void load_reset_values() noexcept;
  void refresh_addressing() noexcept;
  void publish_dl_status() noexcept;
  void show_error(bool error, bool new_error) noexcept;

  EscOptions options_;
  // Members used for every datagram, adjacent in memory.
  std::uint16_t station_address_ = 0;
  std::uint16_t station_alias_ = 0;
  bool alias_enabled_ = false;
  bool reset_requested_ = false;
  bool loop_control_changed_ = false;
  EscMemory memory_;
  EventUnit events_;
  WatchdogUnit watchdog_;
  SyncManagerUnit sync_managers_;
  FmmuUnit fmmus_;
  SiiInterface sii_;
  DistributedClock clock_;

  std::uint64_t frame_serial_ = 0;
  std::uint64_t register_write_enabled_in_ = kNoFrame;  ///< serial of the frame that wrote 0x0020
  std::uint64_t esc_write_enabled_in_ = kNoFrame;       ///< serial of the frame that wrote 0x0030
  ResetSequence reset_ecat_;
  ResetSequence reset_pdi_;
  Nanoseconds al_control_time_{0};
  Nanoseconds loops_revert_at_ = WatchdogUnit::kNever;
  std::uint8_t loops_before_ = 0;  ///< 0x0101 before the temporary setting
  wire::DlStatus dl_status_;
};

}  // namespace driveline::slaves
