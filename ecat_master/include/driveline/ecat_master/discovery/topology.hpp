#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::ecat_master {

/// Number of ports of a slave controller.
inline constexpr unsigned kSlavePorts = 4;

/// State of a slave's ports. Lists are in the order in which a frame passes the slaves.
struct SlavePortFacts {
  std::array<bool, kSlavePorts> open{};  ///< frames pass through the port: loop open, communication established
  std::array<bool, kSlavePorts> link{};  ///< physical link
  /// Local time at which the same frame arrived at each port, in ns modulo 2^32 (registers 0x0900..0x090F).
  std::array<std::uint32_t, kSlavePorts> receive_time_ns{};
  bool receive_times_valid = false;  ///< the controller has the registers (feature bit 2, register 0x0008)
};

/// One end of a cable.
struct PortRef {
  std::uint16_t slave = 0;  ///< position of the slave
  std::uint8_t port = 0;    ///< port of the slave, 0 to 3
  constexpr bool operator==(const PortRef&) const = default;
};

/// Position of a slave in the tree of the line.
struct TopologyNode {
  std::optional<PortRef> parent;  ///< port of the previous slave; empty: the master
  std::uint8_t entry_port = 0;    ///< port towards the master; not 0: IN and OUT swapped
  std::array<std::optional<std::uint16_t>, kSlavePorts> children{};  ///< slave behind each port
  std::uint16_t depth = 0;    ///< number of slaves between this slave and the master
  std::uint32_t span_ns = 0;  ///< time that a frame spends behind this slave
};

/// Connections of the slaves, by position.
struct Topology {
  std::vector<TopologyNode> slaves;  ///< by position; empty: unknown
  /// The slave port that leads back to the master (second interface of a ring); empty for an open line.
  std::optional<PortRef> ring_end;
  /// Ports with a link whose loop is closed: the device at the other end of the cable does not answer.
  std::vector<PortRef> silent_ports;

  [[nodiscard]] std::optional<std::uint16_t> first() const noexcept;  ///< the slave at the master's interface
  /// Positions of the slaves that are entered at another port than 0.
  [[nodiscard]] std::vector<std::uint16_t> swapped() const;
};

/// Builds the tree from the port facts. A frame that arrives at a port leaves at the next open port in the order 0 -
/// processing unit - 3 - 1 - 2 - 0 (ESC data sheet I, "Frame processing order"), so open ports and the order of slaves
/// give the tree; the port reached first is the one towards the master. Where swapped slaves make several trees
/// possible, the slave behind which a frame stays longest is the outer one.
///
/// Slaves without receive times are assumed to be entered at port 0. Error: PortsFitNoTree, with the slave whose ports
/// do not fit, when no tree explains all of them.
[[nodiscard]] Result<Topology> build_topology(std::span<const SlavePortFacts> slaves);

/// Reads DL status and port receive times of all `slaves` (in line order, all of the line). Latches the receive times
/// with a broadcast write. Errors: WorkingCounter, those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::span<const SlaveRef> slaves);
/// Like above, for the first `count` slaves of the line, whatever their station addresses.
[[nodiscard]] Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::uint16_t count);

/// The tree as text: a chain in one column, branches indented under the port where they start. `labels` has a text for
/// each slave; it may be empty.
[[nodiscard]] std::string to_tree_text(const Topology& topology, std::span<const std::string> labels);

/// The tree in the DOT language of Graphviz, edges labelled with the connected ports.
[[nodiscard]] std::string to_graphviz(const Topology& topology, std::span<const std::string> labels);

}  // namespace driveline::ecat_master
