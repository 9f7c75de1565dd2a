#include "operation/stream_service.hpp"

#include <algorithm>
#include <utility>

#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/event.hpp"
#include "stream/stream_bounds.hpp"

namespace driveline::runtime {

StreamService::StreamService(const LineConfig& config, motion::SingleAxes& axes, AxisAuthority& authority)
    : config_(config), authority_(authority), axes_access_(axes), hub_(axes_access_, config.axes.size()) {
  for (const auto axis : config.stream->axes) axes.add_feed(hub_.feed(axis), {axis});
}

Result<void> StreamService::start() {
  std::vector<StreamAxis> axes;
  for (const auto axis : config_.stream->axes) {
    const auto& described = config_.axes[axis];
    axes.push_back({described.name, axis, stream_bounds(described), motion::position_unit(described)});
  }
  remote_ = std::make_unique<RemoteStreams>(hub_, authority_, config_.stream->settings, axes, config_.period);
  auto opened = StreamServer::open(*config_.stream, std::move(axes), hub_, authority_, config_.period);
  if (!opened) return tl::unexpected(opened.error());
  server_ = std::move(*opened);
  return {};
}

std::vector<Event> StreamService::poll() {
  return server_ && !starting() ? server_->poll() : std::vector<Event>{};
}

bool StreamService::starting() const {
  return std::any_of(config_.stream->axes.begin(), config_.stream->axes.end(),
                     [this](std::size_t axis) { return authority_.holds(axis, kStartOfRun); });
}

void StreamService::close() {
  if (server_) server_->close();
}

}  // namespace driveline::runtime
