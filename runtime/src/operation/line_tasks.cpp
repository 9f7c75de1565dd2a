#include "operation/line_tasks.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <utility>

namespace driveline::runtime {
namespace {

std::string names_of(const LineConfig& config) {
  std::string names;
  for (const auto& axis : config.axes) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", axis.name);
  return names.empty() ? "the line has none" : "the line has " + names;
}

Result<std::size_t> number_of(const std::string& axis, const TaskPlan& plan, const LineConfig& config) {
  const auto& axes = config.axes;
  const auto found = std::find_if(axes.begin(), axes.end(), [&](const auto& one) { return one.name == axis; });
  if (found != axes.end()) return static_cast<std::size_t>(found - axes.begin());
  return fail(ErrorKind::kCall,
              fmt::format("task \"{}\": there is no axis \"{}\" to drive; {}", plan.name, axis, names_of(config)));
}

Result<void> check_timing(const TaskPlan& plan) {
  const auto& timing = plan.timing;
  if (timing.divider == 0)
    return fail(ErrorKind::kCall,
                fmt::format("task \"{}\": the divider is 0; 1 (every cycle) or more is expected", plan.name));
  if (timing.phase >= timing.divider) {
    return fail(ErrorKind::kCall, fmt::format("task \"{}\": phase {} of a divider of {}; 0 to {}", plan.name,
                                              timing.phase, timing.divider, timing.divider - 1));
  }
  return {};
}

}  // namespace

Result<void> LineTasks::add(Task& task, TaskPlan plan, const LineConfig& config) {
  if (plan.name.empty()) return fail(ErrorKind::kCall, "a task needs a name for the report");
  for (const auto& entry : entries_) {
    if (entry.plan.name == plan.name)
      return fail(ErrorKind::kCall, fmt::format("the name \"{}\" belongs to another task", plan.name));
    if (entry.task == &task) {
      return fail(ErrorKind::kCall,
                  fmt::format("task \"{}\": already added with the name \"{}\"", plan.name, entry.plan.name));
    }
  }
  if (auto timing = check_timing(plan); !timing) return timing;
  if (!plan.drives.empty() && config.path) {
    return fail(ErrorKind::kCall, fmt::format("task \"{}\": the axes follow the [path] of the line description; a task "
                                              "drives axes of a line without one",
                                              plan.name));
  }
  Entry entry{&task, std::move(plan), {}};
  for (const auto& name : entry.plan.drives) {
    const auto number = number_of(name, entry.plan, config);
    if (!number) return tl::unexpected(number.error());
    const auto same = [&](const TaskAxis& axis) { return axis.number == *number; };
    const auto* driver = std::any_of(entry.axes.begin(), entry.axes.end(), same) ? &entry : driver_of(*number);
    if (driver != nullptr) {
      return fail(ErrorKind::kCall, fmt::format("task \"{}\": axis \"{}\" is driven by the task \"{}\" already",
                                                entry.plan.name, name, driver->plan.name));
    }
    entry.axes.push_back({*number, nullptr});
  }
  schedule_.add(task, entry.plan.timing);
  entries_.push_back(std::move(entry));
  return {};
}

const LineTasks::Entry* LineTasks::driver_of(std::size_t axis) const noexcept {
  for (const auto& entry : entries_) {
    for (const auto& driven : entry.axes) {
      if (driven.number == axis) return &entry;
    }
  }
  return nullptr;
}

bool LineTasks::drive() const noexcept {
  return std::any_of(entries_.begin(), entries_.end(), [](const Entry& entry) { return !entry.axes.empty(); });
}

motion::SetpointSource* LineTasks::make_source(const LineConfig& config) {
  if (!drive()) return nullptr;
  std::vector<std::uint32_t> cycles(config.axes.size(), 1);
  for (const auto& entry : entries_) {
    for (const auto& axis : entry.axes) cycles[axis.number] = entry.plan.timing.divider;
  }
  driven_ =
      std::make_unique<motion::DrivenAxes>(std::move(cycles), std::chrono::duration<double>(config.period).count());
  for (auto& entry : entries_) {
    for (auto& axis : entry.axes) axis.drive = &driven_->axis(axis.number);
  }
  return driven_.get();
}

Result<void> LineTasks::prepare(const LineConfig& config, const ProcessVariables& process_data) {
  for (const auto& entry : entries_) {
    if (auto ready = entry.task->prepare({config, process_data, entry.axes}); !ready) {
      auto error = ready.error();
      if (error.place.empty()) error.place = fmt::format("task \"{}\"", entry.plan.name);
      return tl::unexpected(std::move(error));
    }
  }
  return {};
}

std::vector<TaskReport> LineTasks::report() const {
  std::vector<TaskReport> reports;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    reports.push_back({entries_[i].plan.name, entries_[i].plan.timing, schedule_.figures(i)});
  }
  return reports;
}

}  // namespace driveline::runtime
