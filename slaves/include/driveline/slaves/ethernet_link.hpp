#pragma once

#include <cstddef>
#include <span>

#include "driveline/wire/eoe.hpp"

namespace driveline::slaves {

/// The network behind the EoE port of a simulated device: its IP stack, or what leads there. Called by the thread that
/// drives the line, in the cycle when the line is in process. Frames are Ethernet frames without check sequence.
class EthernetLink {
 public:
  virtual ~EthernetLink() = default;
  /// A frame from the master for the device. False: the queue is full, the frame is lost. \rtsafe
  [[nodiscard]] virtual bool send(std::span<const std::byte> frame) noexcept = 0;
  /// The next frame of the device for the master, written into `out`; returns its length, 0: none. One that is longer
  /// than `out` is lost. \rtsafe
  [[nodiscard]] virtual std::size_t receive(std::span<std::byte> out) noexcept = 0;
  /// The addresses of the device from now on; those that are not there it has not. \rtsafe
  virtual void set_address(const wire::EoeIpParameters& address) noexcept = 0;
  /// The port is up while the mailbox runs. Frames that wait when it goes down are forgotten. \rtsafe
  virtual void set_link(bool up) noexcept = 0;
};

}  // namespace driveline::slaves
