#pragma once

#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/configuration/pdo_mapping.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/ecat_master/discovery/line_comparison.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"
#include "driveline/ecat_master/state_machine.hpp"

namespace driveline::ecat_master {

/// An SDO to be written at start-up.
struct StartupSdo {
  std::uint16_t index = 0;      ///< object
  std::uint8_t subindex = 0;    ///< entry of it, or the first one with `complete`
  std::vector<std::byte> data;  ///< as it goes over the wire: little endian, as long as the entry
  bool complete = false;        ///< all sub-indices from `subindex` (0 or 1) on
  /// The transition before which it is written: to SAFEOP (in PREOP), or to OP (in SAFEOP).
  wire::AlState before = wire::AlState::kSafeOp;
};

/// Watchdogs of the slave controller (ETG.1000.4 6.3); values that are not set stay as after power-on.
struct WatchdogPlan {
  std::optional<std::uint16_t> divider;       ///< register 0x0400: 40 ns * (divider + 2) is one increment
  std::optional<std::uint16_t> process_data;  ///< register 0x0420, in increments; 0: off
  std::optional<std::uint16_t> pdi;           ///< register 0x0410, in increments; 0: off
  constexpr bool operator==(const WatchdogPlan&) const = default;
};

/// What is planned for one slave. Zero in an identity field means: any.
struct SlavePlan {
  std::string name;                        ///< for messages and for ProcessVariables; empty: none
  std::uint32_t vendor_id = 0;             ///< as in the EEPROM or 1018h:01
  std::uint32_t product_code = 0;          ///< as in the EEPROM or 1018h:02
  IdentityRule revision;                   ///< accepted revisions
  IdentityRule serial;                     ///< accepted serial numbers
  std::optional<std::uint16_t> alias;      ///< anywhere on the line, by its station alias
  std::optional<std::uint16_t> device_id;  ///< anywhere on the line, by its explicit device identification
  WatchdogPlan watchdog;                   ///< written in PREOP
  StateTimeouts timeouts;                  ///< of its state changes
  MailboxTimeouts mailbox_timeouts;
  std::vector<StartupSdo> startup_sdos;  ///< in the order in which they are written
  /// Mapping and assignment, written behind the start-up SDOs; PDOs without objects are assigned as the slave has them,
  /// and their mapping is read.
  PdoConfiguration pdos;
  std::size_t group = 0;  ///< of the process image
  /// False: the slave takes its outputs by LWR and gives its inputs by LRD only; none: its description decides.
  std::optional<bool> lrw;
  /// With an alias or device ID: the slave may be missing at the start, be plugged in anywhere, and join at any time.
  /// Without it the slave is identified by its place among the others.
  bool hot_connect = false;
  /// It belongs to the hot-connect group of another slave, at that place behind it: it is plugged in, removed and moved
  /// together with the head of the group, whose alias or device ID identifies both.
  std::optional<GroupPlace> behind{};
  /// The PDOs that the slave has assigned by itself, instead of `pdos`; they are read and nothing is written. With a
  /// description file that has PDOs, those that it assigns.
  bool own_pdos = false;
  /// Description of the device out of its ESI file; null: the EEPROM's. Values of this plan take precedence over it,
  /// and it over the EEPROM (apply_description()).
  std::shared_ptr<const esi::DeviceDescription> esi;
};

/// A slave that has been found and is being run.
struct ConfiguredSlave {
  SlaveInfo info;  ///< as found at discovery
  SlavePlan plan;
  std::unique_ptr<MailboxClient> mailbox;          ///< none: the slave has no mailbox
  std::optional<esi::DeviceDescription> eeprom{};  ///< description in the EEPROM while `info` has that of a file
  /// False: a hot-connected slave that has never been on the line. Its description is that of an equal slave, if there
  /// is one, and its process data have their place in the image.
  bool present = true;
};

/// The identities in the plans, for compare_line().
[[nodiscard]] std::vector<ExpectedSlave> expected_slaves(std::span<const SlavePlan> plans);

/// The SDOs to be written to a slave before a transition (before SAFEOP including the PDO configuration, behind the
/// start-up SDOs); there may be none. Error: NoMailbox.
[[nodiscard]] Result<SdoScript> coe_script(const ConfiguredSlave& slave, wire::AlState before);

/// In INIT: writes the sync managers of the mailboxes as the slave's EEPROM has them; nothing without a mailbox.
[[nodiscard]] Result<std::optional<MailboxWindow>> write_mailbox_channels(Bus& bus, const SlaveInfo& slave,
                                                                          const MailboxTimeouts& timeouts = {});

/// Takes `slaves` (all of the line or some) to INIT, switches their FMMUs and sync managers off, sets up sync managers
/// 0 and 1 of those with a mailbox (out of their EEPROM) and takes them to PREOP. Returns one mailbox client per slave,
/// null without a mailbox. `timeouts` and `mailbox_timeouts` belong to the slaves of the same number. Errors: Sii* for
/// a slave with an unusable EEPROM, State*, those of the bus.
[[nodiscard]] Result<std::vector<std::unique_ptr<MailboxClient>>> enter_pre_op(
    MailboxEngine& engine, std::span<const SlaveInfo> slaves, std::span<const StateTimeouts> timeouts = {},
    std::span<const MailboxTimeouts> mailbox_timeouts = {});

/// Takes one slave to BOOT, with the mailboxes that its EEPROM gives for that state. Errors: NoMailbox when there are
/// none, State*, those of the bus.
[[nodiscard]] Result<std::unique_ptr<MailboxClient>> enter_bootstrap(MailboxEngine& engine, const SlaveInfo& slave);

/// Writes the start-up SDOs planned before a transition (before SAFEOP with the PDO configuration behind them), each
/// slave's in order, all slaves side by side. Errors: those of SdoTransfer, NoMailbox.
[[nodiscard]] Result<void> write_startup_sdos(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves,
                                              wire::AlState before);
/// Writes the watchdog times that are planned. Errors: those of the bus.
[[nodiscard]] Result<void> write_watchdogs(Bus& bus, std::span<const ConfiguredSlave> slaves);

/// In PREOP: writes start-up SDOs and PDO configuration of every slave (or reads the slave's own into the plan, as a
/// whole or the mapping of single PDOs), lays out the process image, writes process data sync managers and FMMUs. The
/// slaves are ready for SAFEOP afterwards.
[[nodiscard]] Result<ProcessImage> configure_process_data(MailboxEngine& engine, std::span<ConfiguredSlave> slaves,
                                                          const LayoutSettings& layout = {});

}  // namespace driveline::ecat_master
