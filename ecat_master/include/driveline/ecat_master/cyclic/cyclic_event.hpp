#pragma once

#include <cstdint>
#include <type_traits>

namespace driveline::ecat_master {

/// An event detected by the cycle, for the history that an ordinary thread records.
struct CyclicEvent {
  /// Kind of event.
  enum class Kind : std::uint8_t {
    kSlaveState,      ///< `before` and `after`: low byte of the AL status; 0: the slave is absent
    kWorkingCounter,  ///< `before`: expected, `after`: received value of a group, when it changes
    kFrameLost,       ///< `after`: frames of a group lost in this cycle
    kOutputsZeroed,   ///< a group reached its limit of bad cycles
  };
  Kind kind = Kind::kSlaveState;  ///< defines the meaning of the members below
  std::uint16_t index = 0;        ///< number of the slave or group
  std::uint16_t before = 0;       ///< see Kind
  std::uint16_t after = 0;        ///< see Kind
  std::uint64_t cycle = 0;        ///< number of the cycle that detected it
  std::int64_t time_ns = 0;       ///< grid time of the cycle
};
static_assert(std::is_trivially_copyable_v<CyclicEvent>);

}  // namespace driveline::ecat_master
