#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>
#include <vector>

namespace driveline::ecat_master::dc {

/// Position of a slave in the line, and the times at which the same frame arrived at its ports.
struct DelayNode {
  std::uint8_t entry_port = 0;                             ///< port towards the master
  std::array<std::optional<std::uint16_t>, 4> children{};  ///< slave behind each port
  std::array<std::uint32_t, 4> receive_time_ns{};          ///< registers 0x0900..0x090F, modulo 2^32
  bool has_receive_times = false;                          ///< false: the slave has no DC unit
  /// Frequency of the slave's clock relative to the clock of the first slave with receive times. A clock that is 100
  /// ppm fast measures 64 us as 6 ns too long.
  double rate = 1.0;
  /// How much longer a frame takes through the processing unit than past it, in ns (tDiff of the controller, up to 40
  /// ns).
  double processing_extra_ns = 0.0;
};

/// Quality of a propagation delay.
enum class DelayQuality : std::uint8_t {
  kMeasured,   ///< from receive times around a single path
  kEstimated,  ///< behind branching slaves without receive times: assumes equal cables there
  kAssumed,    ///< not measurable: only the master is in front of the branch
  kNone,       ///< the slave has no receive times
};

/// Propagation delay of a slave.
struct PropagationDelay {
  /// Delay from the processing unit of the first slave with receive times to that of this slave, in nanoseconds of the
  /// first slave's clock; negative when the frame passes here earlier, because slaves are entered at another port than
  /// 0.
  double from_first_ns = 0.0;
  DelayQuality quality = DelayQuality::kNone;  ///< kNone: from_first_ns is invalid
};

/// A slave with contradictory receive times: less time passed around a branch than inside it.
struct DelayContradiction {
  std::uint16_t slave = 0;  ///< position of the slave
  std::uint8_t port = 0;    ///< port with the branch that took too little time
};

/// Computes the propagation delays between slaves from the receive times of a frame (ETG.1000.4 6.7, ESC data sheet I
/// 9.1.2): the time between two ports of a slave is the time around the branch between them; the first slave of the
/// branch measures the part behind it; half of the rest is the delay to that slave, because cables have the same delay
/// in both directions.
///
/// Lines, branches, stars and slaves entered at other ports than 0 need no special treatment: the function follows each
/// branch in the order in which frames do (0 - processing unit - 3 - 1 - 2). Slaves without receive times count as part
/// of the cable. A ring must be opened at its far end during the measurement. Only differences between times of the
/// same slave are used, modulo 2^32, so neither clock offsets nor wrap-around matter.
///
/// Returns one delay per node. Allocates.
[[nodiscard]] tl::expected<std::vector<PropagationDelay>, DelayContradiction> propagation_delays(
    std::span<const DelayNode> nodes);

}  // namespace driveline::ecat_master::dc
