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

/// Wait-free ring between exactly one producer thread and one consumer thread. When it is full, the new element is
/// dropped and counted: the producer, usually the real-time thread, never waits for the consumer.
///
/// The indices count all elements ever pushed and popped and are masked on access, so that full and empty differ
/// without a spare slot; at one element per nanosecond they last for centuries.
template <typename T>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>,
                "elements are copied as bytes and must not own anything");

 public:
  /// Allocates room for at least `capacity` elements, rounded up to a power of two, and touches all of it.
  /// @throws std::invalid_argument if `capacity` is 0.
  explicit SpscRing(std::size_t capacity) : mask_{checked(capacity) - 1}, slots_{std::make_unique<T[]>(mask_ + 1)} {}

  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Producer: appends a copy of `value`, or drops it and counts the drop if the ring is full.
  /// @return false if it was dropped. \rtsafe
  bool try_push(const T& value) noexcept {
    return try_push_all(1, [&value](std::size_t, T& slot) noexcept { slot = value; });
  }

  /// Producer: appends `count` elements, which become visible to the consumer together, or drops and counts all of them
  /// if they do not all fit. `fill(i, slot)` writes element `i` in place; a slot still holds its previous content.
  /// @return false if they were dropped. \rtsafe if `fill` is.
  template <typename Fill>
  bool try_push_all(std::size_t count, const Fill& fill) noexcept {
    static_assert(noexcept(fill(std::size_t{}, std::declval<T&>())), "an exception would leave half of them");
    // Only this thread writes head, so its own value needs no ordering.
    const std::uint64_t head = producer_.head.load(std::memory_order_relaxed);
    if (head - producer_.cached_tail + count > capacity()) {
      // Acquire pairs with the consumer's release: it has finished reading the slots it returned.
      producer_.cached_tail = consumer_.tail.load(std::memory_order_acquire);
      if (head - producer_.cached_tail + count > capacity()) {
        // A plain statistic that orders nothing. With a single writer, load and store suffice.
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
  /// @return false, with `value` unchanged, if there is none. \rtsafe
  bool try_pop(T& value) noexcept { return pop(std::span<T>{&value, 1}) == 1; }

  /// Consumer: takes the oldest elements, as many as are available and fit.
  /// @return number of elements written to the front of `values`. \rtsafe
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

  /// Number of waiting elements; exact on either of the two threads while the other is inactive, otherwise a recent
  /// value. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept {
    // Load tail first: head can only grow meanwhile, so the difference is never negative; std::min covers pushes that
    // refilled slots in between.
    const std::uint64_t tail = consumer_.tail.load(std::memory_order_acquire);
    const std::uint64_t head = producer_.head.load(std::memory_order_acquire);
    return std::min<std::uint64_t>(head - tail, capacity());
  }

  /// Number of elements that fit: the requested capacity, rounded up to a power of two. \rtsafe
  [[nodiscard]] std::size_t capacity() const noexcept { return mask_ + 1; }

 private:
  // Each side owns a cache line with its index and its last view of the other side's index, so that it touches the
  // other line only when it runs out of known room (or known content).
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
