#pragma once

#include <string>

#include "commands/command.hpp"

namespace driveline::cli {

/// Options of `simulate` for a CAN line.
struct SimulateCanOptions {
  std::string config;          ///< line description
  std::string slcan;           ///< ADDRESS:PORT; empty: not there
  std::string socketcand;      ///< ADDRESS:PORT; empty: not there
  std::string pty;             ///< link to a terminal; empty: none
  std::string cannelloni_udp;  ///< ADDRESS:PORT; empty: not there
  std::string cannelloni_tcp;  ///< ADDRESS:PORT; empty: not there
  std::string control;         ///< socket for commands; empty: none
};

/// Serves a CAN line until a signal stops the program. Returns the exit status.
[[nodiscard]] Outcome<int> simulate_can(const SimulateCanOptions& options);

}  // namespace driveline::cli
