#pragma once

#include <optional>

#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/event/stream_events.hpp"

namespace driveline::runtime {

/// Returns the peer of a connected Unix socket; none: the system does not report it.
[[nodiscard]] std::optional<StreamPeer> peer_of(int socket);

/// Whether the peer may stream; root and the user of this process always may.
[[nodiscard]] bool may_stream(int socket, const StreamPeer& peer, const StreamUsers& allowed);

}  // namespace driveline::runtime
