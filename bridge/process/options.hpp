#pragma once

#include <optional>
#include <string>

#include "confinement.hpp"

namespace driveline::bridge {

/// The command line of `driveline-bridge`. Descriptors are inherited, or taken from the process of a line.
struct Options {
  int feed = -1;       ///< description of the feed; status, cycles and events have the next three numbers
  int counts = -1;     ///< region for counts of what is published; -1: none
  int condition = -1;  ///< condition of the feed (slaves); -1: slaves are not published
  /// Region for commands; answers, setpoints and reports have the next numbers; -1: the bridge takes no commands.
  int commands = -1;
  int security = -1;                     ///< first of the six files of DdsSecurity, in its order; -1: no security
  int qos = -1;                          ///< Fast DDS profiles for the writers; -1: default QoS
  std::string qos_file{"QoS profiles"};  ///< name of the profile file in messages
  /// socket to the supervisor, whose end ends the bridge; -1: it ends with the feed or by SIGTERM
  int supervisor = -1;
  std::optional<Identity> user;  ///< user to change to if started by root; nullopt: default of Identity
  int process = -1;              ///< process whose feed is published instead of inherited descriptors; -1: none
  bool help = false;
  std::string problem;  ///< error in the command line; empty: none
};

/// Parses the arguments after the name of the program.
[[nodiscard]] Options read_options(int count, const char* const* arguments);

/// Text printed by `--help`.
extern const char* const kHelp;

}  // namespace driveline::bridge
