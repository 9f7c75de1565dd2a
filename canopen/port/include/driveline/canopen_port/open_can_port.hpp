#pragma once

#include <memory>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_port/can_port_options.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::canopen {

/// Opens the port that `text` names; the clock must outlive the port.
///
/// | text | port |
/// |---|---|
/// | `can0`, `socketcan:can0` | interface of the kernel |
/// | `slcan:/dev/ttyACM0` | serial adapter at a terminal |
/// | `slcan:tcp:HOST:PORT` | the same protocol over TCP |
/// | `socketcand:HOST:PORT/can0` | server of the protocol of socketcand |
/// | `cannelloni:udp:HOST:PORT`, `cannelloni:tcp:HOST:PORT` | tunnel |
/// | `cannelloni:udp:HOST:PORT:LOCAL` | tunnel whose far end sends to the local port LOCAL |
///
/// HOST is an IPv4 address or `localhost`. Errors: the text is none of these, the machine has no such interface,
/// nobody listens there, the server refuses, the rate does not exist; each says what was expected.
[[nodiscard]] tl::expected<std::unique_ptr<CanPort>, CanPortError> open_can_port(std::string_view text,
                                                                                 const CanPortOptions& options,
                                                                                 rt::Clock& clock);

}  // namespace driveline::canopen
