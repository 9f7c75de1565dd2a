#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "driveline/rt/cache_line.hpp"

namespace driveline::rt {

/// Wait-free ring between exactly one producer thread and one consumer thread. When it is full the new element is
/// dropped and counted: the producer, usually the real-time thread, never waits for the consumer.
///
/// The indices count elements since the beginning and are masked on access, so that full and empty differ without a
/// spare slot; at one element per nanosecond they last for centuries.
template <typename T>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>,
                "elements are copied as bytes and must not own anything");

 public:
  /// Room for at least `capacity` elements, rounded up to a power of two. All memory is allocated and touched here.
  /// @throws std::invalid_argument if `capacity` is 0.
  explicit SpscRing(std::size_t capacity) : mask_{checked(capacity) - 1}, slots_{std::make_unique<T[]>(mask_ + 1)} {}

  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Producer: appends a copy of `value`, or drops it and counts the drop if the ring is full.
  /// @return false if it was dropped. \rtsafe
  bool try_push(const T& value) noexcept {
    return try_push_all(1, [&value](std::size_t, T& slot) noexcept { slot = value; });
  }

  /// Producer: appends `count` elements, which the consumer sees at once, or drops and counts them all if there is not
  /// room for each. `fill(i, slot)` writes element `i` where it stays; a slot still has what was in it before.
  /// @return false if they were dropped. \rtsafe if `fill` is.
  template <typename Fill>
  bool try_push_all(std::size_t count, const Fill& fill) noexcept {
    static_assert(noexcept(fill(std::size_t{}, std::declval<T&>())), "an exception would leave half of them");
    // Only this thread writes head: its own value needs no ordering.
    const std::uint64_t head = producer_.head.load(std::memory_order_relaxed);
    if (head - producer_.cached_tail + count > capacity()) {
      // Acquire pairs with the consumer's release: it has finished reading the slots it gave back.
      producer_.cached_tail = consumer_.tail.load(std::memory_order_acquire);
      if (head - producer_.cached_tail + count > capacity()) {
        // A plain statistic, orders nothing. Single writer, so load and store suffice.
        producer_.dropped.store(producer_.dropped.load(std::memory_order_relaxed) + count, std::memory_order_relaxed);
        return false;
      }
    }
    for (std::size_t i = 0; i < count; ++i) fill(i, slots_[(head + i) & mask_]);
    // Release: a consumer that sees the new head sees the slots filled.
    producer_.head.store(head + count, std::memory_order_release);
    return true;
  }

  /// Consumer: takes the oldest element.
  /// @return false, leaving `value` alone, if there is none. \rtsafe
  bool try_pop(T& value) noexcept { return pop(std::span<T>{&value, 1}) == 1; }

  /// Consumer: takes the oldest elements, as many as there are and as fit.
  /// @return how many were written to the front of `values`. \rtsafe
  std::size_t pop(std::span<T> values) noexcept {
    // Only this thread writes tail.
    const std::uint64_t tail = consumer_.tail.load(std::memory_order_relaxed);
    if (consumer_.cached_head - tail < values.size()) {
      // Acquire pairs with the producer's release: the slots up to head are filled.
      consumer_.cached_head = producer_.head.load(std::memory_order_acquire);
    }
    const std::uint64_t count = std::min<std::uint64_t>(consumer_.cached_head - tail, values.size());
    for (std::uint64_t i = 0; i < count; ++i) {
      values[i] = slots_[(tail + i) & mask_];
    }
    // Release: the producer may overwrite these slots only after they were read.
    consumer_.tail.store(tail + count, std::memory_order_release);
    return count;
  }

  /// Elements dropped because the ring was full. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t dropped() const noexcept { return producer_.dropped.load(std::memory_order_relaxed); }

  /// Elements waiting; exact on either of the two threads if the other rests, otherwise a recent value. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept {
    // Tail first: head can only grow meanwhile, so the difference is never negative; the limit covers pushes that
    // refilled slots in between.
    const std::uint64_t tail = consumer_.tail.load(std::memory_order_acquire);
    const std::uint64_t head = producer_.head.load(std::memory_order_acquire);
    return std::min<std::uint64_t>(head - tail, capacity());
  }

  /// Number of elements it can hold: the requested number, rounded up to a power of two. \rtsafe
  [[nodiscard]] std::size_t capacity() const noexcept { return mask_ + 1; }

 private:
  // Each side owns a cache line: its index, and its last view of the other's, which saves touching the other's line
  // while there is known room (or known content).
  struct alignas(kCacheLineBytes) Producer {
    std::atomic<std::uint64_t> head{0};  // elements ever pushed
    std::uint64_t cached_tail = 0;
    std::atomic<std::uint64_t> dropped{0};
  };
  struct alignas(kCacheLineBytes) Consumer {
    std::atomic<std::uint64_t> tail{0};  // elements ever popped
    std::uint64_t cached_head = 0;
  };

  static std::size_t checked(std::size_t capacity) {
    if (capacity == 0) {
      throw std::invalid_argument("ring: the capacity must not be 0");
    }
    return std::bit_ceil(capacity);
  }

  const std::size_t mask_;
  const std::unique_ptr<T[]> slots_;
  Producer producer_;
  Consumer consumer_;
};

}  // namespace driveline::rt
