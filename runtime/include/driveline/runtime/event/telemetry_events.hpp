#pragma once

#include <chrono>
#include <cstdint>
#include <string>

/// Events of the process that publishes a line over DDS.
namespace driveline::runtime::events {

/// Nothing is published, although it was not switched off.
struct TelemetryOff {
  std::string reason;  ///< reason
};
/// The bridge has ended, and will be restarted.
struct BridgeStopped {
  std::string how;                    ///< "signal 6", "status 1"
  std::string reason;                 ///< reason in the words of the bridge; may be empty
  std::chrono::milliseconds pause{};  ///< time until the restart
};
/// The bridge shows no sign of life, as after SIGSTOP; its samples are lost.
struct BridgeStill {
  std::int32_t process = 0;             ///< process of the bridge; 0: that of a service
  std::chrono::milliseconds silence{};  ///< time since the last sign of life, at least
};
/// The bridge runs again.
struct BridgeBack {
  std::int32_t process = 0;  ///< process of the bridge; 0: that of a service
};
/// The bridge publishes, and has sent a remark.
struct BridgeRemark {
  std::string text;  ///< text of the bridge
};
/// The bridge, or a program that has taken it over, reports impossible counts. They are ignored.
struct InvalidBridgeCounts {};

}  // namespace driveline::runtime::events
