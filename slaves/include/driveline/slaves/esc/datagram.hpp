#pragma once

#include <cstdint>
#include <span>

#include "driveline/wire/datagram.hpp"

namespace driveline::slaves {

/// A datagram on its way through the line: header fields taken out of the frame once, data still in it.
struct Datagram {
  wire::Command command = wire::Command::kNop;  ///< decides the meaning of `adp` and `ado`
  std::uint16_t adp = 0;                        ///< position, station address, or low half of the logical address
  std::uint16_t ado = 0;                        ///< physical address, or high half of the logical address
  std::uint16_t irq = 0;                        ///< event field: every slave ORs its requests in
  std::uint16_t working_counter = 0;            ///< every slave adds its increments
  std::span<std::byte> data;                    ///< in the frame itself: changed in place
  std::uint16_t header_offset = 0;              ///< in its frame

  /// For LRD, LWR and LRW: `ado` above `adp`. \rtsafe
  [[nodiscard]] std::uint32_t logical_address() const noexcept {
    return static_cast<std::uint32_t>(adp) | (static_cast<std::uint32_t>(ado) << 16);
  }
};

}  // namespace driveline::slaves
