#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/cache_line.hpp"

namespace driveline::rt {

/// How the records lie in a shared region, and which side may write.
enum class SharedForm : std::uint32_t {
  kRing = 1,       ///< SharedRingWriter to SharedRingReader; both sides can write everywhere
  kBroadcast = 2,  ///< SharedBroadcastWriter to SharedBroadcastReader; only the process that created it can write
};

/// What the two sides of a region must agree on.
struct SharedLayout {
  SharedForm form = SharedForm::kRing;  ///< ring or broadcast
  std::uint32_t content = 0;            ///< which records: a number that the two programs have agreed on
  std::uint32_t content_version = 0;    ///< changes with the fields of the record
  std::uint32_t record_bytes = 0;       ///< size of one record
  /// Records that fit in; create() rounds up to a power of two, open() takes 0 for any number.
  std::uint64_t capacity = 0;

  /// Equal in every field.
  friend bool operator==(const SharedLayout&, const SharedLayout&) = default;
};

/// How the words of a region are used; for the handles.
namespace shared_detail {

static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free, "a lock would not reach into the other process");

inline constexpr std::size_t kLineWords = kCacheLineBytes / sizeof(std::uint64_t);
inline constexpr std::size_t kHeadWord = kLineWords;         // records ever written, the header is before
inline constexpr std::size_t kTailWord = 2 * kLineWords;     // records ever read
inline constexpr std::size_t kRecordsWord = 3 * kLineWords;  // the first record

/// Words that hold one record of `record_bytes`; in a broadcast one more stands before it.
constexpr std::size_t record_words(std::size_t record_bytes) noexcept {
  return (record_bytes + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
}

constexpr std::size_t slot_words(SharedForm form, std::size_t record_bytes) noexcept {
  return record_words(record_bytes) + (form == SharedForm::kBroadcast ? 1 : 0);
}

// The other process may write at any time: every access is atomic, and so happens once.
template <std::memory_order kOrder>
std::uint64_t load(std::uint64_t& word) noexcept {
  return std::atomic_ref{word}.load(kOrder);
}

template <std::memory_order kOrder>
void store(std::uint64_t& word, std::uint64_t value) noexcept {
  std::atomic_ref{word}.store(value, kOrder);
}

}  // namespace shared_detail
}  // namespace driveline::rt
