#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/endpoints/drive_networks.hpp"
#include "driveline/runtime/eoe/eoe_report.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "eoe/ethernet_tunnel.hpp"

namespace driveline::runtime {

/// What a running line offers to others on this machine: TCP/IP to its slaves over EoE, and the mailbox gateway. Empty
/// for a description without [eoe] and [gateway]. Belongs to the thread that owns the master.
class LineServices {
 public:
  /// `config` must outlive it.
  explicit LineServices(const LineConfig& config) : config_(config) {}

  /// Before the line is touched: opens the TAP interface, and gives simulated drives their network stacks. Errors:
  /// there is no EoE and no gateway on virtual time (kSetting), those of the interface and of DriveNetworks.
  [[nodiscard]] Result<void> prepare(Session& session);
  /// With all slaves in OP: starts what is described. Errors: a slave that is to have an address knows no EoE
  /// (kLine), the gateway's address cannot be had (kMachine).
  [[nodiscard]] Result<void> start(ecat_master::Master& master);
  /// What is on offer since start().
  [[nodiscard]] std::vector<EventFacts> offers() const;
  /// Faults since the last call.
  [[nodiscard]] std::vector<EventFacts> poll();
  /// Ends everything but the network stacks of simulated drives, which end with this object, when the line is at rest;
  /// the reports below stay.
  void stop();

  /// None: the line has no EoE, or is not in operation yet.
  [[nodiscard]] std::optional<EoeReport> eoe() const;
  /// Of the gateway; none: there is no gateway.
  [[nodiscard]] std::vector<GatewayClient> clients() const;

 private:
  [[nodiscard]] Result<void> start_eoe(ecat_master::Master& master);
  [[nodiscard]] Result<void> start_gateway(ecat_master::Master& master);

  const LineConfig& config_;
  std::unique_ptr<DriveNetworks> networks_;  ///< of a line in this process
  std::unique_ptr<TapDevice> tap_;           ///< until the tunnel takes it over
  std::unique_ptr<EthernetTunnel> tunnel_;
  std::unique_ptr<MailboxGateway> gateway_;
  std::optional<EoeReport> last_eoe_;
  std::vector<GatewayClient> last_clients_;
};

}  // namespace driveline::runtime
