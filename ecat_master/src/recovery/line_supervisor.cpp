#include "driveline/ecat_master/recovery/line_supervisor.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace driveline::ecat_master {
namespace {

using std::chrono::nanoseconds;
using wire::AlState;
using RingState = port::RingStatus::State;

/// Interval of the search for slaves that have never joined.
constexpr nanoseconds kJoinPause = std::chrono::milliseconds{200};

std::string ring_break(const LineEvent& event) {
  const auto last = event.slave + event.cut_off;  // the first slave on the secondary side
  const auto from = event.slave == 0 ? std::string("the primary interface") : fmt::format("slave {}", event.slave - 1);
  const auto to = event.count == 0 ? std::string("the secondary interface") : fmt::format("slave {}", last);
  const auto between = fmt::format("between {} and {}", from, to);
  if (event.cut_off == 0) return between;
  if (event.cut_off == 1) return fmt::format("{}, slave {} is cut off", between, event.slave);
  return fmt::format("{}, slaves {} to {} are cut off", between, event.slave, last - 1);
}

/// Number of slaves that neither side reaches; 0 on a line with hot-connect slaves, where the number is unknown.
std::uint16_t cut_off(const Master& master, const port::RingStatus& status) {
  const auto slaves = master.slaves();
  if (std::any_of(slaves.begin(), slaves.end(), [](const auto& slave) { return slave.plan.hot_connect; })) return 0;
  const auto reached = std::size_t{status.primary_slaves} + status.secondary_slaves;
  return static_cast<std::uint16_t>(slaves.size() - std::min(slaves.size(), reached));
}

std::string others(const LineEvent& event) {
  return event.count > 1 ? fmt::format(" (and {} more)", event.count - 1) : std::string();
}

}  // namespace

std::string what_happened(const LineEvent& event, std::string_view name) {
  const auto slave =
      name.empty() ? fmt::format("slave {}", event.slave) : fmt::format("slave {} ({})", event.slave, name);
  switch (event.kind) {
    case LineEvent::Kind::kLeftOp:
      return fmt::format("{}: left OP, is in {}{}, AL status code 0x{:04X} ({})", slave,
                         wire::to_text(event.state.state), event.state.error ? " with an error" : "",
                         static_cast<unsigned>(event.code), wire::to_text(event.code));
    case LineEvent::Kind::kGone:
      return fmt::format("{}: no longer answers", slave);
    case LineEvent::Kind::kRecovered:
      return fmt::format("{}: back in OP", slave);
    case LineEvent::Kind::kJoined:
      return fmt::format("{}: joined the line and is in OP", slave);
    case LineEvent::Kind::kRecoveryFailed:
      return fmt::format("{}: not brought back to OP: {}", slave, describe(event.error));
    case LineEvent::Kind::kRingBroken:
      return fmt::format("the ring is broken {}; process data continue over both interfaces", ring_break(event));
    case LineEvent::Kind::kRingClosed:
      return "the ring is closed again";
    case LineEvent::Kind::kOutputsZeroed:
      return fmt::format("group {}: outputs set to zero after {} bad exchanges in a row", event.slave, event.count);
    case LineEvent::Kind::kRegistersChanged:
      return fmt::format("{}: {}{}; it must be configured again", slave, describe(event.change), others(event));
    case LineEvent::Kind::kOtherMaster:
      return describe(event.other);
    case LineEvent::Kind::kRegistersRestored:
      return fmt::format("{}: {}{}; written again", slave, describe(event.change), others(event));
  }
  return "?";
}

std::string describe(const LineEvent& event) {
  return fmt::format("{:.6f} s {}", std::chrono::duration<double>(event.time).count(), what_happened(event));
}

LineSupervisor::LineSupervisor(Master& master, const port::RedundantPort* ring, Settings settings)
    : master_(master), ring_(ring), settings_(settings), slaves_(master.slaves().size()) {
  // Discard the events on the way to OP.
  CyclicEvent event;
  while (master_.core()->take_event(event)) {
  }
  if (ring_ != nullptr) ring_state_ = ring_->status().state;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    slaves_[i].trouble = slaves_[i].gone = !master_.slaves()[i].present;
  }
}

bool LineSupervisor::all_operational() const noexcept {
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    if (slaves_[i].trouble && master_.slaves()[i].present) return false;
  }
  return true;
}

void LineSupervisor::note(LineEvent event) {
  ++events_;
  if (history_.size() == kMaxHistory) history_.pop_front();
  history_.push_back(event);
}

void LineSupervisor::poll() {
  take_cycle_events();
  watch_ring();
  watch_others();
  watch_slaves();
  watch_registers();
  const auto now = master_.bus().exchange().now();
  std::vector<std::size_t> due;
  bool missing = false;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    const bool wanted = settings_.recover || master_.slaves()[i].plan.hot_connect;
    if (!wanted || !slaves_[i].trouble || now < slaves_[i].next_try) continue;
    due.push_back(i);
    missing = missing || slaves_[i].gone;
  }
  if (due.empty()) return;
  if (missing) restore_addresses();
  for (const auto slave : due) recover(slave);
}

