#include "support/stopwatch.hpp"

#include <vector>

#include "support/samples.hpp"

namespace driveline::bench {
namespace {

double measure_reading() {
  // Measure in batches, because the clock may be coarser than the duration of a reading.
  constexpr int kBatches = 200;
  constexpr int kReadings = 200;
  std::vector<double> samples;
  for (int i = 0; i < kBatches; ++i) {
    const double begin = now_ns();
    for (int k = 1; k < kReadings; ++k) keep(now_ns());
    samples.push_back((now_ns() - begin) / kReadings);
  }
  return summarize(std::move(samples)).p50;
}

}  // namespace

double reading_cost_ns() {
  static const double kCost = measure_reading();
  return kCost;
}

}  // namespace driveline::bench
