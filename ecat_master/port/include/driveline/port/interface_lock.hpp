#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "driveline/port/file_descriptor.hpp"

namespace driveline::port {

/// The process that has a network interface for itself.
struct InterfaceHolder {
  int pid = 0;          ///< 0: it cannot be seen from here, as one of another user or container
  std::string command;  ///< program and first argument, printable; empty when they cannot be read
};

/// "This interface is mine", said to the other processes of this program: one master drives a line, one simulated line
/// answers on an interface. Whoever only looks asks holder() at most.
///
/// A name in the abstract namespace of Unix sockets (unix(7)): no file is left behind, the kernel gives the name back
/// when the process ends, however it ends, and there is one such namespace per network namespace, like the interfaces
/// themselves. The name has the number of the interface, which several names may lead to. A convention between
/// well-meaning processes, no protection.
///
/// One thread at a time; not for the cycle.
class InterfaceLock {
 public:
  /// Takes the lock of `interface`. Error: somebody else has it. Where the kernel gives no such socket at all, the lock
  /// keeps nobody out.
  [[nodiscard]] static tl::expected<InterfaceLock, InterfaceHolder> take(const std::string& interface);

  /// Who has the lock of `interface`, this process or another one; nothing: nobody.
  [[nodiscard]] static std::optional<InterfaceHolder> holder(const std::string& interface);

 private:
  explicit InterfaceLock(FileDescriptor socket) noexcept : socket_(std::move(socket)) {}

  FileDescriptor socket_;
};

}  // namespace driveline::port
