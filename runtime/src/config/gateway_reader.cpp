#include "config/gateway_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "config/machine_user.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"

namespace driveline::runtime {
namespace {

struct NamedProtocol {
  std::string_view name;
  wire::MailboxType type;
};
constexpr std::array kProtocols = {
    NamedProtocol{"aoe", wire::MailboxType::kAoe}, NamedProtocol{"coe", wire::MailboxType::kCoe},
    NamedProtocol{"foe", wire::MailboxType::kFoe}, NamedProtocol{"soe", wire::MailboxType::kSoe},
    NamedProtocol{"voe", wire::MailboxType::kVoe}};

wire::MailboxType protocol_of(const TomlReader& reader, const std::string& name) {
  const auto found =
      std::find_if(kProtocols.begin(), kProtocols.end(), [&](const auto& one) { return one.name == name; });
  if (found != kProtocols.end()) return found->type;
  reader.fail("protocols", fmt::format("has \"{}\", known are \"aoe\", \"coe\", \"foe\", \"soe\" and \"voe\"", name));
}

wire::IpV4Address address_of(const TomlReader& reader, const char* key, const std::string& text,
                             std::string_view whose) {
  const auto address = parse_ip(text);
  if (!address) reader.fail(key, fmt::format("is \"{}\", an IPv4 address of {} is expected", text, whose));
  return *address;
}

uid_t writer_of(const TomlReader& reader, const std::string& name) {
  const auto found = find_user(name);
  if (!found) reader.fail("write_users", fmt::format("there is no user \"{}\" on this machine", name));
  return found->user;
}

std::size_t slave_of(const TomlReader& reader, const std::string& name, const std::vector<SlaveConfig>& slaves) {
  const auto found = std::find_if(slaves.begin(), slaves.end(), [&](const auto& slave) { return slave.name == name; });
  if (found == slaves.end()) reader.fail("slaves", fmt::format("there is no [[slave]] named \"{}\"", name));
  return static_cast<std::size_t>(found - slaves.begin());
}

}  // namespace

GatewayConfig read_gateway(TomlReader reader, const std::vector<SlaveConfig>& slaves) {
  GatewayConfig gateway;
  auto& settings = gateway.settings;
  if (reader.has("address")) {
    settings.address = address_of(reader, "address", reader.text("address"), "this machine");
  }
  settings.port = static_cast<std::uint16_t>(reader.integer_or("port", settings.port, 1, 65535));
  if (reader.has("protocols")) {
    settings.protocols.clear();
    for (const auto& name : reader.texts_or("protocols", {})) settings.protocols.push_back(protocol_of(reader, name));
  }
  for (const auto& name : reader.texts_or("write_users", {})) settings.write_users.push_back(writer_of(reader, name));
  for (const auto& text : reader.texts_or("write_addresses", {}))
    settings.write_addresses.push_back(address_of(reader, "write_addresses", text, "a client"));
  std::vector<std::string> names;
  for (const auto& slave : slaves) names.push_back(slave.name);
  for (const auto& name : reader.texts_or("slaves", names)) gateway.slaves.push_back(slave_of(reader, name, slaves));
  reader.finish();
  return gateway;
}

}  // namespace driveline::runtime
