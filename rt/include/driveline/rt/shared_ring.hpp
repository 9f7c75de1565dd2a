#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/rt/shared_words.hpp"

namespace driveline::rt {

/// Layout that SharedRingWriter<T> and SharedRingReader<T> need. Only create() uses `capacity`.
template <SharedRecord T>
[[nodiscard]] constexpr SharedLayout shared_ring(std::uint32_t content, std::uint32_t content_version,
                                                 std::uint64_t capacity = 0) noexcept {
  return {SharedForm::kRing, content, content_version, sizeof(T), capacity};
}

/// The writing side of a ring between two processes: one writer, one reader; either may own the region. When the ring
/// is full, or appears full because the reader wrote an invalid index, the new record is dropped and counted; the
/// writer never waits. A writer that is killed leaves no half-written record behind; another process replaces it by
/// constructing this object. Two writers at the same time corrupt each other's records and nothing else.
///
/// Belongs to one thread. The region must outlive it.
template <SharedRecord T>
class SharedRingWriter {
 public:
  /// Continues where the previous writer stopped; at the start of a new region. The owner of a region must construct
  /// its handle before it passes the descriptor on.
  /// @throws std::invalid_argument if the region is not a ring of records of this size.
  explicit SharedRingWriter(const SharedMapping& region)
      : slots_{region, SharedForm::kRing}, head_{shared_detail::load<std::memory_order_acquire>(slots_.head())} {
    const std::uint64_t tail = shared_detail::load<std::memory_order_acquire>(slots_.tail());
    if (head_ - tail > slots_.capacity()) {
      head_ = tail;
    }
    publish();
  }

  /// Appends a copy of `value`, or drops it and counts the drop.
  /// @return false if it was dropped. \rtsafe
  bool try_push(const T& value) noexcept {
    // Acquire pairs with the reader's release: the reader has finished with the slots that it returned.
    const std::uint64_t waiting = head_ - shared_detail::load<std::memory_order_acquire>(slots_.tail());
    const bool has_room = waiting < slots_.capacity();
    if (has_room) {
      shared_detail::store_record<std::memory_order_relaxed>(slots_.at(head_), value);
      ++head_;
    } else {
      breaches_ += waiting > slots_.capacity() ? 1 : 0;
      ++dropped_;
    }
    publish();
    return has_room;
  }

  /// Records dropped by this object. \rtsafe
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

  /// Number of invalid indexes from the reader; if not 0, the reader is broken or hostile. \rtsafe
  [[nodiscard]] std::uint64_t breaches() const noexcept { return breaches_; }

 private:
  // Only this object's copy of the index counts: it is stored even if nothing was pushed, in case the peer has
  // overwritten it. Release: a reader that sees the index also sees the records before it.
  void publish() noexcept { shared_detail::store<std::memory_order_release>(slots_.head(), head_); }

  shared_detail::Slots<T> slots_;
  std::uint64_t head_;
  std::uint64_t dropped_ = 0;
  std::uint64_t breaches_ = 0;
};

/// The reading side of a ring between two processes. Another process replaces a reader that was killed by constructing
/// this object; it continues with the oldest record that was not returned to the writer, so the records taken last may
/// appear again.
///
/// pop() returns copies. If the writer is not trusted, check them like any other input: index and contents may be
/// arbitrary, and the memory may change at any time, but the copy does not.
///
/// Belongs to one thread. The region must outlive it.
template <SharedRecord T>
class SharedRingReader {
 public:
  /// Continues where the previous reader stopped; at the start of a new region. The owner of a region must construct
  /// its handle before it passes the descriptor on.
  /// @throws std::invalid_argument if the region is not a ring of records of this size.
  explicit SharedRingReader(const SharedMapping& region)
      : slots_{region, SharedForm::kRing}, tail_{shared_detail::load<std::memory_order_acquire>(slots_.tail())} {
    const std::uint64_t head = shared_detail::load<std::memory_order_acquire>(slots_.head());
    if (head - tail_ > slots_.capacity()) {
      tail_ = head;
    }
    publish();
  }

  /// Takes the oldest records, as many as are available and fit. If the writer's index is invalid, all waiting records
  /// are discarded.
  /// @return number of records written to the front of `values`. \rtsafe
  std::size_t pop(std::span<T> values) noexcept {
    // Acquire pairs with the writer's release: the records before head are complete.
    const std::uint64_t head = shared_detail::load<std::memory_order_acquire>(slots_.head());
    if (head - tail_ > slots_.capacity()) {
      ++breaches_;
      tail_ = head;
    }
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(head - tail_, values.size()));
    for (std::size_t i = 0; i < count; ++i) {
      shared_detail::load_record<std::memory_order_relaxed>(values[i], slots_.at(tail_ + i));
    }
    tail_ += count;
    publish();
    return count;
  }

  /// Takes the oldest record.
  /// @return false, with `value` unchanged, if there is none. \rtsafe
  bool try_pop(T& value) noexcept { return pop(std::span<T>{&value, 1}) == 1; }

  /// Number of invalid indexes from the writer; if not 0, the writer is broken or hostile. \rtsafe
  [[nodiscard]] std::uint64_t breaches() const noexcept { return breaches_; }

 private:
  // Only this object's copy of the index counts: it is stored even if nothing was taken, in case the peer has
  // overwritten it. Release: the writer may reuse these slots only after they were read.
  void publish() noexcept { shared_detail::store<std::memory_order_release>(slots_.tail(), tail_); }

  shared_detail::Slots<T> slots_;
  std::uint64_t tail_;
  std::uint64_t breaches_ = 0;
};

}  // namespace driveline::rt
