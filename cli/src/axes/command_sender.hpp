#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace driveline::cli {

/// Who has sent a command.
struct CommandSender {
  std::uint64_t connection = 0;  ///< of the socket, from 1 on; 0: stdin
  pid_t process = 0;
  uid_t user = 0;
};

/// As events and leases name him: "control socket 3 (process 123, user 1000)".
[[nodiscard]] std::string caller_name(const CommandSender& sender);

}  // namespace driveline::cli
