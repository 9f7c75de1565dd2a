#pragma once

#include <cstdint>

#include "driveline/wire/datagram.hpp"

namespace driveline::ecat_master::dc {

/// The drift datagram of one cycle: four bytes of system time on their way through the line.
struct DriftDatagram {
  static constexpr std::size_t kBytes = 4;
  wire::Command command = wire::Command::kNop;
  wire::DatagramAddress address;
  std::uint32_t time = 0;
};

/// The same as it came back.
struct DriftAnswer {
  std::uint32_t time = 0;
  std::uint16_t working_counter = 0;
};

}  // namespace driveline::ecat_master::dc
