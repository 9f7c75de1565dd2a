#include "axes/axis_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "axes/axis_view.hpp"
#include "axes/axis_words.hpp"
#include "axes/coupling_words.hpp"
#include "driveline/runtime/event/axis_events.hpp"

namespace driveline::cli {
namespace {

using motion::RequestPhase;
using nlohmann::json;

json failure(const Failure& failure) {
  return {{"error", failure.text}, {"status", failure.status}};
}

/// Removes `word` from the words. Returns whether it was there.
bool take_word(std::vector<std::string>& words, std::string_view word) {
  return std::erase(words, word) > 0;
}

}  // namespace

std::string caller_name(const CommandSender& sender) {
  return fmt::format("control socket {} (process {}, user {})", sender.connection, sender.process, sender.user);
}

std::string AxisService::execute(const CommandSender& sender, std::string_view words) {
  auto& client = clients_[sender.connection];
  client.caller.name = caller_name(sender);
  client.caller.keep_alive = kKeepAlive;
  axis_requests_.keep_alive(client.caller);
  return answer(client, split_words(words)).dump(-1, ' ', true, json::error_handler_t::replace);
}

json AxisService::answer(Client& client, std::vector<std::string> words) {
  if (words.size() == 1 && words[0] == "progress") return progress(client);
  if (words.size() == 1 && words[0] == "detach") {
    client.detached = true;
    return json::object();
  }
  if (words.size() < 2) return failure({2, "the name of an axis and a request are expected"});
  const auto axes = find_axes(axis_requests_.axes(), words[0]);
  if (!axes) return failure(axes.error());
  words.erase(words.begin());
  if (words[0] == "status") return status(*axes);
  if (words[0] == "release") {
    for (const auto axis : *axes) axis_requests_.release(client.caller.name, axis);
    return status(*axes);
  }
  return order(client, *axes, std::move(words));
}

/// Submits nothing before the words have been parsed for all axes.
json AxisService::order(Client& client, const std::vector<std::size_t>& axes, std::vector<std::string> words) {
  auto caller = client.caller;
  caller.take_over = take_word(words, "take-over");
  if (!words.empty() && is_coupling_verb(words[0])) return couple(client, caller, axes, words);
  std::vector<motion::AxisRequest> requests;
  for (const auto axis : axes) {
    const auto request = parse_axis_request(axis_requests_.axes()[axis], words);
    if (!request) return failure(request.error());
    requests.push_back(*request);
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto taken = axis_requests_.submit(caller, axes[i], requests[i]);
    if (!taken) {
      return failure(
          {1, runtime::describe(runtime::events::event_axis(axis_requests_.axes()[axes[i]]), taken.error())});
    }
    client.requests[axes[i]] = *taken;
  }
  return status(axes);
}

json AxisService::couple(Client& client, const runtime::AxisCaller& caller, const std::vector<std::size_t>& axes,
                         const std::vector<std::string>& words) {
  std::vector<runtime::CouplingOrder> orders;
  for (const auto axis : axes) {
    auto order = parse_coupling_order(axis_requests_.axes(), couplings_, axis, words);
    if (!order) return failure(order.error());
    orders.push_back(std::move(*order));
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto taken = axis_requests_.submit(caller, axes[i], orders[i]);
    if (!taken) {
      return failure(
          {1, runtime::describe(runtime::events::event_axis(axis_requests_.axes()[axes[i]]), taken.error())});
    }
    client.requests[axes[i]] = *taken;
  }
  return status(axes);
}

json AxisService::progress(const Client& client) const {
  auto rows = json::array();
  for (const auto& [axis, request] : client.requests) {
    const auto progress = axis_requests_.progress(axis, request);
    auto row = to_json(axis_requests_.status(axis));
    row["accepted"] = progress.accepted;
    row["phase"] = std::string(motion::to_text(progress.report.phase));
    row["over"] = progress.report.over() || progress.report.phase == RequestPhase::kUnknown;
    row["reached"] = progress.report.phase == RequestPhase::kReached || progress.report.phase == RequestPhase::kDone;
    if (progress.recorded_position)
      row["recorded_position"] = axis_requests_.status(axis).axis.unit.from_si(*progress.recorded_position);
    if (auto why = failure_of(client, axis, progress); !why.empty()) row["failure"] = std::move(why);
    rows.push_back(std::move(row));
  }
  return {{"axes", std::move(rows)}};
}

/// Why the request failed, as a sentence; empty: it has not failed.
std::string AxisService::failure_of(const Client& client, std::size_t axis,
                                    const runtime::AxisProgress& progress) const {
  const auto event_axis = runtime::events::event_axis(axis_requests_.axes()[axis]);
  if (progress.refusal) return runtime::describe(event_axis, *progress.refusal);
  if (progress.report.phase != RequestPhase::kAborted) return {};
  const auto owner = axis_requests_.status(axis).owner;
  if (!owner.empty() && owner != client.caller.name)
    return fmt::format("axis {}: {} has taken over its control", event_axis.name, owner);
  return fmt::format("axis {}: another request has replaced this one", event_axis.name);
}

json AxisService::status(const std::vector<std::size_t>& axes) const {
  auto rows = json::array();
  for (const auto axis : axes) rows.push_back(to_json(axis_requests_.status(axis)));
  return {{"axes", std::move(rows)}};
}

void AxisService::disconnected(const CommandSender& sender) {
  const auto found = clients_.find(sender.connection);
  if (found == clients_.end()) return;
  axis_requests_.leave(found->second.caller.name, !found->second.detached);
  clients_.erase(found);
}

void AxisService::refused(const CommandSender& sender) {
  axis_requests_.note(
      runtime::events::CallerRefused{fmt::format("control socket (process {}, user {})", sender.process, sender.user),
                                     "the line belongs to another user"});
}

}  // namespace driveline::cli
