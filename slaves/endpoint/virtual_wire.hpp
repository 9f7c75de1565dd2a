#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/slaves/endpoint/endpoint_protocol.hpp"
#include "outcome.hpp"

namespace driveline::endpoint {

/// A veth pair in this network namespace: `eoe0` is the interface of the kernel's IP stack; this class reads and writes
/// frames at the other end.
class VirtualWire {
 public:
  /// Creates the pair; eoe0 has no address yet.
  [[nodiscard]] static Outcome<VirtualWire> open();

  /// Sets the addresses of eoe0.
  [[nodiscard]] Outcome<void> set_address(const slaves::EndpointAddress& address);
  /// Sends a frame to the IP stack; it is lost when the kernel's queue is full.
  void send(std::span<const std::byte> frame) noexcept;
  /// Writes the next frame of the IP stack into `out`; returns its length, 0: none.
  [[nodiscard]] std::size_t receive(std::span<std::byte> out) noexcept;
  /// Returns the descriptor to wait for.
  [[nodiscard]] int descriptor() const noexcept { return packets_.get(); }

 private:
  VirtualWire(rt::FileDescriptor control, rt::FileDescriptor packets)
      : control_(std::move(control)), packets_(std::move(packets)) {}

  rt::FileDescriptor control_;  ///< socket for settings
  rt::FileDescriptor packets_;
};

}  // namespace driveline::endpoint
