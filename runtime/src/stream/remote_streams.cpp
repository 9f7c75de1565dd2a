#include "stream/remote_streams.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string_view>

namespace driveline::runtime {
namespace {

using snapshot::SetpointKind;
using snapshot::StreamedSetpoint;
using stream::EndReason;
using stream::RecordKind;

/// Interval between two events about refused streams.
constexpr std::chrono::seconds kRefusalEvents{1};

/// Returns the text of a client with only printable ASCII: it reaches terminals, files and subscribers.
std::string clean(std::string_view text) {
  std::string result(text.empty() ? "?" : text);
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~' || c == '"'; }, '?');
  return result;
}

/// Converts to the record of a client in shared memory; invalid data stay invalid and are counted by the session.
stream::SetpointRecord record_of(const StreamedSetpoint& from, bool same_axes) {
  stream::SetpointRecord record;
  const auto kind = static_cast<SetpointKind>(from.kind);
  if (kind == SetpointKind::kGo && from.target_count == 0) return record;
  record.kind = kind == SetpointKind::kGo       ? RecordKind::kSetpoint
                : kind == SetpointKind::kFollow ? RecordKind::kFollow
                : kind == SetpointKind::kEnd    ? RecordKind::kEnd
                                                : static_cast<RecordKind>(0);
  record.number = from.number;
  record.time_ns = from.time_ns;
  record.axis_count = same_axes ? from.target_count : 0;
  for (std::size_t i = 0; i < from.targets.size(); ++i) {
    const auto& target = from.targets[i];
    record.targets[i] = {target.position, target.velocity, target.acceleration};
  }
  return record;
}

}  // namespace

static_assert(snapshot::kStreamedAxes == stream::kMaxAxes);

bool RemoteStreams::take(const StreamedSetpoint& record, const std::string& owner, Instant now) {
  auto* found = find(record);
  const bool over = found != nullptr && !hub_.holds(*found->session);
  if (found == nullptr || over) {
    if (static_cast<SetpointKind>(record.kind) != SetpointKind::kGo || over) return false;
    const auto begun = begin(record, owner);
    if (!begun) {
      refuse(record, owner, begun.error().reason, now);
      return false;
    }
    found = *begun;
  }
  const bool all_his = lease_again(*found, record, owner);
  write(*found, record);
  return all_his;
}

RemoteStreams::Stream* RemoteStreams::find(const StreamedSetpoint& record) noexcept {
  const auto found = std::find_if(streams_.begin(), streams_.end(), [&](const Stream& stream) {
    return stream.participant == record.participant && stream.client.view() == record.client.view();
  });
  return found == streams_.end() ? nullptr : &*found;
}

Result<RemoteStreams::Stream*> RemoteStreams::begin(const StreamedSetpoint& record, const std::string& owner) {
  if (closed_) return fail(ErrorKind::kSetting, "the line ends");
  auto axes = choose(record, owner);
  if (!axes) return tl::unexpected(axes.error());
  if (streams_.size() >= kMaxStreams || hub_.full()) {
    return fail(ErrorKind::kMachine, "the maximum number of stream clients is reached");
  }
  std::vector<StreamSession::Member> members;
  for (std::size_t i = 0; i < axes->size(); ++i) {
    members.push_back({(*axes)[i].axis, (*axes)[i].bounds, record.axes[i].lease});
  }
  auto session = StreamSession::make(std::move(members), false, settings_, period_, authority_);
  if (!session) return tl::unexpected(session.error());
  rt::SharedRingWriter<stream::SetpointRecord> ring((*session)->setpoints());
  StreamPeer peer;
  peer.name = owner;
  SessionWatch watch(std::move(peer), *std::move(axes), **session);
  auto& stream =
      streams_.emplace_back(Stream{record.participant, record.client, *std::move(session), ring, std::move(watch)});
  static_cast<void>(hub_.add(*stream.session));  // if the hub is full, poll() finds the session over
  stream.watch.tell_begin([this](EventFacts facts, Severity) { events_.push_back(std::move(facts)); });
  return &stream;
}

Result<std::vector<StreamAxis>> RemoteStreams::choose(const StreamedSetpoint& record, const std::string& owner) const {
  if (record.axis_count == 0 || record.axis_count > record.axes.size()) {
    return fail(ErrorKind::kSetting,
                fmt::format("a stream has 1 to {} axes, not {}", record.axes.size(), record.axis_count));
  }
  std::vector<StreamAxis> chosen;
  for (std::size_t i = 0; i < record.axis_count; ++i) {
    const auto name = record.axes[i].name.view();
    const auto is_it = [name](const StreamAxis& axis) { return axis.name == name; };
    const auto found = std::find_if(axes_.begin(), axes_.end(), is_it);
    if (found == axes_.end())
      return fail(ErrorKind::kSetting, fmt::format("there is no axis \"{}\" for streams", clean(name)));
    if (std::any_of(chosen.begin(), chosen.end(), is_it)) {
      return fail(ErrorKind::kSetting, fmt::format("axis {} is named twice", found->name));
    }
    if (!his(found->axis, record.axes[i].lease, owner)) {
      AxisRefusal refusal;
      refusal.why = AxisRefusal::Why::kNoLease;
      return fail(ErrorKind::kSetting, describe(events::EventAxis{found->name, {}, 1.0}, refusal));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

bool RemoteStreams::his(std::size_t axis, std::uint64_t lease, const std::string& owner) const {
  return authority_.goes_on(axis, lease) && authority_.holds(axis, owner);
}

/// Passes new leases to the session: an axis that was lost and acquired again has another lease. Returns true if the
/// client owns all axes.
bool RemoteStreams::lease_again(Stream& stream, const StreamedSetpoint& record, const std::string& owner) {
  const auto& axes = stream.watch.axes();
  if (record.axis_count != axes.size()) return false;
  bool all = true;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto lease = record.axes[i].lease;
    const bool has_it = his(axes[i].axis, lease, owner);
    all = all && has_it;
    if (has_it && lease != stream.session->lease(i)) stream.session->give(i, lease);
  }
  return all;
}

void RemoteStreams::write(Stream& stream, const StreamedSetpoint& record) {
  const auto& axes = stream.watch.axes();
  bool same = record.axis_count == axes.size() && record.target_count == axes.size();
  for (std::size_t i = 0; same && i < axes.size(); ++i) same = record.axes[i].name.view() == axes[i].name;
  // A record for which there is no room is dropped; the gap in the numbers reveals it.
  static_cast<void>(stream.ring.try_push(record_of(record, same)));
}

void RemoteStreams::refuse(const StreamedSetpoint& record, const std::string& owner, const std::string& reason,
                           Instant now) {
  if (now >= next_refusal_event_) {
    next_refusal_event_ = now + kRefusalEvents;
    events::StreamClientRefused refused;
    refused.peer.name = owner;
    refused.reason = reason;
    refused.more = std::exchange(unreported_, 0);
    events_.emplace_back(std::move(refused));
  } else {
    ++unreported_;
  }
  if (now < next_refusal_) return;
  next_refusal_ = now + kReportInterval;
  auto& report = reports_.emplace_back();
  report.participant = record.participant;
  report.client = record.client;
  report.state = static_cast<std::uint32_t>(snapshot::StreamReportState::kRefused);
  report.text.set(reason);
}

void RemoteStreams::poll(Instant now) {
  for (auto& stream : streams_) poll_stream(stream, now);
  streams_.remove_if([](const Stream& stream) { return stream.over; });
}

void RemoteStreams::poll_stream(Stream& stream, Instant now) {
  const auto note = [&](EventFacts facts, Severity) {
    if (facts.is<events::StreamSetpointRefused>()) stream.text = describe(Event{facts});
    events_.push_back(std::move(facts));
  };
  // Checked before poll(), so that the last poll() comes after the end of the session.
  stream.over = !hub_.holds(*stream.session);
  stream.watch.poll(note);
  bool leased = false;
  for (std::size_t i = 0; i < stream.watch.axes().size(); ++i) leased = leased || stream.session->commands(i);
  if (!leased) stream.session->request_end(EndReason::kGone);
  if (stream.over) {
    stream.text = to_text(stream.watch.status().reason);
    stream.watch.tell_end(note);
  }
  if (stream.over || now >= stream.next_report || stream.watch.status().state != stream.reported) report(stream, now);
}

void RemoteStreams::report(Stream& stream, Instant now) {
  const auto& status = stream.watch.status();
  stream.next_report = now + kReportInterval;
  stream.reported = status.state;
  auto& report = reports_.emplace_back();
  report.participant = stream.participant;
  report.client = stream.client;
  // Both enumerations have the same numbers.
  report.state = static_cast<std::uint32_t>(status.state);
  report.stream_ns = status.stream_ns;
  report.newest_ns = status.newest_ns;
  report.taken = status.taken;
  report.refused = std::accumulate(status.refused.begin(), status.refused.end(), std::uint64_t{0}) -
                   status.count(stream::Refusal::kGap);
  report.starved = status.starved;
  report.text.set(stream.text);
  report.axis_count = static_cast<std::uint32_t>(stream.watch.axes().size());
  for (std::size_t i = 0; i < report.axis_count; ++i) {
    const auto& axis = status.axes[i];
    report.axes[i].name.set(stream.watch.axes()[i].name);
    report.axes[i].following = axis.following;
    report.axes[i].leased = axis.leased;
    report.axes[i].setpoint = axis.setpoint;
    report.axes[i].position = axis.position;
  }
}

void RemoteStreams::end_all(EndReason reason) {
  for (auto& stream : streams_) stream.session->request_end(reason);
}

}  // namespace driveline::runtime
