#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/rt/spsc_ring.hpp"
#include "driveline/slaves/line/simulated_line.hpp"

namespace driveline::runtime {

/// A change of the AL state of a slave, for the owner of the line.
struct StateChange {
  std::uint16_t slave = 0;
  wire::AlStatus status;
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;
};

/// A command to a simulated line, and its result.
struct LineOrder {
  /// Starts or heals a fault, heals all faults, sets or reads a signal of a device, reports the states of the slaves.
  enum class Verb : std::uint8_t { kBegin, kHeal, kHealAll, kSetSignal, kReadSignal, kReportStates };
  Verb verb = Verb::kBegin;
  slaves::Fault fault{};  ///< kBegin, kHeal
  bool done = false;      ///< in an answer: the command was executed
  /// \name kSetSignal, kReadSignal: slave, signal and value
  /// @{
  std::uint16_t slave = 0;
  slaves::SignalId signal{};
  double value = 0.0;  ///< value to set, or the value read
  /// @}
  std::uint32_t number = 0;  ///< number given by the sender; the answer has the same
};

/// Commands to a simulated line, from the thread of their sender to the thread that runs the line, and answers and
/// changes of state back. Neither thread waits for the other.
class LineOrders {
 public:
  using Nanoseconds = std::chrono::nanoseconds;

  /// `line` must outlive it.
  explicit LineOrders(slaves::SimulatedLine& line);

  // Called only on the thread of the sender.
  /// Queues a command; false: the queue is full.
  [[nodiscard]] bool order(const LineOrder& order) noexcept { return orders_.try_push(order); }
  /// Takes the next answer to a command; false: there is none.
  [[nodiscard]] bool next_answer(LineOrder& answer) noexcept { return answers_.try_pop(answer); }
  /// Takes the next change of state; false: there is none.
  [[nodiscard]] bool next_change(StateChange& change) noexcept { return changes_.try_pop(change); }

  // Called only on the thread that runs the line.
  /// Whether a command is queued. \rtsafe
  [[nodiscard]] bool pending() const noexcept { return orders_.size() > 0; }
  /// Executes the queued commands at the time `now` of the line. \rtsafe if SimulatedLine::advance is
  void carry_out(Nanoseconds now) noexcept;
  /// Reports the slaves whose state has changed since the last call; at first those that are not in INIT. \rtsafe
  void watch_states() noexcept;

 private:
  void carry_out(LineOrder order, Nanoseconds now) noexcept;

  slaves::SimulatedLine& line_;
  std::vector<wire::AlStatus> states_;
  rt::SpscRing<StateChange> changes_;
  rt::SpscRing<LineOrder> orders_;
  rt::SpscRing<LineOrder> answers_;
};

}  // namespace driveline::runtime
