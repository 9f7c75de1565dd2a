#include "axes/axis_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "axes/axis_words.hpp"
#include "axes/quantity.hpp"
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/runtime/files/input_file.hpp"

namespace driveline::cli {
namespace {

using ecat_master::RequestPhase;

constexpr std::string_view kScript = "script";

std::string_view without_remark(std::string_view line) {
  return line.substr(0, line.find('#'));
}

}  // namespace

tl::unexpected<Failure> AxisScript::fail(std::size_t line, const std::string& reason) const {
  return failed(fmt::format("{}:{}: {}", name_, line, reason));
}

Outcome<AxisScript> AxisScript::read(const std::filesystem::path& file, std::span<const ecat_master::AxisConfig> axes) {
  const auto text = runtime::read_input_file(file);
  if (!text) return tl::unexpected(Failure(text.error()));
  return parse(*text, file.string(), axes);
}

Outcome<AxisScript> AxisScript::parse(std::string_view text, const std::string& name,
                                      std::span<const ecat_master::AxisConfig> axes) {
  AxisScript script(name);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = split_words(without_remark(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty()) continue;
    auto step = read_step(words, axes);
    if (!step) return misused(fmt::format("{}:{}: {}", name, line, step.error().text));
    step->line = line;
    script.steps_.push_back(std::move(*step));
  }
  if (script.steps_.empty()) return misused(fmt::format("{}: there is no request in it", name));
  return script;
}

Outcome<AxisScript::Step> AxisScript::read_step(std::span<const std::string> words,
                                                std::span<const ecat_master::AxisConfig> axes) {
  Step step;
  if (words[0] == "sleep" && words.size() == 2) {
    const auto time = parse_time(words[1], "sleep");
    if (!time) return tl::unexpected(time.error());
    step.kind = Step::Kind::kSleep;
    step.time = *time;
    return step;
  }
  const bool waits = words[0] == "wait" && words.size() == 2;
  if (words.size() < 2) return misused("an axis and a request, wait AXIS or sleep TIME are expected");
  auto found = find_axes(axes, words[waits ? 1 : 0]);
  if (!found) return tl::unexpected(found.error());
  step.axes = std::move(*found);
  if (waits) {
    step.kind = Step::Kind::kWait;
    return step;
  }
  for (const auto axis : step.axes) {
    const auto request = parse_axis_request(axes[axis], words.subspan(1));
    if (!request) return tl::unexpected(request.error());
    step.requests.push_back(*request);
  }
  return step;
}

Outcome<bool> AxisScript::step(runtime::AxisDoor& door, std::chrono::nanoseconds now) {
  // The axes are being enabled.
  for (std::size_t axis = 0; axis < door.axes().size() && !begun_; ++axis) {
    if (door.authority().holds(axis, runtime::kStartOfRun)) return false;
  }
  begun_ = true;
  if (auto looked = look_at_requests(door); !looked) return tl::unexpected(looked.error());
  while (next_ < steps_.size()) {
    auto over = done(door, steps_[next_], now);
    if (!over || !*over) return over;
    ++next_;
    step_runs_ = false;
  }
  return std::all_of(made_.begin(), made_.end(), [](const Made& made) { return made.over; });
}

Outcome<bool> AxisScript::done(runtime::AxisDoor& door, const Step& step, std::chrono::nanoseconds now) {
  if (!step_runs_) step_began_ = now;
  step_runs_ = true;
  switch (step.kind) {
    case Step::Kind::kSleep:
      return now - step_began_ >= step.time;
    case Step::Kind::kWait:
      return arrived(step.axes);
    case Step::Kind::kRequest:
      break;
  }
  if (auto asked = ask(door, step); !asked) return tl::unexpected(asked.error());
  return true;
}

Outcome<void> AxisScript::ask(runtime::AxisDoor& door, const Step& step) {
  runtime::AxisCaller caller;
  caller.name = std::string(kScript);
  for (std::size_t i = 0; i < step.axes.size(); ++i) {
    const auto axis = step.axes[i];
    const auto taken = door.submit(caller, axis, step.requests[i]);
    if (!taken) {
      return fail(step.line, runtime::describe(runtime::events::event_axis(door.axes()[axis]), taken.error()));
    }
    for (auto& made : made_) made.last = made.last && made.axis != axis;
    made_.push_back({step.line, axis, *taken, true, false});
  }
  return {};
}

/// A request that another one of the script has ended is over; one that somebody else has ended is a failure.
Outcome<void> AxisScript::look_at_requests(const runtime::AxisDoor& door) {
  for (auto& made : made_) {
    if (made.over && !made.last) continue;
    const auto progress = door.progress(made.axis, made.number);
    const auto axis = runtime::events::event_axis(door.axes()[made.axis]);
    if (progress.refusal) return fail(made.line, runtime::describe(axis, *progress.refusal));
    if (progress.report.phase == RequestPhase::kAborted && made.last)
      return fail(made.line, fmt::format("axis {}: another request has ended this one", axis.name));
    const auto phase = progress.report.phase;
    made.over = progress.report.over() || phase == RequestPhase::kReached || phase == RequestPhase::kUnknown;
  }
  return {};
}

bool AxisScript::arrived(std::span<const std::size_t> axes) const {
  return std::all_of(made_.begin(), made_.end(), [axes](const Made& made) {
    const bool meant = std::find(axes.begin(), axes.end(), made.axis) != axes.end();
    return !meant || !made.last || made.over;
  });
}

}  // namespace driveline::cli
