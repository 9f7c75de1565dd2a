#include "ethercat/line_services.hpp"

#include <utility>

#include "driveline/runtime/event.hpp"

namespace driveline::runtime {
namespace {

/// Returns a locally administered address that is the same in every run: 02:64:6c and the last three bytes of the
/// address.
wire::MacAddress mac_of(const wire::IpV4Address& ip) {
  return {std::byte{0x02}, std::byte{0x64}, std::byte{0x6C}, std::byte{ip[1]}, std::byte{ip[2]}, std::byte{ip[3]}};
}

wire::EoeIpParameters parameters_of(const EoeConfig& eoe, const wire::IpV4Address& ip) {
  wire::EoeIpParameters parameters;
  parameters.mac = mac_of(ip);
  parameters.ip = ip;
  parameters.subnet_mask = eoe.address.mask();
  parameters.gateway = eoe.gateway;
  return parameters;
}

}  // namespace

Result<void> LineServices::prepare(Session& session) {
  if (session.virtual_time() && config_.eoe) {
    return fail(ErrorKind::kSetting, "needs real time: TCP/IP cannot follow virtual time", "[eoe]");
  }
  if (session.virtual_time() && config_.gateway) {
    return fail(ErrorKind::kSetting, "needs real time: its clients cannot follow virtual time", "[gateway]");
  }
  if (!config_.eoe) return {};
  auto tap = TapDevice::open(config_.eoe->interface, config_.eoe->address);
  if (!tap) return tl::unexpected(tap.error());
  tap_ = std::move(*tap);
  if (session.simulated_line() == nullptr) return {};
  auto networks = DriveNetworks::start(*session.simulated_line());
  if (!networks) return tl::unexpected(networks.error());
  networks_ = std::move(*networks);
  return {};
}

Result<void> LineServices::start(ecat_master::Master& master) {
  if (config_.eoe) {
    if (auto started = start_eoe(master); !started) return started;
  }
  if (config_.gateway) return start_gateway(master);
  return {};
}

Result<void> LineServices::start_eoe(ecat_master::Master& master) {
  std::vector<EoeHost> hosts;
  for (std::size_t i = 0; i < config_.slaves.size(); ++i) {
    const auto& slave = config_.slaves[i];
    const auto position = master.position_of(i);
    if (!slave.ip || !position) continue;
    hosts.push_back({static_cast<std::uint16_t>(*position), slave.name, parameters_of(*config_.eoe, *slave.ip)});
  }
  auto started = EthernetTunnel::start(master, std::move(tap_), config_.eoe->address, std::move(hosts));
  if (!started) return tl::unexpected(started.error());
  tunnel_ = std::move(*started);
  return {};
}

Result<void> LineServices::start_gateway(ecat_master::Master& master) {
  std::vector<ecat_master::SlaveRef> slaves;
  for (const auto number : config_.gateway->slaves) {
    const auto position = master.position_of(number);
    if (!position) continue;
    slaves.push_back(master.slaves()[*position].info.ref);
    gateway_names_[slaves.back().position] = config_.slaves[number].name;
  }
  auto opened = MailboxGateway::open(master.mailboxes(), std::move(slaves), config_.gateway->settings);
  if (!opened) return tl::unexpected(opened.error());
  gateway_ = std::move(*opened);
  return {};
}

std::vector<EventFacts> LineServices::offers() const {
  std::vector<EventFacts> all;
  if (tunnel_) {
    events::EoeUp up;
    for (const auto& port : tunnel_->report().ports) {
      if (port.slave) {
        up.hosts.push_back({port.figures.name, port.ip});
      } else {
        up.interface = port.figures.name;
      }
    }
    up.network = config_.eoe->address;
    up.routes = route_commands(*config_.eoe);
    all.emplace_back(std::move(up));
  }
  if (gateway_) {
    const auto& settings = config_.gateway->settings;
    const bool read_only = settings.write_users.empty() && settings.write_addresses.empty();
    all.emplace_back(events::GatewayUp{settings.address, gateway_->port(), read_only});
  }
  return all;
}

std::vector<EventFacts> LineServices::poll() {
  take_gateway_writes();
  auto all = std::exchange(gateway_events_, {});
  if (!tunnel_) return all;
  for (const auto& refusal : tunnel_->take_refusals()) {
    all.emplace_back(events::EoeAddressRefused{refusal.host.position, refusal.host.name, *refusal.host.parameters.ip,
                                               refusal.error});
  }
  return all;
}

void LineServices::take_gateway_writes() {
  if (!gateway_) return;
  for (auto& write : gateway_->take_writes()) {
    auto& name = gateway_names_[write.slave];
    if (write.refused) {
      gateway_events_.emplace_back(
          events::GatewayWriteRefused{std::move(write.client), write.slave, name, std::move(write.what)});
    } else {
      gateway_events_.emplace_back(
          events::GatewayWritten{std::move(write.client), write.slave, name, std::move(write.what)});
    }
  }
}

void LineServices::stop() {
  last_eoe_ = eoe();
  if (gateway_) gateway_->stop();
  last_clients_ = clients();
  take_gateway_writes();
  gateway_.reset();
  tunnel_.reset();
}

std::optional<EoeReport> LineServices::eoe() const {
  return tunnel_ ? std::optional(tunnel_->report()) : last_eoe_;
}

std::vector<GatewayClient> LineServices::clients() const {
  return gateway_ ? gateway_->clients() : last_clients_;
}

}  // namespace driveline::runtime
