#include "driveline/rt/cycle_timer.hpp"

#include <algorithm>
#include <stdexcept>

namespace driveline::rt {

namespace {

using std::chrono::nanoseconds;

// 16 parts awake require one part of sleep: 94.1 % of the CPU, below the 95 % at which Linux stops the thread.
constexpr int kAwakePerRest = 16;
// Number of periods awake from which a system call is worthwhile to find out whether the thread was running at all.
constexpr int kLongAwake = 2;

}  // namespace

CycleTimer::CycleTimer(Clock& clock, nanoseconds period, std::optional<nanoseconds> wake_ahead, nanoseconds early)
    : clock_{clock}, period_{period}, early_{early}, wake_ahead_{wake_ahead}, margin_{max_wake_ahead(period)} {
  if (period <= nanoseconds::zero()) {
    throw std::invalid_argument("cycle timer: the period must be longer than 0 ns");
  }
  if (wake_ahead && (*wake_ahead < nanoseconds::zero() || *wake_ahead > max_wake_ahead(period))) {
    throw std::invalid_argument("cycle timer: the wake-up lead must lie between 0 and a quarter of the period");
  }
  if (early < nanoseconds::zero() || early > max_wake_ahead(period)) {
    throw std::invalid_argument("cycle timer: a thread is early by 0 to a quarter of the period");
  }
  start(clock_.now());
}

void CycleTimer::start(nanoseconds first) noexcept {
  next_ = first;
  next_cycle_ = 0;
  pending_shift_ = phase_shift_ = nanoseconds::zero();
  slept_ = false;
  missed_total_ = forced_rests_ = 0;
  awake_since_ = clock_.now();
  rest_debt_ = awake_unproven_ = nanoseconds::zero();
  cpu_at_ = clock_.cpu_time();
}

void CycleTimer::sleep_ahead() noexcept {
  if (slept_) return;
  next_ += pending_shift_;
  pending_shift_ = nanoseconds::zero();
  sleep_towards_next();
  slept_ = true;
}

CycleStart CycleTimer::wait_next() noexcept {
  sleep_ahead();
  slept_ = false;
  const nanoseconds wake = clock_.spin_until(next_ - early_);

  // Computed after the sleep, so that periods lost by a late wake-up count like those lost by a long cycle. 0 for a
  // thread that is early.
  const std::int64_t missed = (wake - next_) / period_;
  const CycleStart start{next_cycle_ + missed, next_ + missed * period_, wake, missed};
  missed_total_ += missed;
  next_ = start.grid + period_;
  next_cycle_ = start.cycle + 1;
  return start;
}

nanoseconds CycleTimer::shift_phase(nanoseconds shift) noexcept {
  const nanoseconds limit = period_ / 2;
  // Clamp to the remaining room, so that no sum can overflow.
  const nanoseconds accepted = std::clamp(shift, -limit - pending_shift_, limit - pending_shift_);
  pending_shift_ += accepted;
  phase_shift_ += accepted;
  return accepted;
}

void CycleTimer::sleep_towards_next() noexcept {
  const nanoseconds now = clock_.now();
  owe_rest(now - awake_since_);

  // The learned margin never shortens the sleep that is owed; otherwise a whole period would be skipped to pay for it.
  const nanoseconds due = next_ - early_;
  const nanoseconds lead =
      wake_ahead_.value_or(std::max(nanoseconds::zero(), std::min(margin_.value(), due - now - rest_debt_)));
  nanoseconds target = due - lead;
  // Small debts wait: the sleep at the end of an ordinary period pays them.
  if (rest_debt_ >= period_ / 2 && target < now + rest_debt_) {
    target = next_at_or_after(now + rest_debt_);
    ++forced_rests_;
  }
  clock_.sleep_until(target);
  awake_since_ = clock_.now();
  // Without a sleep there was no wake-up to measure.
  if (target > now) margin_.observe(awake_since_ - target);
  rest_debt_ = std::max(nanoseconds::zero(), rest_debt_ - (awake_since_ - now));
}

/// Adds the sleep owed for the time `awake`. A thread that was stopped or preempted owes nothing for that time: it is
/// late enough without an additional rest.
void CycleTimer::owe_rest(nanoseconds awake) noexcept {
  rest_debt_ += awake / kAwakePerRest;
  awake_unproven_ += awake;
  if (awake < kLongAwake * period_) return;
  const nanoseconds cpu = clock_.cpu_time();
  const nanoseconds idle = std::clamp(awake_unproven_ - (cpu - cpu_at_), nanoseconds::zero(), awake);
  rest_debt_ = std::max(nanoseconds::zero(), rest_debt_ - idle / kAwakePerRest);
  awake_unproven_ = nanoseconds::zero();
  cpu_at_ = cpu;
}

nanoseconds CycleTimer::next_at_or_after(nanoseconds time) const noexcept {
  if (time <= next_) {
    return next_;
  }
  const std::int64_t periods = (time - next_ + period_ - nanoseconds{1}) / period_;
  return next_ + periods * period_;
}

}  // namespace driveline::rt
