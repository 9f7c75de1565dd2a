#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>

#include "driveline/rt/shared_words.hpp"

namespace driveline::rt {

/// Layout of a broadcast whose records are `record_bytes` long, for a size that is known only at run time, such as one
/// part per axis of a line. Only create() uses `capacity`.
[[nodiscard]] constexpr SharedLayout shared_blocks(std::uint32_t content, std::uint32_t content_version,
                                                   std::uint32_t record_bytes, std::uint64_t capacity = 0) noexcept {
  return {SharedForm::kBroadcast, content, content_version, record_bytes, capacity};
}

/// A SharedBroadcastWriter for records that are assembled part by part: begin(), any number of write(), commit().
/// Readers see nothing of a record before its commit(), and never a record whose writer was killed before that.
///
/// Belongs to one thread. The region must outlive it.
class SharedBlockWriter {
 public:
  /// `region` must have been created, not opened, by this process.
  /// @throws std::invalid_argument if it is not a broadcast, or was opened.
  explicit SharedBlockWriter(const SharedMapping& region)
      : words_{region.words().data()},
        mask_{region.layout().capacity - 1},
        bytes_{region.layout().record_bytes},
        head_{shared_detail::load<std::memory_order_acquire>(words_[shared_detail::kHeadWord])} {
    if (region.layout().form != SharedForm::kBroadcast || !region.made_here()) {
      throw std::invalid_argument("shared region: only the process that made a broadcast can write to it");
    }
  }

  /// Starts a record in the slot of the oldest one. \rtsafe
  void begin() noexcept { shared_detail::store<std::memory_order_relaxed>(slot()[0], 0); }

  /// Writes `value` at `offset` bytes from the start of the record, a multiple of 8. A part that does not fit is
  /// ignored. \rtsafe
  template <SharedRecord T>
  void write(std::size_t offset, const T& value) noexcept {
    if (offset % sizeof(std::uint64_t) != 0 || offset > bytes_ || sizeof(T) > bytes_ - offset) {
      return;
    }
    // Release, word by word, for the same reason as in SharedBroadcastWriter::push().
    shared_detail::store_record<std::memory_order_release>(slot() + 1 + offset / sizeof(std::uint64_t), value);
  }

  /// Publishes the record. \rtsafe
  void commit() noexcept {
    std::uint64_t* const number = slot();
    ++head_;
    shared_detail::store<std::memory_order_release>(*number, head_);
    shared_detail::store<std::memory_order_release>(words_[shared_detail::kHeadWord], head_);
  }

  /// Number of records published so far. \rtsafe
  [[nodiscard]] std::uint64_t written() const noexcept { return head_; }
  /// Number of records that fit into the region. \rtsafe
  [[nodiscard]] std::uint64_t capacity() const noexcept { return mask_ + 1; }

 private:
  [[nodiscard]] std::uint64_t* slot() const noexcept {
    return words_ + shared_detail::kRecordsWord +
           (head_ & mask_) * shared_detail::slot_words(SharedForm::kBroadcast, bytes_);
  }

  std::uint64_t* words_;
  std::uint64_t mask_;
  std::size_t bytes_;
  std::uint64_t head_;
};

/// The reading side of SharedBlockWriter, like SharedBroadcastReader. It may also continue where another reader ended.
///
/// Belongs to one thread. The region must outlive it.
class SharedBlockReader {
 public:
  /// Starts with record number `from` (the first record ever is 0), or with the oldest one still available after it.
  /// Without `from`, or if that record has not been published yet, starts with the next record to be published.
  /// @throws std::invalid_argument if the region is not a broadcast.
  explicit SharedBlockReader(const SharedMapping& region, std::optional<std::uint64_t> from = std::nullopt)
      : words_{region.words().data()}, mask_{region.layout().capacity - 1}, bytes_{region.layout().record_bytes} {
    if (region.layout().form != SharedForm::kBroadcast) {
      throw std::invalid_argument("shared region: it is not a broadcast");
    }
    const std::uint64_t now = head();
    next_ = from && *from < now ? *from : now;
  }

  /// Words per record, rounded up.
  [[nodiscard]] std::size_t record_words() const noexcept { return shared_detail::record_words(bytes_); }

  /// Copies the next record to the front of `record`, which must have room for record_words(); counts the records that
  /// were overwritten before. false: no record, or no room. Examines at most as many records as are published, whatever
  /// the writer does. \rtsafe
  [[nodiscard]] bool take(std::span<std::uint64_t> record) noexcept {
    if (record.size() < record_words()) {
      return false;
    }
    const std::uint64_t published = head();
    if (published < next_) {
      next_ = published;  // a driveline writer never goes back, so the earlier records are lost
    }
    if (published - next_ > mask_ + 1) {
      lost_ += published - next_ - (mask_ + 1);
      next_ = published - (mask_ + 1);
    }
    for (; next_ != published; ++next_) {
      if (copy(next_, record)) {
        ++next_;
        return true;
      }
      ++lost_;
    }
    return false;
  }

  /// Records that were overwritten before this reader took them. \rtsafe
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }
  /// Number of the next record. \rtsafe
  [[nodiscard]] std::uint64_t next() const noexcept { return next_; }

 private:
  [[nodiscard]] std::uint64_t head() const noexcept {
    return shared_detail::load<std::memory_order_acquire>(words_[shared_detail::kHeadWord]);
  }

  [[nodiscard]] bool copy(std::uint64_t position, std::span<std::uint64_t> record) const noexcept {
    std::uint64_t* const slot = words_ + shared_detail::kRecordsWord +
                                (position & mask_) * shared_detail::slot_words(SharedForm::kBroadcast, bytes_);
    // Acquire, word by word, for the same reason as in SharedBroadcastReader::copy().
    for (std::size_t i = 0; i < record_words(); ++i) {
      record[i] = shared_detail::load<std::memory_order_acquire>(slot[1 + i]);
    }
    return shared_detail::load<std::memory_order_relaxed>(slot[0]) == position + 1;
  }

  std::uint64_t* words_;
  std::uint64_t mask_;
  std::size_t bytes_;
  std::uint64_t next_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace driveline::rt
