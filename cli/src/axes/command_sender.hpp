#pragma once

#include <sys/types.h>

#include <cstdint>

namespace driveline::cli {

/// Who has sent a command.
struct CommandSender {
  std::uint64_t connection = 0;  ///< of the socket, from 1 on; 0: stdin
  pid_t process = 0;
  uid_t user = 0;
};

}  // namespace driveline::cli
