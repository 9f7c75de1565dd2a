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

bool supported(const SyncDemand& demand, SyncType type) noexcept {
  switch (type) {
    case SyncType::kFreeRun:
      return demand.free_run;
    case SyncType::kSmEvent:
      return demand.sm_event;
    case SyncType::kSync0:
      return demand.sync0;
    case SyncType::kSync1:
      return demand.sync1;
  }
  return false;
}

}  // namespace

AlStatusCode SyncSupervision::check(const SyncDemand& demand) const noexcept {
  const auto active = activated(memory_);
  if (demand.type) {
    const auto type = *demand.type;
    if (!supported(demand, type)) {
      return type == SyncType::kFreeRun ? AlStatusCode::kFreeRunNotSupported : AlStatusCode::kSyncModeNotSupported;
    }
    const bool wants_sync = type == SyncType::kSync0 || type == SyncType::kSync1;
    if (wants_sync != active.sync0 || (type == SyncType::kSync1 && !active.sync1)) {
      return AlStatusCode::kInvalidDcSyncConfiguration;
    }
  } else if (!active.sync0 && !demand.free_run && !demand.sm_event) {
    return AlStatusCode::kFreeRunNotSupported;
  }
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
  fault_ = AlStatusCode::kNoError;
  in_op_ = false;
  due_ = kNever;
  if (active.sync0) {
    mode_ = Mode::kSync;
    cycle_ = active.cycle0;
    data_signal_ = active.subordinated() ? SyncSignal::kSync1 : SyncSignal::kSync0;
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
  some_came_ = false;
  margin_ = {};
  first_pulse_ = true;
  if (mode_ == Mode::kSync) due_ = last_pulse_ + kMissingCycles * cycle_;
  if (mode_ == Mode::kSmEvent) due_ = now + cycle_;
}

void SyncSupervision::pulse(SyncSignal signal, Nanoseconds time, std::uint32_t outputs, Nanoseconds written) noexcept {
  if (mode_ != Mode::kSync) return;
  if (signal == SyncSignal::kSync0) {
    const auto late = time - last_pulse_ - cycle_;
    const auto tolerance = cycle_ / kEvenShare;
    const bool even = pulse_seen_ && late <= tolerance && late >= -tolerance;
    even_pulses_ = even ? std::min(even_pulses_ + 1, kLockPulses) : 0;
    pulse_seen_ = true;
    last_pulse_ = time;
    if (in_op_) {
      due_ = time + kMissingCycles * cycle_;
      if (!even) fault_ = AlStatusCode::kPllError;
    }
  }
  if (!in_op_ || signal != data_signal_) return;
  // When a pulse is handled late, newer outputs may already have arrived, which belong to the next pulse.
  const std::uint32_t early = written > time && outputs != outputs_ ? 1 : 0;
  const bool came = outputs - early != outputs_;
  outputs_ = outputs - early;
  if (came && early == 0) margin_.found(time - written);
  if (!came && !first_pulse_) ++margin_.missed;
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
