#pragma once

#include <cstddef>

/// Time on the wire: 100BASE-TX, the only speed of EtherCAT (ETG.1000.2).
namespace driveline::wire {

/// Transmission time of a byte at 100 Mbit/s, in ns.
inline constexpr unsigned kNsPerByte = 80;
/// Bytes around each frame: preamble with start delimiter, FCS, gap to the next frame (IEEE 802.3).
inline constexpr std::size_t kPreambleFcsGap = 8 + 4 + 12;

}  // namespace driveline::wire
