#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

#include "driveline/bytes/endian.hpp"

namespace driveline::esi {

/// Takes little-endian numbers and bytes from the front of a buffer. Precondition of each read: left() is large enough.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes), size_(bytes.size()) {}

  template <bytes::Integer T>
  [[nodiscard]] T number() {
    return bytes::load_le<T>(raw(sizeof(T)));
  }
  template <bytes::Integer T>
  void read(T& value) {
    value = number<T>();
  }
  template <bytes::Integer T, std::size_t N>
  void read(std::array<T, N>& values) {
    for (T& value : values) value = number<T>();
  }
  [[nodiscard]] std::span<const std::byte> raw(std::size_t size) {
    assert(size <= rest_.size());
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  [[nodiscard]] std::vector<std::byte> take_rest() {
    const auto taken = raw(rest_.size());
    return {taken.begin(), taken.end()};
  }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  [[nodiscard]] std::size_t position() const { return size_ - rest_.size(); }

 private:
  std::span<const std::byte> rest_;
  std::size_t size_;
};

}  // namespace driveline::esi
