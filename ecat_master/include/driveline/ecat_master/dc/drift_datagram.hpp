#pragma once

#include <cstdint>

#include "driveline/wire/datagram.hpp"

namespace driveline::ecat_master::dc {

/// The drift datagram of one cycle: four bytes of system time on their way through the line.
struct DriftDatagram {
  /// Length of its data: the low half of the system time (0x0910) is enough.
  static constexpr std::size_t kBytes = 4;
  wire::Command command = wire::Command::kNop;  ///< FRMW, FPWR or FPRD; NOP: none is sent
  wire::DatagramAddress address;                ///< the reference clock's 0x0910
  std::uint32_t time = 0;                       ///< low half of the system time it is sent with
};

/// The answer to a DriftDatagram.
struct DriftAnswer {
  std::uint32_t time = 0;             ///< low half of the reference clock's time
  std::uint16_t working_counter = 0;  ///< of the datagram; 0: no slave has answered
};

}  // namespace driveline::ecat_master::dc
