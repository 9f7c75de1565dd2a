#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/eoe/eoe_port.hpp"
#include "driveline/runtime/eoe/ethernet_switch.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"

namespace driveline::runtime {

/// One port of the switch between this machine and the slaves.
struct EoePortReport {
  SwitchPortFigures figures;                                ///< with the name of the TAP interface or of the slave
  std::optional<std::uint16_t> slave;                       ///< position of the slave; none: the TAP interface
  wire::IpV4Address ip{};                                   ///< address of the machine or the slave
  std::optional<ecat_master::EoePortStatistics> fragments;  ///< only for a slave
};

/// State of Ethernet over EtherCAT at one moment.
struct EoeReport {
  IpNetwork network;                 ///< address of this machine and its network
  std::vector<EoePortReport> ports;  ///< the TAP interface, then the slaves
};

}  // namespace driveline::runtime
