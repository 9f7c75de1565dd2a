#pragma once

#include <array>
#include <cstddef>

#include "driveline/wire/registers.hpp"

namespace driveline::slaves {

/// Who accesses the memory of a slave controller.
enum class Side : std::uint8_t { kEcat, kPdi };

/// Access right per register byte, made from the register table; bytes in no register are kNone.
class RegisterAccessMap {
 public:
  constexpr explicit RegisterAccessMap(Side side) noexcept {
    for (const auto& row : wire::kRegisters) {
      for (unsigned n = 0; n < row.count; ++n) {
        for (unsigned i = 0; i < row.size; ++i) {
          bytes_[row.address + n * row.stride + i] = side == Side::kEcat ? row.ecat : row.pdi;
        }
      }
    }
  }
  /// Precondition: `address` < 0x1000. \rtsafe
  [[nodiscard]] constexpr bool writable(std::size_t address) const noexcept {
    const auto access = bytes_[address];
    return access == wire::RegisterAccess::kWrite || access == wire::RegisterAccess::kReadWrite;
  }

 private:
  std::array<wire::RegisterAccess, wire::kProcessRamStart> bytes_{};
};

inline constexpr RegisterAccessMap kEcatAccess{Side::kEcat};
inline constexpr RegisterAccessMap kPdiAccess{Side::kPdi};

}  // namespace driveline::slaves
