#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace driveline::slaves {

/// Number of ports of a slave controller.
inline constexpr unsigned kPortCount = 4;

/// Identifies a port of a slave, and thus an end of a cable.
struct PortId {
  std::size_t slave = 0;  ///< position in the line
  unsigned port = 0;      ///< 0 to kPortCount - 1
  constexpr bool operator==(const PortId&) const = default;
};

/// Interfaces of the master.
enum class MasterPort : std::uint8_t { kPrimary, kSecondary };
/// Maximum number of master interfaces on a line.
inline constexpr std::size_t kMasterPortCount = 2;

/// Cables between slaves and to the master's interfaces, each with its delay. A cable can be broken and healed.
/// Construction allocates; break_cable() and the queries are \rtsafe.
class Wiring {
 public:
  /// An end of a cable.
  struct End {
    /// Device at the end of the cable.
    enum class Kind : std::uint8_t { kNothing, kSlave, kMaster };
    Kind kind = Kind::kNothing;                ///< selects the member that is used
    PortId slave;                              ///< for kSlave
    MasterPort master = MasterPort::kPrimary;  ///< for kMaster
    std::chrono::nanoseconds delay{0};         ///< delay of the cable
    bool broken = false;                       ///< no frame passes, neither side detects a link
  };

  /// Creates `slave_count` slaves without any cable.
  explicit Wiring(std::size_t slave_count) : ends_(slave_count) {}

  /// Creates a plain line: the master at port 0 of the first slave, port 1 of each slave at port 0 of the next.
  [[nodiscard]] static Wiring line(std::size_t slave_count, std::chrono::nanoseconds cable_delay = {});
  /// Creates a line whose last slave is connected to the master's secondary interface.
  [[nodiscard]] static Wiring ring(std::size_t slave_count, std::chrono::nanoseconds cable_delay = {});

  /// Connects two free ports; returns false when one is in use, does not exist, or both are the same.
  bool connect(PortId a, PortId b, std::chrono::nanoseconds delay = {});
  /// Connects a master interface to a free port; returns false when the port or the interface is in use.
  bool connect_master(MasterPort master, PortId slave, std::chrono::nanoseconds delay = {});
  /// Sets the delay of the cable at `port`; returns false when there is none.
  bool set_delay(PortId port, std::chrono::nanoseconds delay) noexcept;
  /// Breaks or heals the cable at `port` (both of its ends); returns false when there is none.
  bool break_cable(PortId port, bool broken = true) noexcept;

  /// Returns the number of slaves that was passed to the constructor.
  [[nodiscard]] std::size_t slave_count() const noexcept { return ends_.size(); }
  /// Returns the other end of the cable at `port`.
  [[nodiscard]] const End& at(PortId port) const noexcept { return ends_[port.slave][port.port]; }
  /// Returns the slave port that a master interface is connected to.
  [[nodiscard]] const std::optional<PortId>& master(MasterPort port) const noexcept {
    return masters_[static_cast<std::size_t>(port)];
  }

 private:
  [[nodiscard]] bool free(PortId port) const noexcept;

  std::vector<std::array<End, kPortCount>> ends_;
  std::array<std::optional<PortId>, kMasterPortCount> masters_;
};

}  // namespace driveline::slaves
