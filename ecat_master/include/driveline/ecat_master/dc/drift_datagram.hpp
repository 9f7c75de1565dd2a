#pragma once

#include <cstdint>

#include "driveline/wire/datagram.hpp"

namespace driveline::ecat_master::dc {

/// The drift datagram of a cycle: it carries four bytes of system time through the line.
struct DriftDatagram {
  /// Length of its data in bytes: the low half of the system time (0x0910) is enough.
  static constexpr std::size_t kBytes = 4;
  wire::Command command = wire::Command::kNop;  ///< FRMW, FPWR or FPRD; NOP: none is sent
  wire::DatagramAddress address;                ///< register 0x0910 of the reference clock
  std::uint32_t time = 0;                       ///< low half of the system time sent
};

/// The answer to a DriftDatagram.
struct DriftAnswer {
  std::uint32_t time = 0;             ///< low half of the reference clock's time
  std::uint16_t working_counter = 0;  ///< working counter of the datagram; 0: no slave answered
};

}  // namespace driveline::ecat_master::dc
