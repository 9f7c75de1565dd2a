#include "driveline/slaves/esc/latch_unit.hpp"

namespace driveline::slaves {

namespace reg = wire::reg;

namespace {

/// Registers and bits of an edge of an input.
struct Edge {
  unsigned input;
  std::uint8_t bit;  ///< in control (single event) and status (event)
  const reg::U64& time;
};
constexpr std::array kEdges = {
    Edge{0, 0x01, reg::kLatch0PositiveEdge},
    Edge{0, 0x02, reg::kLatch0NegativeEdge},
    Edge{1, 0x01, reg::kLatch1PositiveEdge},
    Edge{1, 0x02, reg::kLatch1NegativeEdge},
};
constexpr std::uint8_t kEvents = 0x03;
constexpr std::uint8_t kLevel = 0x04;

constexpr const reg::U8& control(unsigned input) noexcept {
  return input == 0 ? reg::kLatch0Control : reg::kLatch1Control;
}
constexpr const reg::U8& status(unsigned input) noexcept {
  return input == 0 ? reg::kLatch0Status : reg::kLatch1Status;
}

}  // namespace

void LatchUnit::set_input(unsigned input, bool high, std::uint64_t time) noexcept {
  if (input >= kInputs || levels_[input] == high) return;
  levels_[input] = high;
  auto flags = static_cast<unsigned>(memory_.get(status(input)) & ~unsigned{kLevel}) | (high ? kLevel : 0U);
  const auto& edge = kEdges[2 * input + (high ? 0U : 1U)];
  const bool single = (memory_.get(control(input)) & edge.bit) != 0;
  if (!single || (flags & edge.bit) == 0) {
    memory_.set(edge.time, time);
    // The status shows events of the single event mode only.
    if (single) flags |= edge.bit;
    events_.set_ecat(ecat_event::kDcLatch, true);
    events_.set_al(al_event::kDcLatch, true);
  }
  memory_.set(status(input), static_cast<std::uint8_t>(flags));
}

void LatchUnit::acknowledge(std::size_t address, std::size_t length) noexcept {
  bool any = false;
  for (const auto& edge : kEdges) {
    if (edge.time.address < address || edge.time.address >= address + length) continue;
    any = true;
    memory_.set(status(edge.input), static_cast<std::uint8_t>(memory_.get(status(edge.input)) & ~unsigned{edge.bit}));
  }
  if (!any || ((memory_.get(status(0)) | memory_.get(status(1))) & kEvents) != 0) return;
  events_.set_ecat(ecat_event::kDcLatch, false);
  events_.set_al(al_event::kDcLatch, false);
}

}  // namespace driveline::slaves
