#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace driveline::bridge::test {

using Bytes = std::vector<std::uint8_t>;

/// A message composed by the definition of its parts (OMG CORBA 15.3, plain CDR): every value is aligned to its size,
/// counted from after the four bytes of the encapsulation header. Independent of the generated code.
class Cdr {
 public:
  void number(std::uint64_t value, std::size_t size) {
    while (bytes_.size() % size != 0) bytes_.push_back(0);
    for (std::size_t i = 0; i < size; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  }
  void real(double value) { number(std::bit_cast<std::uint64_t>(value), 8); }
  void text(const std::string& value) {
    number(value.size() + 1, 4);
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    bytes_.push_back(0);
  }
  [[nodiscard]] Bytes message() const {
    Bytes all{0, 1, 0, 0};  // CDR, little endian
    all.insert(all.end(), bytes_.begin(), bytes_.end());
    return all;
  }

 private:
  Bytes bytes_;
};

}  // namespace driveline::bridge::test
