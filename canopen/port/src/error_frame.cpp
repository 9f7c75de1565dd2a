#include "error_frame.hpp"

#include "driveline/canopen_wire/socketcan.hpp"

namespace driveline::canopen {
namespace {

/// State of the controller in data[1] (CAN_ERR_CRTL_...).
namespace controller_flag {
constexpr std::uint8_t kOverflow = 0x03;  // of the receive or the transmit buffer
constexpr std::uint8_t kWarning = 0x0C;   // receive or transmit errors
constexpr std::uint8_t kPassive = 0x30;
constexpr std::uint8_t kActive = 0x40;
}  // namespace controller_flag

void apply_controller_state(PortStatistics& counters, std::uint8_t flags) noexcept {
  if ((flags & controller_flag::kOverflow) != 0) ++counters.lost;
  if ((flags & controller_flag::kPassive) != 0) {
    counters.state = BusState::kErrorPassive;
  } else if ((flags & controller_flag::kWarning) != 0) {
    counters.state = BusState::kErrorWarning;
  } else if ((flags & controller_flag::kActive) != 0) {
    counters.state = BusState::kErrorActive;
  }
}

}  // namespace

void apply_error_frame(PortStatistics& counters, std::uint32_t classes, std::span<const std::byte> data) noexcept {
  using namespace socketcan::error_class;
  const bool has_data = data.size() >= socketcan::kErrorFrameLength;
  if (has_data && (classes & kController) != 0)
    apply_controller_state(counters, std::to_integer<std::uint8_t>(data[1]));
  if ((classes & kRestarted) != 0) counters.state = BusState::kErrorActive;
  if ((classes & kBusOff) != 0) counters.state = BusState::kBusOff;
  // Drivers before Linux 6.0 write the counters without the flag.
  const bool counted =
      has_data && ((classes & kCounters) != 0 || ((classes & kController) != 0 && (data[6] | data[7]) != std::byte{0}));
  if (!counted) return;
  counters.send_errors = std::to_integer<std::uint8_t>(data[6]);
  counters.receive_errors = std::to_integer<std::uint8_t>(data[7]);
}

}  // namespace driveline::canopen
