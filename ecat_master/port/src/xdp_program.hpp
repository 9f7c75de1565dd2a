#pragma once

#include <tl/expected.hpp>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

/// A refused system call: its purpose and errno.
struct XdpRefusal {
  enum class Step : unsigned char { kSocket, kMemory, kBind, kProgram, kAttach };
  Step step = Step::kSocket;
  int error_number = 0;
};

/// The XDP program that hands the EtherCAT frames of a receive queue to an AF_XDP socket and passes all others to the
/// kernel. A link attaches it to an interface; the kernel removes it when this object is destroyed or its process ends.
class XdpProgram {
 public:
  /// `generic`: the kernel runs the program, not the driver. `socket` must be bound to queue 0 of the interface.
  [[nodiscard]] static tl::expected<XdpProgram, XdpRefusal> attach(int interface_index, int socket, bool generic);

  /// Whether this process may load the program: 0, or errno. Does not attach it.
  [[nodiscard]] static int try_load();

 private:
  XdpProgram(rt::FileDescriptor map, rt::FileDescriptor program, rt::FileDescriptor link) noexcept
      : map_(std::move(map)), program_(std::move(program)), link_(std::move(link)) {}

  rt::FileDescriptor map_;
  rt::FileDescriptor program_;
  rt::FileDescriptor link_;
};

}  // namespace driveline::port
