#pragma once

#include <array>
#include <cstddef>

#include "driveline/wire/registers.hpp"

namespace driveline::slaves {

/// The side that accesses the memory of a slave controller. The master by datagrams, or the application by the process
/// data interface.
enum class Side : std::uint8_t { kEcat, kPdi };

/// Which bits of each register byte a side may write, made from the register table; none in bytes of no register.
class RegisterAccessMap {
 public:
  /// Allocates nothing; meant to be built by the compiler.
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
  /// Precondition: `address` < 0x1000. \rtsafe
  [[nodiscard]] constexpr bool writable(std::size_t address) const noexcept { return writable_[address]; }
  /// The byte stored when the side writes `value`: reserved bits stay zero. \rtsafe
  [[nodiscard]] constexpr std::byte accepted(std::size_t address, std::byte value) const noexcept {
    return value & bits_[address];
  }

 private:
  std::array<std::byte, wire::kProcessRamStart> bits_{};
  std::array<bool, wire::kProcessRamStart> writable_{};
};

/// Access of datagrams.
inline constexpr RegisterAccessMap kEcatAccess{Side::kEcat};
/// Access of the application.
inline constexpr RegisterAccessMap kPdiAccess{Side::kPdi};

}  // namespace driveline::slaves
