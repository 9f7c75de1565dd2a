#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/registers.hpp"

namespace driveline::slaves {

/// The physical address space of a slave controller: registers 0x0000-0x0FFF, followed by process RAM. Plain storage;
/// the units implement the effects of accesses. Bytes of reserved and write-only registers stay zero.
class EscMemory {
 public:
  /// `ram_kib` KiB of process RAM, at most 60 (the address space ends at 64 KiB).
  explicit EscMemory(std::size_t ram_kib)
      : bytes_(wire::kProcessRamStart + std::min<std::size_t>(ram_kib, kMaxRamKib) * 1024) {}

  /// Maximum process RAM in the address space of 64 KiB.
  static constexpr std::size_t kMaxRamKib = 60;

  /// Returns the end of the memory: the first address that does not exist.
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size(); }

  /// Returns a range of memory. Precondition: the range exists. \rtsafe
  [[nodiscard]] std::span<std::byte> at(std::size_t address, std::size_t length) noexcept {
    return std::span(bytes_).subspan(address, length);
  }
  /// Returns a range of memory, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> at(std::size_t address, std::size_t length) const noexcept {
    return std::span(bytes_).subspan(address, length);
  }

  /// Returns the value of element `n` of a register. \rtsafe
  template <typename T>
  [[nodiscard]] T get(const wire::Register<T>& reg, unsigned n = 0) const noexcept {
    return bytes::load_le<T>(at(reg.at(n), sizeof(T)));
  }
  /// Sets element `n` of a register, bypassing the access rules. \rtsafe
  template <typename T>
  void set(const wire::Register<T>& reg, std::type_identity_t<T> value, unsigned n = 0) noexcept {
    bytes::store_le<T>(at(reg.at(n), sizeof(T)), value);
  }

  /// Sets all registers and the process RAM to zero. \rtsafe
  void clear() noexcept { std::fill(bytes_.begin(), bytes_.end(), std::byte{0}); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace driveline::slaves
