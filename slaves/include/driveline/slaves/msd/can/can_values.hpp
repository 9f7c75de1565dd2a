#pragma once

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {

/// Values of the object dictionary that the CANopen front end uses; their slots follow those of the drive.
struct CanValues : SlotNumbers {
  constexpr CanValues() noexcept : SlotNumbers(kValue.end()) {}
  Slot<std::uint8_t> address{next()};                ///< P 2005
  Slot<std::uint16_t> bit_rate{next()};              ///< P 2006, in kbit/s
  SlotArray<std::uint32_t, 8> event_masks{next(8)};  ///< P 2007
  Slot<std::uint32_t> communication_cycle{next()};   ///< 1006h, P 2015, in us
  Slot<std::uint8_t> active_address{next()};         ///< P 2058
  Slot<std::uint16_t> active_bit_rate{next()};       ///< P 2059, in kbit/s
  Slot<std::uint8_t> telegram{next()};               ///< P 2061
  Slot<std::uint32_t> telegram_time_out{next()};     ///< P 2062, in ms
};

/// The slots of these values.
inline constexpr CanValues kCanValue{};

}  // namespace driveline::slaves::msd
