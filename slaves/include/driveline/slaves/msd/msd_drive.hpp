#pragma once

#include <memory>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/mailbox/coe_server.hpp"
#include "driveline/slaves/mailbox/eoe_server.hpp"
#include "driveline/slaves/mailbox/foe_server.hpp"
#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/slaves/msd/drive_files.hpp"
#include "driveline/slaves/msd/indicators.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/slaves/msd/sync0_watch.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves::msd {

/// EtherCAT front end of the MSD servo drive and its variants: AL states, process data, CoE, EoE and FoE for a
/// DriveCore, which is the drive itself.
///
/// Belongs to the thread that drives the line. Times are relative to the first call of advance().
class MsdDrive final : public Device, private DictionaryOwner, private DriveBus {
 public:
  /// Starts in the state of restart(), with mains on, ENPO and ISDSH connected and the other terminals low.
  explicit MsdDrive(const MsdParameters& parameters = {});
  MsdDrive(const MsdDrive&) = delete;  // the CoE server refers to the dictionary of this object
  MsdDrive& operator=(const MsdDrive&) = delete;
  ~MsdDrive() override = default;

  /// Returns the ESI and SII description of all drives of this type (serial number 0).
  [[nodiscard]] static esi::DeviceDescription description(Variant variant = Variant::kMsd) {
    return device_description(variant);
  }

  // Device
  /// Returns identity, memory and EEPROM image of the variant.
  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override;
  [[nodiscard]] std::optional<MappedEntry> mapped_input(std::uint16_t index,
                                                        std::uint8_t subindex) const noexcept override;
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override;
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override;
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override;
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override;
  [[nodiscard]] bool takes_mailbox(std::span<const std::byte> mailbox) const noexcept override {
    return mailbox_.has_room(mailbox);
  }
  void mailbox_request(std::span<const std::byte> mailbox) override;
  bool connect_network(EthernetLink* network) override;
  void show(DeviceStatus& out) const noexcept override;
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte> out) override;
  void advance(std::chrono::nanoseconds now) noexcept override { core_.advance(now); }
  [[nodiscard]] std::chrono::nanoseconds process_data_period() const noexcept override { return kProcessDataPeriod; }
  [[nodiscard]] SyncDemand sync_demand() const noexcept override;
  void sync_started(std::chrono::nanoseconds sync0_cycle) noexcept override;
  void sync_event(SyncSignal signal, std::chrono::nanoseconds time) noexcept override;
  void eeprom_loaded(std::span<const std::byte> image, bool valid) noexcept override;
  void sync_margin(const SyncMargin& margin) noexcept override;
  [[nodiscard]] DeviceSignals* signals() noexcept override { return &core_.signals(); }
  /// Switches the drive off and on again: restores stored parameters, restarts the state machine, enters INIT. Not for
  /// use in the cycle.
  void restart() override;

  /// Returns the drive itself. \rtsafe
  [[nodiscard]] DriveCore& core() noexcept { return core_; }
  /// Returns the drive itself, read only. \rtsafe
  [[nodiscard]] const DriveCore& core() const noexcept { return core_; }
  /// Whether the RUN LED is lit at this time. \rtsafe
  [[nodiscard]] bool run_led_now() const noexcept { return run_led(al_state_, core_.running_time()); }
  /// Returns the EoE server of the drive, for its counters. \rtsafe
  [[nodiscard]] const EoeServer& eoe() const noexcept { return *eoe_; }
  /// Returns the mailbox server, for its counters. \rtsafe
  [[nodiscard]] const MailboxServer& mailbox() const noexcept { return mailbox_; }

 private:
  // DictionaryOwner
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  [[nodiscard]] bool power_stage_on() const noexcept override { return core_.power_stage_on(); }

  // DriveBus
  void report(const FaultMessage& message) noexcept override;
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept override;
  void parameters_replaced() override { build_process_data(); }

  void build_process_data() noexcept;
  void enter_al_state(wire::AlState state) noexcept;
  void outputs_ended() noexcept;
  [[nodiscard]] bool sync0_matches() const noexcept;

  DriveCore core_;
  DeviceProfile profile_;
  PdoLimits pdo_limits_ = kPdoLimits;
  CoeServer coe_;
  DriveFiles files_;
  FoeServer foe_;
  std::unique_ptr<EoeServer> eoe_;  ///< frame buffers; never null
  MailboxServer mailbox_;
  PdoMap rx_map_;
  PdoMap tx_map_;
  Sync0Watch sync0_;
  wire::AlState al_state_ = wire::AlState::kInit;
  bool settings_mapped_ = false;  ///< the outputs contain settings
  bool eeprom_good_ = true;       ///< the EEPROM was loaded and belongs to this drive
};

}  // namespace driveline::slaves::msd
