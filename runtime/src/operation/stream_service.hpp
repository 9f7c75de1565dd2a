#pragma once

#include <memory>
#include <vector>

#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/event.hpp"
#include "stream/remote_streams.hpp"
#include "stream/single_axes_access.hpp"
#include "stream/stream_hub.hpp"
#include "stream/stream_server.hpp"

namespace driveline::runtime {

/// [stream] of a line whose axes are commanded individually. Made before the cycle starts, destroyed when it has ended;
/// belongs to the thread that owns the master.
class StreamService {
 public:
  /// Gives each axis that accepts streams its feed. The references must outlive it.
  StreamService(const LineConfig& config, motion::SingleAxes& axes, AxisAuthority& authority);

  /// Returns the task to run in every cycle.
  [[nodiscard]] motion::CycleTask& task() noexcept { return hub_; }
  /// Call with all slaves in OP: clients may connect. Error (kMachine): the socket is not available.
  [[nodiscard]] Result<void> start();
  /// Returns the streaming interface available since start(), as an event.
  [[nodiscard]] events::StreamUp offer() const { return server_->offer(); }
  /// Returns the streams of remote clients. Valid since start().
  [[nodiscard]] RemoteStreams& remote() noexcept { return *remote_; }
  /// Returns the events since the last call. Accepts waiting clients as soon as the start of the run has released the
  /// axes.
  [[nodiscard]] std::vector<Event> poll();
  /// Ends all sessions; their axes come to rest.
  void close();

 private:
  [[nodiscard]] bool starting() const;

  const LineConfig& config_;
  AxisAuthority& authority_;
  SingleAxesAccess axes_access_;
  StreamHub hub_;
  std::unique_ptr<StreamServer> server_;
  std::unique_ptr<RemoteStreams> remote_;
};

}  // namespace driveline::runtime
