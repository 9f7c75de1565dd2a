#include <fmt/format.h>

#include <algorithm>

#include "can/can_description.hpp"
#include "can/frame_words.hpp"
#include "can/node_facts.hpp"
#include "commands/can_tools.hpp"
#include "console.hpp"
#include "driveline/canopen_client/nmt_commands.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using canopen::FoundNode;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr int kNodesDiffer = 3;  ///< exit status: the bus differs from its description
constexpr nanoseconds kSdoTimeout = milliseconds{500};
constexpr nanoseconds kGuardTimeout = milliseconds{200};
constexpr nanoseconds kLongestHeartbeat = std::chrono::seconds{5};  ///< that is waited for

canopen::SdoOptions sdo_settings(nanoseconds timeout) {
  canopen::SdoOptions settings;
  settings.answer_timeout = timeout;
  return settings;
}

/// A node that was found, with what it says of itself.
struct NodeRow {
  FoundNode found;
  NodeFacts facts;
};

Outcome<std::vector<NodeRow>> read_nodes(CanBus& bus, const CanOptions& can, std::vector<std::uint8_t> nodes,
                                         bool versions) {
  const auto timeout = can.answer_timeout(kSdoTimeout);
  if (!timeout) return tl::unexpected(timeout.error());
  const auto found = scan_bus(bus, can, std::move(nodes));
  if (!found) return tl::unexpected(found.error());
  CanProgress told("nodes asked");
  std::vector<NodeRow> rows;
  for (const auto& node : *found) {
    told.show(rows.size(), found->size());
    NodeRow row{node, {}};
    row.facts.node = node.node;
    row.facts.device_type = node.device_type;
    if (node.answers) {
      canopen::SdoClient client(bus.link(), node.node, sdo_settings(*timeout));
      row.facts = read_node_facts(client, versions);
    } else {
      row.facts.trouble = "is on the bus, but does not answer SDOs";
    }
    if (!row.found.state) row.found.state = bus.states().of(node.node).state;
    rows.push_back(std::move(row));
  }
  if (bus.link().stopped()) return can_failure({canopen::ClientErrorKind::kStopped});
  return rows;
}

/// Sentences about what is on the bus and in the description and not on the other side.
std::vector<std::string> differences(const CanBus& bus, const std::vector<NodeRow>& rows) {
  std::vector<std::string> sentences;
  if (bus.described().empty()) return sentences;
  const auto is_there = [&](std::uint8_t node) {
    return std::any_of(rows.begin(), rows.end(), [&](const NodeRow& row) { return row.facts.node == node; });
  };
  for (const auto& [node, name] : bus.described()) {
    if (!is_there(node)) sentences.push_back(fmt::format("missing: \"{}\" (node {})", name, node));
  }
  for (const auto& row : rows) {
    if (bus.name_of(row.facts.node).empty()) {
      sentences.push_back(fmt::format("extra: node {} is not planned: {}", row.facts.node, row.facts.shown_name()));
    }
  }
  return sentences;
}

std::string hex_or_dash(const std::optional<std::uint32_t>& value) {
  return value ? fmt::format("0x{:08X}", *value) : std::string("-");
}

std::string scan_table(const std::vector<NodeRow>& rows) {
  auto text = fmt::format("{:>4} {:>10} {:>10} {:>10} {:>10} {:>10} {}\n", "node", "type", "vendor", "product",
                          "revision", "serial", "name");
  for (const auto& [found, facts] : rows) {
    text += fmt::format("{:>4} {:>10} {:>10} {:>10} {:>10} {:>10} {}\n", facts.node, hex_or_dash(facts.device_type),
                        hex_or_dash(facts.vendor_id), hex_or_dash(facts.product_code), hex_or_dash(facts.revision),
                        facts.serial_number ? std::to_string(*facts.serial_number) : "-", facts.shown_name());
  }
  return text;
}

std::string state_or_unknown(const std::optional<canopen::NmtState>& state) {
  return state ? nmt_state_words(*state) : std::string("unknown");
}

nlohmann::json row_json(const NodeRow& row) {
  auto document = node_json(row.facts);
  document["state"] = row.found.state ? nlohmann::json(nmt_state_words(*row.found.state)) : nlohmann::json();
  return document;
}

/// The state of a node that has not told it: waits for its heartbeat where it has one, else asks as node guarding does.
std::optional<canopen::NmtState> find_state(CanBus& bus, std::uint8_t node, nanoseconds timeout) {
  auto& link = bus.link();
  const auto& condition = bus.states().of(node);
  if (condition.state) return condition.state;
  // A node in Stopped answers no SDO: it is not waited for long.
  canopen::SdoClient client(link, node, sdo_settings(std::min(timeout, kSdoTimeout)));
  const auto heartbeat = client.upload_number({0x1017, 0});
  if (heartbeat && *heartbeat != 0) {
    const auto deadline = link.now() + std::min<nanoseconds>(2 * milliseconds{*heartbeat}, kLongestHeartbeat);
    while (!condition.state && link.receive(deadline)) {
    }
    return condition.state;
  }
  const auto answer = canopen::NmtCommands(link).guard(node, std::max(kGuardTimeout, timeout));
  return answer ? std::optional(answer->state) : std::nullopt;
}

