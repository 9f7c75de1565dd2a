#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

#include "driveline/rt/shared_words.hpp"

namespace driveline::rt {

/// Layout that SharedBroadcastWriter<T> and SharedBroadcastReader<T> need. Only create() uses `capacity`.
template <SharedRecord T>
[[nodiscard]] constexpr SharedLayout shared_broadcast(std::uint32_t content, std::uint32_t content_version,
                                                      std::uint64_t capacity = 0) noexcept {
  return {SharedForm::kBroadcast, content, content_version, sizeof(T), capacity};
}

/// The writing side of a broadcast: the owner of the region writes; any number of processes read, and may start and end
/// at any time. Readers cannot affect the writer, which never checks on them. A record that is not read in time is
/// overwritten; the reader detects that.
///
/// Every slot carries the number of its record, or 0 while it is being written: if the number is unchanged after a
/// reader has copied the record, the copy is intact.
///
/// Belongs to one thread. The region must outlive it.
template <SharedRecord T>
class SharedBroadcastWriter {
 public:
  /// `region` must have been created, not opened, by this process.
  /// @throws std::invalid_argument if it is not a broadcast of records of this size, or was opened.
  explicit SharedBroadcastWriter(const SharedMapping& region)
      : slots_{region, SharedForm::kBroadcast}, head_{shared_detail::load<std::memory_order_acquire>(slots_.head())} {
    if (!region.made_here()) {
      throw std::invalid_argument("shared region: only the process that made a broadcast can write to it");
    }
  }

  /// Publishes a copy of `value`. \rtsafe
  void push(const T& value) noexcept {
    std::uint64_t* const slot = slots_.at(head_);
    shared_detail::store<std::memory_order_relaxed>(slot[0], 0);
    // Release, word by word: a reader that gets one of these words also sees that the slot is being written. A fence
    // would do the same, but ThreadSanitizer does not understand fences.
    shared_detail::store_record<std::memory_order_release>(slot + 1, value);
    ++head_;
    shared_detail::store<std::memory_order_release>(slot[0], head_);
    shared_detail::store<std::memory_order_release>(slots_.head(), head_);
  }

 private:
  shared_detail::Slots<T> slots_;
  std::uint64_t head_;
};

/// The reading side of a broadcast; starts with the first record that is published after its construction. It never
/// waits for the writer: if the writer is killed in the middle of a record, that record is missing.
///
/// Belongs to one thread. The region must outlive it.
template <SharedRecord T>
class SharedBroadcastReader {
 public:
  /// Number of attempts of latest() when the writer overtakes its copy.
  static constexpr int kAttempts = 4;

  /// @throws std::invalid_argument if the region is not a broadcast of records of this size.
  explicit SharedBroadcastReader(const SharedMapping& region)
      : slots_{region, SharedForm::kBroadcast}, next_{shared_detail::load<std::memory_order_acquire>(slots_.head())} {}

  /// Takes the oldest records, as many as are available and fit; counts the records that were overwritten before.
  /// @return number of records written to the front of `values`. \rtsafe
  std::size_t take(std::span<T> values) noexcept {
    const std::uint64_t head = shared_detail::load<std::memory_order_acquire>(slots_.head());
    if (head - next_ > slots_.capacity()) {
      lost_ += head - slots_.capacity() - next_;
      next_ = head - slots_.capacity();
    }
    std::size_t count = 0;
    for (; next_ != head && count < values.size(); ++next_) {
      if (copy(next_, values[count])) {
        ++count;
      } else {
        ++lost_;
      }
    }
    return count;
  }

  /// Copies the newest record, whether or not it was taken before. The broadcast then acts as a cell with the latest
  /// value.
  /// @return false, with `value` unspecified, if there is no record yet, or if the writer overwrote it kAttempts times
  /// during the copy. \rtsafe
  [[nodiscard]] bool latest(T& value) const noexcept {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const std::uint64_t head = shared_detail::load<std::memory_order_acquire>(slots_.head());
      if (head == 0) {
        return false;
      }
      if (copy(head - 1, value)) {
        return true;
      }
    }
    return false;
  }

  /// Records that were overwritten before this reader took them. \rtsafe
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  [[nodiscard]] bool copy(std::uint64_t position, T& value) const noexcept {
    std::uint64_t* const slot = slots_.at(position);
    // The record was complete before head was advanced. Acquire, word by word: the check of its number comes after all
    // of these loads, and finds another number if the writer had started to overwrite any word.
    shared_detail::load_record<std::memory_order_acquire>(value, slot + 1);
    return shared_detail::load<std::memory_order_relaxed>(slot[0]) == position + 1;
  }

  shared_detail::Slots<T> slots_;
  std::uint64_t next_;
  std::uint64_t lost_ = 0;
};

}  // namespace driveline::rt
