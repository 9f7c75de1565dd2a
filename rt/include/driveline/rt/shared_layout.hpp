#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "driveline/rt/cache_line.hpp"

namespace driveline::rt {

/// How records are arranged in a shared region, and which side may write.
enum class SharedForm : std::uint32_t {
  kRing = 1,       ///< SharedRingWriter to SharedRingReader; both sides can write to the whole region
  kBroadcast = 2,  ///< SharedBroadcastWriter to SharedBroadcastReader; only the creating process can write
};

/// Whether the seals of a region are complete.
enum class SharedSealing : std::uint8_t {
  kComplete,  ///< the size is fixed, and nothing can be sealed any more
  /// The size is fixed. The creating process adds the other seals when its peer has mapped the region
  /// (SharedRegion::close_to_writers()).
  kSizeOnly,
};

/// What the two sides of a region must agree on.
struct SharedLayout {
  SharedForm form = SharedForm::kRing;  ///< ring or broadcast
  std::uint32_t content = 0;            ///< kind of the records: a number that the two programs agree on
  std::uint32_t content_version = 0;    ///< changes when the fields of the record change
  std::uint32_t record_bytes = 0;       ///< size of a record in bytes
  /// Number of records that fit; create() rounds up to a power of two, open() accepts any number if it is 0.
  std::uint64_t capacity = 0;

  /// Compares all fields.
  friend bool operator==(const SharedLayout&, const SharedLayout&) = default;
};

/// Arrangement of the words of a region; for the handles.
namespace shared_detail {

static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free, "a lock would not reach into the other process");

inline constexpr std::size_t kLineWords = kCacheLineBytes / sizeof(std::uint64_t);
inline constexpr std::size_t kHeadWord = kLineWords;         // number of records ever written; the header precedes it
inline constexpr std::size_t kTailWord = 2 * kLineWords;     // number of records ever read
inline constexpr std::size_t kRecordsWord = 3 * kLineWords;  // the first record

/// Number of words of a record of `record_bytes`; in a broadcast another word precedes it.
constexpr std::size_t record_words(std::size_t record_bytes) noexcept {
  return (record_bytes + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
}

constexpr std::size_t slot_words(SharedForm form, std::size_t record_bytes) noexcept {
  return record_words(record_bytes) + (form == SharedForm::kBroadcast ? 1 : 0);
}

// The other process may write at any time, so every access is atomic and happens exactly once.
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
