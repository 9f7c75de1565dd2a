#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/device_signals.hpp"
#include "driveline/slaves/device_status.hpp"
#include "driveline/slaves/ethernet_link.hpp"
#include "driveline/slaves/sync_demand.hpp"
#include "driveline/slaves/sync_margin.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"

namespace driveline::slaves {

/// Use and limits of a process-data or mailbox sync manager of a device; the AL state machine compares the master's
/// settings with them (ETG.1000.6 5.3.2).
struct SyncManagerLayout {
  /// Purposes of SII category 41 (types 1 to 4).
  enum class Use : std::uint8_t { kMailboxOut, kMailboxIn, kOutputs, kInputs };
  Use use = Use::kOutputs;           ///< required purpose
  std::uint16_t start_address = 0;   ///< physical address that the SII and the device require
  std::uint16_t min_length = 0;      ///< mailboxes: smallest acceptable length
  std::uint16_t max_length = 0;      ///< mailboxes: largest acceptable length
  std::uint16_t default_length = 0;  ///< length in the SII
  /// Process data: length that the device accepts although it has no PDOs for it; 0: none.
  std::uint16_t unmapped_length = 0;
};

/// Fixed properties of a device for its slave controller and its AL state machine.
struct DeviceProfile {
  std::vector<std::byte> sii_image;                    ///< complete EEPROM content, CRC valid
  std::vector<SyncManagerLayout> sync_managers;        ///< by sync manager number
  std::vector<SyncManagerLayout> bootstrap_mailboxes;  ///< SM0 and SM1 in BOOT; empty: bootstrap not supported
  std::uint8_t fmmu_count = 8;                         ///< FMMUs of the controller, at most 16
  std::uint8_t sync_manager_count = 8;                 ///< sync managers of the controller, at most 16
  std::uint8_t ram_kib = 8;                            ///< process RAM in KiB, at most 60
  bool distributed_clock = true;                       ///< the controller has a DC unit
  bool distributed_clock_64bit = true;                 ///< the times of the DC unit have 64 bits, else 32
  bool logical_read_write = true;                      ///< LRW is supported, else only LRD and LWR
  std::uint16_t device_id = 0;                         ///< explicit device identification; 0: none
  bool identification = false;                         ///< requests for it are answered with 0 when there is none
};

/// Place of an object in the process data of a sync manager.
struct MappedEntry {
  std::size_t sync_manager = 0;  ///< number of the sync manager
  std::size_t bit_offset = 0;    ///< first bit in its process data
  std::size_t bits = 0;          ///< length in bits
};

/// Application at the process data interface of an emulated slave controller: a drive, a terminal, a coupler.
///
/// All functions run on the thread that drives the line; none may block, and all except the mailbox functions are
/// \rtsafe (they run inside the cycle when the line is in process). Times are on the line's clock.
class Device {
 public:
  virtual ~Device() = default;

  /// Returns the profile. Content and address are constant for the life of the device: its SII image, layouts and
  /// controller are set up from it once.
  [[nodiscard]] virtual const DeviceProfile& profile() const noexcept = 0;

  /// Returns the number of bytes that output / input sync manager number `sync_manager` must have for the current PDO
  /// assignment and mapping.
  [[nodiscard]] virtual std::size_t process_data_size(std::size_t sync_manager) const noexcept = 0;

  /// Finds an object in the input process data of the current mapping; none: it is not mapped, or the device has no
  /// object dictionary. \rtsafe
  [[nodiscard]] virtual std::optional<MappedEntry> mapped_input(std::uint16_t /*index*/,
                                                                std::uint8_t /*subindex*/) const noexcept {
    return std::nullopt;
  }

  /// Requests a legal transition whose sync managers have been checked: kNoError accepts it, any other AL status code
  /// refuses it.
  [[nodiscard]] virtual wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept = 0;

  /// Called after the slave has left its state on its own because of `reason` (watchdog: kSyncManagerWatchdog).
  virtual void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept = 0;

  /// Called after power-on, or after a reset of the controller and thus of the application: everything starts again in
  /// INIT. No fault is reported, since no application was running to detect one. The clock of advance() may have
  /// jumped. Not \rtsafe.
  virtual void restart() {}

