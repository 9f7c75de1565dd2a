#pragma once

#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/configuration/pdo_mapping.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/ecat_master/discovery/line_comparison.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"
#include "driveline/ecat_master/soe/startup_idn.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/motion/cia301/startup_sdo.hpp"

namespace driveline::ecat_master {

/// How much the start depends on writes that many slaves refuse, because they have a fixed value, or none.
struct StartupNeeds {
  motion::WriteNeed sync_objects =
      motion::WriteNeed::kOptional;  ///< 1C32h:01, :02, 1C33h:01, :02 of a slave with SYNC signals
  motion::WriteNeed pdo_assignment = motion::WriteNeed::kOptional;  ///< 1C10h + number of the sync manager
  motion::WriteNeed pdo_mapping = motion::WriteNeed::kOptional;     ///< 1600h to 17FFh, 1A00h to 1BFFh
  constexpr bool operator==(const StartupNeeds&) const = default;
};

/// Directions in which a slave keeps its own assignment of PDOs, and nothing is written.
struct KeptPdos {
  bool outputs = false;  ///< the outputs are the slave's own
  bool inputs = false;   ///< the inputs are the slave's own
  constexpr bool operator==(const KeptPdos&) const = default;
};

/// Watchdogs of the slave controller (ETG.1000.4 6.3); empty values keep the power-on setting.
struct WatchdogPlan {
  std::optional<std::uint16_t> divider;       ///< register 0x0400: one increment is 40 ns * (divider + 2)
  std::optional<std::uint16_t> process_data;  ///< register 0x0420, in increments; 0: off
  std::optional<std::uint16_t> pdi;           ///< register 0x0410, in increments; 0: off
  constexpr bool operator==(const WatchdogPlan&) const = default;
};

/// The plan for a slave. Zero in an identity field means: any.
struct SlavePlan {
  std::string name;                        ///< used in messages and by ProcessVariables; empty: none
  std::uint32_t vendor_id = 0;             ///< as in the EEPROM or 1018h:01
  std::uint32_t product_code = 0;          ///< as in the EEPROM or 1018h:02
  IdentityRule revision;                   ///< accepted revisions
  IdentityRule serial;                     ///< accepted serial numbers
  std::optional<std::uint16_t> alias;      ///< station alias; finds the slave anywhere on the line
  std::optional<std::uint16_t> device_id;  ///< explicit device identification; finds the slave anywhere on the line
  WatchdogPlan watchdog;                   ///< watchdog settings, written in PREOP
  StateTimeouts timeouts;                  ///< time-outs of the slave's state changes
  StateRetries safe_op_retries;            ///< repeated requests of SAFEOP, from PREOP
  MailboxTimeouts mailbox_timeouts;
  /// Gives the EEPROM interface to the application of the slave before PREOP; empty: as its ESI file says, else only
  /// when the slave refuses a state because it cannot read its EEPROM (StateTarget).
  std::optional<bool> eeprom_to_application{};
  std::vector<motion::StartupSdo> startup_sdos;  ///< in the order of writing
  std::vector<StartupIdn> startup_idns{};        ///< operation data of its drives, after the SDOs of the same state
  StartupNeeds needs;                            ///< which other writes a slave may refuse
  /// Mapping and assignment, written after the start-up SDOs; for PDOs without objects the slave's mapping is kept and
  /// read.
  motion::PdoConfiguration pdos;
  KeptPdos kept{};        ///< set when the slave is configured: its own PDOs have replaced those of `pdos`
  std::size_t group = 0;  ///< group of the process image
  /// False: the slave supports only LWR for outputs and LRD for inputs; empty: its description decides.
  std::optional<bool> lrw;
  /// With an alias or device ID: the slave may be missing at the start, be plugged in anywhere, and join at any time.
  /// Else the slave is identified by its position relative to the others.
  bool hot_connect = false;
  /// Place in a hot-connect group: the slave is plugged in, removed and moved together with the head of the group,
  /// whose alias or device ID identifies both.
  std::optional<HotConnectPlace> behind{};
  /// Uses the PDOs that the slave has assigned itself, instead of `pdos`; they are read and nothing is written. With a
  /// description file that has PDOs, uses the PDOs that the file assigns.
  bool own_pdos = false;
  /// Description of the device from its ESI file; null: that of the EEPROM. Values of this plan take precedence over
  /// the file, and the file over the EEPROM (apply_description()).
  std::shared_ptr<const esi::DeviceDescription> esi;
};

/// A slave found on the line, with its plan.
struct ConfiguredSlave {
  SlaveInfo info;  ///< as found at discovery
  SlavePlan plan;
  std::unique_ptr<MailboxClient> mailbox;          ///< null: the slave has no mailbox
  std::optional<esi::DeviceDescription> eeprom{};  ///< description in the EEPROM while `info` holds that of a file
  /// False: a hot-connect slave that has never been on the line. Its description is that of an identical slave, if
  /// there is one, and its process data have reserved space in the image.
  bool present = true;
};

/// Time-out of a slave from below to SAFEOP or OP: that of its plan; without one kSoeOpTimeout for a slave with an SoE
/// mailbox, else kOpTimeout.
[[nodiscard]] std::chrono::nanoseconds rise_timeout(const ConfiguredSlave& slave, wire::AlState target) noexcept;

/// The identities in the plans, as input of compare_line().
[[nodiscard]] std::vector<ExpectedSlave> expected_slaves(std::span<const SlavePlan> plans);

/// The start-up SDOs to be written to a slave in a state; may be empty. Error: NoMailbox.
[[nodiscard]] Result<SdoScript> coe_script(const ConfiguredSlave& slave, motion::StartupState in);

/// The plans by which a slave exchanges its planned PDOs, without the directions that it keeps; empty for a slave whose
/// PDOs are not configured.
[[nodiscard]] std::vector<AssignmentPlan> planned_assignments(const ConfiguredSlave& slave);

/// In INIT: writes the sync managers of the mailboxes as given by the EEPROM; returns empty without a mailbox.
[[nodiscard]] Result<std::optional<MailboxWindow>> write_mailbox_channels(Bus& bus, const SlaveInfo& slave,
                                                                          const MailboxTimeouts& timeouts = {});

/// In INIT: gives the EEPROM interface to the applications of those slaves whose description has
/// eeprom_to_application. A later access of the master to an EEPROM takes it for its duration. Errors: those of the
/// bus.
[[nodiscard]] Result<void> hand_over_eeproms(Bus& bus, std::span<const SlaveInfo> slaves);

/// Takes `slaves` (all or some of the line) to INIT, disables their FMMUs and sync managers, sets up sync managers 0
/// and 1 of slaves with a mailbox (from their EEPROM) and takes them to PREOP. Returns one mailbox client per slave,
/// null without a mailbox. `timeouts` and `mailbox_timeouts` are in the order of `slaves`. Slaves whose description has
/// eeprom_to_application get their EEPROM interface before PREOP. Errors: Sii* for a slave with an unusable EEPROM,
/// State*, those of the bus.
[[nodiscard]] Result<std::vector<std::unique_ptr<MailboxClient>>> enter_pre_op(
    MailboxEngine& engine, std::span<const SlaveInfo> slaves, std::span<const StateTimeouts> timeouts = {},
    std::span<const MailboxTimeouts> mailbox_timeouts = {});

/// Takes one slave to BOOT, with the bootstrap mailboxes given by its EEPROM. Errors: NoMailbox when there are none,
/// State*, those of the bus.
[[nodiscard]] Result<std::unique_ptr<MailboxClient>> enter_bootstrap(MailboxEngine& engine, const SlaveInfo& slave);

/// Writes the start-up SDOs planned for a state, then the operation data of drives (write_startup_idns()): each slave's
/// in order, the slaves in parallel. Refused optional SDOs are added to `notes`. Errors: those of SdoTransfer and of
/// write_startup_idns(), NoMailbox.
[[nodiscard]] Result<void> write_startup_values(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves,
                                                motion::StartupState in, StartupNotes& notes);
/// Writes the operation data planned for a state: each slave's in order, the slaves in parallel. A value is encoded as
/// its attribute says, a list gets the maximum length that the drive tells. What was written is read back. The first
/// failure ends the writes to a slave. Errors: NoMailbox, those of SoeTransfer, SoeForm, SoeListLength, SoeLimit for a
/// number that the drive refuses because of its limits, SoeNotKept, SoeCommandEnded, SoeCommandTimeout.
[[nodiscard]] Result<void> write_startup_idns(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves,
                                              motion::StartupState in);
/// Writes the planned watchdog times. Errors: those of the bus.
[[nodiscard]] Result<void> write_watchdogs(Bus& bus, std::span<const ConfiguredSlave> slaves);

/// In PREOP: writes start-up SDOs and PDO configuration of every slave (or reads the slave's PDO configuration, or the
/// mapping of single PDOs, into the plan), lays out the process image, writes process data sync managers and FMMUs.
/// Afterwards the slaves are ready for SAFEOP. What slaves refuse or do not show without an error is added to `notes`.
[[nodiscard]] Result<ProcessImage> configure_process_data(MailboxEngine& engine, std::span<ConfiguredSlave> slaves,
                                                          const LayoutSettings& layout, StartupNotes& notes);

}  // namespace driveline::ecat_master
