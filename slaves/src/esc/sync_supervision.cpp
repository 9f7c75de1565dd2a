#include "driveline/slaves/esc/sync_supervision.hpp"

#include <algorithm>

#include "driveline/slaves/esc/sync_unit.hpp"

namespace driveline::slaves {

using wire::AlStatusCode;
namespace reg = wire::reg;

namespace {

/// A pulse is regular if it deviates from its time by at most 1/64 of the cycle; the time control loop alone causes
/// less than a tenth of that.
constexpr int kEvenShare = 64;
/// Increment of the sync error counter (ETG.1020, 10F1h).
constexpr unsigned kMissingStep = 3;

/// SYNC signals activated by the master.
struct Activated {
  bool sync0 = false;
  bool sync1 = false;
  bool contradictory = false;  ///< SYNC1 without SYNC0, or the unit without a signal
  std::chrono::nanoseconds cycle0{0};
  std::chrono::nanoseconds cycle1{0};

  /// Whether SYNC1 occurs less often than SYNC0, so that process data follow SYNC1.
  [[nodiscard]] bool subordinated() const noexcept { return sync1 && cycle0.count() > 0 && cycle1 >= cycle0; }
  [[nodiscard]] std::chrono::nanoseconds data_cycle() const noexcept {
    return subordinated() ? (cycle1 / cycle0 + 1) * cycle0 : cycle0;
  }
};

Activated activated(const EscMemory& memory) noexcept {
  const auto bits = memory.get(reg::kDcActivation);
  const bool unit = (bits & dc_activation::kUnit) != 0;
  Activated result;
  result.sync0 = unit && (bits & dc_activation::kSync0) != 0;
  result.sync1 = unit && (bits & dc_activation::kSync1) != 0;
  result.contradictory = unit && !result.sync0;
  result.cycle0 = std::chrono::nanoseconds{memory.get(reg::kSync0CycleTime)};
  result.cycle1 = std::chrono::nanoseconds{memory.get(reg::kSync1CycleTime)};
  return result;
}

bool is_signal(SyncType type) noexcept {
  return type == SyncType::kSync0 || type == SyncType::kSync1;
}

/// Whether the master has activated the signal that the type needs.
bool has_signal(SyncType type, const Activated& active) noexcept {
  return !is_signal(type) || (active.sync0 && (type == SyncType::kSync0 || active.sync1));
}

bool supported(const SyncDemand& demand, SyncType type) noexcept {
  switch (type) {
    case SyncType::kFreeRun:
      return demand.free_run;
    case SyncType::kSmEvent:
      return demand.sm_event;
    case SyncType::kSm2Event:
      return demand.sm_event && demand.outputs;
    case SyncType::kSync0:
      return demand.sync0;
    case SyncType::kSync1:
      return demand.sync1;
  }
  return false;
}

/// Inputs need the signal of their type, but may follow another event than the outputs (Beckhoff's Slave Stack Code
/// 5.11, StartInputHandler).
AlStatusCode check_inputs(const SyncDemand& demand, const Activated& active) noexcept {
  if (!demand.input_type) return AlStatusCode::kNoError;
  if (!supported(demand, *demand.input_type)) return AlStatusCode::kSyncModeNotSupported;
  return has_signal(*demand.input_type, active) ? AlStatusCode::kNoError : AlStatusCode::kInvalidDcSyncConfiguration;
}

}  // namespace

AlStatusCode SyncSupervision::check(const SyncDemand& demand) const noexcept {
  const auto active = activated(memory_);
  if (demand.type) {
    const auto type = *demand.type;
    if (!supported(demand, type)) {
      return type == SyncType::kFreeRun ? AlStatusCode::kFreeRunNotSupported : AlStatusCode::kSyncModeNotSupported;
    }
    if (is_signal(type) != active.sync0 || !has_signal(type, active)) return AlStatusCode::kInvalidDcSyncConfiguration;
  } else if (!active.sync0 && !demand.free_run && !demand.sm_event) {
    return AlStatusCode::kFreeRunNotSupported;
  }
  if (const auto inputs = check_inputs(demand, active); inputs != AlStatusCode::kNoError) return inputs;
  if (active.contradictory) return AlStatusCode::kInvalidDcSyncConfiguration;
  if ((active.sync0 && !demand.sync0) || (active.sync1 && !demand.sync1)) return AlStatusCode::kSyncModeNotSupported;
  return active.sync0 ? check_cycles(demand) : AlStatusCode::kNoError;
}

AlStatusCode SyncSupervision::check_cycles(const SyncDemand& demand) const noexcept {
  const auto active = activated(memory_);
  const bool off_base = demand.time_base.count() > 0 && active.cycle0 % demand.time_base != Nanoseconds{0};
  if (active.cycle0.count() == 0 || off_base || active.cycle0 < demand.min_cycle || active.cycle0 > demand.max_cycle) {
    return AlStatusCode::kDcSync0CycleTime;
  }
  if (active.subordinated() && active.cycle1 % active.cycle0 != Nanoseconds{0}) return AlStatusCode::kDcSync1CycleTime;
  if (demand.cycle.count() > 0 && active.data_cycle() != demand.cycle) return AlStatusCode::kDcInvalidSyncCycleTime;
  return AlStatusCode::kNoError;
}

void SyncSupervision::start(const SyncDemand& demand) noexcept {
  const auto active = activated(memory_);
  const bool was_sync = mode_ == Mode::kSync;
  const auto old_cycle = cycle_;
  error_limit_ = demand.error_limit;
  calc_and_copy_ = demand.calc_and_copy;
  fault_ = AlStatusCode::kNoError;
  in_op_ = false;
  due_ = kNever;
  if (active.sync0) {
    mode_ = Mode::kSync;
    cycle_ = active.cycle0;
    data_signal_ = active.subordinated() ? SyncSignal::kSync1 : SyncSignal::kSync0;
    const auto data_cycle = active.data_cycle();
    pulses_per_outputs_ =
        data_cycle.count() > 0 ? std::max<std::int64_t>(1, demand.outputs_cycle / data_cycle) : std::int64_t{1};
  } else if (demand.type == SyncType::kSmEvent && demand.cycle.count() > 0) {
    mode_ = Mode::kSmEvent;
    cycle_ = demand.cycle;
  } else {
    mode_ = Mode::kNone;
  }
  // The state of pulses that continue unchanged remains valid.
  if (mode_ != Mode::kSync || !was_sync || old_cycle != cycle_) {
    even_pulses_ = 0;
    pulse_seen_ = false;
  }
}

void SyncSupervision::stop() noexcept {
  mode_ = Mode::kNone;
  leave_op();
  even_pulses_ = 0;
  pulse_seen_ = false;
}

void SyncSupervision::leave_op() noexcept {
  in_op_ = false;
  due_ = kNever;
  fault_ = AlStatusCode::kNoError;
}

void SyncSupervision::enter_op(Nanoseconds now, std::uint32_t outputs) noexcept {
  in_op_ = true;
  outputs_ = outputs;
  missing_ = 0;
  pulses_without_ = 0;
  some_came_ = false;
  margin_ = {};
  first_pulse_ = true;
  if (mode_ == Mode::kSync) due_ = last_pulse_ + kMissingCycles * cycle_;
  if (mode_ == Mode::kSmEvent) due_ = now + cycle_;
}

void SyncSupervision::pulse(SyncSignal signal, Nanoseconds time, std::uint32_t outputs, Nanoseconds written) noexcept {
  if (mode_ != Mode::kSync) return;
  if (signal == SyncSignal::kSync0) note_sync0(time);
  if (!in_op_ || signal != data_signal_) return;
  // When a pulse is handled late, newer outputs may already have arrived, which belong to the next pulse.
  const std::uint32_t early = written > time && outputs != outputs_ ? 1 : 0;
  const bool came = outputs - early != outputs_;
  outputs_ = outputs - early;
  if (came && early == 0) {
    margin_.found(time - written);
    if (time - written < calc_and_copy_) ++margin_.too_short;
  }
  judge_pulse(came);
}

void SyncSupervision::unserved(SyncSignal signal, Nanoseconds time) noexcept {
  if (mode_ != Mode::kSync) return;
  if (signal == SyncSignal::kSync0) note_sync0(time);
  if (in_op_ && signal == data_signal_) ++margin_.exceeded;
}

/// Notes a pulse of SYNC0, and whether it came at its time.
void SyncSupervision::note_sync0(Nanoseconds time) noexcept {
  const auto late = time - last_pulse_ - cycle_;
  const auto tolerance = cycle_ / kEvenShare;
  const bool even = pulse_seen_ && late <= tolerance && late >= -tolerance;
  even_pulses_ = even ? std::min(even_pulses_ + 1, kLockPulses) : 0;
  pulse_seen_ = true;
  last_pulse_ = time;
  if (!in_op_) return;
  due_ = time + kMissingCycles * cycle_;
  if (!even) fault_ = AlStatusCode::kPllError;
}

/// Judges a pulse with or without new outputs. When SYNC0 comes more often than the application needs outputs, they are
/// missing only after a whole cycle of the application without any.
void SyncSupervision::judge_pulse(bool came) noexcept {
  if (came) {
    pulses_without_ = 0;
  } else {
    // Outputs that arrive near a pulse find the one before it or the next one: half a cycle more is no loss.
    if (++pulses_without_ < pulses_per_outputs_ + pulses_per_outputs_ / 2) return;
    pulses_without_ -= pulses_per_outputs_;
    if (!first_pulse_) ++margin_.missed;
  }
  first_pulse_ = false;
  count_cycle(came);
}

void SyncSupervision::on_time(Nanoseconds now, std::uint32_t outputs) noexcept {
  if (now < due_) return;
  if (mode_ == Mode::kSync) {
    due_ = kNever;
    fault_ = AlStatusCode::kFatalSyncError;
    return;
  }
  due_ += cycle_;
  const bool came = outputs != outputs_;
  outputs_ = outputs;
  count_cycle(came);
}

void SyncSupervision::count_cycle(bool came) noexcept {
  if (error_limit_ == 0) return;
  if (came) {
    some_came_ = missing_ > 1;
    missing_ = missing_ == 0 ? 0 : missing_ - 1;
    return;
  }
  missing_ += kMissingStep;
  if (missing_ <= error_limit_) return;
  if (mode_ == Mode::kSmEvent) {
    fault_ = AlStatusCode::kSynchronizationError;
  } else {
    fault_ = some_came_ ? AlStatusCode::kDcSyncIoError : AlStatusCode::kDcSyncTimeout;
  }
}

AlStatusCode SyncSupervision::obstacle() const noexcept {
  if (mode_ != Mode::kSync) return AlStatusCode::kNoError;
  if (!pulse_seen_) return AlStatusCode::kNoSyncError;
  return even_pulses_ < kLockPulses ? AlStatusCode::kPllError : AlStatusCode::kNoError;
}

}  // namespace driveline::slaves
