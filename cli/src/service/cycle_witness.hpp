#pragma once

#include <atomic>

#include "driveline/snapshot/sample_consumer.hpp"

namespace driveline::cli {

/// Counts the cycles of a line from outside: a cycle that has stopped writes no samples.
class CycleWitness final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> samples) override {
    cycles_.fetch_add(samples.size(), std::memory_order_relaxed);
  }
  void axes(std::span<const snapshot::AxisSample> /*samples*/) override {}

  /// Number of cycles seen so far. Any thread.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> cycles_{0};
};

}  // namespace driveline::cli
