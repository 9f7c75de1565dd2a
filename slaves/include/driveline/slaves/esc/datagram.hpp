#pragma once

#include <cstdint>
#include <span>

#include "driveline/wire/datagram.hpp"

namespace driveline::slaves {

/// A datagram on its way through the line: header fields taken out of the frame once, data still in it.
struct Datagram {
  wire::Command command = wire::Command::kNop;
  std::uint16_t adp = 0;
  std::uint16_t ado = 0;
  std::uint16_t irq = 0;
  std::uint16_t working_counter = 0;
  std::span<std::byte> data;
  std::uint16_t header_offset = 0;  ///< in its frame

  [[nodiscard]] std::uint32_t logical_address() const noexcept {
    return static_cast<std::uint32_t>(adp) | (static_cast<std::uint32_t>(ado) << 16);
  }
};

}  // namespace driveline::slaves
