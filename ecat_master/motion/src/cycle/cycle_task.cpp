#include "driveline/motion/cycle/cycle_task.hpp"

#include <stdexcept>

#ifdef DRIVELINE_TASK_GUARD
#include "driveline/rt_guard/rt_guard.hpp"
#endif

namespace driveline::motion {
namespace {

/// Runs the task; returns the number of forbidden functions that it called, 0 if they are not counted.
std::uint64_t guarded_update(CycleTask& task, const TaskCycle& now) noexcept {
#ifdef DRIVELINE_TASK_GUARD
  const rt::RtGuard::Watch watch;
  task.update(now);
  return watch.total();
#else
  task.update(now);
  return 0;
#endif
}

}  // namespace

void TaskSchedule::add(CycleTask& task, TaskTiming timing) {
  if (timing.divider == 0) throw std::invalid_argument("task: the divider must be at least 1");
  if (timing.phase >= timing.divider) throw std::invalid_argument("task: the phase must be below the divider");
  entries_.push_back(std::make_unique<Entry>(Entry{&task, timing}));
}

void TaskSchedule::begin(const rt::CycleStart& start) noexcept {
  for (auto& entry : entries_) {
    const std::int64_t divider = entry->timing.divider;
    const std::int64_t turn = (start.cycle + divider - entry->timing.phase) / divider;
    entry->due = turn != entry->turn;
    entry->turn = turn;
    entry->missed += start.missed;
  }
}

void TaskSchedule::run(TaskTiming::Order order, TaskCycle now, std::chrono::nanoseconds period,
                       rt::Clock& clock) noexcept {
  for (auto& entry : entries_) {
    if (!entry->due || entry->timing.order != order) continue;
    now.missed = entry->missed;
    now.elapsed = entry->figures.calls == 0 ? std::chrono::nanoseconds{0} : (now.cycle - entry->last) * period;
    entry->missed = 0;
    entry->last = now.cycle;
    ++entry->figures.calls;
    const auto begin = clock.now();
    entry->figures.forbidden_calls += guarded_update(*entry->task, now);
    entry->figures.cost.record(clock.now() - begin);
  }
}

}  // namespace driveline::motion
