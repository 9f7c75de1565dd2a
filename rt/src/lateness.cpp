#include "driveline/rt/lateness.hpp"

#include <algorithm>

namespace driveline::rt {

void record_lateness(Histogram& histogram, std::chrono::nanoseconds late, std::int64_t missed,
                     std::chrono::nanoseconds period) noexcept {
  const auto single = std::min(missed, kSingleInstants);
  if (missed > single) histogram.record(late, static_cast<std::uint64_t>(missed - single));
  for (auto behind = single; behind >= 0; --behind) histogram.record(late - (missed - behind) * period);
}

}  // namespace driveline::rt
