#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "driveline/canopen_master/can_master.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/runtime/can_line/simulated_can_port.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/line_rig.hpp"

namespace driveline::bench {

/// A CAN port whose calls can be kept out of a measurement: while it is staged, they only touch memory. A cycle of the
/// master calls its port some twenty times: a clock around each call would be a large part of what it measures.
class StagedCanPort final : public canopen::CanPort {
 public:
  /// The port below must outlive this.
  explicit StagedCanPort(canopen::CanPort& inner);

  /// Takes in what has arrived. The clock must stand still until release().
  void stage();
  /// Makes the calls since stage() once more and returns their time in nanoseconds, for subtraction: the same frames
  /// are received and sent.
  [[nodiscard]] double repeat_calls_ns();
  /// Hands what was sent meanwhile to the port below. Throws std::runtime_error if it does not take it.
  void release();

  [[nodiscard]] canopen::SendStatus send(const canopen::Frame& frame) noexcept override;
  [[nodiscard]] std::optional<canopen::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override;

 private:
  canopen::CanPort& inner_;
  bool staged_ = false;
  std::vector<canopen::ReceivedFrame> arrived_;
  std::size_t next_ = 0;  ///< index in arrived_ of the next frame
  std::vector<canopen::Frame> sent_;
  std::vector<canopen::Frame> repeated_;
  canopen::PortStatistics statistics_;
};

/// A CAN line of simulated MSD drives in this process and the master that runs them, composed by the runtime as from a
/// line description, on virtual time. Every axis follows its own sine, that of LineRig.
class CanRig {
 public:
  /// `path_duration`: length of the path.
  CanRig(rt::VirtualClock& clock, std::size_t axes, std::chrono::nanoseconds period,
         std::chrono::nanoseconds path_duration);

  /// Takes the line to operation and all axes onto the path. Throws std::runtime_error on failure.
  void bring_up(const canopen::CanMaster::MakeRunner& make_runner);
  /// Empties the telemetry rings, as their reader would. One thread.
  void drain();
  /// Throws Disturbed if the axes have left the path, or a PDO was lost: the figures would be invalid.
  void check();

  [[nodiscard]] StagedCanPort& port() noexcept { return port_; }
  [[nodiscard]] canopen::CanMaster& master() noexcept { return master_; }

 private:
  std::chrono::nanoseconds path_duration_;
  rt::VirtualClock& clock_;
  runtime::LineConfig config_;
  std::unique_ptr<runtime::SimulatedCanPort> bus_;
  StagedCanPort port_;
  LineRings rings_;
  std::unique_ptr<motion::Motion> motion_;
  canopen::CanMaster master_;
};

}  // namespace driveline::bench
