#pragma once

#include <atomic>
#include <cstdint>

namespace driveline::port {

/// Counts events in one thread; any thread may read. The numbers order nothing else, hence relaxed.
class Counter {
 public:
  /// Only one thread at a time counts, so that load and store suffice. \rtsafe
  void add(std::uint64_t events = 1) noexcept {
    events_.store(events_.load(std::memory_order_relaxed) + events, std::memory_order_relaxed);
  }

  /// \rtsafe
  [[nodiscard]] std::uint64_t value() const noexcept { return events_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> events_{0};
};

}  // namespace driveline::port
