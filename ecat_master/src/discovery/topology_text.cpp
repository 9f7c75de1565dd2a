#include <fmt/format.h>

#include <iterator>

#include "driveline/ecat_master/discovery/topology.hpp"

namespace driveline::ecat_master {
namespace {

/// The order in which a frame leaves a slave.
constexpr std::array<std::uint8_t, kSlavePorts> kLeavingOrder = {3, 1, 2, 0};

std::string label_of(std::span<const std::string> labels, std::size_t slave) {
  return slave < labels.size() ? labels[slave] : std::string{};
}

std::vector<PortRef> children_of(const Topology& topology, std::uint16_t slave) {
  std::vector<PortRef> list;
  for (const auto port : kLeavingOrder) {
    if (const auto& child = topology.slaves[slave].children[port]) list.push_back({*child, port});
  }
  return list;
}

void append_line(std::string& text, const Topology& topology, std::span<const std::string> labels, std::uint16_t slave,
                 const std::string& indent) {
  const auto& node = topology.slaves[slave];
  fmt::format_to(std::back_inserter(text), "{}{:3}  {}", indent, slave, label_of(labels, slave));
  if (node.entry_port != 0) {
    fmt::format_to(std::back_inserter(text), "  (IN and OUT swapped: entered at port {})", node.entry_port);
  }
  if (topology.ring_end && topology.ring_end->slave == slave) {
    fmt::format_to(std::back_inserter(text), "  (port {} leads back to the master)", topology.ring_end->port);
  }
  for (const auto& silent : topology.silent_ports) {
    if (silent.slave == slave) fmt::format_to(std::back_inserter(text), "  (link at port {}, no answer)", silent.port);
  }
  while (text.ends_with(' ')) text.pop_back();
  text += '\n';
}

struct Chain {
  std::uint16_t first;
  std::string head;    ///< indentation of the line that starts the chain
  std::string indent;  ///< indentation of all further lines
};

std::string quoted(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

}  // namespace

std::string to_tree_text(const Topology& topology, std::span<const std::string> labels) {
  const auto first = topology.first();
  if (!first) return "master\n";
  std::string text = "master\n";
  // Depth first without recursion: a chain may have thousands of slaves.
  std::vector<Chain> waiting{{*first, "", ""}};
  while (!waiting.empty()) {
    auto chain = std::move(waiting.back());
    waiting.pop_back();
    std::uint16_t slave = chain.first;
    append_line(text, topology, labels, slave, chain.head);
    for (auto children = children_of(topology, slave); !children.empty(); children = children_of(topology, slave)) {
      if (children.size() == 1) {
        slave = children[0].slave;
        append_line(text, topology, labels, slave, chain.indent);
        continue;
      }
      for (std::size_t n = children.size(); n-- > 0;) {
        const bool last = n + 1 == children.size();
        waiting.push_back({children[n].slave,
                           fmt::format("{}  {} port {} ", chain.indent, last ? "└─" : "├─", children[n].port),
                           fmt::format("{}  {}        ", chain.indent, last ? "  " : "│ ")});
      }
      break;
    }
  }
  return text;
}

std::string to_graphviz(const Topology& topology, std::span<const std::string> labels) {
  std::string text = "digraph line {\n  rankdir=LR;\n  node [shape=box];\n  master [shape=ellipse];\n";
  auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < topology.slaves.size(); ++i) {
    fmt::format_to(out, "  s{} [label=\"{} {}\"{}];\n", i, i, quoted(label_of(labels, i)),
                   topology.slaves[i].entry_port != 0 ? ", color=red" : "");
  }
  for (std::size_t i = 0; i < topology.slaves.size(); ++i) {
    const auto& node = topology.slaves[i];
    const auto from = node.parent ? fmt::format("s{}", node.parent->slave) : std::string("master");
    const auto tail = node.parent ? fmt::format("{}", node.parent->port) : std::string{};
    fmt::format_to(out, "  {} -> s{} [taillabel=\"{}\", headlabel=\"{}\"];\n", from, i, tail, node.entry_port);
  }
  if (topology.ring_end) {
    fmt::format_to(out, "  s{} -> master [taillabel=\"{}\", style=dashed];\n", topology.ring_end->slave,
                   topology.ring_end->port);
  }
  text += "}\n";
  return text;
}

}  // namespace driveline::ecat_master
