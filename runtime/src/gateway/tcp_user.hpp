#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <istream>
#include <optional>

namespace driveline::runtime {

/// Returns the user of the process at the other end of a TCP connection on this machine. None: the connection is not
/// established any more, or its other end is on another machine.
[[nodiscard]] std::optional<uid_t> user_of_connection(int connection);

/// The same from a table of the form of /proc/net/tcp or /proc/net/tcp6, for a connection from `client` to `server`.
[[nodiscard]] std::optional<uid_t> find_tcp_user(std::istream& table, const sockaddr_in& client,
                                                 const sockaddr_in& server);

}  // namespace driveline::runtime
