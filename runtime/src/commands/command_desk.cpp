#include "commands/command_desk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "driveline/runtime/event/axis_events.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::RequestPhase;
using snapshot::CommandKind;
using snapshot::CommandRecord;
using snapshot::CommandResult;

constexpr std::chrono::seconds kSumInterval{1};
/// Shortest interval between renewals by setpoints, which arrive by the thousand; the shortest lease is ten times as
/// long.
constexpr std::chrono::milliseconds kHeardInterval{5};
/// A client without pending requests may be replaced after being silent for this long.
constexpr std::chrono::seconds kForgetAfter{10};
/// Leading bytes of the GUID that identify the participant (RTPS 2.2, 8.2.4.2).
constexpr std::size_t kPrefixBytes = 12;

struct KindName {
  CommandKind kind;
  std::string_view name;
  AxisCommand command = AxisCommand::kHalt;  ///< for commands that become a request to the axis
};
/// Indexed by the number of the command.
constexpr std::array kKinds = {
    KindName{CommandKind::kAcquire, "acquire"},
    KindName{CommandKind::kRenew, "renew"},
    KindName{CommandKind::kRelease, "release"},
    KindName{CommandKind::kEnable, "enable", AxisCommand::kPower},
    KindName{CommandKind::kDisable, "disable", AxisCommand::kPower},
    KindName{CommandKind::kReset, "reset", AxisCommand::kReset},
    KindName{CommandKind::kHalt, "halt", AxisCommand::kHalt},
    KindName{CommandKind::kQuickStop, "quick stop", AxisCommand::kStop},
    KindName{CommandKind::kReleaseStop, "release stop", AxisCommand::kReleaseStop},
    KindName{CommandKind::kJog, "jog", AxisCommand::kMoveVelocity},
    KindName{CommandKind::kMoveAbsolute, "move absolute", AxisCommand::kMoveAbsolute},
    KindName{CommandKind::kMoveRelative, "move relative", AxisCommand::kMoveRelative},
};

/// Returns null if there is no such command.
const KindName* kind_of(const CommandRecord& record) noexcept {
  return record.kind < kKinds.size() ? &kKinds[record.kind] : nullptr;
}

std::string name_of_kind(const CommandRecord& record) {
  const auto* const kind = kind_of(record);
  return kind != nullptr ? std::string(kind->name) : fmt::format("command {}", record.kind);
}

bool is_lease(CommandKind kind) noexcept {
  return kind == CommandKind::kAcquire || kind == CommandKind::kRenew || kind == CommandKind::kRelease;
}

bool is_stop(const CommandRecord& record) noexcept {
  const auto* const kind = kind_of(record);
  return kind != nullptr && (kind->kind == CommandKind::kHalt || kind->kind == CommandKind::kQuickStop);
}

