#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/canopen_master/node_report.hpp"
#include "driveline/rt/counter.hpp"

namespace driveline::canopen {

/// The nodes as the cycle sees them, by their place in the plan. The constructor allocates all memory.
class NodeTable {
 public:
  /// A node in the period that is judged.
  struct Node {
    bool in_use = false;        ///< set_operational() said so when the period began
    bool begun = false;         ///< it has become so with this period
    bool sent = true;           ///< every RPDO with SYNC was
    std::uint32_t due = 0;      ///< TPDOs that are to answer each SYNC
    std::uint32_t came = 0;     ///< those of them that came in this period
    std::uint32_t tpdos = 0;    ///< all TPDOs
    std::uint32_t heard = 0;    ///< those of them that have come since the node was last not in use
    std::uint32_t sojourn = 0;  ///< number of times that the node was put out of use; tells which TPDOs count as heard
    std::uint32_t worst_bits = 0;  ///< worst case of the bits of its PDOs with SYNC
  };
  /// Sums over the nodes in use.
  struct Totals {
    std::uint32_t due = 0;         ///< sum of Node::due
    std::uint32_t came = 0;        ///< sum of Node::came
    std::uint32_t worst_bits = 0;  ///< sum of Node::worst_bits
  };

  /// No node is operational.
  explicit NodeTable(std::size_t nodes);

  /// \name For any thread, \rtsafe
  /// @{
  void set_operational(std::size_t node, bool operational) noexcept;
  [[nodiscard]] NodeReport report(std::size_t node) const noexcept;
  /// @}

  /// \name For the cycle, \rtsafe
  /// @{
  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  [[nodiscard]] Node& operator[](std::size_t node) noexcept { return nodes_[node]; }
  [[nodiscard]] const Node& operator[](std::size_t node) const noexcept { return nodes_[node]; }
  /// Takes over which nodes are operational, for the period that begins. From the first call on, Node::due, tpdos and
  /// worst_bits must not change.
  void begin_period() noexcept;
  /// Whether a node has come into use with this period.
  [[nodiscard]] bool some_begun() const noexcept { return some_begun_; }
  /// Sums over the nodes in use.
  [[nodiscard]] const Totals& totals() const noexcept { return totals_; }
  /// A TPDO of a node that was due has come, for the first time in this period.
  void note_came(std::size_t node) noexcept {
    ++nodes_[node].came;
    if (nodes_[node].in_use) ++totals_.came;
  }
  /// A TPDO of a node has come for the first time since the node was last not in use.
  void note_heard(std::size_t node) noexcept {
    ++nodes_[node].heard;
    settled_ = false;
  }
  void note_late(std::size_t node) noexcept { shared_[node].late.add(); }
  /// A TPDO of a node that was shorter than its mapping. Aligned as a whole word, which std::atomic needs to load it
  /// without a call of libatomic.
  struct alignas(std::uint32_t) ShortPdo {
    std::uint16_t number = 0;  ///< 0: none yet
    std::uint8_t bytes = 0;    ///< bytes received
    std::uint8_t mapped = 0;   ///< bytes of the mapping
  };
  void note_short(std::size_t node, ShortPdo pdo) noexcept;
  void note_unsent(std::size_t node) noexcept;
  /// What was sent to a node for this period is out of date.
  void note_outdated(std::size_t node) noexcept {
    nodes_[node].sent = false;
    settled_ = false;
  }
  /// Result of the judgement of a period.
  struct Verdict {
    std::uint32_t due = 0;   ///< TPDOs that were
    std::uint32_t came = 0;  ///< those of them that came
    bool all_valid = true;   ///< every node in use is valid
  };
  /// Judges all nodes. `synced`: SYNC was sent, so that answers are due.
  [[nodiscard]] Verdict judge(bool synced) noexcept;
  /// By node: in use, and its outputs of the period judged last were sent. On CAN a frame that was sent has arrived,
  /// because the adapter repeats it until it is acknowledged: an answer that is missing says nothing about it.
  [[nodiscard]] std::span<const bool> supplied() const noexcept { return {supplied_.get(), nodes_.size()}; }
  /// By node: valid in the period judged last.
  [[nodiscard]] std::span<const bool> valid() const noexcept { return {valid_.get(), nodes_.size()}; }
  /// @}

 private:
  struct Shared {
    std::atomic<std::uint32_t> requested{0};  ///< number of changes by set_operational(); odd: operational
    std::atomic<std::uint32_t> flags{0};      ///< results of the last judgement
    std::atomic<std::uint32_t> stale{0};
    rt::Counter lost;
    rt::Counter late;
    rt::Counter wrong_length;
    std::atomic<ShortPdo> short_pdo{};
    rt::Counter unsent;
  };

  [[nodiscard]] bool judge(std::size_t place, bool synced) noexcept;
  void take_requests() noexcept;

  std::vector<Node> nodes_;
  Totals totals_;
  bool some_begun_ = false;
  /// The last judgement found all nodes in use and valid, and no other event has come since: only a missing TPDO or
  /// SYNC can change it.
  bool settled_ = false;
  std::uint32_t changes_seen_ = 0;
  std::atomic<std::uint32_t> changes_{0};  ///< number of all requests, incremented after each
  std::vector<std::uint32_t> requests_seen_;
  std::unique_ptr<Shared[]> shared_;
  std::unique_ptr<bool[]> valid_;
  std::unique_ptr<bool[]> supplied_;
};

}  // namespace driveline::canopen
