#pragma once

#include <cstddef>
#include <span>

#include "driveline/wire/eoe.hpp"

namespace driveline::slaves {

/// The network behind the EoE port of a simulated device: its IP stack, or a connection to it. Called by the thread
/// that drives the line, in the cycle when the line is in process. Frames are Ethernet frames without frame check
/// sequence.
class EthernetLink {
 public:
  virtual ~EthernetLink() = default;
  /// Sends a frame from the master to the device. False: the queue is full, the frame is lost. \rtsafe
  [[nodiscard]] virtual bool send(std::span<const std::byte> frame) noexcept = 0;
  /// Writes the next frame to the master into `out`; returns its length, 0: none. A longer frame is lost. \rtsafe
  [[nodiscard]] virtual std::size_t receive(std::span<std::byte> out) noexcept = 0;
  /// Sets all addresses of the device; it has no address where the parameter is empty. \rtsafe
  virtual void set_address(const wire::EoeIpParameters& address) noexcept = 0;
  /// Sets the port's link, which is up while the mailbox runs. Waiting frames are discarded when it goes down. \rtsafe
  virtual void set_link(bool up) noexcept = 0;
};

}  // namespace driveline::slaves
