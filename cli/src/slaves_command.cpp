#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "json_text.hpp"
#include "tool_options.hpp"

namespace driveline::cli {
namespace {

struct SlavesOptions {
  BusOptions bus;
  bool json = false;
};

nlohmann::json to_json(const ecat_master::SlaveInfo& info) {
  const auto& device = info.description;
  return {{"position", info.ref.position},
          {"station_address", info.ref.station},
          {"alias", info.alias},
          {"vendor_id", device.vendor_id},
          {"product_code", device.product_code},
          {"revision", device.revision},
          {"serial_number", device.serial_number},
          {"name", device.name}};
}

Outcome<int> list_slaves(const SlavesOptions& options) {
  auto session = Session::open(options.bus);
  if (!session) return tl::unexpected(session.error());
  ecat_master::Master master((*session)->port(), (*session)->clock());
  if (auto done = master.scan(); !done) return bus_failure(done.error());
  if (options.json) {
    auto slaves = nlohmann::json::array();
    for (const auto& slave : master.slaves()) slaves.push_back(to_json(slave.info));
    fmt::print("{}", json_text({{"slaves", slaves}}));
    return 0;
  }
  fmt::print("{:>4} {:>8} {:>6}  {:>10} {:>10} {:>10} {:>10}  {}\n", "pos", "address", "alias", "vendor", "product",
             "revision", "serial", "name");
  for (const auto& slave : master.slaves()) {
    const auto& device = slave.info.description;
    fmt::print("{:>4}   0x{:04X} {:>6}  0x{:08X} 0x{:08X} 0x{:08X} {:>10}  {}\n", slave.info.ref.position,
               slave.info.ref.station, slave.info.alias, device.vendor_id, device.product_code, device.revision,
               device.serial_number, device.name);
  }
  return 0;
}

}  // namespace

Execute prepare_slaves(Arguments& to) {
  auto options = std::make_shared<SlavesOptions>();
  add_bus_options(to, options->bus);
  add_json_flag(to, options->json);
  return [options] { return list_slaves(*options); };
}

}  // namespace driveline::cli
