#include "driveline/slaves/bit_copy.hpp"

#include <algorithm>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

bool bit_at(std::span<const std::byte> bytes, std::size_t bit) noexcept {
  return ((bytes[bit / 8] >> (bit % 8)) & std::byte{1}) != std::byte{0};
}

void set_bit(std::span<std::byte> bytes, std::size_t bit, bool value) noexcept {
  const auto mask = std::byte{1} << (bit % 8);
  bytes[bit / 8] = value ? bytes[bit / 8] | mask : bytes[bit / 8] & ~mask;
}

}  // namespace

void copy_bits(std::span<const std::byte> from, std::size_t from_bit, std::span<std::byte> to, std::size_t to_bit,
               std::size_t count) noexcept {
  std::size_t done = 0;
  if (from_bit % 8 == 0 && to_bit % 8 == 0) {
    const auto whole = from.subspan(from_bit / 8, count / 8);
    std::copy(whole.begin(), whole.end(), to.begin() + static_cast<std::ptrdiff_t>(to_bit / 8));
    done = count / 8 * 8;
  }
  for (; done < count; ++done) set_bit(to, to_bit + done, bit_at(from, from_bit + done));
}

std::uint64_t load_bits(std::span<const std::byte> from, std::size_t bit, std::size_t count) noexcept {
  std::array<std::byte, sizeof(std::uint64_t)> bytes{};
  copy_bits(from, bit, bytes, 0, std::min<std::size_t>(count, 64));
  return bytes::load_le<std::uint64_t>(bytes);
}

void store_bits(std::span<std::byte> to, std::size_t bit, std::size_t count, std::uint64_t value) noexcept {
  copy_bits(bytes::to_le_bytes(value), 0, to, bit, std::min<std::size_t>(count, 64));
}

}  // namespace driveline::slaves
