#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/canopen_wire/frame.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia301/startup_sdo.hpp"

/// The master of a CANopen line: boots and watches its nodes, and exchanges their process data.
namespace driveline::canopen {

/// How the master exchanges a PDO.
enum class PdoExchange : std::uint8_t {
  kWithSync,  ///< once in every SYNC period
  kOnChange,  ///< when its content changes, and again within PdoPlan::resend
};

/// A PDO of a node as the master configures it: communication parameter and mapping (CiA 301 7.5.2.35 to 7.5.2.38).
struct PdoPlan {
  std::uint16_t number = 1;       ///< 1 to 512
  std::uint16_t identifier = 0;   ///< base identifier; 0: that of the predefined connection set, PDO 1 to 4
  std::uint8_t transmission = 1;  ///< transmission type of the node: sub-index 2 of its communication parameter
  PdoExchange exchange = PdoExchange::kWithSync;  ///< when the PDO is due
  /// kOnChange, RPDO: time within which unchanged content is sent again; the first time earlier, at a place of the
  /// RPDO.
  std::chrono::nanoseconds resend = std::chrono::milliseconds{100};
  std::optional<std::uint16_t> inhibit_100us{};  ///< TPDO: inhibit time, in 100 us; none: that of the node
  std::optional<std::uint16_t> event_ms{};       ///< TPDO: event timer; none: that of the node
  /// Mapping; empty: that of the node, which is read when it boots.
  std::vector<motion::MappedObject> objects{};
};

/// How the master finds out that a node is gone, and the node that the master is.
struct ErrorControlPlan {
  /// Heartbeat of the node (1017h); 0: none. The node is lost after `tolerance` without one.
  std::chrono::milliseconds heartbeat{0};
  std::chrono::milliseconds tolerance{0};  ///< 0: three times `heartbeat`
  /// Time within which the node expects the heartbeat of the master (1016h); 0: it does not.
  std::chrono::milliseconds master_tolerance{0};
  std::chrono::milliseconds guard_time{
      0};                             ///< interval of node guarding (100Ch); 0: none. Not together with `heartbeat`
  std::uint8_t life_time_factor = 3;  ///< life time factor of node guarding (100Dh)
};

/// Time limits of the requests to a node.
struct NodeTimeouts {
  std::chrono::milliseconds sdo{500};       ///< for each answer of an SDO transfer
  std::chrono::milliseconds boot_up{3000};  ///< from the reset until the boot-up message
  std::chrono::milliseconds start{1000};    ///< from the NMT start until the node is Operational
};

/// A node as the master expects and configures it.
struct NodePlan {
  std::string name;     ///< unique on the line, for messages
  std::uint8_t id = 0;  ///< node-ID, 1 to 127
  /// \name Expected identity (CiA 302-2); none: not compared
  /// @{
  std::optional<std::uint32_t> device_type{};    ///< 1000h
  std::optional<std::uint32_t> vendor_id{};      ///< 1018h:01
  std::optional<std::uint32_t> product_code{};   ///< 1018h:02
  std::optional<std::uint32_t> revision{};       ///< 1018h:03: same major revision, minor revision not lower
  std::optional<std::uint32_t> serial_number{};  ///< 1018h:04
  /// @}
  std::vector<motion::StartupSdo> startup_sdos{};  ///< written in Pre-operational, in their order, before the PDOs
  std::vector<PdoPlan> rpdos{};                    ///< sent by the master, in the order of the image of outputs
  std::vector<PdoPlan> tpdos{};                    ///< sent by the node, in the order of the image of inputs
  ErrorControlPlan error_control{};                ///< how a lost node is noticed
  NodeTimeouts timeouts{};                         ///< limits of its requests
  bool optional = false;  ///< the line starts without the node; it joins when its boot-up message comes
};

/// A line as its master runs it.
struct MasterPlan {
  std::uint32_t bit_rate = 1'000'000;                              ///< bit/s
  std::chrono::nanoseconds period = std::chrono::milliseconds{2};  ///< SYNC period
  std::uint16_t sync_identifier = 0x80;                            ///< identifier of SYNC
  std::uint8_t master_id = 127;                   ///< node-ID of the master, for its heartbeat; not one of a node
  std::chrono::milliseconds master_heartbeat{0};  ///< interval of the heartbeat of the master; 0: none
  std::vector<NodePlan> nodes{};                  ///< in the order of the line description
};

}  // namespace driveline::canopen
