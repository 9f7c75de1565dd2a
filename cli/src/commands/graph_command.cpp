#include <fmt/format.h>

#include "commands/commands.hpp"
#include "console.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

struct GraphOptions {
  runtime::BusOptions bus;
  bool tree = false;
  bool json = false;
};

nlohmann::json graph_to_json(const ecat_master::Topology& topology, const std::vector<std::string>& labels) {
  auto slaves = nlohmann::json::array();
  for (std::size_t i = 0; i < topology.slaves.size(); ++i) {
    const auto& node = topology.slaves[i];
    nlohmann::json row = {{"position", i}, {"name", labels[i]}, {"entry_port", node.entry_port}, {"depth", node.depth}};
    row["parent"] = nullptr;
    if (node.parent) row["parent"] = {{"slave", node.parent->slave}, {"port", node.parent->port}};
    slaves.push_back(std::move(row));
  }
  nlohmann::json document = {{"slaves", slaves}};
  document["ring_end"] = nullptr;
  if (topology.ring_end) {
    document["ring_end"] = {{"slave", topology.ring_end->slave}, {"port", topology.ring_end->port}};
  }
  return document;
}

Outcome<int> draw(const GraphOptions& options) {
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto topology = (*line)->topology();
  if (!topology) return tl::unexpected(topology.error());
  std::vector<std::string> labels;
  for (const auto& view : (*line)->read_all()) labels.push_back(view.name());
  if (options.json) {
    print_out("{}", json_text(graph_to_json(*topology, labels)));
  } else if (options.tree) {
    print_out("{}", ecat_master::to_tree_text(*topology, labels));
  } else {
    print_out("{}", ecat_master::to_graphviz(*topology, labels));
  }
  return 0;
}

}  // namespace

Execute prepare_graph(Arguments& to) {
  auto options = std::make_shared<GraphOptions>();
  add_bus_options(to, options->bus);
  to.flag("--tree", options->tree, "As a tree of text instead of Graphviz");
  add_json_flag(to, options->json);
  return [options] { return draw(*options); };
}

}  // namespace driveline::cli
