#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/slaves/endpoint/endpoint_protocol.hpp"
#include "outcome.hpp"

namespace driveline::endpoint {

/// A veth pair in this network namespace: `eoe0` is the interface of the kernel's IP stack, the other end is read and
/// written here, frame by frame.
class VirtualWire {
 public:
  /// Makes the pair; eoe0 has no address yet.
  [[nodiscard]] static Outcome<VirtualWire> open();

  /// The addresses of eoe0 from now on.
  [[nodiscard]] Outcome<void> set_address(const slaves::EndpointAddress& address);
  /// A frame for the IP stack; lost when the kernel has no room.
  void send(std::span<const std::byte> frame) noexcept;
  /// The next frame that the IP stack has sent, written into `out`; returns its length, 0: none.
  [[nodiscard]] std::size_t receive(std::span<std::byte> out) noexcept;
  /// To wait for.
  [[nodiscard]] int descriptor() const noexcept { return packets_.get(); }

 private:
  VirtualWire(port::FileDescriptor control, port::FileDescriptor packets)
      : control_(std::move(control)), packets_(std::move(packets)) {}

  port::FileDescriptor control_;  ///< for settings
  port::FileDescriptor packets_;
};

}  // namespace driveline::endpoint
