#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/esi/data_type.hpp"

/// Description of a device with the content of the ESI schema (ETG.2000) and the SII (ETG.1000.6 5.4): the common form
/// that object dictionary, ESI file, SII image and master configuration are converted to and from.
namespace driveline::esi {

/// An object entry inside a PDO; index 0 is a gap of `bit_length` bits.
struct PdoEntry {
  std::uint16_t index = 0;               ///< index of the mapped object; 0: a gap
  std::uint8_t subindex = 0;             ///< sub-index of the mapped entry
  std::uint8_t bit_length = 0;           ///< length in the process data, 1 to 255 bits
  std::string name;                      ///< name as in the file or EEPROM
  DataType type = DataType::kUnsigned8;  ///< data type of the value; meaningless for a gap
  bool operator==(const PdoEntry&) const = default;
};

/// A PDO: its mapping, and the sync manager that it is assigned to.
struct Pdo {
  std::uint16_t index = 0;                   ///< 0x1600 and up for RxPDOs, 0x1A00 and up for TxPDOs
  std::string name;                          ///< name as in the file or EEPROM
  bool fixed = false;                        ///< the mapping cannot be changed
  bool mandatory = false;                    ///< the PDO is always assigned
  std::optional<std::uint8_t> sync_manager;  ///< default assignment; none: not assigned
  std::vector<PdoEntry> entries;             ///< in the order of the process data
  std::vector<std::uint16_t> excluded{};     ///< PDOs that must not be assigned together with this one; not in the SII
  bool operator==(const Pdo&) const = default;
};

/// A sync manager with the settings that the device is delivered with.
struct SyncManager {
  /// Purpose of the channel, numbered as in SII category 41.
  enum class Use : std::uint8_t { kUnused = 0, kMailboxOut = 1, kMailboxIn = 2, kOutputs = 3, kInputs = 4 };
  Use use = Use::kUnused;           ///< purpose of the channel
  std::uint16_t start_address = 0;  ///< address in the slave's memory
  std::uint16_t default_size = 0;   ///< default size in bytes
  std::uint16_t min_size = 0;       ///< bytes; 0: not specified
  std::uint16_t max_size = 0;       ///< bytes; 0: not specified
  std::uint8_t control = 0;         ///< wire::SyncManagerControl::raw()
  bool enable = false;              ///< enabled in PREOP and above
  bool operator==(const SyncManager&) const = default;
};

/// Purpose of an FMMU of the device, numbered as in SII category 40.
enum class FmmuUse : std::uint8_t { kUnused = 0, kOutputs = 1, kInputs = 2, kMailboxState = 3 };

/// PDOs that an operation mode assigns to a sync manager.
struct SmAssignment {
  std::uint8_t sync_manager = 0;    ///< number of the sync manager
  std::vector<std::uint16_t> pdos;  ///< indices of the assigned PDOs, 1600h ... or 1A00h ...
  bool operator==(const SmAssignment&) const = default;
};

/// A distributed-clock operation mode (ETG.2000, Dc/OpMode).
struct DcOpMode {
  std::string name;                      ///< name that files and line descriptions select the mode by
  std::string description;               ///< text for display
  std::uint16_t assign_activate = 0;     ///< value of registers 0x0980/0x0981
  std::int32_t cycle_time_sync0_ns = 0;  ///< 0: bus cycle time times the factor
  /// bus cycles per SYNC0 cycle; negative: SYNC0 cycles per bus cycle
  std::int16_t cycle_time_sync0_factor = 0;
  std::int32_t shift_time_sync0_ns = 0;      ///< from the start of the bus cycle to SYNC0
  std::int32_t cycle_time_sync1_ns = 0;      ///< 0: SYNC0 cycle time times the factor
  std::int16_t cycle_time_sync1_factor = 0;  ///< SYNC0 cycles per SYNC1 cycle
  std::int32_t shift_time_sync1_ns = 0;      ///< from SYNC0 to SYNC1
  /// PDO assignment that replaces the default one in this mode (ETG.2000, Dc/OpMode/Sm). Not in the SII.
  std::vector<SmAssignment> assignments{};
  bool operator==(const DcOpMode&) const = default;
};

/// One sub-index of an object.
struct ObjectEntry {
  std::uint8_t subindex = 0;              ///< sub-index within the object
  std::string name;                       ///< name as in the file
  DataType type = DataType::kUnsigned32;  ///< data type of the value
  std::uint16_t bit_length = 32;          ///< length of the value in bits
  bool readable = true;                   ///< by SDO upload, in at least one state
  bool writable = false;                  ///< by SDO download, in at least one state
  bool rx_mappable = false;               ///< can be mapped into an RxPDO
  bool tx_mappable = false;               ///< can be mapped into a TxPDO
  std::string default_hex;                ///< raw little-endian value as hex digits; empty: none
  std::string minimum_hex;                ///< raw little-endian value as hex digits; empty: none
  std::string maximum_hex;                ///< raw little-endian value as hex digits; empty: none
  /// Bit offset in the whole object (complete access). None: sub-index 0 at 0, 1 at bit 16, others directly after the
  /// previous entry.
  std::optional<std::uint32_t> bit_offset{};
  bool operator==(const ObjectEntry&) const = default;
};

/// An object of the dictionary with its entries.
struct Object {
  std::uint16_t index = 0;                  ///< index of the object
  std::string name;                         ///< name as in the file
  ObjectCode code = ObjectCode::kVariable;  ///< variable, array or record
  std::vector<ObjectEntry> entries;         ///< ascending by sub-index
  bool operator==(const Object&) const = default;
};

/// Mailbox protocols that a device supports, and its CoE features.
struct MailboxSupport {
  bool aoe = false;  ///< ADS over EtherCAT
  bool eoe = false;  ///< Ethernet over EtherCAT
  bool coe = false;  ///< CANopen over EtherCAT
  bool foe = false;  ///< File access over EtherCAT
  bool soe = false;  ///< Servo drive profile over EtherCAT
  bool voe = false;  ///< vendor-specific protocol over EtherCAT
  bool coe_sdo_info = false;
  bool coe_pdo_assign = false;         ///< PDO assignment can be changed
  bool coe_pdo_config = false;         ///< PDO mapping can be changed
  bool coe_complete_access = false;    ///< SDO transfers of whole objects
  bool coe_upload_at_startup = false;  ///< the master reads the PDOs at start-up
  bool eoe_ip = false;                 ///< the master can set the IP parameters
  bool eoe_mac = false;                ///< the master can set the MAC address
  std::uint8_t soe_channels = 0;       ///< drives that SoE addresses, at most 8; 0: not specified, one
  /// Whether the device supports any mailbox protocol. \rtsafe
  [[nodiscard]] bool any() const noexcept { return aoe || eoe || coe || foe || soe || voe; }
  bool operator==(const MailboxSupport&) const = default;
};

/// Time-outs that a device requires of its master, in ms (ETG.2000, Info/StateMachine/Timeout, Info/Mailbox/Timeout);
/// empty: not specified.
struct DeviceTimeouts {
  std::optional<std::uint32_t> to_pre_op;          ///< from INIT
  std::optional<std::uint32_t> to_safe_op_and_op;  ///< from PREOP to SAFEOP, and from SAFEOP to OP
  std::optional<std::uint32_t> back_to_init;       ///< from any state
  std::optional<std::uint32_t> back_to_safe_op;    ///< from OP
  std::optional<std::uint32_t> mailbox_request;    ///< until the device accepts a mailbox message
  std::optional<std::uint32_t> mailbox_response;   ///< until the device answers
  bool operator==(const DeviceTimeouts&) const = default;
};

/// Watchdog register values that a device requires (ETG.2000, ESC); empty: the power-on value.
struct DeviceWatchdogs {
  std::optional<std::uint16_t> divider;       ///< register 0x0400
  std::optional<std::uint16_t> pdi;           ///< register 0x0410
  std::optional<std::uint16_t> process_data;  ///< register 0x0420
  bool operator==(const DeviceWatchdogs&) const = default;
};

/// An object that a master must write over CoE in a state transition (ETG.2000, Mailbox/CoE/InitCmd).
struct InitCommand {
  std::vector<std::string> transitions;  ///< transitions that it is written in: "IP", "PS", "SO" ...
  std::uint16_t index = 0;               ///< index of the object
  std::uint8_t subindex = 0;             ///< sub-index of the entry
  std::string data_hex;                  ///< raw little-endian bytes as hex digits
  bool complete_access = false;          ///< writes all entries at once
  bool operator==(const InitCommand&) const = default;
};

/// One revision of a device.
struct DeviceDescription {
  std::uint32_t vendor_id = 0;             ///< vendor ID assigned by the ETG
  std::uint32_t product_code = 0;          ///< product code assigned by the vendor
  std::uint32_t revision = 0;              ///< revision number of the device
  std::uint32_t serial_number = 0;         ///< 0: none, as always in ESI files
  std::string vendor_name;                 ///< empty: not specified, as always in EEPROMs
  std::string group_type;                  ///< ESI group, also SII group name
  std::string group_name;                  ///< name of the device group, for display
  std::string type;                        ///< ESI Device/Type text, SII order code
  std::string name;                        ///< name for display
  std::string physics = "YY";              ///< per port: Y MII, K EBUS
  std::uint16_t device_profile = 0;        ///< device profile number, e.g. 402
  bool not_lrw = false;                    ///< supports LWR and LRD only (SII general category, flags bit 1)
  bool identification = false;             ///< its ID can be requested in register 0x0134 (the same, flags bit 3)
  MailboxSupport mailbox;                  ///< mailbox protocols and CoE features
  std::uint16_t bootstrap_rx_offset = 0;   ///< mailbox of the master's requests in BOOT: address in the slave's memory
  std::uint16_t bootstrap_rx_size = 0;     ///< bytes; 0: none
  std::uint16_t bootstrap_tx_offset = 0;   ///< mailbox of the slave's answers in BOOT: address in the slave's memory
  std::uint16_t bootstrap_tx_size = 0;     ///< bytes; 0: none
  std::vector<FmmuUse> fmmus;              ///< by FMMU number
  std::vector<SyncManager> sync_managers;  ///< by sync manager number
  std::vector<Pdo> rx_pdos;                ///< PDOs of the slave's outputs
  std::vector<Pdo> tx_pdos;                ///< PDOs of the slave's inputs
  std::vector<DcOpMode> dc_modes;          ///< the first mode is the default
  DeviceTimeouts timeouts;                 ///< not in the SII
  DeviceWatchdogs watchdogs;               ///< not in the SII
  std::vector<InitCommand> init_commands;  ///< not in the SII
  std::vector<Object> objects;             ///< object dictionary, where it is described
  std::uint32_t eeprom_bytes = 2048;       ///< size of the EEPROM, 128 bytes to 8 MiB
  std::string eeprom_config_data_hex;      ///< first 14 bytes of the SII (ESC configuration area)
  /// The application reads the EEPROM itself: it needs the EEPROM interface from PREOP on (ETG.2000,
  /// Eeprom, attribute AssignToPdi). Not in the SII.
  bool eeprom_to_application = false;
  bool operator==(const DeviceDescription&) const = default;
};

}  // namespace driveline::esi
