#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/endpoints/drive_networks.hpp"
#include "driveline/runtime/eoe/eoe_report.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "eoe/ethernet_tunnel.hpp"

namespace driveline::runtime {

/// Services of a running line on this machine: TCP/IP to its slaves over EoE, and the mailbox gateway. Empty for a
/// description without [eoe] and [gateway]. Belongs to the thread that owns the master.
class LineServices {
 public:
  /// `config` must outlive it.
  explicit LineServices(const LineConfig& config) : config_(config) {}

  /// Call before the line is used: opens the TAP interface, and gives simulated drives their network stacks. Errors:
  /// EoE and gateway are not available on virtual time (kSetting), errors of the interface and of DriveNetworks.
  [[nodiscard]] Result<void> prepare(Session& session);
  /// Call with all slaves in OP: starts the described services. Errors: a slave with an address does not support EoE
  /// (kLine), the address of the gateway is not available (kMachine).
  [[nodiscard]] Result<void> start(ecat_master::Master& master);
  /// Returns the services available since start(), as events.
  [[nodiscard]] std::vector<EventFacts> offers() const;
  /// Returns the events since the last call, also those before stop(): addresses that slaves have refused, and changes
  /// by clients of the gateway.
  [[nodiscard]] std::vector<EventFacts> poll();
  /// Ends all services except the network stacks of simulated drives, which end with this object, when the line is
  /// idle. The reports below remain available.
  void stop();

  /// Returns the report of EoE; none: the line has no EoE, or is not in operation yet.
  [[nodiscard]] std::optional<EoeReport> eoe() const;
  /// Returns the clients of the gateway; empty: there is no gateway.
  [[nodiscard]] std::vector<GatewayClient> clients() const;

 private:
  [[nodiscard]] Result<void> start_eoe(ecat_master::Master& master);
  [[nodiscard]] Result<void> start_gateway(ecat_master::Master& master);
  /// Collects the changes by clients of the gateway as events.
  void take_gateway_writes();

  const LineConfig& config_;
  std::unique_ptr<DriveNetworks> networks_;  ///< for a line in this process
  std::unique_ptr<TapDevice> tap_;           ///< held until the tunnel takes it over
  std::unique_ptr<EthernetTunnel> tunnel_;
  std::unique_ptr<MailboxGateway> gateway_;
  std::map<std::size_t, std::string> gateway_names_;  ///< name of each slave that the gateway serves, by position
  std::vector<EventFacts> gateway_events_;            ///< for poll()
  std::optional<EoeReport> last_eoe_;
  std::vector<GatewayClient> last_clients_;
};

}  // namespace driveline::runtime
