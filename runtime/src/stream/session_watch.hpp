#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "driveline/rt/shared_broadcast.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/stream/greeting.hpp"
#include "driveline/stream/records.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "stream/stream_session.hpp"

namespace driveline::runtime {

/// An axis that clients may have.
struct StreamAxis {
  std::string name;      ///< as in the line description
  std::size_t axis = 0;  ///< number on the line
  stream::AxisBounds bounds{};
  trajectory::PositionUnit unit = *trajectory::find_position_unit("rad");  ///< in which people read its positions
};

/// Tells people what becomes of a session: who came, the first setpoint of each kind that is refused, the end. Belongs
/// to one thread.
class SessionWatch {
 public:
  /// Where events go.
  using Note = std::function<void(EventFacts, Severity)>;

  /// `axes`: of the session, in its order. `session` must outlive it.
  SessionWatch(StreamPeer peer, std::vector<StreamAxis> axes, StreamSession& session);

  /// Tells of the beginning.
  void tell_begin(const Note& note) const;
  /// Looks at the status, and tells what is new in it.
  void look(const Note& note);
  /// Tells of the end.
  void tell_end(const Note& note) const;

  /// Whose it is.
  [[nodiscard]] const StreamPeer& peer() const noexcept { return peer_; }
  /// Of the session.
  [[nodiscard]] const std::vector<StreamAxis>& axes() const noexcept { return axes_; }
  /// The status of the last look.
  [[nodiscard]] const stream::StatusRecord& status() const noexcept { return last_; }

 private:
  void tell_refusal(stream::Refusal reason, const Note& note) const;

  StreamPeer peer_;
  std::vector<StreamAxis> axes_;
  StreamSession& session_;
  rt::SharedBroadcastReader<stream::StatusRecord> status_;
  stream::StatusRecord last_{};
  std::array<bool, stream::kRefusals> told_{};
  bool told_starved_ = false;
};

}  // namespace driveline::runtime
