#pragma once

#include <vector>

#include "driveline/canopen_client/bus_link.hpp"
#include "driveline/canopen_client/node_states.hpp"

namespace driveline::canopen {

/// How a bus is searched.
struct ScanOptions {
  std::vector<std::uint8_t> nodes;  ///< node-IDs to ask, ascending; empty: 1 to 127
  std::chrono::nanoseconds answer_timeout = std::chrono::milliseconds{50};  ///< for each node
  std::uint32_t bit_rate = 1'000'000;                                       ///< of the bus, for the pace
};

/// A node that was found.
struct FoundNode {
  std::uint8_t node = 0;                     ///< node-ID
  bool answers = false;                      ///< its SDO server answers
  std::optional<std::uint32_t> device_type;  ///< object 1000h; empty: not answered, or aborted
  std::optional<NmtState> state;             ///< by its heartbeat or boot-up message, if one was heard
};

/// Searches a bus for nodes: asks each node-ID for object 1000h, which every CANopen device has, and listens for
/// boot-up messages, heartbeats and emergencies meanwhile.
///
/// One request is under way at a time, and requests and answers take at most a tenth of the bus, whatever its bit rate:
/// a scan that sends 127 requests at once fills the queues of a slow bus. An answer that comes late, while the next
/// node is being asked, counts, too.
class Scan {
 public:
  /// Told before each request: how many node-IDs have been asked, and of how many.
  using Progress = std::function<void(std::size_t done, std::size_t total)>;

  /// The link must outlive this.
  Scan(BusLink& link, ScanOptions options);

  /// Searches; returns the nodes, ascending. Errors: those of BusLink::send(), without a node.
  [[nodiscard]] ClientResult<std::vector<FoundNode>> run(const Progress& progress = {});
  /// Least time from one request to the next at a bit rate. \rtsafe
  [[nodiscard]] static std::chrono::nanoseconds pace(std::uint32_t bit_rate) noexcept;

 private:
  [[nodiscard]] ClientResult<void> ask(std::uint8_t node);
  void listen_until(std::chrono::nanoseconds deadline, std::uint8_t awaited);
  void take(const ReceivedFrame& received);
  [[nodiscard]] std::vector<FoundNode> found() const;

  BusLink* link_;
  ScanOptions options_;
  NodeStates states_;
  std::array<bool, kMaxNodeId + 1U> answers_{};
  std::array<std::optional<std::uint32_t>, kMaxNodeId + 1U> device_types_{};
};

}  // namespace driveline::canopen
