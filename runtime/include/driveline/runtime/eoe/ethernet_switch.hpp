#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "driveline/wire/ethernet.hpp"

namespace driveline::runtime {

/// A device that is connected to a port of an EthernetSwitch.
class SwitchedDevice {
 public:
  virtual ~SwitchedDevice() = default;
  /// Sends an Ethernet frame, without check sequence, to the device; false: its queue is full. Must not call the switch
  /// back.
  [[nodiscard]] virtual bool send(std::span<const std::byte> frame) = 0;
};

/// Frames and bytes of a port since the start.
struct SwitchPortFigures {
  std::string name;               ///< name of the connected device
  bool link = false;              ///< the link is up, frames pass
  std::uint64_t received = 0;     ///< frames from the device
  std::uint64_t sent = 0;         ///< frames to the device
  std::uint64_t bytes_in = 0;     ///< bytes of the received frames
  std::uint64_t bytes_out = 0;    ///< bytes of the sent frames
  std::uint64_t full = 0;         ///< frames to the device dropped because its queue was full
  std::uint64_t flood_limit = 0;  ///< frames from the device to all ports dropped because of the rate limit
  std::uint64_t refused = 0;      ///< frames from the device that no switch forwards: length, source, reserved group
  std::vector<wire::MacAddress> addresses;  ///< addresses of stations at the port
};

/// A learning Ethernet switch: forwards a frame to the port at which its destination has been seen, and broadcast,
/// multicast and unknown unicast frames to all ports with a link. Works only on layer 2. Any thread.
class EthernetSwitch {
 public:
  /// Limits of the switch.
  struct Settings {
    std::chrono::nanoseconds ageing = std::chrono::seconds{300};  ///< until an address is forgotten (IEEE 802.1D)
    std::size_t addresses = 1024;  ///< most addresses stored; further ones are not learnt
    double flood_rate = 1000.0;    ///< limit per port of frames to all ports, 1/s
    double flood_burst = 100.0;    ///< limit per port of a burst of such frames
    std::size_t mtu = 1500;        ///< payload of a frame without VLAN tag, bytes
  };

  /// Makes a switch with the default settings.
  EthernetSwitch() : EthernetSwitch(Settings{}) {}
  /// Makes a switch without ports.
  explicit EthernetSwitch(const Settings& settings) : settings_(settings) {}

  /// Connects `device`, which must live until its last frame; returns the number of the port, from 0. Its link is down.
  std::size_t connect(std::string name, SwitchedDevice& device);
  /// Sets the link state. While the link is down no frame passes; addresses learnt at the port are forgotten.
  void set_link(std::size_t port, bool up);
  /// Forwards a frame from the device at `port`, at time `now` of a monotonic clock.
  void receive(std::size_t port, std::span<const std::byte> frame, std::chrono::nanoseconds now);
  /// Returns the figures, indexed by port.
  [[nodiscard]] std::vector<SwitchPortFigures> figures() const;

 private:
  struct Port {
    SwitchedDevice* device = nullptr;
    SwitchPortFigures figures;
    double flood_credit = 0.0;
    std::chrono::nanoseconds credit_at{};
  };
  struct Station {
    std::size_t port = 0;
    std::chrono::nanoseconds seen{};
  };

  [[nodiscard]] bool acceptable(std::span<const std::byte> frame) const noexcept;
  void learn(const wire::MacAddress& source, std::size_t port, std::chrono::nanoseconds now);
  void forget_old(std::chrono::nanoseconds now);
  void flood(std::size_t from, std::span<const std::byte> frame, std::chrono::nanoseconds now);
  void forward(Port& port, std::span<const std::byte> frame);

  Settings settings_;
  mutable std::mutex mutex_;  ///< protects the members below
  std::vector<Port> ports_;
  std::map<wire::MacAddress, Station> stations_;
  std::chrono::nanoseconds next_ageing_{};
};

}  // namespace driveline::runtime