/// Writes the line description of the nodes, and the path of their axes.
Outcome<void> write_can_description(CanBus& bus, const std::string& interface, const std::vector<NodeRow>& rows,
                                    const DataSheets& sheets, const CanScanOptions& options) {
  const std::filesystem::path file = options.write;
  FoundCanLine line;
  line.bit_rate = bus.bit_rate();
  if (!interface.empty()) line.interface = interface;
  for (const auto& row : rows) {
    FoundCanNode node{row.facts, std::nullopt, {}};
    if (const auto* sheet = sheets.find(row.facts); sheet != nullptr && needs_sheet(row.facts)) {
      node.eds = std::filesystem::proximate(*sheet, std::filesystem::absolute(file).parent_path()).string();
    }
    if (row.facts.trouble.empty()) {
      canopen::SdoClient client(bus.link(), row.facts.node, sdo_settings(kSdoTimeout));
      node.drive = read_can_drive(client, row.facts);
    }
    line.nodes.push_back(std::move(node));
  }
  const auto axes = axes_of(line);
  if (options.turns && axes.empty()) progress("{}: the bus has no axis that can move", file.string());
  const bool follow = can_follow_path(line);
  if (options.turns && !follow)
    progress("{}: has no path, as a drive without interpolated position follows none", file.string());
  if (options.turns && !axes.empty() && follow) {
    line.path_file = file.stem().string() + ".path.csv";
    const auto done = runtime::write_file(file.parent_path() / line.path_file, gentle_path(axes, *options.turns));
    if (!done) return tl::unexpected(done.error());
  }
  if (auto done = runtime::write_file(file, describe_can_line(line)); !done) return tl::unexpected(done.error());
  progress("{}: {} nodes", file.string(), rows.size());
  return {};
}

}  // namespace

Outcome<int> scan_can(const runtime::BusOptions& bus_options, const CanOptions& can, const CanScanOptions& options) {
  const auto selected = can.selected();
  if (!selected) return tl::unexpected(selected.error());
  const auto sheets = options.eds.empty() ? Outcome<DataSheets>(DataSheets{}) : DataSheets::read(options.eds);
  if (!sheets) return tl::unexpected(sheets.error());
  const auto bus = open_can_bus(bus_options.config, bus_options.interface, can);
  if (!bus) return tl::unexpected(bus.error());
  const auto rows = read_nodes(**bus, can, *selected, false);
  if (!rows) return tl::unexpected(rows.error());
  // A part of the bus is not compared with the description of all of it.
  const auto sentences = selected->empty() ? differences(**bus, *rows) : std::vector<std::string>();
  if (options.json) {
    auto list = nlohmann::json::array();
    for (const auto& row : *rows) list.push_back(row_json(row));
    nlohmann::json document = {{"nodes", list}, {"differences", nullptr}};
    if (selected->empty() && !(*bus)->described().empty()) document["differences"] = sentences;
    print_out("{}", json_text(document));
  } else {
    print_out("{}", scan_table(*rows));
  }
  for (const auto& sentence : sentences) progress("{}", sentence);
  if (!options.write.empty()) {
    const auto written = write_can_description(**bus, bus_options.interface, *rows, *sheets, options);
    if (!written) return tl::unexpected(written.error());
    return 0;
  }
  return sentences.empty() ? 0 : kNodesDiffer;
}

Outcome<int> list_can_nodes(const runtime::BusOptions& bus_options, const CanOptions& can, bool as_json) {
  const auto selected = can.selected();
  if (!selected) return tl::unexpected(selected.error());
  const auto bus = open_can_bus(bus_options.config, bus_options.interface, can);
  if (!bus) return tl::unexpected(bus.error());
  const auto nodes = nodes_of(**bus, can);
  if (!nodes) return tl::unexpected(nodes.error());
  const auto rows = read_nodes(**bus, can, *nodes, true);
  if (!rows) return tl::unexpected(rows.error());
  auto list = nlohmann::json::array();
  for (const auto& row : *rows) {
    const auto& facts = row.facts;
    if (as_json) {
      list.push_back(row_json(row));
      list.back()["hardware_version"] = facts.hardware_version;
      list.back()["software_version"] = facts.software_version;
      continue;
    }
    print_out("{:>3}  {:<15}  {}{}{}\n", facts.node, state_or_unknown(row.found.state), facts.shown_name(),
              facts.hardware_version.empty() ? "" : ", hardware " + facts.hardware_version,
              facts.software_version.empty() ? "" : ", software " + facts.software_version);
  }
  if (as_json) print_out("{}", json_text({{"nodes", list}}));
  return 0;
}

Outcome<int> show_can_states(const runtime::BusOptions& bus_options, const CanOptions& can, const std::string& wanted,
                             bool as_json) {
  if (!wanted.empty()) {
    return misused(
        fmt::format("{}: is a state of EtherCAT; nodes of a CAN bus change theirs by `driveline nmt`", wanted));
  }
  const auto timeout = can.answer_timeout(kSdoTimeout);
  if (!timeout) return tl::unexpected(timeout.error());
  const auto bus = open_can_bus(bus_options.config, bus_options.interface, can);
  if (!bus) return tl::unexpected(bus.error());
  const auto nodes = nodes_of(**bus, can);
  if (!nodes) return tl::unexpected(nodes.error());
  CanProgress told("nodes asked");
  auto list = nlohmann::json::array();
  std::size_t asked = 0;
  for (const auto node : *nodes) {
    told.show(asked++, nodes->size());
    const auto state = find_state(**bus, node, *timeout);
    if ((*bus)->link().stopped()) return can_failure({canopen::ClientErrorKind::kStopped});
    if ((*bus)->link().down()) return can_failure({canopen::ClientErrorKind::kDown});
    if (as_json) {
      list.push_back({{"node", node}, {"state", state ? nlohmann::json(nmt_state_words(*state)) : nlohmann::json()}});
    } else {
      print_out("{:>4}  {}\n", node, state_or_unknown(state));
    }
  }
  if (as_json) print_out("{}", json_text({{"nodes", list}}));
  return 0;
}

}  // namespace driveline::cli
