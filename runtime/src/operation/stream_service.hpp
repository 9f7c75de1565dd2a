#pragma once

#include <memory>
#include <vector>

#include "driveline/ecat_master/cyclic/cycle_task.hpp"
#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event.hpp"
#include "stream/remote_streams.hpp"
#include "stream/single_axes_door.hpp"
#include "stream/stream_hub.hpp"
#include "stream/stream_server.hpp"

namespace driveline::runtime {

/// [stream] of a line whose axes are commanded one by one. Made before the cycle starts, destroyed when it has ended;
/// belongs to the thread that owns the master.
class StreamService {
 public:
  /// Gives each axis that may be streamed to its feed. The references must outlive it.
  StreamService(const LineConfig& config, ecat_master::SingleAxes& axes, AxisAuthority& authority);

  /// To be run in every cycle.
  [[nodiscard]] ecat_master::CycleTask& task() noexcept { return hub_; }
  /// With all slaves in OP: clients may connect. Error (kMachine): the socket cannot be had.
  [[nodiscard]] Result<void> start();
  /// What is on offer since start().
  [[nodiscard]] events::StreamUp offer() const { return server_->offer(); }
  /// Since start(): streams of clients elsewhere.
  [[nodiscard]] RemoteStreams& remote() noexcept { return *remote_; }
  /// What has happened since the last call. Those who have connected are let in as soon as the start of the run has
  /// given the axes free.
  [[nodiscard]] std::vector<Event> poll();
  /// Ends all sessions; their axes come to rest.
  void close();

 private:
  [[nodiscard]] bool starting() const;

  const LineConfig& config_;
  AxisAuthority& authority_;
  SingleAxesDoor door_;
  StreamHub hub_;
  std::unique_ptr<StreamServer> server_;
  std::unique_ptr<RemoteStreams> remote_;
};

}  // namespace driveline::runtime
