#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "driveline/wire/al_status_code.hpp"

namespace driveline::slaves {

/// Synchronisation types, coded as in 1C32h:01 and 1C33h:01 (ETG.1020 Table 60). kSmEvent is the event of the sync
/// manager itself; inputs of a device with outputs may follow the event of the outputs instead, kSm2Event.
enum class SyncType : std::uint16_t { kFreeRun = 0, kSmEvent = 1, kSync0 = 2, kSync1 = 3, kSm2Event = 0x22 };

/// Returns the index of the object with the synchronisation of a sync manager: 1C30h + its number. \rtsafe
[[nodiscard]] constexpr std::uint16_t sync_parameter_object(std::size_t sync_manager) noexcept {
  return static_cast<std::uint16_t>(0x1C30 + sync_manager);
}

/// Synchronisation types that the application of a device supports, and its settings.
struct SyncDemand {
  /// Type selected in 1C32h:01; empty: any type that the master activates.
  std::optional<SyncType> type;
  /// Type selected in 1C33h:01; empty: that of the outputs.
  std::optional<SyncType> input_type{};
  bool free_run = true;  ///< type 0 is supported: no synchronisation
  bool sm_event = true;  ///< type 1 is supported: outputs take effect when the frame has written them
  bool sync0 = true;     ///< type 2 is supported: outputs take effect at SYNC0
  bool sync1 = false;    ///< type 3 is supported: outputs take effect at SYNC1
  bool outputs = true;   ///< the device has outputs, whose event its inputs may follow
  /// Cycle that the application is set to (1C32h:02, 60C2h); 0: any.
  std::chrono::nanoseconds cycle{0};
  /// Cycle in which the application needs new outputs, at every n-th pulse; 0, or less than a pulse: at every pulse.
  std::chrono::nanoseconds outputs_cycle{0};
  /// Time before a pulse at which its outputs must be complete (1C32h:06, calc and copy time).
  std::chrono::nanoseconds calc_and_copy{0};
  /// The SYNC0 cycle must be a multiple of this; 0: any cycle.
  std::chrono::nanoseconds time_base{0};
  std::chrono::nanoseconds min_cycle{0};                                 ///< shortest SYNC0 cycle
  std::chrono::nanoseconds max_cycle = std::chrono::nanoseconds::max();  ///< longest SYNC0 cycle
  /// Sync error counter limit (10F1h:02): a cycle without new outputs adds 3, a cycle with new outputs subtracts 1, and
  /// a count above the limit is an error; 0: no error.
  unsigned error_limit = 0;
};

/// The two signals of the SYNC out unit.
enum class SyncSignal : std::uint8_t { kSync0, kSync1 };

/// Whether the code reports a loss of synchronisation (ETG.1020, AL status codes). \rtsafe
[[nodiscard]] constexpr bool is_sync_error(wire::AlStatusCode code) noexcept {
  switch (code) {
    case wire::AlStatusCode::kSynchronizationError:
    case wire::AlStatusCode::kFatalSyncError:
    case wire::AlStatusCode::kNoSyncError:
    case wire::AlStatusCode::kPllError:
    case wire::AlStatusCode::kDcSyncIoError:
    case wire::AlStatusCode::kDcSyncTimeout:
      return true;
    default:
      return false;
  }
}

}  // namespace driveline::slaves
