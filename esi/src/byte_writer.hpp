#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/bytes/endian.hpp"

namespace driveline::esi {

/// Appends little-endian numbers and bytes to a growing buffer.
class ByteWriter {
 public:
  template <bytes::Integer T>
  void number(T value) {
    const auto bytes = bytes::to_le_bytes(value);
    raw(bytes);
  }
  template <bytes::Integer T, std::size_t N>
  void numbers(const std::array<T, N>& values) {
    for (const T value : values) number(value);
  }
  void raw(std::span<const std::byte> bytes) {
    for (const std::byte b : bytes) bytes_.push_back(b);
  }
  void text(std::string_view characters) {
    for (const char c : characters) bytes_.push_back(static_cast<std::byte>(c));
  }
  void pad_to(std::size_t size, std::byte value) {
    if (bytes_.size() < size) bytes_.resize(size, value);
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace driveline::esi
