#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace driveline::slaves {

/// Synchronisation types as 1C32h:01 and 1C33h:01 code them (ETG.1020 Table 60).
enum class SyncType : std::uint16_t { kFreeRun = 0, kSmEvent = 1, kSync0 = 2, kSync1 = 3 };

/// Synchronisation types that the application of a device supports, and its settings.
struct SyncDemand {
  /// The type that is set in 1C32h:01; nothing: any type that the master activates.
  std::optional<SyncType> type;
  bool free_run = true;  ///< types the application supports
  bool sm_event = true;  ///< type 1: outputs act when the frame has written them
  bool sync0 = true;     ///< type 2: outputs act at SYNC0
  bool sync1 = false;    ///< type 3: outputs act at SYNC1
  /// Cycle the application is set to (1C32h:02, 60C2h); 0: it takes any.
  std::chrono::nanoseconds cycle{0};
  /// SYNC0 must come in multiples of this; 0: any cycle.
  std::chrono::nanoseconds time_base{0};
  std::chrono::nanoseconds min_cycle{0};                                 ///< shortest SYNC0 cycle
  std::chrono::nanoseconds max_cycle = std::chrono::nanoseconds::max();  ///< longest one
  /// Sync error counter limit (10F1h:02): a cycle without new outputs counts 3 up, one with them 1 down, above the
  /// limit it is an error; 0: never.
  unsigned error_limit = 0;
};

/// The two signals of the SYNC out unit.
enum class SyncSignal : std::uint8_t { kSync0, kSync1 };

}  // namespace driveline::slaves
