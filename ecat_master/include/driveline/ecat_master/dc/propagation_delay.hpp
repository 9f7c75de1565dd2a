#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::ecat_master::dc {

/// A slave's place in the line, and the times at which the same frame came in at its ports.
struct DelayNode {
  std::uint8_t entry_port = 0;                             ///< towards the master
  std::array<std::optional<std::uint16_t>, 4> children{};  ///< slave behind each port
  std::array<std::uint32_t, 4> receive_time_ns{};          ///< registers 0x0900..0x090F, modulo 2^32
  bool has_receive_times = false;                          ///< false: the slave has no DC unit
  /// Frequency of the slave's clock relative to that of the first slave with receive times. 64 us on a clock that is
  /// 100 ppm fast are 6 ns too long.
  double rate = 1.0;
  /// How much longer a frame takes through the processing unit than past it (tDiff of the controller, up to 40 ns).
  double processing_extra_ns = 0.0;
};

/// Quality of a propagation delay.
enum class DelayQuality : std::uint8_t {
  kMeasured,   ///< from receive times around a single path
  kEstimated,  ///< behind slaves without receive times that branch: all cables there are taken to be equal
  kAssumed,    ///< not measurable: only the master is in front of the branch
  kNone,       ///< the slave has no receive times
};

/// Propagation delay of one slave.
struct PropagationDelay {
  /// From the processing unit of the first slave with receive times to that of this one, in nanoseconds of its clock;
  /// the frame may come by here earlier (negative) when slaves are entered at another port than 0.
  double from_first_ns = 0.0;
  DelayQuality quality = DelayQuality::kNone;  ///< kNone: from_first_ns is not valid
};

/// Slaves whose receive times contradict each other: less time passed around a branch than inside of it.
struct DelayContradiction {
  std::uint16_t slave = 0;  ///< position
  std::uint8_t port = 0;    ///< port whose branch took too little time
};

/// The time a frame takes from slave to slave, from its receive times (ETG.1000.4 6.7, ESC data sheet I 9.1.2): the
/// time between two ports of a slave is that of the way around the branch in between; the share of it behind the first
/// slave of the branch is measured there; half of the rest is the way to that slave, because cables have the same delay
/// in both directions.
///
/// Lines, branches, stars and slaves entered at other ports than 0 are the same to this function: it goes around each
/// branch in the order in which frames do (0 - processing unit - 3 - 1 - 2). Slaves without receive times count as part
/// of the cable. A ring must be opened at its far end meanwhile. Only differences of times of the same slave are used,
/// modulo 2^32, so neither the offsets between the clocks nor any wrap-around matter.
///
/// Result: one per node. Allocates.
[[nodiscard]] tl::expected<std::vector<PropagationDelay>, DelayContradiction> propagation_delays(
    std::span<const DelayNode> nodes);

}  // namespace driveline::ecat_master::dc
