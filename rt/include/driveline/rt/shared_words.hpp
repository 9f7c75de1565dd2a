#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "driveline/rt/shared_layout.hpp"
#include "driveline/rt/shared_mapping.hpp"

namespace driveline::rt {

/// A type that can be passed through a shared region, where it is copied byte by byte. Every bit pattern must be a
/// valid value of its fields, because the peer may write any: integers, floating point and enumerations with a fixed
/// underlying type, but no `bool`, pointer or reference.
template <typename T>
concept SharedRecord = std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T> && !std::is_pointer_v<T> &&
                       !std::is_same_v<T, bool>;

namespace shared_detail {

template <std::memory_order kOrder, SharedRecord T>
void store_record(std::uint64_t* words, const T& value) noexcept {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  for (std::size_t at = 0; at < sizeof(T); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + at, std::min(sizeof(word), sizeof(T) - at));
    store<kOrder>(*words++, word);
  }
}

template <std::memory_order kOrder, SharedRecord T>
void load_record(T& value, std::uint64_t* words) noexcept {
  auto* bytes = reinterpret_cast<std::byte*>(&value);
  for (std::size_t at = 0; at < sizeof(T); at += sizeof(std::uint64_t)) {
    const std::uint64_t word = load<kOrder>(*words++);
    std::memcpy(bytes + at, &word, std::min(sizeof(word), sizeof(T) - at));
  }
}

/// The words of a region with records of type T.
template <SharedRecord T>
class Slots {
 public:
  Slots(const SharedMapping& region, SharedForm form)
      : words_{region.words().data()}, mask_{region.layout().capacity - 1} {
    if (region.layout().form != form || region.layout().record_bytes != sizeof(T)) {
      throw std::invalid_argument("shared region: it has another form, or records of another size, than its user");
    }
    stride_ = slot_words(form, sizeof(T));
  }

  [[nodiscard]] std::uint64_t& head() const noexcept { return words_[kHeadWord]; }
  [[nodiscard]] std::uint64_t& tail() const noexcept { return words_[kTailWord]; }
  [[nodiscard]] std::uint64_t* at(std::uint64_t position) const noexcept {
    return words_ + kRecordsWord + (position & mask_) * stride_;
  }
  [[nodiscard]] std::uint64_t capacity() const noexcept { return mask_ + 1; }

 private:
  std::uint64_t* words_;
  std::uint64_t mask_;
  std::size_t stride_ = 0;
};

}  // namespace shared_detail
}  // namespace driveline::rt
