#pragma once

#include <atomic>
#include <cstdint>

namespace driveline::rt {

/// Counts events in one thread; any thread may read the count. The count synchronises no other data, hence relaxed.
class Counter {
 public:
  /// Only one thread at a time may call this, so that a load and a store suffice. \rtsafe
  void add(std::uint64_t events = 1) noexcept {
    events_.store(events_.load(std::memory_order_relaxed) + events, std::memory_order_relaxed);
  }

  /// Number of events so far. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t value() const noexcept { return events_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> events_{0};
};

}  // namespace driveline::rt
