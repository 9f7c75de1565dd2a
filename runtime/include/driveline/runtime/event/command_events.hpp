#pragma once

#include <cstdint>
#include <string>

/// Events of commands over DDS. Requests that reach the AxisRequests have their own event (AxisRequested).
namespace driveline::runtime::events {

/// The line accepts commands.
struct CommandsOpen {
  bool insecure = false;  ///< accepts them from anyone in the network
};
/// A command that sends no request to an axis, or that was refused before the AxisRequests.
struct CommandAnswered {
  std::string who;      ///< "dds panel (participant 010f45d2e8a1b2c3d4e5f607)"
  std::string axis;     ///< name as sent by the client; empty: none
  std::string what;     ///< "acquire"
  std::string refusal;  ///< reason of the refusal; empty: the command was executed
};
/// Commands that came too fast for an event each.
struct CommandsSummary {
  std::uint64_t accepted = 0;  ///< since the last event of this kind
  std::uint64_t refused = 0;   ///< refused since the last event of this kind
  std::uint64_t dropped = 0;   ///< dropped, without a check, since the last event of this kind
};
/// The bridge has ended, and a client has lost its connection to its axes, which stop.
struct CommanderLost {
  std::string who;  ///< CommandAnswered::who
};
/// The bridge, or a program that has taken it over, has written invalid commands. They are ignored.
struct InvalidCommands {};

}  // namespace driveline::runtime::events
