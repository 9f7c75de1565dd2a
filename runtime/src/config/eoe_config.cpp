#include "driveline/runtime/config/eoe_config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "config/eoe_reader.hpp"

namespace driveline::runtime {
namespace {

constexpr std::string_view kAddressForm =
    "an IPv4 address with the bits of its network, \"192.168.38.1/24\", is expected";

/// Whether both networks have an address in common.
bool overlap(const IpNetwork& a, const IpNetwork& b) {
  return a.prefix < b.prefix ? a.contains(b.address) : b.contains(a.address);
}

IpNetwork read_network(TomlReader& reader, std::string_view key) {
  const auto text = reader.text(key);
  const auto network = parse_network(text);
  if (!network) reader.fail(key, fmt::format("is \"{}\", {}", text, kAddressForm));
  if (!network->is_host(network->address)) {
    reader.fail(
        key, fmt::format("is \"{}\", the address of the network itself or its broadcast address: a host cannot use it",
                         text));
  }
  if (overlap(*network, service_interface_network())) {
    reader.fail(key, fmt::format("is \"{}\": {} is the network of the drives' service interface, EoE needs another",
                                 text, to_text(service_interface_network())));
  }
  return *network;
}

wire::IpV4Address read_address(TomlReader& reader, std::string_view key) {
  const auto text = reader.text(key);
  const auto address = parse_ip(text);
  if (!address) reader.fail(key, fmt::format("is \"{}\", an IPv4 address, \"192.168.38.5\", is expected", text));
  return *address;
}

void check_slaves(const TomlReader& reader, const LineConfig& config) {
  const auto& eoe = *config.eoe;
  bool any = false;
  for (const auto& slave : config.slaves) {
    if (!slave.ip) continue;
    any = true;
    if (!eoe.address.is_host(*slave.ip)) {
      reader.fail("address", fmt::format("is {}, but \"{}\" has {}: all slaves must be in this network",
                                         to_text(eoe.address), slave.name, to_text(*slave.ip)));
    }
    if (*slave.ip == eoe.address.address || *slave.ip == eoe.gateway) {
      reader.fail("address", fmt::format("\"{}\" has {}, which is the address of this machine or the gateway",
                                         slave.name, to_text(*slave.ip)));
    }
  }
  if (!any) reader.fail("", "no [[slave]] has an ip: set the ip of each slave to reach over EoE");
}

}  // namespace

IpNetwork service_interface_network() {
  return {{192, 168, 39, 0}, 24};
}

std::vector<std::string> route_commands(const EoeConfig& config) {
  if (!config.service_address) return {};
  const auto network = IpNetwork{config.address.base(), config.address.prefix};
  const auto via = to_text(config.service_address->address);
  return {"this machine:            sysctl -w net.ipv4.ip_forward=1",
          fmt::format("service PC with Linux:   ip route add {} via {}", to_text(network), via),
          fmt::format("service PC with Windows: route add {} mask {} {}", to_text(network.address),
                      to_text(network.mask()), via)};
}

std::optional<wire::IpV4Address> read_slave_ip(TomlReader& reader, const std::vector<SlaveConfig>& others) {
  if (!reader.has("ip")) return std::nullopt;
  const auto address = read_address(reader, "ip");
  const auto same = std::find_if(others.begin(), others.end(), [&](const auto& other) { return other.ip == address; });
  if (same != others.end()) reader.fail("ip", fmt::format("\"{}\" has {} already", same->name, to_text(address)));
  return address;
}

void read_eoe(TomlReader reader, LineConfig& config) {
  auto& eoe = config.eoe.emplace();
  eoe.interface = reader.text("interface");
  if (eoe.interface.empty()) reader.fail("interface", "is empty, the name of a TAP interface is expected");
  eoe.address = read_network(reader, "address");
  eoe.gateway = reader.has("gateway") ? read_address(reader, "gateway") : eoe.address.address;
  if (!eoe.address.is_host(eoe.gateway)) {
    reader.fail("gateway", fmt::format("is {}, which is no host of {}", to_text(eoe.gateway), to_text(eoe.address)));
  }
  if (reader.has("service_address")) {
    eoe.service_address = read_network(reader, "service_address");
    if (overlap(*eoe.service_address, eoe.address)) {
      reader.fail("service_address",
                  fmt::format("is {}, in the network of the slaves, {}: the service PC needs another",
                              to_text(*eoe.service_address), to_text(eoe.address)));
    }
  }
  check_slaves(reader, config);
  reader.finish();
}

}  // namespace driveline::runtime
