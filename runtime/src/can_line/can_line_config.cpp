#include "driveline/runtime/can_line/can_line_config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "config/bus_reader.hpp"
#include "config/description_text.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "toml/toml_table.hpp"

namespace driveline::runtime {
namespace {

constexpr std::size_t kMaxCanNodes = 127;
/// Longest name of a network interface in Linux (IFNAMSIZ without the end).
constexpr std::size_t kMaxInterfaceName = 15;
constexpr double kMaxCableM = 10'000.0;

void read_can_bus(TomlReader reader, CanLineConfig& config) {
  static_cast<void>(reader.choice_or("type", 1, {"ethercat", "can"}));
  config.interface = reader.text_or("interface", config.interface);
  if (config.interface.empty() || config.interface.size() > kMaxInterfaceName) {
    reader.fail("interface", fmt::format("must have 1 to {} characters", kMaxInterfaceName));
  }
  config.bit_rate = static_cast<std::uint32_t>(reader.integer_or("bit_rate", config.bit_rate, 10'000, 1'000'000));
  if (1'000'000'000 % config.bit_rate != 0) {
    reader.fail("bit_rate", fmt::format("is {}, a rate whose bits are whole nanoseconds is expected", config.bit_rate));
  }
  auto& wiring = config.wiring;
  wiring.length_m = reader.number_or("length_m", wiring.length_m, 0.0, kMaxCableM);
  const auto ends = reader.choice_or("terminators", 0, {"both", "first", "last", "none"});
  wiring.first_terminated = ends <= 1;
  wiring.last_terminated = ends == 0 || ends == 2;
  config.seed = static_cast<std::uint64_t>(reader.integer_or("seed", 0, 0, INT64_MAX));
  reader.finish();
}

const DeviceFamily& read_can_family(TomlReader& reader, const DeviceRegistry& devices) {
  const auto key = reader.text_or("model", std::string(devices.families().front()->key()));
  const auto* family = devices.find(key);
  if (family == nullptr) reader.fail("model", fmt::format("is \"{}\", known are {}", key, devices.known_keys()));
  return *family;
}

CanNodeConfig read_can_node(TomlReader reader, const CanLineConfig& config, const std::filesystem::path& directory,
                            const DeviceRegistry& devices) {
  CanNodeConfig node;
  node.name = reader.text("name");
  if (node.name.empty() || node.name.size() > kMaxNameLength) reader.fail("name", kNameLengthText);
  const auto same = [&node](const CanNodeConfig& other) { return other.name == node.name; };
  if (std::any_of(config.nodes.begin(), config.nodes.end(), same)) {
    reader.fail("name", fmt::format("\"{}\" is there twice", node.name));
  }
  node.node_id = static_cast<std::uint8_t>(reader.integer("node", 1, 127));
  for (const auto& other : config.nodes) {
    if (other.node_id != node.node_id) continue;
    reader.fail("node",
                fmt::format("is {}, as that of \"{}\": each node-ID is for one slave", node.node_id, other.name));
  }
  std::vector<std::shared_ptr<const SlaveDevice>> before;
  for (const auto& other : config.nodes) before.push_back(other.device);
  const auto& family = read_can_family(reader, devices);
  node.device = family.read({reader, directory, nullptr, before});
  if (!node.device->simulate_on_can({node.name, 1, node.node_id, config.bit_rate})) {
    reader.fail("model", fmt::format("is \"{}\", which has no CAN connection", family.key()));
  }
  if (const auto reason = node.device->why_not_at(config.bit_rate); !reason.empty()) {
    reader.fail("model", fmt::format("\"{}\" {}", node.name, reason));
  }
  reader.finish();
  return node;
}

CanLineConfig read_can_config(const toml::table& table, const std::filesystem::path& file,
                              const DeviceRegistry& devices) {
  auto root = read_toml_table(table, file.string());
  CanLineConfig config;
  auto line = root.table("line");
  config.name = line.text_or("name", config.name);
  line.finish();
  read_can_bus(root.table("bus"), config);
  auto nodes = root.tables("slave");
  if (nodes.empty()) root.fail("", "there is no [[slave]]");
  if (nodes.size() > kMaxCanNodes) {
    root.fail("slave", fmt::format("there are {}, the limit is {}", nodes.size(), kMaxCanNodes));
  }
  for (auto& reader : nodes) {
    config.nodes.push_back(read_can_node(std::move(reader), config, file.parent_path(), devices));
  }
  std::vector<std::string> names;
  for (const auto& node : config.nodes) names.push_back(node.name);
  for (auto& reader : root.tables("fault")) config.faults.push_back(read_can_fault(std::move(reader), names));
  root.finish();
  return config;
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

Result<CanLineConfig> parse_can_line_config(std::string_view text, const std::filesystem::path& name,
                                            const DeviceRegistry& devices) {
  return read_description(text, name, [&](const toml::table& table) { return read_can_config(table, name, devices); });
}

Result<CanLineConfig> load_can_line_config(const std::filesystem::path& file, const DeviceRegistry& devices) {
  const auto text = read_input_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_can_line_config(*text, file, devices);
}

}  // namespace driveline::runtime
