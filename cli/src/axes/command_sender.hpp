#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace driveline::cli {

/// The sender of a command.
struct CommandSender {
  std::uint64_t connection = 0;  ///< number of the connection to the socket, from 1; 0: stdin
  pid_t process = 0;
  uid_t user = 0;
};

/// The sender's name in events and leases: "control socket 3 (process 123, user 1000)".
[[nodiscard]] std::string caller_name(const CommandSender& sender);

}  // namespace driveline::cli
