#include "operation/stream_service.hpp"

#include <utility>

#include "stream/stream_bounds.hpp"

namespace driveline::runtime {

StreamService::StreamService(const LineConfig& config, ecat_master::SingleAxes& axes)
    : config_(config), door_(axes), hub_(door_, config.axes.size()) {
  for (const auto axis : config.stream->axes) axes.add_feed(hub_.feed(axis), {axis});
}

Result<void> StreamService::start() {
  std::vector<StreamAxis> axes;
  for (const auto axis : config_.stream->axes) {
    axes.push_back({config_.axes[axis].name, axis, stream_bounds(config_.axes[axis])});
  }
  auto opened = StreamServer::open(*config_.stream, std::move(axes), hub_, config_.period);
  if (!opened) return tl::unexpected(opened.error());
  server_ = std::move(*opened);
  return {};
}

std::vector<Event> StreamService::poll() {
  return server_ ? server_->poll() : std::vector<Event>{};
}

void StreamService::close() {
  if (server_) server_->close();
}

}  // namespace driveline::runtime
