#pragma once

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {

/// Values of the object dictionary that the EtherCAT front end uses; their slots follow those of the drive.
struct EtherCatValues : SlotNumbers {
  constexpr EtherCatValues() noexcept : SlotNumbers(kValue.end()) {}
  Slot<std::uint16_t> sync_type_outputs{next()};      ///< 1C32h:01
  Slot<std::uint16_t> sync_type_inputs{next()};       ///< 1C33h:01
  Slot<std::uint32_t> sync_cycle{next()};             ///< 1C32h:02, 1C33h:02
  Slot<std::uint16_t> sync_error_limit{next()};       ///< 10F1h:02
  Slot<std::uint16_t> sync_events_missed{next()};     ///< 1C32h:0B, 1C33h:0B
  Slot<std::uint16_t> sync_cycles_exceeded{next()};   ///< 1C32h:0C, 1C33h:0C
  Slot<std::uint16_t> sync_shifts_too_short{next()};  ///< 1C32h:0D, 1C33h:0D
  Slot<std::uint32_t> sync_distance_min{next()};      ///< 1C32h:11
  Slot<std::uint32_t> sync_distance_max{next()};      ///< 1C32h:12
  Slot<bool> sync_error{next()};                      ///< 1C32h:20, 1C33h:20
};

/// The slots of these values.
inline constexpr EtherCatValues kBusValue{};

}  // namespace driveline::slaves::msd
