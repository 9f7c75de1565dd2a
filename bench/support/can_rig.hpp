#pragma once

#include <memory>

#include "driveline/canopen_master/can_master.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/runtime/can_line/simulated_can_port.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/line_rig.hpp"

namespace driveline::bench {

/// A CAN port that can measure the time spent inside the underlying port.
class TimedCanPort final : public canopen::CanPort {
 public:
  explicit TimedCanPort(canopen::CanPort& inner) noexcept : inner_(inner) {}

  /// Resets the times to zero, and starts or stops measuring.
  void reset(bool measure) noexcept;
  /// Time since reset(), without the readings of the clock.
  [[nodiscard]] double inside_ns() const noexcept;
  /// The cost of measuring for the caller outside of inside_ns().
  [[nodiscard]] double overhead_ns() const noexcept;

  [[nodiscard]] canopen::SendStatus send(const canopen::Frame& frame) noexcept override;
  [[nodiscard]] std::optional<canopen::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override;

 private:
  template <typename Call>
  auto timed(const Call& call) const noexcept;

  canopen::CanPort& inner_;
  bool measure_ = false;
  mutable double measured_ns_ = 0.0;
  mutable int calls_ = 0;
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

  [[nodiscard]] TimedCanPort& port() noexcept { return port_; }
  [[nodiscard]] canopen::CanMaster& master() noexcept { return master_; }

 private:
  std::chrono::nanoseconds path_duration_;
  rt::VirtualClock& clock_;
  runtime::LineConfig config_;
  std::unique_ptr<runtime::SimulatedCanPort> bus_;
  TimedCanPort port_;
  LineRings rings_;
  std::unique_ptr<motion::Motion> motion_;
  canopen::CanMaster master_;
};

}  // namespace driveline::bench
