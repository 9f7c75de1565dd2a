#pragma once

#include <string_view>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

/// Keeps one file descriptor in reserve for a server that runs out of them (`ulimit -n`). Without it, a connection that
/// cannot be accepted remains in the queue: its client waits in vain, and a loop that polls the listening socket spins.
class DescriptorReserve {
 public:
  DescriptorReserve() noexcept;

  /// Call it when accept() at the non-blocking socket `listener` has failed, while errno is valid. If the process or
  /// the machine has no descriptor left, accepts one waiting connection with the reserved one, sends `farewell` and
  /// closes it. Returns false if even that is impossible, because another thread has taken the descriptor meanwhile: a
  /// loop that polls the socket must pause, because the connection keeps waiting. Never waits.
  [[nodiscard]] bool turn_away(int listener, std::string_view farewell = {}) noexcept;

 private:
  rt::FileDescriptor spare_;
};

}  // namespace driveline::port
