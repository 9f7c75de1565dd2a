#pragma once

#include <cstdint>

namespace driveline::canopen {

/// Settings of a bus that the adapter is asked for when it is opened.
struct CanPortOptions {
  std::uint32_t bit_rate = 1'000'000;  ///< in bit/s: one of 10000, 20000, 50000, 100000, 125000, 250000, 500000,
                                       ///< 800000, 1000000; adapters whose rate is set elsewhere ignore it
  bool listen_only = false;            ///< receives without acknowledging, where the adapter can
  bool error_frames = false;           ///< reports error frames, where the adapter can
  bool automatic_recovery = false;     ///< a simulated bus only: returns from bus off by itself, as adapters do that
                                       ///< are set up so (SocketCAN: restart-ms)
};

}  // namespace driveline::canopen
