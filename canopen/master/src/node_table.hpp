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
  /// Takes over which nodes are operational, for the period that begins.
  void begin_period() noexcept;
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

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> requests_seen_;
  std::unique_ptr<Shared[]> shared_;
  std::unique_ptr<bool[]> valid_;
  std::unique_ptr<bool[]> supplied_;
};

}  // namespace driveline::canopen
