#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/line/wiring.hpp"

namespace driveline::slaves {

/// Delays between the ports of a slave: through the processing unit (in at port 0) or past it.
struct SlaveDelays {
  std::chrono::nanoseconds processing{500};  ///< in at port 0, out at the next open port
  std::chrono::nanoseconds forwarding{500};  ///< in at another port, out at the next open port
};

/// Properties of a slave's ports that determine the path.
struct SlavePorts {
  std::array<bool, kPortCount> closed{};  ///< by port: the loop is closed
  SlaveDelays delays;                     ///< without supply all ports are closed, so that no frame passes
};

/// Path of a frame from a master interface: in at a port, through the processing unit if it comes from port 0, out at
/// the next open port in the order 0, 3, 1, 2 (ESC data sheet I, frame processing order). Only this class determines
/// the order of slaves. Times are relative to the start at the master.
class FramePath {
 public:
  /// Time of a port that does not receive the frame.
  static constexpr std::chrono::nanoseconds kNotReceived = std::chrono::nanoseconds::min();

  /// Passage of the frame through a processing unit.
  struct Step {
    std::size_t slave = 0;             ///< position in the line
    std::chrono::nanoseconds time{0};  ///< time after the start at the master
    /// The frame comes from a closed port 0: the circulating bit is set; if it is already set, the frame is destroyed.
    bool circulates = false;
  };

  /// Traces the wiring from `from` on. Allocates only when a path is longer than all previous ones.
  void trace(const Wiring& wiring, std::span<const SlavePorts> slaves, MasterPort from);

  /// Returns the processing units in the order of passage. Valid until the next trace().
  [[nodiscard]] std::span<const Step> steps() const noexcept { return steps_; }
  /// Returns the times when each port of `slave` received the frame.
  [[nodiscard]] const std::array<std::chrono::nanoseconds, kPortCount>& received(std::size_t slave) const noexcept {
    return received_[slave];
  }
  /// Returns the interface where the frame leaves the line; nullopt when it is lost.
  [[nodiscard]] std::optional<MasterPort> exit() const noexcept { return exit_; }
  /// Returns the closed port where the frame was lost, if any.
  [[nodiscard]] const std::optional<PortId>& blocked() const noexcept { return blocked_; }
  /// Returns the time from the start at the master to the exit.
  [[nodiscard]] std::chrono::nanoseconds delay() const noexcept { return delay_; }

 private:
  std::vector<Step> steps_;
  std::vector<std::array<std::chrono::nanoseconds, kPortCount>> received_;
  std::optional<MasterPort> exit_;
  std::optional<PortId> blocked_;
  std::chrono::nanoseconds delay_{0};
};

}  // namespace driveline::slaves
