#pragma once

#include <optional>

#include "driveline/runtime/config/stream_config.hpp"
#include "driveline/runtime/event/stream_events.hpp"

namespace driveline::runtime {

/// Who is at the other end of a connected Unix socket; none: the system does not say.
[[nodiscard]] std::optional<StreamPeer> peer_of(int socket);

/// Root and the user of this process may always.
[[nodiscard]] bool may_stream(int socket, const StreamPeer& peer, const StreamUsers& allowed);

}  // namespace driveline::runtime
