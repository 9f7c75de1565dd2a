#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/esi/data_type.hpp"

/// The description of a device as the ESI schema (ETG.2000) and the SII (ETG.1000.6 5.4) know it: the one neutral
/// form between object dictionary, ESI file, SII image and master configuration.
namespace driveline::esi {

/// An object entry inside a PDO; index 0 is a gap of `bit_length` bits.
struct PdoEntry {
  std::uint16_t index = 0;               ///< of the object; 0: a gap
  std::uint8_t subindex = 0;             ///< of the entry
  std::uint8_t bit_length = 0;           ///< in the process data, 1 to 255
  std::string name;                      ///< in the words of the file or EEPROM
  DataType type = DataType::kUnsigned8;  ///< of the value; without meaning for a gap
  bool operator==(const PdoEntry&) const = default;
};

/// A PDO: what is mapped into it, and the sync manager it is assigned to.
struct Pdo {
  std::uint16_t index = 0;                   ///< 0x1600 on for RxPDOs, 0x1A00 on for TxPDOs
  std::string name;                          ///< in the words of the file or EEPROM
  bool fixed = false;                        ///< its mapping cannot be changed
  bool mandatory = false;                    ///< it is always assigned
  std::optional<std::uint8_t> sync_manager;  ///< default assignment; none: not assigned
  std::vector<PdoEntry> entries;             ///< in the order of the process data
  std::vector<std::uint16_t> excluded{};     ///< PDOs that must not be assigned together with this one; not in the SII
  bool operator==(const Pdo&) const = default;
};

/// A sync manager as the device comes with it.
struct SyncManager {
  /// What the channel is for, as SII category 41 numbers it.
  enum class Use : std::uint8_t { kUnused = 0, kMailboxOut = 1, kMailboxIn = 2, kOutputs = 3, kInputs = 4 };
  Use use = Use::kUnused;           ///< what the channel is for
  std::uint16_t start_address = 0;  ///< in the slave's memory
  std::uint16_t default_size = 0;   ///< bytes, as the device comes
  std::uint16_t min_size = 0;       ///< bytes; 0: not told
  std::uint16_t max_size = 0;       ///< bytes; 0: not told
  std::uint8_t control = 0;         ///< wire::SyncManagerControl::raw()
  bool enable = false;              ///< on in PREOP and above
  bool operator==(const SyncManager&) const = default;
};

/// What an FMMU of the device is for, as SII category 40 numbers it.
enum class FmmuUse : std::uint8_t { kUnused = 0, kOutputs = 1, kInputs = 2, kMailboxState = 3 };

/// PDOs that an operation mode assigns to a sync manager.
struct SmAssignment {
  std::uint8_t sync_manager = 0;    ///< its number
  std::vector<std::uint16_t> pdos;  ///< their objects, 1600h ... or 1A00h ...
  bool operator==(const SmAssignment&) const = default;
};

/// A distributed-clock operation mode (ETG.2000, Dc/OpMode).
struct DcOpMode {
  std::string name;                      ///< by which files and line descriptions choose it
  std::string description;               ///< for people
  std::uint16_t assign_activate = 0;     ///< value for registers 0x0980/0x0981
  std::int32_t cycle_time_sync0_ns = 0;  ///< 0: that of the bus cycle times the factor
  /// cycles of the bus per cycle of SYNC0; negative: cycles of SYNC0 per cycle of the bus
  std::int16_t cycle_time_sync0_factor = 0;
  std::int32_t shift_time_sync0_ns = 0;      ///< from the start of the cycle to SYNC0
  std::int32_t cycle_time_sync1_ns = 0;      ///< 0: that of SYNC0 times the factor
  std::int16_t cycle_time_sync1_factor = 0;  ///< cycles of SYNC0 per cycle of SYNC1
  std::int32_t shift_time_sync1_ns = 0;      ///< from SYNC0 to SYNC1
  /// PDO assignment of this mode in place of the default one (ETG.2000, Dc/OpMode/Sm). Not in the SII.
  std::vector<SmAssignment> assignments{};
  bool operator==(const DcOpMode&) const = default;
};

/// One sub-index of an object.
struct ObjectEntry {
  std::uint8_t subindex = 0;              ///< of the entry
  std::string name;                       ///< in the words of the file
  DataType type = DataType::kUnsigned32;  ///< of the value
  std::uint16_t bit_length = 32;          ///< of the value
  bool readable = true;                   ///< by SDO upload, in some state
  bool writable = false;                  ///< by SDO download, in some state
  bool rx_mappable = false;               ///< may be mapped into an RxPDO
  bool tx_mappable = false;               ///< may be mapped into a TxPDO
  std::string default_hex;                ///< raw little-endian value as hex digits, empty: none
  std::string minimum_hex;                ///< bytes in the order of the wire, two digits each; empty: none
  std::string maximum_hex;                ///< the same
  /// Place in the whole object (complete access). None: sub-index 0 at 0, 1 at bit 16, others behind the one before.
  std::optional<std::uint32_t> bit_offset{};
  bool operator==(const ObjectEntry&) const = default;
};

/// An object of the dictionary with its entries.
struct Object {
  std::uint16_t index = 0;                  ///< of the object
  std::string name;                         ///< in the words of the file
  ObjectCode code = ObjectCode::kVariable;  ///< variable, array or record
  std::vector<ObjectEntry> entries;         ///< ascending by sub-index
  bool operator==(const Object&) const = default;
};

/// Mailbox protocols of a device, and its CoE features.
struct MailboxSupport {
  bool aoe = false;  ///< ADS over EtherCAT
  bool eoe = false;  ///< Ethernet over EtherCAT
  bool coe = false;  ///< CANopen over EtherCAT
  bool foe = false;  ///< files over EtherCAT
  bool soe = false;  ///< servo profile over EtherCAT
  bool voe = false;  ///< of the vendor
  bool coe_sdo_info = false;
  bool coe_pdo_assign = false;         ///< PDO assignment can be changed
  bool coe_pdo_config = false;         ///< PDO mapping can be changed
  bool coe_complete_access = false;    ///< SDO transfers of whole objects
  bool coe_upload_at_startup = false;  ///< the master reads the PDOs at start
  bool eoe_ip = false;                 ///< the master can set the IP parameters
  bool eoe_mac = false;                ///< the master can set the MAC address
  std::uint8_t soe_channels = 0;       ///< drives behind SoE, at most 8; 0: not told, one
  /// There is a mailbox. \rtsafe
  [[nodiscard]] bool any() const noexcept { return aoe || eoe || coe || foe || soe || voe; }
  bool operator==(const MailboxSupport&) const = default;
};

/// Time-outs that a device asks of its master, in ms (ETG.2000, Info/StateMachine/Timeout, Info/Mailbox/Timeout); none:
/// not told.
struct DeviceTimeouts {
  std::optional<std::uint32_t> to_pre_op;          ///< from INIT
  std::optional<std::uint32_t> to_safe_op_and_op;  ///< from PREOP, from SAFEOP
  std::optional<std::uint32_t> back_to_init;       ///< from any state
  std::optional<std::uint32_t> back_to_safe_op;    ///< from OP
  std::optional<std::uint32_t> mailbox_request;    ///< until the device takes a mailbox
  std::optional<std::uint32_t> mailbox_response;   ///< until it answers
  bool operator==(const DeviceTimeouts&) const = default;
};

/// Register values that a device asks for (ETG.2000, ESC); none: as after power-on.
struct DeviceWatchdogs {
  std::optional<std::uint16_t> divider;       ///< register 0x0400
  std::optional<std::uint16_t> pdi;           ///< register 0x0410
  std::optional<std::uint16_t> process_data;  ///< register 0x0420
  bool operator==(const DeviceWatchdogs&) const = default;
};

/// An object that a master is to write over CoE on its way up or down (ETG.2000, Mailbox/CoE/InitCmd).
struct InitCommand {
  std::vector<std::string> transitions;  ///< "IP", "PS", "SO" ...
  std::uint16_t index = 0;               ///< of the object
  std::uint8_t subindex = 0;             ///< of the entry
  std::string data_hex;                  ///< raw little-endian bytes as hex digits
  bool complete_access = false;          ///< all entries at once
  bool operator==(const InitCommand&) const = default;
};

/// A device, one revision of it.
struct DeviceDescription {
  std::uint32_t vendor_id = 0;             ///< of the ETG
  std::uint32_t product_code = 0;          ///< of the vendor
  std::uint32_t revision = 0;              ///< of the device
  std::uint32_t serial_number = 0;         ///< 0: none, as in files
  std::string vendor_name;                 ///< empty: not told, as in EEPROMs
  std::string group_type;                  ///< ESI group, also SII group name
  std::string group_name;                  ///< of devices, for people
  std::string type;                        ///< ESI Device/Type text, SII order code
  std::string name;                        ///< for people
  std::string physics = "YY";              ///< per port: Y MII, K EBUS
  std::uint16_t device_profile = 0;        ///< e.g. 402
  bool not_lrw = false;                    ///< LWR and LRD only (SII general category, flags bit 1)
  MailboxSupport mailbox;                  ///< protocols and what CoE can do
  std::uint16_t bootstrap_rx_offset = 0;   ///< mailbox of the master's requests in BOOT, in the slave's memory
  std::uint16_t bootstrap_rx_size = 0;     ///< bytes; 0: none
  std::uint16_t bootstrap_tx_offset = 0;   ///< mailbox of the slave's answers in BOOT
  std::uint16_t bootstrap_tx_size = 0;     ///< bytes; 0: none
  std::vector<FmmuUse> fmmus;              ///< by their number
  std::vector<SyncManager> sync_managers;  ///< by their number
  std::vector<Pdo> rx_pdos;                ///< of the slave's outputs
  std::vector<Pdo> tx_pdos;                ///< of the slave's inputs
  std::vector<DcOpMode> dc_modes;          ///< the first is the default
  DeviceTimeouts timeouts;                 ///< not in the SII
  DeviceWatchdogs watchdogs;               ///< not in the SII
  std::vector<InitCommand> init_commands;  ///< not in the SII
  std::vector<Object> objects;             ///< object dictionary, as far as it is described
  std::uint32_t eeprom_bytes = 2048;       ///< size of the EEPROM, 128 to 8 MiB
  std::string eeprom_config_data_hex;      ///< first 14 bytes of the SII (ESC configuration area)
  bool operator==(const DeviceDescription&) const = default;
};

}  // namespace driveline::esi