void LineSupervisor::take_cycle_events() {
  CyclicEvent event;
  while (master_.core()->take_event(event)) {
    if (event.kind == CyclicEvent::Kind::kOutputsZeroed) {
      LineEvent zeroed{.kind = LineEvent::Kind::kOutputsZeroed, .slave = event.index, .count = event.after};
      zeroed.time = nanoseconds{event.time_ns};
      note(zeroed);
    }
    auto& history = event.kind == CyclicEvent::Kind::kSlaveState ? state_history_ : exchange_history_;
    if (history.size() == kMaxHistory) history.pop_front();
    history.push_back(event);
  }
}

void LineSupervisor::watch_ring() {
  if (ring_ == nullptr) return;
  const auto status = ring_->status();
  const bool same_place =
      status.primary_slaves == ring_status_.primary_slaves && status.secondary_slaves == ring_status_.secondary_slaves;
  if (status.state == ring_state_ && same_place) return;
  LineEvent event;
  event.time = master_.bus().exchange().now();
  event.kind = status.state == RingState::kOpen ? LineEvent::Kind::kRingBroken : LineEvent::Kind::kRingClosed;
  event.slave = status.primary_slaves;
  event.count = status.secondary_slaves;
  event.cut_off = cut_off(master_, status);
  ring_state_ = status.state;
  ring_status_ = status;
  note(event);
}

/// Reports another master when it appears, and again when it becomes more harmful: reads, then writes, then state
/// changes.
void LineSupervisor::watch_others() {
  const auto other = master_.core()->other_master();
  if (other.frames == 0) return;
  if (other_.frames > 0 && harm_of(other.command, other.ado) <= harm_of(other_.command, other_.ado)) return;
  other_ = other;
  LineEvent event{.kind = LineEvent::Kind::kOtherMaster};
  event.time = master_.bus().exchange().now();
  event.other = other;
  note(event);
}

void LineSupervisor::watch_slaves() {
  auto& core = *master_.core();
  const auto line = core.al_status();
  const auto expected = std::count_if(slaves_.begin(), slaves_.end(), [](const Slave& slave) { return !slave.gone; });
  const bool line_complete = line.all_op(static_cast<std::uint16_t>(expected));
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    if (slaves_[i].trouble) continue;
    const auto report = core.slave_report(i);
    // Slaves without a status byte in the image are checked when the broadcast reports a state other than OP.
    if (report.watched ? report.operational : line_complete) continue;
    poll_slave(i);
  }
}

/// Determines why a slave is not operational.
void LineSupervisor::poll_slave(std::size_t slave) {
  const auto now = master_.bus().exchange().now();
  const auto report = master_.al_status_of(slave);
  if (!report) {
    const auto* counter = report.error().as<facts::WorkingCounter>();
    if (counter != nullptr && counter->received == 0) note_gone(slave, now);
    return;  // otherwise the whole line is unreachable, not only this slave
  }
  if (report->status.state != AlState::kOp || report->status.error) return note_state(slave, *report, now);
  slaves_[slave].suspicious = true;
}

void LineSupervisor::note_gone(std::size_t slave, nanoseconds time) {
  auto& one = slaves_[slave];
  one.trouble = true;
  one.gone = true;
  one.noted_failure.reset();
  master_.core()->set_recovering(slave, true);
  LineEvent event{.kind = LineEvent::Kind::kGone, .slave = static_cast<std::uint16_t>(slave)};
  event.time = time;
  note(event);
}

void LineSupervisor::note_state(std::size_t slave, const AlReport& report, nanoseconds time) {
  auto& one = slaves_[slave];
  one.trouble = true;
  one.noted_failure.reset();
  master_.core()->set_recovering(slave, true);
  LineEvent event{.kind = LineEvent::Kind::kLeftOp, .slave = static_cast<std::uint16_t>(slave)};
  event.time = time;
  event.state = report.status;
  event.code = report.code;
  note(event);
  // The cause may be an overwritten register.
  if (!settings_.guard_registers || report.status.state < AlState::kSafeOp) return;
  const auto changes = master_.changed_registers(slave);
  if (!changes || !needs_configuration(*changes) || restore_addresses()) return;
  note_changes(slave, *changes);
}

void LineSupervisor::recover(std::size_t slave) {
  auto& one = slaves_[slave];
  const bool joins = !master_.slaves()[slave].present;
  const auto done = master_.recover(slave, settings_.state_timeout);
  const auto now = master_.bus().exchange().now();
  LineEvent event{.kind = LineEvent::Kind::kRecovered, .slave = static_cast<std::uint16_t>(slave)};
  event.time = now;
  if (done) {
    one = {};
    if (joins) event.kind = LineEvent::Kind::kJoined;
    if (!joins) ++recoveries_;
    master_.core()->set_recovering(slave, false);
    note(event);
    return;
  }
  // A slave may be plugged in at any time: search regularly.
  one.next_try = now + (joins ? kJoinPause : settings_.retry_pause);
  const auto& error = done.error();
  const bool answers = !error.is<facts::WorkingCounter>() && !error.is<facts::NoAnswer>();
  one.gone = !answers || error.is<facts::PlaceUnknown>();
  // Report once per reason; the missing answer of a gone slave has already been reported.
  const bool noted = one.noted_failure && one.noted_failure->facts.index() == error.facts.index();
  if (!answers || noted) return;
  one.noted_failure = error;
  event.kind = LineEvent::Kind::kRecoveryFailed;
  event.error = error;
  note(event);
}

}  // namespace driveline::ecat_master
