#pragma once

#include <cstddef>

#include "support/samples.hpp"

namespace driveline::bench {

/// What the cycle finds when every axis is to stop.
enum class StopLoad {
  kNothing,   ///< the stops alone
  kRequests,  ///< the queue of requests is full after 10,000 have been submitted, and a move waits in each axis
};

/// Costs of cycles in ns, without the time inside the port. A turn is one stop of all axes.
struct StopCosts {
  TurnSamples moving{};    ///< cycles in which all axes move and nothing is requested
  TurnSamples stopping{};  ///< the cycle that takes the stops of all axes
};

/// Stops all axes of a line of simulated drives in one cycle, `turns` times (at least two), on virtual time. Throws
/// std::runtime_error if an axis does not stop in that cycle, or if the line was not under the load.
[[nodiscard]] StopCosts measure_stops(std::size_t axes, StopLoad load, int turns);

}  // namespace driveline::bench
