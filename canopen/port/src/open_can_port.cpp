#include "driveline/canopen_port/open_can_port.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "driveline/canopen_port/cannelloni_tcp_port.hpp"
#include "driveline/canopen_port/cannelloni_udp_port.hpp"
#include "driveline/canopen_port/slcan_port.hpp"
#include "driveline/canopen_port/socketcan_port.hpp"
#include "driveline/canopen_port/socketcand_port.hpp"

namespace driveline::canopen {
namespace {

using Opened = tl::expected<std::unique_ptr<CanPort>, CanPortError>;

tl::unexpected<CanPortError> usage(std::string message) {
  return tl::unexpected(CanPortError{CanPortErrorCode::kUsage, std::move(message)});
}

template <typename Port>
Opened general(tl::expected<std::unique_ptr<Port>, CanPortError> port) {
  if (!port) return tl::unexpected(std::move(port.error()));
  return std::unique_ptr<CanPort>(std::move(*port));
}

/// Takes a prefix off a text; false: the text begins otherwise.
bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

Opened open_slcan(std::string_view place, const CanPortOptions& options, rt::Clock& clock) {
  if (take_prefix(place, "tcp:")) return general(SlcanPort::open_tcp(place, options, clock));
  if (place.empty()) return usage("'slcan:' names no adapter; slcan:/dev/ttyACM0 or slcan:tcp:HOST:PORT was expected.");
  return general(SlcanPort::open_terminal(place, options, clock));
}

Opened open_socketcand(std::string_view place, const CanPortOptions& options, rt::Clock& clock) {
  constexpr std::size_t kLongestName = 16;  // of a bus, doc/protocol.md of socketcand
  const auto slash = place.find('/');
  const auto bus = slash == std::string_view::npos ? std::string_view() : place.substr(slash + 1);
  if (bus.empty() || bus.size() > kLongestName || bus.find_first_of("<> \t\r\n") != std::string_view::npos) {
    return usage("'socketcand:" + std::string(place) +
                 "' names no bus of a server; socketcand:HOST:PORT/BUS was expected, BUS has 1 to 16 characters.");
  }
  return general(SocketcandPort::open(place.substr(0, slash), bus, options, clock));
}

Opened open_cannelloni(std::string_view place, const CanPortOptions& options, rt::Clock& clock) {
  if (take_prefix(place, "tcp:")) return general(CannelloniTcpPort::open(place, options, clock));
  if (!take_prefix(place, "udp:")) {
    return usage("'cannelloni:" + std::string(place) +
                 "' is no tunnel; cannelloni:udp:HOST:PORT, cannelloni:udp:HOST:PORT:LOCAL or "
                 "cannelloni:tcp:HOST:PORT was expected.");
  }
  const auto last = place.rfind(':');
  if (std::count(place.begin(), place.end(), ':') != 2) return general(CannelloniUdpPort::open(place, 0, clock));
  const auto local = decimal_number(place.substr(last + 1));
  if (!local || *local == 0 || *local > 0xFFFF)
    return usage("'" + std::string(place.substr(last + 1)) + "' is no local UDP port; it is 1 to 65535.");
  return general(CannelloniUdpPort::open(place.substr(0, last), static_cast<std::uint16_t>(*local), clock));
}

}  // namespace

tl::expected<std::unique_ptr<CanPort>, CanPortError> open_can_port(std::string_view text, const CanPortOptions& options,
                                                                   rt::Clock& clock) {
  const auto& rates = slcan::kBitRates;
  if (std::find(rates.begin(), rates.end(), options.bit_rate) == rates.end()) {
    return usage("there is no bit rate of " + std::to_string(options.bit_rate) +
                 " bit/s; 10000, 20000, 50000, 100000, 125000, 250000, 500000, 800000 or 1000000 was expected.");
  }
  std::string_view place = text;
  if (take_prefix(place, "slcan:")) return open_slcan(place, options, clock);
  if (take_prefix(place, "socketcand:")) return open_socketcand(place, options, clock);
  if (take_prefix(place, "cannelloni:")) return open_cannelloni(place, options, clock);
  const bool named = take_prefix(place, "socketcan:");
  if (place.empty() || (!named && place.find_first_of(":/") != std::string_view::npos)) {
    return usage("'" + std::string(text) +
                 "' names no port to a CAN bus; an interface (can0), slcan:, socketcand: or cannelloni: was expected.");
  }
  return general(SocketCanPort::open(place, options, clock));
}

}  // namespace driveline::canopen
