#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/rt/spsc_ring.hpp"
#include "driveline/rt/triple_buffer.hpp"
#include "driveline/slaves/device.hpp"
#include "driveline/slaves/device_status.hpp"
#include "driveline/slaves/endpoint/endpoint_protocol.hpp"
#include "driveline/slaves/ethernet_link.hpp"

namespace driveline::runtime {

/// A frame in a ring.
struct NetworkFrame {
  std::size_t length = 0;
  std::array<std::byte, wire::kMaxEoeFrame> bytes{};
};

/// Network of a device, between the thread that runs the line and the thread that serves its end point. Neither
/// thread waits for the other.
class DeviceNetwork final : public slaves::EthernetLink {
 public:
  /// Has room for `queue` frames in each direction. `device` must outlive this object.
  DeviceNetwork(const slaves::Device& device, std::size_t queue)
      : device_(&device), to_network_(queue), to_master_(queue) {}

  // EthernetLink: called on the thread that runs the line.
  [[nodiscard]] bool send(std::span<const std::byte> frame) noexcept override;
  [[nodiscard]] std::size_t receive(std::span<std::byte> out) noexcept override;
  void set_address(const wire::EoeIpParameters& address) noexcept override;
  void set_link(bool up) noexcept override;

  /// \name Called on the thread that serves the end point
  /// @{

  /// Takes the next frame of the master.
  [[nodiscard]] bool next_frame(NetworkFrame& frame) noexcept { return to_network_.try_pop(frame); }
  /// Whether there is room for a frame to the master.
  [[nodiscard]] bool has_room() const noexcept { return to_master_.size() < to_master_.capacity(); }
  /// Queues a frame for the master; drops and counts it if there is no room.
  void offer(const NetworkFrame& frame) noexcept { static_cast<void>(to_master_.try_push(frame)); }
  /// Returns the addresses that were set last.
  [[nodiscard]] slaves::EndpointAddress address() noexcept {
    static_cast<void>(addresses_.update());
    return addresses_.read();
  }
  /// Returns the link state that was set last.
  [[nodiscard]] bool link_up() const noexcept { return up_.load(std::memory_order_relaxed); }
  /// Requests the status of the device at the next opportunity.
  void ask_for_status() noexcept { status_wanted_.store(true, std::memory_order_relaxed); }
  /// Takes a status that the device has reported.
  [[nodiscard]] bool next_status(slaves::DeviceStatus& status) noexcept { return statuses_.try_pop(status); }
  /// @}

  /// Returns the number of frames dropped in both directions. Any thread.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return to_network_.dropped() + to_master_.dropped(); }

 private:
  void tell_status() noexcept;

  const slaves::Device* device_;
  rt::SpscRing<NetworkFrame> to_network_;
  rt::SpscRing<NetworkFrame> to_master_;
  rt::SpscRing<slaves::DeviceStatus> statuses_{2};
  rt::TripleBuffer<slaves::EndpointAddress> addresses_;
  std::atomic<bool> up_{false};
  std::atomic<bool> status_wanted_{false};
  NetworkFrame sent_;      ///< used by the thread that runs the line
  NetworkFrame received_;  ///< used by the thread that runs the line
  slaves::DeviceStatus status_;
};

}  // namespace driveline::runtime