/// Texts of a client reach terminals, files and subscribers: only printable ASCII is permitted.
bool printable(std::string_view text) noexcept {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

std::string shown(std::string_view text) {
  std::string clean(text);
  std::replace_if(
      clean.begin(), clean.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return clean;
}

AxisRequest request_of(const CommandRecord& record, const KindName& kind) {
  AxisRequest request;
  request.command = kind.command;
  request.on = kind.kind == CommandKind::kEnable;
  const bool moves = kind.kind == CommandKind::kJog || kind.kind == CommandKind::kMoveAbsolute ||
                     kind.kind == CommandKind::kMoveRelative;
  if (!moves) return request;
  request.target_si = record.target;
  request.velocity_si = kind.kind == CommandKind::kJog ? 0.0 : record.velocity;
  request.acceleration_si = record.acceleration;
  request.deceleration_si = record.deceleration;
  request.jerk_si = record.jerk;
  return request;
}

}  // namespace

std::string commander_name(const snapshot::CommandParticipant& participant, std::string_view client) {
  auto text = fmt::format("dds {} (participant ", client.empty() ? "?" : shown(client));
  for (std::size_t i = 0; i < kPrefixBytes; ++i) text += fmt::format("{:02x}", participant[i]);
  return text + ')';
}

void CommandDesk::take(const CommandRecord& record) {
  const auto now = clock_.now();
  // A client that floods the line must not keep others from stopping an axis: stops are limited separately.
  if (!(is_stop(record) ? total_stops_ : total_).take(now)) {
    ++summary_.dropped;
    return;
  }
  const auto name = record.client.view();
  auto who = commander_name(record.participant, name);
  if (name.empty() || !printable(name)) {
    refuse(who, record, "the name of a client must have 1 to 63 printable ASCII characters");
    return;
  }
  auto* const client = find_client(record, name);
  if (client == nullptr) {
    refuse(who, record, "the maximum number of clients is reached");
    return;
  }
  if (!client->begun) client->caller.name = std::move(who);
  auto& limit = is_stop(record) ? client->stops : client->rate;
  if (!limit.take(now)) {
    ++summary_.refused;
    answer(record, CommandResult::kRefused,
           fmt::format("too many commands: at most {} per second are accepted", kClientRate), held(*client, record));
    return;
  }
  if (client->begun && record.number <= client->last_number) {
    refuse(client->caller.name, record,
           fmt::format("number {} must be above {}, the number of the previous command", record.number,
                       client->last_number),
           held(*client, record));
    return;
  }
  client->begun = true;
  client->heard = now;
  client->last_number = record.number;
  judge(*client, record);
}

/// Returns null if there are too many clients.
CommandDesk::Client* CommandDesk::find_client(const CommandRecord& record, std::string_view name) {
  Key key{record.participant, std::string(name)};
  if (const auto found = clients_.find(key); found != clients_.end()) return &found->second;
  const auto names = std::count_if(clients_.begin(), clients_.end(),
                                   [&](const auto& entry) { return entry.first.first == record.participant; });
  if (names >= kMaxNames && !make_room(&record.participant)) return nullptr;
  if (clients_.size() >= kMaxClients && !make_room(nullptr)) return nullptr;
  auto& client = clients_[std::move(key)];
  client.caller.keep_alive = lease_timeout_;
  return &client;
}

bool CommandDesk::make_room(const snapshot::CommandParticipant* of) {
  const auto now = clock_.now();
  const auto free = std::find_if(clients_.begin(), clients_.end(), [&](const auto& entry) {
    const auto& client = entry.second;
    return (of == nullptr || entry.first.first == *of) && client.pending.empty() &&
           now - client.heard > std::max<std::chrono::nanoseconds>(kForgetAfter, lease_timeout_);
  });
  if (free == clients_.end()) return false;
  clients_.erase(free);
  return true;
}

void CommandDesk::judge(Client& client, const CommandRecord& record) {
  const auto* const kind = kind_of(record);
  if (kind == nullptr) {
    refuse(client.caller.name, record, fmt::format("there is no command with number {}", record.kind),
           held(client, record));
    return;
  }
  const auto axis = axis_requests_.find(record.axis.view());
  if (!axis) {
    refuse(client.caller.name, record, fmt::format("there is no axis \"{}\"", shown(record.axis.view())));
    return;
  }
  if (is_lease(kind->kind)) {
    lease(client, record, *axis);
  } else {
    request(client, record, *axis);
  }
}

void CommandDesk::lease(Client& client, const CommandRecord& record, std::size_t axis) {
  auto caller = client.caller;
  caller.lease = record.lease;
  const auto& name = axis_requests_.axes()[axis].name;
  const auto kind = kKinds[record.kind].kind;
  if (kind == CommandKind::kAcquire) {
    const auto taken = axis_requests_.acquire(client.caller, axis);
    if (!taken) {
      refuse(caller.name, record, describe(events::event_axis(axis_requests_.axes()[axis]), taken.error()));
      return;
    }
    client.commands = true;
    note({caller.name, name, name_of_kind(record), {}});
    answer(record, CommandResult::kDone, {}, *taken);
    return;
  }
  if (!axis_requests_.holds(caller, axis)) {
    AxisRefusal refusal;
    refusal.why = AxisRefusal::Why::kNoLease;
    refuse(caller.name, record, describe(events::event_axis(axis_requests_.axes()[axis]), refusal));
    return;
  }
  if (kind == CommandKind::kRenew) {
    axis_requests_.keep_alive(client.caller);
    answer(record, CommandResult::kDone, {}, record.lease);
    return;
  }
  axis_requests_.give_back(caller.name, axis);
  note({caller.name, name, name_of_kind(record), {}});
  answer(record, CommandResult::kDone, {});
}

void CommandDesk::request(Client& client, const CommandRecord& record, std::size_t axis) {
  if (client.pending.size() >= kMaxRequests && !is_stop(record)) {
    refuse(client.caller.name, record, fmt::format("{} commands are already in progress", kMaxRequests),
           held(client, record));
    return;
  }
  auto caller = client.caller;
  caller.lease = record.lease;
  caller.quiet = !may_tell();
  const auto submitted = axis_requests_.submit(caller, axis, request_of(record, kKinds[record.kind]));
  if (caller.quiet) ++(submitted ? summary_.accepted : summary_.refused);
  if (!submitted) {
    answer(record, CommandResult::kRefused,
           describe(events::event_axis(axis_requests_.axes()[axis]), submitted.error()), held(client, record));
    return;
  }
  const auto lease = held(client, record);
  if (*submitted == AxisRequests::kRunEnded) {
    answer(record, CommandResult::kDone, "all axes stop, and the run ends", lease);
    return;
  }
  // Stops are always accepted, but only a limited number of them is tracked.
  const bool followed = client.pending.size() < 2 * kMaxRequests;
  answer(record, followed ? CommandResult::kAccepted : CommandResult::kDone,
         followed ? "" : "the axis is commanded to stop; no further answer follows: too many commands are pending",
         lease);
  if (followed) client.pending.push_back({record, axis, *submitted});
}

void CommandDesk::poll() {
  axis_requests_.watch();
  for (auto& [key, client] : clients_) poll_client(client);
  const auto now = clock_.now();
  if (now < next_sum_) return;
  next_sum_ = now + kSumInterval;
  const auto sum = std::exchange(summary_, {});
  if (sum.accepted + sum.refused + sum.dropped > 0) axis_requests_.note(sum);
}

/// Answers the requests of a client that are over.
void CommandDesk::poll_client(Client& client) {
  std::erase_if(client.pending, [&](const Pending& pending) {
    const auto progress = axis_requests_.progress(pending.axis, pending.request);
    const auto phase = progress.report.phase;
    if (phase == RequestPhase::kWaiting || phase == RequestPhase::kActive) return false;
    const auto lease = held(client, pending.record);
    const auto axis = events::event_axis(axis_requests_.axes()[pending.axis]);
    if (phase == RequestPhase::kDone || phase == RequestPhase::kReached) {
      answer(pending.record, CommandResult::kDone,
             phase == RequestPhase::kReached ? "the axis has reached the velocity" : "", lease);
    } else if (progress.refusal) {
      answer(pending.record, CommandResult::kAborted, describe(axis, *progress.refusal), lease);
    } else {
      answer(pending.record, CommandResult::kAborted,
             fmt::format("axis {}: another request has replaced it", axis.name), lease);
    }
    return true;
  });
}

void CommandDesk::heard(const snapshot::CommandParticipant& participant, std::string_view name) {
  const auto found = clients_.find(Key{participant, std::string(name)});
  const auto now = clock_.now();
  if (found == clients_.end() || now - found->second.heard < kHeardInterval) return;
  found->second.heard = now;
  axis_requests_.keep_alive(found->second.caller);
}

/// Clients stay known: after a restart of the bridge their middleware resends unacknowledged commands, even if
/// they were executed long ago; their numbers identify them.
void CommandDesk::bridge_lost() {
  invalid_data_reported_ = false;
  for (auto& [key, client] : clients_) {
    client.pending.clear();
    if (!std::exchange(client.commands, false)) continue;
    bool holds = false;
    for (std::size_t axis = 0; axis < axis_requests_.axes().size(); ++axis) {
      if (axis_requests_.status(axis).owner != client.caller.name) continue;
      holds = true;
      axis_requests_.give_back(client.caller.name, axis);
    }
    if (holds) axis_requests_.note(events::CommanderLost{client.caller.name});
  }
}

void CommandDesk::report_invalid_data() {
  if (!std::exchange(invalid_data_reported_, true)) axis_requests_.note(events::InvalidCommands{});
}

void CommandDesk::answer(const CommandRecord& record, CommandResult result, std::string_view text,
                         std::uint64_t lease) {
  snapshot::CommandAnswer answer;
  answer.participant = record.participant;
  answer.client = record.client;
  answer.axis = record.axis;
  answer.number = record.number;
  answer.lease = lease;
  answer.result = static_cast<std::uint32_t>(result);
  answer.text.set(text);
  answers_.push_back(answer);
}

void CommandDesk::refuse(const std::string& who, const CommandRecord& record, const Problem& problem,
                         std::uint64_t lease) {
  note({who, shown(record.axis.view()), name_of_kind(record), problem});
  answer(record, CommandResult::kRefused, problem, lease);
}

/// Returns the lease that the record names if the client holds it; 0: it does not.
std::uint64_t CommandDesk::held(const Client& client, const CommandRecord& record) const {
  const auto axis = axis_requests_.find(record.axis.view());
  auto caller = client.caller;
  caller.lease = record.lease;
  return axis && axis_requests_.holds(caller, *axis) ? record.lease : 0;
}

void CommandDesk::note(events::CommandAnswered facts) {
  if (may_tell()) {
    axis_requests_.note(std::move(facts));
  } else {
    ++(facts.refusal.empty() ? summary_.accepted : summary_.refused);
  }
}

}  // namespace driveline::runtime
