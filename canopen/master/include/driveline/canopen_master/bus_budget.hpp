#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/canopen_master/pdo_image.hpp"

namespace driveline::canopen {

/// Bits of a base frame with `bytes` bytes and the space behind it, without stuff bits. \rtsafe
[[nodiscard]] constexpr std::uint32_t frame_bits(std::size_t bytes) noexcept {
  return 47 + 8 * static_cast<std::uint32_t>(bytes);
}
/// The same with as many stuff bits as any content can cause. \rtsafe
[[nodiscard]] constexpr std::uint32_t worst_frame_bits(std::size_t bytes) noexcept {
  return frame_bits(bytes) + (33 + 8 * static_cast<std::uint32_t>(bytes)) / 4;
}
/// Bits of the longest base frame in the worst case.
inline constexpr std::uint32_t kLongestFrameBits = worst_frame_bits(8);

/// Traffic of a SYNC period, and whether the bus carries it.
///
/// Counted in every period: SYNC, and every PDO with PdoExchange::kWithSync. A line is accepted if these fit in the
/// worst case and one more frame of the longest kind does, too: the frame that an SDO, a control word or an EMCY needs,
/// and behind which a PDO may have to wait.
struct BusBudget {
  std::uint32_t bit_rate = 1'000'000;        ///< bit/s
  std::chrono::nanoseconds period{0};        ///< SYNC period
  std::size_t nodes = 0;                     ///< nodes with at least one PDO in every period
  std::uint32_t bits = 0;                    ///< bits of a period, without stuff bits
  std::uint32_t worst_bits = 0;              ///< bits of a period, in the worst case
  std::uint32_t period_bits = 0;             ///< bits that the bus carries in a period
  std::chrono::nanoseconds needed{0};        ///< time of `worst_bits`
  bool fits = false;                         ///< `worst_bits` and the longest frame fit into `period_bits`
  std::uint32_t acyclic_frames = 0;          ///< frames of the longest kind that fit behind the PDOs of a period
  std::chrono::nanoseconds least_period{0};  ///< shortest period of whole ms in which this traffic fits
  std::size_t most_nodes = 0;                ///< first nodes of the plan whose traffic fits into this period
  double other_load = 0.0;                   ///< share of the bus of what comes now and then, in the worst case:
                                             ///< resent RPDOs, heartbeats, node guarding

  /// Load without stuff bits, as a share of the period. \rtsafe
  [[nodiscard]] double load() const noexcept { return static_cast<double>(bits) / period_bits; }
  /// Load in the worst case. \rtsafe
  [[nodiscard]] double worst_load() const noexcept { return static_cast<double>(worst_bits) / period_bits; }
};

/// Computes the budget of a plan; `image` is its image.
[[nodiscard]] BusBudget bus_budget(const MasterPlan& plan, const PdoImage& image);

/// A budget that does not fit as a sentence: "8 axes need 1.74 ms of bus in the worst case, SYNC is 1 ms: take 2 ms, or
/// 3 axes". For a plan that fits, the sentence gives its load. `things`: name of the nodes, in plural.
[[nodiscard]] std::string describe(const BusBudget& budget, const std::string& things = "nodes");

}  // namespace driveline::canopen
