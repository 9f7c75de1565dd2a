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

/// A program that streams setpoints, or wants to.
struct StreamPeer {
  std::string name;   ///< as it calls itself; of one over DDS that of its leases
  pid_t process = 0;  ///< as the kernel says; 0: it comes over DDS
  uid_t user = 0;     ///< as the kernel says
  gid_t group = 0;    ///< as the kernel says
};

/// "stream client "sine" (process 123, user 1000)", as events and leases have it.
[[nodiscard]] std::string describe(const StreamPeer& peer);

/// What of a setpoint of a stream was wrong, where it was a figure of an axis.
struct SetpointFault {
  /// The figure.
  enum class Figure : std::uint8_t {
    kPosition,      ///< rad or m, as requests count
    kVelocity,      ///< rad/s or m/s
    kAcceleration,  ///< rad/s^2 or m/s^2
    kStep,          ///< rad/s or m/s: the velocity that it takes to get there from the setpoint before
  };
  std::size_t axis = 0;               ///< of those of the session
  Figure figure = Figure::kPosition;  ///< which
  double value = 0.0;                 ///< its value
  double lowest = 0.0;                ///< that is possible; with stream::Refusal::kNotFinite nothing is said of it
  double highest = 0.0;               ///< likewise
};

/// Events of setpoints out of other processes.
namespace events {

/// Programs can connect.
struct StreamUp {
  std::string socket;             ///< path
  std::vector<std::string> axes;  ///< that they may have
};
/// A program has been given axes.
struct StreamClientCame {
  StreamPeer peer;                ///< who
  std::vector<std::string> axes;  ///< which it has now
};
/// A program was sent away.
struct StreamClientRefused {
  StreamPeer peer;         ///< who
  std::string reason;      ///< as it was told
  std::uint64_t more = 0;  ///< others that were sent away since the last of these events
};
/// The first setpoint of a client that was refused for this reason.
struct StreamSetpointRefused {
  StreamPeer peer;                       ///< whose
  stream::Refusal reason{};              ///< why
  EventAxis axis{};                      ///< the axis of `fault`
  std::optional<SetpointFault> fault{};  ///< none: it was wrong as a whole
};
/// The axes of a client have used up its setpoints for the first time, and have come to rest.
struct StreamStarved {
  StreamPeer peer;  ///< whose
};
/// The axes of a client are free again.
struct StreamClientLeft {
  StreamPeer peer;                                         ///< who
  stream::EndReason reason{};                              ///< why
  std::uint64_t taken = 0;                                 ///< setpoints
  std::array<std::uint64_t, stream::kRefusals> refused{};  ///< by stream::Refusal
  std::uint64_t starved = 0;                               ///< how often its setpoints were used up
};

}  // namespace events
}  // namespace driveline::runtime
