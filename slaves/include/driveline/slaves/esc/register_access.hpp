#pragma once

#include <array>
#include <cstddef>

#include "driveline/wire/registers.hpp"

namespace driveline::slaves {

/// The side that accesses the memory of a slave controller: the master by datagrams, or the application over the
/// process data interface.
enum class Side : std::uint8_t { kEcat, kPdi };

/// Bits of each register byte that a side may write, from the register table; none in bytes that belong to no register.
class RegisterAccessMap {
 public:
  /// Does not allocate; intended for compile-time evaluation.
  constexpr explicit RegisterAccessMap(Side side) noexcept {
    for (const auto& row : wire::kRegisters) {
      const auto access = side == Side::kEcat ? row.ecat : row.pdi;
      if (access != wire::RegisterAccess::kWrite && access != wire::RegisterAccess::kReadWrite) continue;
      for (unsigned n = 0; n < row.count; ++n) {
        for (unsigned i = 0; i < row.size; ++i) {
          bits_[row.address + n * row.stride + i] = static_cast<std::byte>(row.bits >> (8 * i) & 0xFF);
          writable_[row.address + n * row.stride + i] = true;
        }
      }
    }
  }
  /// Whether the side may write the byte. Precondition: `address` < 0x1000. \rtsafe
  [[nodiscard]] constexpr bool writable(std::size_t address) const noexcept { return writable_[address]; }
  /// Returns the byte that is stored when the side writes `value`: reserved bits stay zero. \rtsafe
  [[nodiscard]] constexpr std::byte accepted(std::size_t address, std::byte value) const noexcept {
    return value & bits_[address];
  }

 private:
  std::array<std::byte, wire::kProcessRamStart> bits_{};
  std::array<bool, wire::kProcessRamStart> writable_{};
};

/// Write access of datagrams.
inline constexpr RegisterAccessMap kEcatAccess{Side::kEcat};
/// Write access of the application.
inline constexpr RegisterAccessMap kPdiAccess{Side::kPdi};

}  // namespace driveline::slaves
