#include "stream/session_watch.hpp"

#include <utility>

namespace driveline::runtime {

SessionWatch::SessionWatch(StreamPeer peer, std::vector<StreamAxis> axes, StreamSession& session)
    : peer_(std::move(peer)), axes_(std::move(axes)), session_(session), status_(session.status()) {}

void SessionWatch::tell_begin(const Note& note) const {
  std::vector<std::string> names;
  for (const auto& axis : axes_) names.push_back(axis.name);
  note(events::StreamClientCame{peer_, std::move(names)}, Severity::kProgress);
}

void SessionWatch::poll(const Note& note) {
  stream::StatusRecord record;
  if (!status_.latest(record)) return;
  last_ = record;
  for (std::size_t i = 0; i < stream::kRefusals; ++i) {
    if (record.refused[i] == 0 || std::exchange(reported_[i], true)) continue;
    tell_refusal(static_cast<stream::Refusal>(i), note);
  }
  if (record.starved > 0 && !std::exchange(reported_starved_, true))
    note(events::StreamStarved{peer_}, Severity::kNotice);
}

void SessionWatch::tell_refusal(stream::Refusal reason, const Note& note) const {
  events::StreamSetpointRefused refused{peer_, reason, {}, session_.first_fault(reason)};
  if (refused.fault) {
    const auto& axis = axes_[refused.fault->axis];
    refused.axis = {axis.name, axis.unit};
  }
  note(std::move(refused), Severity::kNotice);
}

void SessionWatch::tell_end(const Note& note) const {
  const bool orderly = last_.reason == stream::EndReason::kEnded || last_.reason == stream::EndReason::kLine;
  note(events::StreamClientLeft{peer_, last_.reason, last_.taken, last_.refused, last_.starved},
       orderly ? Severity::kProgress : Severity::kNotice);
}

}  // namespace driveline::runtime
