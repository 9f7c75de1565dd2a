#include "sample_filter.hpp"

#include <cstring>

namespace driveline::bridge {
namespace {

/// Time after which an unchanged sample is published again, for new subscribers.
constexpr std::int64_t kRepeatAfterNs = 1'000'000'000;

/// Whether two samples are equal except for cycle and time. Compares bits, so that NaN equals NaN.
bool alike(const snapshot::AxisSample& a, snapshot::AxisSample b) {
  b.cycle = a.cycle;
  b.time_ns = a.time_ns;
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): the bits are meant, and there is no padding
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}
static_assert(sizeof(snapshot::AxisSample) == 8 + 8 + 2 + 2 + 2 + 1 + 1 + 1 + 1 + 2 + 4 + 8 + 11 * 8, "no padding");

}  // namespace

bool SampleFilter::takes(const snapshot::AxisSample& sample) {
  if (sample.cycle % rate_.cycles != 0) return false;
  if (sample.axis >= last_.size()) return true;
  auto& last = last_[sample.axis];
  const bool soon = last.any && sample.time_ns - last.sample.time_ns < kRepeatAfterNs;
  if (soon && alike(sample, last.sample)) return false;
  last = {true, sample};
  return true;
}

}  // namespace driveline::bridge
