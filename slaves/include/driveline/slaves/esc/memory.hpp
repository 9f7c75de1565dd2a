#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "driveline/wire/endian.hpp"
#include "driveline/wire/registers.hpp"

namespace driveline::slaves {

/// The physical address space of a slave controller: registers 0x0000-0x0FFF and process RAM behind them. Plain
/// storage; the units implement the effect of an access. Bytes of reserved and write-only registers stay zero.
class EscMemory {
 public:
  /// `ram_kib` KiB of process RAM, at most 60 (the address space ends at 64 KiB).
  explicit EscMemory(std::size_t ram_kib)
      : bytes_(wire::kProcessRamStart + std::min<std::size_t>(ram_kib, kMaxRamKib) * 1024) {}

  /// Process RAM that the 64 KiB of addresses leave room for.
  static constexpr std::size_t kMaxRamKib = 60;

  /// First address that does not exist any more.
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size(); }

  /// Precondition: the range exists. \rtsafe
  [[nodiscard]] std::span<std::byte> at(std::size_t address, std::size_t length) noexcept {
    return std::span(bytes_).subspan(address, length);
  }
  /// The same, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> at(std::size_t address, std::size_t length) const noexcept {
    return std::span(bytes_).subspan(address, length);
  }

  /// Value of element `n` of a register. \rtsafe
  template <typename T>
  [[nodiscard]] T get(const wire::Register<T>& reg, unsigned n = 0) const noexcept {
    return wire::load_le<T>(at(reg.at(n), sizeof(T)));
  }
  /// Sets element `n` of a register, past all access rules. \rtsafe
  template <typename T>
  void set(const wire::Register<T>& reg, std::type_identity_t<T> value, unsigned n = 0) noexcept {
    wire::store_le<T>(at(reg.at(n), sizeof(T)), value);
  }

  /// All registers and the process RAM read zero. \rtsafe
  void clear() noexcept { std::fill(bytes_.begin(), bytes_.end(), std::byte{0}); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace driveline::slaves
