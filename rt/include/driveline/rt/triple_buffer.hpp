#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "driveline/rt/cache_line.hpp"

namespace driveline::rt {

/// Passes the latest value from one writer thread to one reader thread, wait-free on both sides: commands into the
/// cycle, states out of it. Values that the reader does not fetch in time are overwritten; a value is never torn.
///
/// One of the three slots belongs to the writer, another one to the reader, and they exchange the third.
template <typename T>
class TripleBuffer {
  static_assert(std::is_trivially_copyable_v<T>, "values are copied as bytes and must not own anything");

 public:
  /// The reader sees `initial` until the first write.
  explicit TripleBuffer(const T& initial = T{}) noexcept {
    for (Slot& slot : slots_) {
      slot.value = initial;
    }
  }

  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Writer: makes `value` the latest. \rtsafe
  void write(const T& value) noexcept {
    slots_[writer_slot_].value = value;
    // Release: the reader that takes this slot sees its content. Acquire: the slot received in exchange is no longer
    // being read.
    writer_slot_ = exchanged_.exchange(writer_slot_ | kFresh, std::memory_order_acq_rel) & kSlotMask;
  }

  /// Reader: takes the latest value if it is new.
  /// @return whether read() now returns a new value. \rtsafe
  bool update() noexcept {
    // A relaxed load suffices: if it misses a value just written, the next call finds it; the exchange orders the data.
    if ((exchanged_.load(std::memory_order_relaxed) & kFresh) == 0) {
      return false;
    }
    // Acquire: the slot's content. Release: this thread has finished reading the slot that it returns.
    reader_slot_ = exchanged_.exchange(reader_slot_, std::memory_order_acq_rel) & kSlotMask;
    return true;
  }

  /// Reader: the value taken last; valid and unchanged until the next update(). \rtsafe
  [[nodiscard]] const T& read() const noexcept { return slots_[reader_slot_].value; }

 private:
  static constexpr std::uint32_t kFresh = 4;  // the exchanged slot holds a value that the reader has not seen
  static constexpr std::uint32_t kSlotMask = 3;

  struct alignas(kCacheLineBytes) Slot {
    T value;
  };

  std::array<Slot, 3> slots_;
  alignas(kCacheLineBytes) std::uint32_t writer_slot_ = 0;
  alignas(kCacheLineBytes) std::uint32_t reader_slot_ = 1;
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> exchanged_{2};
};

}  // namespace driveline::rt
