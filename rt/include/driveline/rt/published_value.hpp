#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace driveline::rt {

/// A value that one thread writes and any number of threads read as a whole: results of the cycle that change rarely.
/// The writer never waits; a reader copies again if a write came in between (a sequence lock whose words are atomic).
template <typename T>
class PublishedValue {
  static_assert(std::is_trivially_copyable_v<T>, "values are copied as bytes and must not own anything");
  static_assert(std::is_default_constructible_v<T>, "readers start with a value of their own");

 public:
  /// Readers see a default-constructed value until the first write.
  PublishedValue() noexcept { copy_in(T{}); }

  PublishedValue(const PublishedValue&) = delete;
  PublishedValue& operator=(const PublishedValue&) = delete;

  /// Publishes `value`, which read() then returns. One thread. \rtsafe
  void write(const T& value) noexcept {
    const auto version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    copy_in(value);
    version_.store(version + 2, std::memory_order_release);
  }

  /// Returns the value written last. Any thread; not for the cycle of another writer, because it may have to repeat.
  [[nodiscard]] T read() const noexcept {
    for (;;) {
      const auto before = version_.load(std::memory_order_acquire);
      const T value = copy_out();
      if (before % 2 == 0 && version_.load(std::memory_order_relaxed) == before) return value;
    }
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);

  // Release and acquire of each word: a reader that sees a word of a new value sees its odd version, too.
  void copy_in(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
  }
  [[nodiscard]] T copy_out() const noexcept {
    std::array<std::uint64_t, kWords> words{};
    for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
    T value{};
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return value;
  }

  std::atomic<std::uint64_t> version_{0};  ///< odd while a write is in progress
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace driveline::rt
