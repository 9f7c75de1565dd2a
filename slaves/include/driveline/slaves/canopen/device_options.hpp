#pragma once

#include <vector>

#include "driveline/canopen_wire/cob_id.hpp"
#include "driveline/slaves/can/node.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves::cia301 {

using can::nanoseconds;

/// An entry of the dictionary by its address.
struct Address {
  std::uint16_t index = 0;    ///< index of the object
  std::uint8_t subindex = 0;  ///< sub-index of the entry
  constexpr bool operator==(const Address&) const = default;
};

/// What devices do differently, and what is optional in CiA 301. Identifiers are bases to which the node-ID is added.
struct DeviceOptions {
  std::uint32_t boot_up = canopen::predefined::kErrorControl;           ///< of the boot-up message
  std::uint8_t boot_up_length = 1;                                      ///< its bytes 00h: 1; some devices send none
  std::uint32_t error_control = canopen::predefined::kErrorControl;     ///< of heartbeat and guarding
  std::uint32_t sdo_request = canopen::predefined::kSdoClientToServer;  ///< client to server
  std::uint32_t sdo_answer = canopen::predefined::kSdoServerToClient;   ///< server to client
  nanoseconds sdo_delay{0};                                             ///< from an SDO request to its answer
  bool block_transfer = false;                                          ///< SDO block transfer; otherwise 05040001h
  bool size_indicated = true;  ///< expedited uploads state their size; false: command 42h (MC7000 manual 4.3.2)
  bool cut_expedited = false;  ///< an expedited download that is longer than its entry is cut; otherwise 06070012h
  bool fill_sign = false;      ///< unused bytes of an expedited upload of an INTEGER have its sign (MSD manual 8.2.2)
  std::uint16_t rpdos = 4;     ///< 1400h and following
  std::uint16_t tpdos = 4;     ///< 1800h and following
  PdoLimits mapping{.dummies = true};  ///< rules of 1600h, 1A00h and following
  bool rpdo_counts_syncs = false;      ///< an RPDO of type n waits for n SYNCs (MC7000 manual 6.5.1); otherwise for one
  bool remote_types = false;           ///< TPDO transmission types 252 and 253
  bool long_rpdo_emergency = false;    ///< EMCY 8220h for an RPDO that is longer than its mapping
  /// Event-driven RPDOs are applied at the next multiple of this time; a newer frame replaces one that waits. 0: at
  /// once.
  nanoseconds pdo_cycle{0};
  nanoseconds nmt_cycle{0};  ///< NMT requests are obeyed at the next multiple of this time; 0: at once
  bool stores = true;        ///< 1010h and 1011h are of the device; false: the application stores its values by itself
  /// EMCY 8130h and 8140h for failures of the communication; false: the application tells of them in its own way.
  bool failure_emergencies = true;
  /// COB-IDs whose initial value in the table counts from the node-ID, as $NODEID in an EDS does.
  std::vector<Address> node_relative{{0x1014, 0}, {0x1200, 1}, {0x1200, 2}, {0x1400, 1}, {0x1401, 1}, {0x1402, 1},
                                     {0x1403, 1}, {0x1800, 1}, {0x1801, 1}, {0x1802, 1}, {0x1803, 1}};
};

}  // namespace driveline::slaves::cia301