  /// Called after the controller has loaded its EEPROM, at power-on or by a reload command: `image` is its content;
  /// `valid` means that the checksum of the configuration area is right, without which the process data interface does
  /// not start. \rtsafe
  virtual void eeprom_loaded(std::span<const std::byte> /*image*/, bool /*valid*/) noexcept {}

  /// \name Obstacles to a transition Checked before the sync managers are compared.
  /// @{

  /// Whether the firmware is complete. INIT to PREOP needs it, else it fails with 0x0014; BOOT does not.
  [[nodiscard]] virtual bool firmware_valid() const noexcept { return true; }
  /// Checks PDO assignment and mapping for PREOP to SAFEOP: kInvalidInputMapping or kInvalidOutputMapping when they
  /// cannot be process data of this device.
  [[nodiscard]] virtual wire::AlStatusCode check_mapping() const noexcept { return wire::AlStatusCode::kNoError; }
  /// Whether the inputs are valid (a sensor is connected). PREOP to SAFEOP needs this, else it fails with 0x0018.
  [[nodiscard]] virtual bool inputs_valid() const noexcept { return true; }
  /// Returns the synchronisation requirements with the current settings.
  [[nodiscard]] virtual SyncDemand sync_demand() const noexcept { return {}; }
  /// @}

  /// Called when SAFEOP was entered from PREOP, and when OP is requested: the cycle of SYNC0 as the master has
  /// activated it; 0: SYNC0 is off.
  virtual void sync_started(std::chrono::nanoseconds /*sync0_cycle*/) noexcept {}

  /// Called for each SYNC0 or SYNC1, at `time` on the line's clock (the true time of the pulse, between two ticks of
  /// the device's own clock), in every state; the slave transfers outputs and inputs.
  virtual void sync_event(SyncSignal /*signal*/, std::chrono::nanoseconds /*time*/) noexcept {}

  /// Reports how long before the SYNC pulses the outputs arrived so far; called after each pulse in OP, and after the
  /// application has hung.
  virtual void sync_margin(const SyncMargin& /*margin*/) noexcept {}

  /// Receives new outputs of an output sync manager; only in OP.
  virtual void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept = 0;

  /// Fills in the input process data that the slave is about to publish; in SAFEOP and OP.
  virtual void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept = 0;

  /// Whether the device accepts this mailbox message now. If not, the message stays in sync manager 0, which the master
  /// finds full, and is offered again after an answer has been sent. \rtsafe
  [[nodiscard]] virtual bool takes_mailbox(std::span<const std::byte> /*mailbox*/) const noexcept { return true; }

  /// Receives a mailbox message of the master, header included (as many bytes as sync manager 0 has). In PREOP, SAFEOP,
  /// OP and BOOT.
  virtual void mailbox_request(std::span<const std::byte> mailbox) = 0;

  /// Writes the next mailbox message for the master, header included, into `out` (as long as sync manager 1); returns
  /// its length, 0 when there is none. Called whenever sync manager 1 is empty.
  [[nodiscard]] virtual std::size_t mailbox_reply(std::span<std::byte> out) = 0;

  /// Connects the network behind the device's EoE port; it must outlive the device or be replaced; null: none. Returns
  /// false when the device has no EoE. Not for use in the cycle.
  virtual bool connect_network(EthernetLink* /*network*/) { return false; }

  /// Writes the status that the device displays, e.g. on its web page. \rtsafe
  virtual void show(DeviceStatus& out) const noexcept { out = {}; }

  /// Runs the device's application (control loops, timers) up to `now`.
  virtual void advance(std::chrono::nanoseconds now) noexcept = 0;

  /// Returns the signals between the device and its machine; null: no signals can be set or read from outside.
  [[nodiscard]] virtual DeviceSignals* signals() noexcept { return nullptr; }

  /// Returns the period in which the device reads its outputs and publishes its inputs, e.g. 125 us.
  [[nodiscard]] virtual std::chrono::nanoseconds process_data_period() const noexcept = 0;
};

}  // namespace driveline::slaves
