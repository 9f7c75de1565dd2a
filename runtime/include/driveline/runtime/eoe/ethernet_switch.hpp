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

/// What is plugged into a port of an EthernetSwitch.
class SwitchedDevice {
 public:
  virtual ~SwitchedDevice() = default;
  /// Takes an Ethernet frame without check sequence; false: its queue is full. Must not call the switch back.
  [[nodiscard]] virtual bool send(std::span<const std::byte> frame) = 0;
};

/// Frames and bytes of one port since the beginning.
struct SwitchPortFigures {
  std::string name;               ///< of the device that is plugged in
  bool link = false;              ///< frames pass
  std::uint64_t received = 0;     ///< frames from the device
  std::uint64_t sent = 0;         ///< frames to the device
  std::uint64_t bytes_in = 0;     ///< of the frames received
  std::uint64_t bytes_out = 0;    ///< of the frames sent
  std::uint64_t full = 0;         ///< frames to the device that were dropped because its queue was full
  std::uint64_t flood_limit = 0;  ///< frames from the device for all ports, dropped because there were too many
  std::uint64_t refused = 0;      ///< frames from the device that no switch forwards: length, source, reserved group
  std::vector<wire::MacAddress> addresses;  ///< of stations behind the port
};

/// A learning Ethernet switch: it forwards a frame to the port behind which its destination has been seen, and frames
/// for everybody, or for nobody known, to all ports with a link. It does not look above layer 2. Any thread.
class EthernetSwitch {
 public:
  /// Limits of the switch.
  struct Settings {
    std::chrono::nanoseconds ageing = std::chrono::seconds{300};  ///< until an address is forgotten (IEEE 802.1D)
    std::size_t addresses = 1024;                                 ///< kept at most; further ones are not learnt
    double flood_rate = 1000.0;                                   ///< frames for all ports that a port may bring, 1/s
    double flood_burst = 100.0;                                   ///< the same at once
    std::size_t mtu = 1500;                                       ///< payload of a frame without VLAN tag, bytes
  };

  /// With the default settings.
  EthernetSwitch() : EthernetSwitch(Settings{}) {}
  /// No port is there yet.
  explicit EthernetSwitch(const Settings& settings) : settings_(settings) {}

  /// Plugs in `device`, which must outlive the switch or at least its last frame; returns the number of the port, from
  /// 0 on. Its link is down.
  std::size_t connect(std::string name, SwitchedDevice& device);
  /// While the link is down no frame passes; what was learnt there is forgotten.
  void set_link(std::size_t port, bool up);
  /// A frame from the device at `port`, at `now` on any clock that goes on.
  void receive(std::size_t port, std::span<const std::byte> frame, std::chrono::nanoseconds now);
  /// By port.
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
  mutable std::mutex mutex_;  ///< of everything below
  std::vector<Port> ports_;
  std::map<wire::MacAddress, Station> stations_;
  std::chrono::nanoseconds next_ageing_{};
};

}  // namespace driveline::runtime
