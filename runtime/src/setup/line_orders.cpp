#include "driveline/runtime/setup/line_orders.hpp"

#include "driveline/wire/registers.hpp"

namespace driveline::runtime {
namespace {

constexpr std::size_t kMaxChanges = 4096;
constexpr std::size_t kMaxOrders = 64;

}  // namespace

LineOrders::LineOrders(slaves::SimulatedLine& line)
    : line_(line), states_(line.size()), changes_(kMaxChanges), orders_(kMaxOrders), answers_(kMaxOrders) {}

void LineOrders::carry_out(Nanoseconds now) noexcept {
  LineOrder order;
  while (orders_.try_pop(order)) carry_out(order, now);
}

void LineOrders::carry_out(LineOrder order, Nanoseconds now) noexcept {
  line_.advance(now);
  auto& faults = line_.faults();
  order.done = true;
  switch (order.verb) {
    case LineOrder::Verb::kBegin:
      order.done = faults.begin(order.fault, now);
      break;
    case LineOrder::Verb::kHeal:
      order.done = faults.heal(order.fault, now);
      break;
    case LineOrder::Verb::kHealAll:
      faults.heal_all(now);
      break;
    case LineOrder::Verb::kSetSignal:
      line_.slave(order.slave).device().signals()->set_signal(order.signal.number, order.value);
      break;
    case LineOrder::Verb::kReadSignal:
      order.value = line_.slave(order.slave).device().signals()->signal(order.signal);
      break;
    case LineOrder::Verb::kReportStates:
      watch_states();
      break;
  }
  answers_.try_push(order);
}

void LineOrders::watch_states() noexcept {
  for (std::size_t i = 0; i < line_.size(); ++i) {
    const auto& slave = line_.slave(i);
    // A slave without supply has no state.
    const auto status = slave.powered() ? slave.esc().al_status() : wire::AlStatus{wire::AlState::kNone, false, false};
    if (status == states_[i]) continue;
    states_[i] = status;
    changes_.try_push({static_cast<std::uint16_t>(i), status,
                       static_cast<wire::AlStatusCode>(slave.esc().memory().get(wire::reg::kAlStatusCode))});
  }
}

}  // namespace driveline::runtime
