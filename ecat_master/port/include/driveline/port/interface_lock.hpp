#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

/// The process that holds the lock of a network interface.
struct InterfaceHolder {
  int pid = 0;          ///< 0: not visible to this process, because it belongs to another user or container
  std::string command;  ///< program and first argument, printable; empty when it cannot be read
};

/// Keeps other driveline processes off an interface: only one master may drive a line, and only one simulated line may
/// answer on an interface. Tools that only read take no lock; they may call holder().
///
/// The lock is a name in the abstract namespace of Unix sockets (unix(7)): no file is left behind, the kernel releases
/// the name when the process ends, however it ends, and each network namespace has one such namespace, like the
/// interfaces themselves. The name contains the interface's index, because one interface may have several names. The
/// lock is a convention between cooperating processes, not a protection.
///
/// One thread at a time; not for the cycle.
class InterfaceLock {
 public:
  /// Takes the lock of `interface`. Error: another process holds it. Where the kernel provides no such sockets, the
  /// call succeeds and protects nothing.
  [[nodiscard]] static tl::expected<InterfaceLock, InterfaceHolder> take(const std::string& interface);

  /// The process that holds the lock of `interface`, possibly this process; empty when the lock is free.
  [[nodiscard]] static std::optional<InterfaceHolder> holder(const std::string& interface);

 private:
  explicit InterfaceLock(rt::FileDescriptor socket) noexcept : socket_(std::move(socket)) {}

  rt::FileDescriptor socket_;
};

}  // namespace driveline::port
