#pragma once

#include <optional>
#include <string>

#include "confinement.hpp"

namespace driveline::bridge {

/// The command line of `driveline-bridge`. Descriptors are inherited, or taken from the process of a line.
struct Options {
  int feed = -1;       ///< description of the feed; its status, cycles and events have the next three numbers
  int counts = -1;     ///< where it tells what it has published; -1: nowhere
  int condition = -1;  ///< condition of the feed: its slaves; -1: they are not published
  /// Where it puts commands; answers, setpoints and reports have the next numbers; -1: it takes none.
  int commands = -1;
  int security = -1;                     ///< the first of the six files of DdsSecurity, in its order; -1: without
  int qos = -1;                          ///< profiles of Fast DDS for the writers; -1: they have their own
  std::string qos_file{"QoS profiles"};  ///< what the file of the profiles is called in messages
  int supervisor = -1;                   ///< socket whose end is its own; -1: it ends with the feed, or by SIGTERM
  std::optional<Identity> user;          ///< whom it becomes where root starts it; none: nobody
  int process = -1;                      ///< whose feed is published in place of inherited descriptors; -1: none
  bool help = false;
  std::string problem;  ///< with the command line; empty: none
};

/// Of the arguments after the name of the program.
[[nodiscard]] Options read_options(int count, const char* const* arguments);

/// What `--help` prints.
extern const char* const kHelp;

}  // namespace driveline::bridge
