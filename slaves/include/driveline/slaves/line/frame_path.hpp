#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/line/wiring.hpp"

namespace driveline::slaves {

/// Delays of a slave, port to port: through the processing unit (in at port 0), or past it.
struct SlaveDelays {
  std::chrono::nanoseconds processing{500};  ///< in at port 0, out at the next open port
  std::chrono::nanoseconds forwarding{500};  ///< in at another port, out at the next open one
};

/// Ports of a slave as far as they determine the path.
struct SlavePorts {
  std::array<bool, kPortCount> closed{};  ///< by port: frames turn round inside
  SlaveDelays delays;                     ///< of the slave; without supply all ports are closed and nothing passes
};

/// The way a frame takes from one master interface on: in at a port, through the processing unit when it comes from
/// port 0, out at the next open port in the order 0, 3, 1, 2 (ESC data sheet I, frame processing order). Only this
/// class determines the order of slaves. Times are relative to the start at the master.
class FramePath {
 public:
  /// Time of a port that the frame does not come in at.
  static constexpr std::chrono::nanoseconds kNotReceived = std::chrono::nanoseconds::min();

  /// The frame passes a processing unit.
  struct Step {
    std::size_t slave = 0;             ///< position in the line
    std::chrono::nanoseconds time{0};  ///< after the start at the master
    /// It comes from a closed port 0: the circulating bit is set, or, when it is set already, the frame destroyed.
    bool circulates = false;
  };

  /// Follows the wiring from `from` on. Allocates only when a path is longer than any before.
  void trace(const Wiring& wiring, std::span<const SlavePorts> slaves, MasterPort from);

  /// Processing units in the order in which the frame passes them. Valid until the next trace().
  [[nodiscard]] std::span<const Step> steps() const noexcept { return steps_; }
  /// When the frame came in at each port of `slave`.
  [[nodiscard]] const std::array<std::chrono::nanoseconds, kPortCount>& received(std::size_t slave) const noexcept {
    return received_[slave];
  }
  /// The interface where the frame comes out; nothing when it gets lost.
  [[nodiscard]] std::optional<MasterPort> exit() const noexcept { return exit_; }
  /// The closed port at which the frame ended, if that is where it got lost.
  [[nodiscard]] const std::optional<PortId>& blocked() const noexcept { return blocked_; }
  /// From the start at the master to the exit.
  [[nodiscard]] std::chrono::nanoseconds delay() const noexcept { return delay_; }

 private:
  std::vector<Step> steps_;
  std::vector<std::array<std::chrono::nanoseconds, kPortCount>> received_;
  std::optional<MasterPort> exit_;
  std::optional<PortId> blocked_;
  std::chrono::nanoseconds delay_{0};
};

}  // namespace driveline::slaves
