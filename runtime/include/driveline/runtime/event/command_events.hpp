#pragma once

#include <cstdint>
#include <string>

/// Events of commands that come over DDS. What is asked of an axis and passes its door has events of its own
/// (AxisRequested).
namespace driveline::runtime::events {

/// The line takes commands.
struct CommandsOpen {
  bool insecure = false;  ///< from everybody in the network
};
/// A command that asks nothing of an axis, or was refused before its door.
struct CommandAnswered {
  std::string who;      ///< "dds panel (participant 010f45d2e8a1b2c3d4e5f607)"
  std::string axis;     ///< name as he wrote it; empty: it is about none
  std::string what;     ///< "acquire"
  std::string refusal;  ///< why it was refused; empty: it was done
};
/// Commands that came so fast that there is no event for each.
struct CommandsUntold {
  std::uint64_t accepted = 0;  ///< since the last event of this kind
  std::uint64_t refused = 0;   ///< likewise
  std::uint64_t dropped = 0;   ///< likewise; they were not looked at
};
/// The bridge has ended, and with it a client's way to his axes, which stop.
struct CommanderLost {
  std::string who;  ///< CommandAnswered::who
};
/// What the bridge, or who has taken it over, has written for commands cannot be. It is left out.
struct CommandsUnbelieved {};

}  // namespace driveline::runtime::events
