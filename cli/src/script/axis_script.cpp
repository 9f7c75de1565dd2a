#include "script/axis_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "axes/axis_words.hpp"
#include "axes/coupling_words.hpp"
#include "axes/quantity.hpp"
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/toml/suggestion.hpp"
#include "groups/group_words.hpp"

namespace driveline::cli {
namespace {

using motion::RequestPhase;

constexpr std::string_view kScript = "script";

std::string_view without_remark(std::string_view line) {
  return line.substr(0, line.find('#'));
}

}  // namespace

tl::unexpected<Failure> AxisScript::fail(std::size_t line, const std::string& reason) const {
  return failed(fmt::format("{}:{}: {}", name_, line, reason));
}

AxisScript::AxisScript(std::string name) : name_(std::move(name)), groups_(std::string(kScript)) {}

Outcome<AxisScript> AxisScript::read(const std::filesystem::path& file, const Names& names) {
  const auto text = runtime::read_input_lines(file);
  if (!text) return tl::unexpected(Failure(text.error()));
  return parse(*text, file.string(), names);
}

Outcome<AxisScript> AxisScript::parse(std::string_view text, const std::string& name, const Names& names) {
  AxisScript script(name);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = split_words(without_remark(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty()) continue;
    auto step = script.read_step(words, names);
    if (!step) return misused(fmt::format("{}:{}: {}", name, line, step.error().text));
    step->line = line;
    script.steps_.push_back(std::move(*step));
  }
  if (script.steps_.empty()) return misused(fmt::format("{}: it contains no request", name));
  script.join_blended_moves();
  return script;
}

Outcome<AxisScript::Step> AxisScript::read_step(std::span<const std::string> words, const Names& names) const {
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
  const auto& name = words[waits ? 1 : 0];
  step.kind = waits ? Step::Kind::kWait : Step::Kind::kRequest;
  const auto group =
      std::find_if(names.groups.begin(), names.groups.end(), [&name](const auto& one) { return one.name == name; });
  if (group != names.groups.end()) {
    const auto number = static_cast<std::size_t>(group - names.groups.begin());
    step.group = number;
    return waits ? Outcome<Step>(std::move(step)) : read_group_step(number, words.subspan(1), names);
  }
  auto found = find_axes(names.axes, name);
  if (!found) {
    std::vector<std::string_view> groups;
    for (const auto& one : names.groups) groups.emplace_back(one.name);
    const auto meant = runtime::closest(name, groups);
    return meant.empty() ? tl::unexpected(found.error())
                         : misused(fmt::format("there is no axis \"{0}\"; did you mean the group {1}?", name, meant));
  }
  step.axes = std::move(*found);
  step.all = name == "all";
  if (waits) return step;
  if (is_coupling_verb(words[1])) {
    const runtime::CouplingPlan none;
    const auto& couplings = names.couplings == nullptr ? none : *names.couplings;
    for (const auto axis : step.axes) {
      auto order = parse_coupling_order(names.axes, couplings, axis, words.subspan(1));
      if (!order) return tl::unexpected(order.error());
      step.orders.push_back(std::move(*order));
    }
    return step;
  }
  for (const auto axis : step.axes) {
    const auto request = parse_axis_request(names.axes[axis], words.subspan(1));
    if (!request) return tl::unexpected(request.error());
    step.requests.push_back(*request);
  }
  return step;
}

Outcome<AxisScript::Step> AxisScript::read_group_step(std::size_t group, std::span<const std::string> words,
                                                      const Names& names) const {
  Step step;
  step.group = group;
  const auto& config = names.groups[group];
  if (words[0] == "path") {
    if (words.size() != 2) return misused(fmt::format("group {}: path: one file of moves is expected", config.name));
    step.kind = Step::Kind::kGroupPath;
    step.file = std::filesystem::path(name_).parent_path() / words[1];
    return step;
  }
  step.kind = Step::Kind::kGroupRequest;
  auto request = parse_group_request({config, names.axes}, words);
  if (!request) return tl::unexpected(request.error());
  step.group_request = std::move(*request);
  return step;
}

/// A move must know in advance that a later move is to be blended with it.
void AxisScript::join_blended_moves() {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    auto& step = steps_[i];
    if (step.kind != Step::Kind::kGroupRequest || step.group_request.verb != runtime::ClientGroupRequest::Verb::kMove)
      continue;
    const auto next =
        std::find_if(steps_.begin() + static_cast<std::ptrdiff_t>(i) + 1, steps_.end(), [&step](const Step& later) {
          const bool waits = later.kind == Step::Kind::kWait && later.all;
          return later.group == step.group || waits;
        });
    if (next == steps_.end() || next->kind != Step::Kind::kGroupRequest) continue;
    const auto& request = next->group_request;
    step.group_request.move.continues = request.verb == runtime::ClientGroupRequest::Verb::kMove &&
                                        request.move.buffer == motion::GroupBuffer::kBlending;
  }
}

