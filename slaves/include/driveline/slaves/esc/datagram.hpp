#pragma once

#include <cstdint>
#include <span>

#include "driveline/wire/datagram.hpp"

namespace driveline::slaves {

/// A datagram that passes the line: header fields decoded once, data still in the frame.
struct Datagram {
  wire::Command command = wire::Command::kNop;  ///< determines the meaning of `adp` and `ado`
  std::uint16_t adp = 0;                        ///< position, station address, or low half of the logical address
  std::uint16_t ado = 0;                        ///< physical address, or high half of the logical address
  std::uint16_t irq = 0;                        ///< event field: every slave ORs its event requests into it
  std::uint16_t working_counter = 0;            ///< every slave adds its increments
  std::span<std::byte> data;                    ///< data in the frame, changed in place
  std::uint16_t header_offset = 0;              ///< offset of the header in the frame

  /// Returns the logical address of LRD, LWR and LRW: `ado` is the upper half, `adp` the lower half. \rtsafe
  [[nodiscard]] std::uint32_t logical_address() const noexcept {
    return static_cast<std::uint32_t>(adp) | (static_cast<std::uint32_t>(ado) << 16);
  }
};

}  // namespace driveline::slaves
