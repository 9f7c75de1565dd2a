#include "groups/group_service.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "axes/axis_service.hpp"
#include "axes/axis_words.hpp"
#include "groups/group_view.hpp"
#include "groups/group_words.hpp"

namespace driveline::cli {
namespace {

using motion::RequestPhase;
using nlohmann::json;

json failure(const Failure& failure) {
  return {{"error", failure.text}, {"status", failure.status}};
}

/// Whether the request leaves the motion in progress, which is what the client waits for.
bool steers(runtime::ClientGroupRequest::Verb verb) {
  using Verb = runtime::ClientGroupRequest::Verb;
  return verb == Verb::kHold || verb == Verb::kResume || verb == Verb::kReverse || verb == Verb::kForward ||
         verb == Verb::kOverride;
}

/// Removes the first word from the line and returns it.
std::string_view take_word(std::string_view& line) {
  while (line.starts_with(' ')) line.remove_prefix(1);
  const auto word = line.substr(0, line.find(' '));
  line.remove_prefix(word.size());
  return word;
}

}  // namespace

std::string GroupService::execute(const CommandSender& sender, std::string_view words) {
  auto& client = clients_[sender.connection];
  client.caller.name = caller_name(sender);
  client.caller.keep_alive = AxisService::kKeepAlive;
  axes_.keep_alive(client.caller);
  return answer(client, words).dump(-1, ' ', true, json::error_handler_t::replace);
}

json GroupService::answer(Client& client, std::string_view line) {
  auto rest = line;
  const auto first = take_word(rest);
  auto words = split_words(rest);
  if (words.empty() && first == "progress") return progress(client);
  if (words.empty() && first == "detach") {
    client.detached = true;
    return json::object();
  }
  if (words.empty()) return failure({2, "the name of a group and a request are expected"});
  if (first == "all" && words[0] == "status" && words.size() == 1) return status(std::nullopt);
  const auto group = find_group(groups_.groups(), first);
  if (!group) return failure(group.error());
  if (words[0] == "status" && words.size() == 1) return status(*group);
  if (words[0] == "release" && words.size() == 1) {
    groups_.release(client.caller.name, *group);
    return status(*group);
  }
  if (words[0] == "path") {
    take_word(rest);
    return add_moves(client, *group, rest);
  }
  return order(client, *group, std::move(words));
}

json GroupService::order(Client& client, std::size_t group, std::vector<std::string> words) {
  auto caller = client.caller;
  caller.take_over = std::erase(words, "take-over") > 0;
  const auto request = parse_group_request({groups_.groups()[group], axes_.axes()}, words);
  if (!request) return failure(request.error());
  const auto taken = groups_.submit(caller, group, *request);
  if (!taken) return failure({1, runtime::describe(groups_.event_group(group), taken.error())});
  auto& tracked = client.requests[group];
  update_request(group, client, tracked);
  const bool under_way = tracked.first <= tracked.last && tracked.last != 0 && tracked.failure.empty();
  if (!under_way || !steers(request->verb)) tracked = {*taken, *taken, {}};
  return status(group);
}

json GroupService::add_moves(Client& client, std::size_t group, std::string_view text) {
  auto caller = client.caller;
  const auto which = take_word(text);
  const bool begins = which == "begin" || which == "only";
  const bool ends = which == "end" || which == "only";
  if (!begins && !ends && which != "go-on") return failure({2, "path: begin, go-on, end or only is expected"});
  constexpr std::string_view kTakeOver = " take-over";
  if (text.starts_with(kTakeOver)) {
    caller.take_over = true;
    text.remove_prefix(kTakeOver.size());
  }
  const auto document = json::parse(text, nullptr, false);
  if (!document.is_array()) return failure({2, "path: an array of moves is expected"});
  std::vector<trajectory::PathMove> moves;
  for (const auto& one : document) {
    auto move = parse_move(one, groups_.groups()[group].axes.size());
    if (!move) return failure(move.error());
    moves.push_back(std::move(*move));
  }
  const auto taken = groups_.add_moves(caller, group, moves, begins, ends);
  if (!taken) return failure({1, runtime::describe(groups_.event_group(group), taken.error())});
  if (taken->count > 0) {
    auto& request = client.requests[group];
    if (begins) request = {taken->first, 0, {}};
    update_request(group, client, request);
    if (request.first > request.last) request.first = taken->first;
    request.last = taken->first + taken->count - 1;
  }
  return {{"taken", taken->count}};
}

/// Advances `first` to the first request that is not over; numbers in between belong to other callers.
void GroupService::update_request(std::size_t group, const Client& client, Request& request) const {
  for (; request.failure.empty() && request.last != 0 && request.first <= request.last; ++request.first) {
    const auto progress = groups_.progress(group, request.first);
    const auto phase = progress.report.phase;
    if (!progress.report.over() && phase != RequestPhase::kUnknown) return;
    const auto name = groups_.groups()[group].name;
    if (progress.refusal) {
      request.failure = runtime::describe(groups_.event_group(group), *progress.refusal);
    } else if (phase == RequestPhase::kAborted) {
      const auto owner = groups_.status(group).owner;
      request.failure = !owner.empty() && owner != client.caller.name
                            ? fmt::format("group {}: {} has taken over its control", name, owner)
                            : fmt::format("group {}: another request has replaced this one", name);
    }
  }
}

json GroupService::progress(Client& client) const {
  auto rows = json::array();
  for (auto& [group, request] : client.requests) {
    update_request(group, client, request);
    auto row = this->row(group);
    row["accepted"] = request.first > request.last || groups_.progress(group, request.first).accepted;
    row["over"] = request.first > request.last || !request.failure.empty();
    if (!request.failure.empty()) row["failure"] = request.failure;
    rows.push_back(std::move(row));
  }
  return {{"groups", std::move(rows)}};
}

json GroupService::row(std::size_t group) const {
  return groups_json(groups_).at(group);
}

json GroupService::status(std::optional<std::size_t> group) const {
  if (!group) return {{"groups", groups_json(groups_)}};
  return {{"groups", json::array({row(*group)})}};
}

void GroupService::disconnected(const CommandSender& sender) {
  const auto found = clients_.find(sender.connection);
  if (found == clients_.end()) return;
  const auto& client = found->second;
  groups_.leave(client.caller.name, !client.detached);
  axes_.leave(client.caller.name, !client.detached);
  clients_.erase(found);
}

}  // namespace driveline::cli