Outcome<bool> AxisScript::step(runtime::AxisRequests& axis_requests, runtime::GroupRequests& groups,
                               std::chrono::nanoseconds now) {
  // Wait until the axes have been enabled.
  for (std::size_t axis = 0; axis < axis_requests.axes().size() && !begun_; ++axis) {
    if (axis_requests.authority().holds(axis, runtime::kStartOfRun)) return false;
  }
  begun_ = true;
  if (auto looked = check_requests(axis_requests); !looked) return tl::unexpected(looked.error());
  if (auto looked = to_outcome(groups_.poll(groups)); !looked) return tl::unexpected(looked.error());
  while (next_ < steps_.size()) {
    auto over = done(axis_requests, groups, steps_[next_], now);
    if (!over || !*over) return over;
    ++next_;
    step_runs_ = false;
  }
  return groups_.arrived(std::nullopt) &&
         std::all_of(made_.begin(), made_.end(), [](const Made& made) { return made.over; });
}

Outcome<void> AxisScript::to_outcome(const std::optional<ScriptGroups::Trouble>& trouble) const {
  if (!trouble) return {};
  return tl::unexpected(
      Failure{trouble->failure.status, fmt::format("{}:{}: {}", name_, trouble->line, trouble->failure.text)});
}

Outcome<bool> AxisScript::done(runtime::AxisRequests& axis_requests, runtime::GroupRequests& groups, const Step& step,
                               std::chrono::nanoseconds now) {
  if (!step_runs_) step_began_ = now;
  step_runs_ = true;
  switch (step.kind) {
    case Step::Kind::kSleep:
      return now - step_began_ >= step.time;
    case Step::Kind::kWait:
      return arrived(step);
    case Step::Kind::kRequest:
    case Step::Kind::kGroupRequest:
    case Step::Kind::kGroupPath:
      break;
  }
  if (auto asked = step.group ? ask(groups, step) : ask(axis_requests, step); !asked)
    return tl::unexpected(asked.error());
  return true;
}

Outcome<void> AxisScript::ask(runtime::AxisRequests& axis_requests, const Step& step) {
  runtime::AxisCaller caller;
  caller.name = std::string(kScript);
  for (std::size_t i = 0; i < step.axes.size(); ++i) {
    const auto axis = step.axes[i];
    const auto taken = step.orders.empty() ? axis_requests.submit(caller, axis, step.requests[i])
                                           : axis_requests.submit(caller, axis, step.orders[i]);
    if (!taken) {
      return fail(step.line, runtime::describe(runtime::events::event_axis(axis_requests.axes()[axis]), taken.error()));
    }
    for (auto& made : made_) made.last = made.last && made.axis != axis;
    made_.push_back({step.line, axis, *taken, true, false});
  }
  return {};
}

Outcome<void> AxisScript::ask(runtime::GroupRequests& group_requests, const Step& step) {
  if (step.kind == Step::Kind::kGroupPath)
    return to_outcome(groups_.begin_path(group_requests, step.line, *step.group, step.file));
  return to_outcome(groups_.ask(group_requests, step.line, *step.group, step.group_request));
}

/// A request that a later request of the script has ended is over; if another caller has ended it, that is a failure.
Outcome<void> AxisScript::check_requests(const runtime::AxisRequests& axis_requests) {
  for (auto& made : made_) {
    if (made.over && !made.last) continue;
    const auto progress = axis_requests.progress(made.axis, made.number);
    const auto axis = runtime::events::event_axis(axis_requests.axes()[made.axis]);
    if (progress.refusal) return fail(made.line, runtime::describe(axis, *progress.refusal));
    if (progress.report.phase == RequestPhase::kAborted && made.last)
      return fail(made.line, fmt::format("axis {}: another request has replaced this one", axis.name));
    const auto phase = progress.report.phase;
    made.over = progress.report.over() || phase == RequestPhase::kReached || phase == RequestPhase::kUnknown;
  }
  return {};
}

bool AxisScript::arrived(const Step& step) const {
  if (step.group) return groups_.arrived(step.group);
  const auto& axes = step.axes;
  if (step.all && !groups_.arrived(std::nullopt)) return false;
  return std::all_of(made_.begin(), made_.end(), [&axes](const Made& made) {
    const bool meant = std::find(axes.begin(), axes.end(), made.axis) != axes.end();
    return !meant || !made.last || made.over;
  });
}

}  // namespace driveline::cli
