#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "stream/stream_session.hpp"

namespace driveline::runtime {

/// An axis that accepts streams.
struct StreamAxis {
  std::string name;      ///< name in the line description
  std::size_t axis = 0;  ///< number on the line
  stream::AxisBounds bounds{};
  /// Unit in which its positions are displayed.
  trajectory::PositionUnit unit = *trajectory::find_position_unit("rad");
};

/// Reports the events of a session: its start, the first refused setpoint of each kind, its end. Belongs to one thread.
class SessionWatch {
 public:
  /// Receives the events.
  using Note = std::function<void(EventFacts, Severity)>;

  /// `axes`: axes of the session, in its order. `session` must outlive it.
  SessionWatch(StreamPeer peer, std::vector<StreamAxis> axes, StreamSession& session);

  /// Reports the start of the session.
  void tell_begin(const Note& note) const;
  /// Reads the status, and reports what is new in it.
  void poll(const Note& note);
  /// Reports the end of the session.
  void tell_end(const Note& note) const;

  /// Returns the client.
  [[nodiscard]] const StreamPeer& peer() const noexcept { return peer_; }
  /// Returns the axes of the session.
  [[nodiscard]] const std::vector<StreamAxis>& axes() const noexcept { return axes_; }
  /// Returns the status at the last poll().
  [[nodiscard]] const stream::StatusRecord& status() const noexcept { return last_; }

 private:
  void tell_refusal(stream::Refusal reason, const Note& note) const;

  StreamPeer peer_;
  std::vector<StreamAxis> axes_;
  StreamSession& session_;
  rt::SharedBroadcastReader<stream::StatusRecord> status_;
  stream::StatusRecord last_{};
  std::array<bool, stream::kRefusals> reported_{};
  bool reported_starved_ = false;
};

}  // namespace driveline::runtime
