#pragma once

#include <chrono>
#include <cstdint>
#include <string>

/// Events of the process that publishes a line over DDS.
namespace driveline::runtime::events {

/// Nothing is published, though nobody has asked for that.
struct TelemetryOff {
  std::string reason;  ///< why
};
/// The bridge has ended, and is started again.
struct BridgeStopped {
  std::string how;                    ///< "signal 6", "status 1"
  std::string reason;                 ///< in its own words; may be empty
  std::chrono::milliseconds pause{};  ///< until it is started again
};
/// It runs again.
struct BridgeBack {
  std::int32_t process = 0;  ///< that is the bridge now
};
/// The bridge publishes, and has something to say of it.
struct BridgeRemark {
  std::string text;  ///< in its own words
};
/// The bridge, or who has taken it over, tells counts that cannot be. They are left out.
struct BridgeUnbelieved {};

}  // namespace driveline::runtime::events
