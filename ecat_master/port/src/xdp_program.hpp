#pragma once

#include <tl/expected.hpp>

#include "driveline/port/file_descriptor.hpp"

namespace driveline::port {

/// A system call that was refused: what it was to do, and errno.
struct XdpRefusal {
  enum class Step : unsigned char { kSocket, kMemory, kBind, kProgram, kAttach };
  Step step = Step::kSocket;
  int error_number = 0;
};

/// The XDP program that hands the EtherCAT frames of one receive queue to an AF_XDP socket and passes all others on,
/// attached to an interface by a link. The kernel takes it off when this object or its process ends.
class XdpProgram {
 public:
  /// `generic`: run by the kernel, not by the driver. `socket`: bound to queue 0 of the interface.
  [[nodiscard]] static tl::expected<XdpProgram, XdpRefusal> attach(int interface_index, int socket, bool generic);

  /// Whether this process may load the program; errno if not. It is not attached.
  [[nodiscard]] static int try_load();

 private:
  XdpProgram(FileDescriptor map, FileDescriptor program, FileDescriptor link) noexcept
      : map_(std::move(map)), program_(std::move(program)), link_(std::move(link)) {}

  FileDescriptor map_;
  FileDescriptor program_;
  FileDescriptor link_;
};

}  // namespace driveline::port
