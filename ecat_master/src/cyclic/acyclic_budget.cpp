#include "driveline/ecat_master/cyclic/acyclic_budget.hpp"

#include <algorithm>
#include <cstdint>

#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/wire_time.hpp"

namespace driveline::ecat_master {

std::size_t acyclic_bytes(const ProcessImage& image, bool clocks, std::chrono::nanoseconds period) {
  // A tenth stays free for a cycle that wakes up late.
  const auto usable = static_cast<std::uint64_t>(period.count()) * 9 / 10;
  const auto taken = wire_time_ns(image, clocks) + wire::kPreambleFcsGap * wire::kNsPerByte;
  const auto left = usable > taken ? (usable - taken) / wire::kNsPerByte : 0;
  return std::clamp<std::size_t>(left, wire::kMinFrameBytes, AcyclicChannel::kMaxBytes);
}

}  // namespace driveline::ecat_master
