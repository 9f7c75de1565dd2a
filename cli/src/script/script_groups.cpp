#include "script/script_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "groups/group_path.hpp"

namespace driveline::cli {
namespace {

using motion::RequestPhase;
using Verb = runtime::ClientGroupRequest::Verb;

constexpr std::size_t kMovesAtOnce = 128;

/// Whether the request ends what the group did before.
bool replaces(Verb verb) {
  return verb == Verb::kMove || verb == Verb::kHalt || verb == Verb::kStop || verb == Verb::kDisable ||
         verb == Verb::kReset;
}

}  // namespace

void ScriptGroups::add(Made made, bool moves) {
  if (moves) {
    for (auto& before : made_) before.newest = before.newest && before.group != made.group;
  }
  made_.push_back(std::move(made));
}

std::optional<ScriptGroups::Trouble> ScriptGroups::ask(runtime::GroupRequests& group_requests, std::size_t line,
                                                       std::size_t group, const runtime::ClientGroupRequest& request) {
  const auto taken = group_requests.submit(caller_, group, request);
  if (!taken) return Trouble{line, {1, runtime::describe(group_requests.event_group(group), taken.error())}};
  Made made;
  made.line = line;
  made.group = group;
  made.first = made.last = *taken;
  add(std::move(made), replaces(request.verb));
  return std::nullopt;
}

std::optional<ScriptGroups::Trouble> ScriptGroups::begin_path(runtime::GroupRequests& group_requests, std::size_t line,
                                                              std::size_t group, const std::filesystem::path& file) {
  const auto status = group_requests.status(group);
  auto moves = read_group_path(file, {status.limits, status.place, group_requests.groups()[group].tolerance});
  if (!moves) return Trouble{line, moves.error()};
  Made made;
  made.line = line;
  made.group = group;
  made.moves = std::move(*moves);
  made.file = file.string();
  add(std::move(made), true);
  return give_moves(group_requests, made_.back());
}

std::optional<ScriptGroups::Trouble> ScriptGroups::give_moves(runtime::GroupRequests& group_requests, Made& made) {
  while (made.newest && made.given < made.moves.size()) {
    std::vector<trajectory::PathMove> next;
    for (auto i = made.given; i < made.moves.size() && next.size() < kMovesAtOnce; ++i)
      next.push_back(made.moves[i].move);
    const bool ends = made.given + next.size() == made.moves.size();
    const auto taken = group_requests.add_moves(caller_, made.group, next, made.given == 0, ends);
    if (!taken) {
      return Trouble{made.line,
                     {1, fmt::format("{}:{}: {}", made.file, made.moves[made.given].line,
                                     runtime::describe(group_requests.event_group(made.group), taken.error()))}};
    }
    if (taken->count == 0) break;
    if (made.last == 0 || made.first > made.last) made.first = taken->first;
    made.last = taken->first + taken->count - 1;
    made.given += taken->count;
  }
  return std::nullopt;
}

/// Requests numbered between those of a path may belong to other callers.
std::optional<ScriptGroups::Trouble> ScriptGroups::check_made(const runtime::GroupRequests& group_requests,
                                                              Made& made) const {
  for (; made.last != 0 && made.first <= made.last; ++made.first) {
    const auto progress = group_requests.progress(made.group, made.first);
    const auto phase = progress.report.phase;
    if (!progress.report.over() && phase != RequestPhase::kUnknown) return std::nullopt;
    if (!made.newest) continue;
    if (progress.refusal)
      return Trouble{made.line, {1, runtime::describe(group_requests.event_group(made.group), *progress.refusal)}};
    if (phase == RequestPhase::kAborted) {
      return Trouble{made.line,
                     {1, fmt::format("group {}: another request has replaced this one",
                                     group_requests.groups()[made.group].name)}};
    }
  }
  made.over = made.given == made.moves.size() || !made.newest;
  return std::nullopt;
}

std::optional<ScriptGroups::Trouble> ScriptGroups::poll(runtime::GroupRequests& group_requests) {
  for (auto& made : made_) {
    if (made.over) continue;
    if (auto trouble = check_made(group_requests, made)) return trouble;
    if (auto trouble = give_moves(group_requests, made)) return trouble;
  }
  return std::nullopt;
}

bool ScriptGroups::arrived(std::optional<std::size_t> group) const {
  return std::all_of(made_.begin(), made_.end(), [group](const Made& made) {
    return made.over || !made.newest || (group && *group != made.group);
  });
}

}  // namespace driveline::cli
