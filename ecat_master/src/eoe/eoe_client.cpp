#include "driveline/ecat_master/eoe/eoe_client.hpp"

namespace driveline::ecat_master {
namespace {

/// IP parameters with all members present.
constexpr wire::EoeIpParameters kNoGaps{.mac = wire::MacAddress{},
                                        .ip = wire::IpV4Address{},
                                        .subnet_mask = wire::IpV4Address{},
                                        .gateway = wire::IpV4Address{},
                                        .dns_server = wire::IpV4Address{},
                                        .dns_name = wire::EoeIpParameters::Name{}};

/// Fills gaps in front of the last parameter of `wanted` with the values of the slave: without gaps, slaves that expect
/// every parameter at its fixed offset and slaves that expect no gaps read the same.
wire::EoeIpParameters without_gaps(wire::EoeIpParameters wanted, const wire::EoeIpParameters& known) {
  bool behind = wanted.dns_name.has_value();
  const auto fill = [&behind](auto& parameter, const auto& value) {
    if (behind && !parameter) parameter = value;
    behind = behind || parameter.has_value();
  };
  fill(wanted.dns_server, known.dns_server);
  fill(wanted.gateway, known.gateway);
  fill(wanted.subnet_mask, known.subnet_mask);
  fill(wanted.ip, known.ip);
  fill(wanted.mac, known.mac);
  return wanted;
}

}  // namespace

Result<void> EoeClient::run(const std::shared_ptr<EoeService>& service) {
  engine_.submit(position_, service);
  engine_.wait(*service);
  return service->result();
}

Result<void> EoeClient::set_ip(const wire::EoeIpParameters& parameters) {
  auto wanted = parameters;
  if (without_gaps(parameters, kNoGaps) != parameters) {
    const auto known = get_ip();
    // A slave that refuses to report its parameters may still accept new ones.
    if (!known && !known.error().is<facts::EoeRefused>()) return tl::unexpected(known.error());
    if (known) wanted = without_gaps(parameters, *known);
  }
  return run(EoeService::set_ip(wanted));
}

Result<wire::EoeIpParameters> EoeClient::get_ip() {
  const auto service = EoeService::get_ip();
  return run(service).map([&] { return service->ip(); });
}

Result<void> EoeClient::set_filter(const wire::EoeAddressFilter& filter) {
  return run(EoeService::set_filter(filter));
}

Result<wire::EoeAddressFilter> EoeClient::get_filter() {
  const auto service = EoeService::get_filter();
  return run(service).map([&] { return service->filter(); });
}

}  // namespace driveline::ecat_master
