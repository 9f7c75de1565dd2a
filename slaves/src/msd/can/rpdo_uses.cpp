#include "driveline/slaves/msd/can/rpdo_uses.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint32_t kFirstEventType = 254;    ///< transmission types FEh and FFh
constexpr std::uint32_t kSetpoint = 0x60C1'0120;  ///< 60C1h:01 with its 32 bits, as a mapping entry

}  // namespace

RpdoUses::RpdoUses(ObjectDictionary& dictionary) noexcept : dictionary_(&dictionary) {
  for (std::size_t i = 0; i < kCanPdos; ++i) {
    rx_types_[i] = {dictionary, static_cast<std::uint16_t>(0x1400 + i), 2};
    tx_types_[i] = {dictionary, static_cast<std::uint16_t>(0x1800 + i), 2};
  }
}

void RpdoUses::update() noexcept {
  for (std::size_t i = 0; i < kCanPdos; ++i) {
    const auto mapping = static_cast<std::uint16_t>(0x1600 + i);
    const std::uint32_t count = cia301::Entry(*dictionary_, mapping, 0).value();
    setpoint_[i] = false;
    for (std::uint32_t sub = 1; sub <= count; ++sub) {
      const cia301::Entry entry(*dictionary_, mapping, static_cast<std::uint8_t>(sub));
      setpoint_[i] = setpoint_[i] || entry.value() == kSetpoint;
    }
  }
}

bool RpdoUses::is_answered(std::size_t number) const noexcept {
  return rx_types_[number].value() >= kFirstEventType && tx_types_[number].value() >= kFirstEventType;
}

}  // namespace driveline::slaves::msd
