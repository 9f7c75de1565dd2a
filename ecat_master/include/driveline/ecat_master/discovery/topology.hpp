#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::ecat_master {

/// Ports of a slave controller.
inline constexpr unsigned kSlavePorts = 4;

/// State of a slave's ports. Lists of it are in the order in which a frame passes the slaves.
struct SlavePortFacts {
  std::array<bool, kSlavePorts> open{};  ///< frames leave and come in here: loop open, communication established
  std::array<bool, kSlavePorts> link{};  ///< physical link
  /// Local time at which one and the same frame came in at each port, in ns modulo 2^32 (registers 0x0900..0x090F).
  std::array<std::uint32_t, kSlavePorts> receive_time_ns{};
  bool receive_times_valid = false;  ///< the controller has the registers (feature bit 2, register 0x0008)
};

/// One end of a cable.
struct PortRef {
  std::uint16_t slave = 0;  ///< position
  std::uint8_t port = 0;    ///< 0 to 3
  constexpr bool operator==(const PortRef&) const = default;
};

/// Place of one slave in the line.
struct TopologyNode {
  std::optional<PortRef> parent;                                     ///< nothing: the master
  std::uint8_t entry_port = 0;                                       ///< towards the master; not 0: IN and OUT swapped
  std::array<std::optional<std::uint16_t>, kSlavePorts> children{};  ///< slave behind each port
  std::uint16_t depth = 0;                                           ///< slaves between this one and the master
  std::uint32_t span_ns = 0;                                         ///< time a frame spends behind this slave
};

/// Connections of the slaves, by position.
struct Topology {
  std::vector<TopologyNode> slaves;  ///< by position; empty: not known
  /// The slave whose free port leads back to the master (second interface of a ring), nothing for an open line.
  std::optional<PortRef> ring_end;
  /// Ports with a link whose loop is closed: the device at the other end of the cable does not answer.
  std::vector<PortRef> silent_ports;

  [[nodiscard]] std::optional<std::uint16_t> first() const noexcept;  ///< the slave at the master's interface
  /// Slaves that are entered at another port than 0.
  [[nodiscard]] std::vector<std::uint16_t> swapped() const;
};

/// Finds the tree behind the port facts. A frame that comes in at a port leaves at the next open one in the order
/// 0 - processing unit - 3 - 1 - 2 - 0 (ESC data sheet I, "Frame processing order"), so open ports and order give the
/// tree; the port that was reached first is the one towards the master. Where swapped slaves leave several trees
/// possible, the slave behind which a frame stays longest is the outer one.
///
/// Slaves without receive times are taken to be entered at port 0. Error: PortsFitNoTree, with the slave whose
/// ports do not fit, when no tree explains all of them.
[[nodiscard]] Result<Topology> build_topology(std::span<const SlavePortFacts> slaves);

/// Reads DL status and port receive times of all `slaves` (in line order, all of the line). Latches the receive times
/// with a broadcast write. Errors: WorkingCounter, those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::span<const SlaveRef> slaves);
/// The same for the first `count` slaves of the line, whatever station addresses they have.
[[nodiscard]] Result<std::vector<SlavePortFacts>> read_port_facts(Bus& bus, std::uint16_t count);

/// The tree as text, a chain in one column and branches indented under the port they leave from. `labels` has a text
/// for each slave; it may be empty.
[[nodiscard]] std::string to_tree_text(const Topology& topology, std::span<const std::string> labels);

/// The tree in the DOT language of Graphviz, edges labelled with the ports they connect.
[[nodiscard]] std::string to_graphviz(const Topology& topology, std::span<const std::string> labels);

}  // namespace driveline::ecat_master
