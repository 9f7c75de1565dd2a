#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace driveline::slaves {

/// Ports of a slave controller.
inline constexpr unsigned kPortCount = 4;

/// One end of a cable: a port of a slave.
struct PortId {
  std::size_t slave = 0;  ///< position in the line
  unsigned port = 0;      ///< 0 to kPortCount - 1
  constexpr bool operator==(const PortId&) const = default;
};

/// Where the master's interfaces are plugged in.
enum class MasterPort : std::uint8_t { kPrimary, kSecondary };
/// As many interfaces as a master can have on one line.
inline constexpr std::size_t kMasterPortCount = 2;

/// Cables between slaves and to the master's interfaces, each with its delay. A cable may be broken and healed. Setting
/// up allocates; break_cable() and the look-ups are \rtsafe.
class Wiring {
 public:
  /// One end of a cable.
  struct End {
    /// Device at the end of the cable.
    enum class Kind : std::uint8_t { kNothing, kSlave, kMaster };
    Kind kind = Kind::kNothing;                ///< decides which of the members below count
    PortId slave;                              ///< kSlave
    MasterPort master = MasterPort::kPrimary;  ///< kMaster
    std::chrono::nanoseconds delay{0};         ///< of the cable
    bool broken = false;                       ///< no frame passes, neither side sees a link
  };

  /// `slave_count` slaves without any cable.
  explicit Wiring(std::size_t slave_count) : ends_(slave_count) {}

  /// A plain line: the master at port 0 of the first slave, port 1 of each slave to port 0 of the next.
  [[nodiscard]] static Wiring line(std::size_t slave_count, std::chrono::nanoseconds cable_delay = {});
  /// A line whose last slave leads back to the master's secondary interface.
  [[nodiscard]] static Wiring ring(std::size_t slave_count, std::chrono::nanoseconds cable_delay = {});

  /// Connects two free ports; false when one is taken, does not exist, or both are the same.
  bool connect(PortId a, PortId b, std::chrono::nanoseconds delay = {});
  /// Plugs a master interface into a free port; false when the port or the interface is taken.
  bool connect_master(MasterPort master, PortId slave, std::chrono::nanoseconds delay = {});
  /// Gives the cable at `port` another delay; false when there is none.
  bool set_delay(PortId port, std::chrono::nanoseconds delay) noexcept;
  /// Breaks or heals the cable at `port` (both ends of it); false when there is none.
  bool break_cable(PortId port, bool broken = true) noexcept;

  /// As given to the constructor.
  [[nodiscard]] std::size_t slave_count() const noexcept { return ends_.size(); }
  /// The other end of the cable at `port`.
  [[nodiscard]] const End& at(PortId port) const noexcept { return ends_[port.slave][port.port]; }
  /// The slave port a master interface is plugged into.
  [[nodiscard]] const std::optional<PortId>& master(MasterPort port) const noexcept {
    return masters_[static_cast<std::size_t>(port)];
  }

 private:
  [[nodiscard]] bool free(PortId port) const noexcept;

  std::vector<std::array<End, kPortCount>> ends_;
  std::array<std::optional<PortId>, kMasterPortCount> masters_;
};

}  // namespace driveline::slaves
