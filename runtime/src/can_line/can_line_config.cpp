#include "driveline/runtime/can_line/can_line_config.hpp"

#include <utility>

#include "config/description_text.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "toml/toml_table.hpp"

namespace driveline::runtime {
namespace {

Result<CanLineConfig> can_line_or_error(const Result<LineConfig>& config, const std::filesystem::path& file) {
  if (!config) return tl::unexpected(config.error());
  if (config->can) return can_line_of(*config);
  return fail_file(file, "describes a line of EtherCAT, one with [bus] type = \"can\" is expected");
}

}  // namespace

bool describes_can_line(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;  // what a pipe has can be read only once
  const auto text = read_input_file(file);
  if (!text) return false;
  const auto type = read_description(
      *text, file, [](const toml::table& table) { return table["bus"]["type"].value_or(std::string()); });
  return type && *type == "can";
}

CanLineConfig can_line_of(const LineConfig& config) {
  const auto& can = *config.can;
  CanLineConfig line;
  line.name = config.name;
  if (config.interface && config.interface->find(':') == std::string::npos) line.interface = *config.interface;
  line.bit_rate = can.bit_rate;
  line.wiring = can.wiring;
  line.seed = can.seed;
  for (const auto& slave : config.slaves) {
    line.nodes.push_back({slave.name, slave.can.node, slave.device, slave.can.dip});
  }
  line.faults = can.faults;
  return line;
}

Result<CanLineConfig> parse_can_line_config(std::string_view text, const std::filesystem::path& name,
                                            const DeviceRegistry& devices) {
  return can_line_or_error(parse_line_config(text, name, devices), name);
}

Result<CanLineConfig> load_can_line_config(const std::filesystem::path& file, const DeviceRegistry& devices) {
  return can_line_or_error(load_line_config(file, devices), file);
}

}  // namespace driveline::runtime
