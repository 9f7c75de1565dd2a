#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::runtime {

/// A program that streams setpoints, or requests to do so.
struct StreamPeer {
  std::string name;   ///< name given by the client; over DDS, the name in its leases
  pid_t process = 0;  ///< process number from the kernel; 0: a client over DDS
  uid_t user = 0;     ///< user from the kernel
  gid_t group = 0;    ///< group from the kernel
};

/// Returns the name in events and leases: "stream client "sine" (process 123, user 1000)".
[[nodiscard]] std::string describe(const StreamPeer& peer);

/// Invalid value of an axis in a setpoint of a stream.
struct SetpointFault {
  /// The kind of value.
  enum class Figure : std::uint8_t {
    kPosition,      ///< rad or m, as requests count
    kVelocity,      ///< rad/s or m/s
    kAcceleration,  ///< rad/s^2 or m/s^2
    kStep,          ///< rad/s or m/s: velocity needed to reach the position from the preceding setpoint
  };
  std::size_t axis = 0;               ///< index among the axes of the session
  Figure figure = Figure::kPosition;  ///< kind of value
  double value = 0.0;                 ///< the value
  double lowest = 0.0;                ///< lowest permitted value; unused with stream::Refusal::kNotFinite
  double highest = 0.0;               ///< highest permitted value; unused with stream::Refusal::kNotFinite
};

/// Events of setpoints from other processes.
namespace events {

/// Streaming programs can connect.
struct StreamUp {
  std::string socket;             ///< path of the socket
  std::vector<std::string> axes;  ///< axes that accept streams
};
/// A program was granted axes.
struct StreamClientCame {
  StreamPeer peer;                ///< the program
  std::vector<std::string> axes;  ///< axes that it has now
};
/// A program was refused.
struct StreamClientRefused {
  StreamPeer peer;         ///< the program
  std::string reason;      ///< reason, as sent to the program
  std::uint64_t more = 0;  ///< further refusals since the last of these events
};
/// First setpoint of a client that was refused for this reason.
struct StreamSetpointRefused {
  StreamPeer peer;                       ///< the client
  stream::Refusal reason{};              ///< reason
  EventAxis axis{};                      ///< axis of `fault`
  std::optional<SetpointFault> fault{};  ///< none: the setpoint was invalid as a whole
};
/// The axes of a client have run out of setpoints for the first time, and have come to rest.
struct StreamStarved {
  StreamPeer peer;  ///< the client
};
/// The axes of a client have become free.
struct StreamClientLeft {
  StreamPeer peer;                                         ///< the client
  stream::EndReason reason{};                              ///< reason
  std::uint64_t taken = 0;                                 ///< number of accepted setpoints
  std::array<std::uint64_t, stream::kRefusals> refused{};  ///< refused setpoints, indexed by stream::Refusal
  std::uint64_t starved = 0;                               ///< number of times the axes ran out of setpoints
};

}  // namespace events
}  // namespace driveline::runtime
