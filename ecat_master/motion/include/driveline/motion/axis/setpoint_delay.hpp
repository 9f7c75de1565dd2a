#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace driveline::motion {

/// Exchanges by which spline interpolation lags behind the setpoints: it also needs the next setpoint.
inline constexpr unsigned kSplinePeriods = 2;

/// The delays between a cyclic position setpoint and the motion of the shaft.
struct SetpointDelays {
  std::chrono::nanoseconds period{0};  ///< cycle time of the line
  std::uint32_t divider = 1;           ///< the drive is exchanged in every n-th cycle
  /// Exchanges until the drive has reached a setpoint that it received: 1 with linear interpolation, else
  /// kSplinePeriods.
  unsigned interpolation = 1;
  /// Time from the exchange to the SYNC0 at which the drive applies its setpoints; none: it applies them at once.
  std::optional<std::chrono::nanoseconds> to_sync0{};
};

/// Cycles between computing a setpoint and reading the actual position that belongs to it.
[[nodiscard]] double setpoint_delay_cycles(const SetpointDelays& delays) noexcept;

/// The same for a drive on a CAN bus that takes its setpoints with SYNC: a setpoint is computed with the answers to one
/// SYNC, sent behind the next one, and applied at the one after that (CiA 301 7.2.2.2). `interpolation` as in
/// SetpointDelays.
[[nodiscard]] double can_setpoint_delay_cycles(std::chrono::nanoseconds period, unsigned interpolation) noexcept;

/// The setpoints of the last cycles, for comparison with actual positions. The constructor allocates all memory;
/// everything else is \rtsafe.
class SetpointHistory {
 public:
  /// `delay_cycles`: age of the setpoint that followed() returns; 0 or more, may be fractional.
  explicit SetpointHistory(double delay_cycles);

  /// Adds the setpoint of this cycle.
  void push(double position) noexcept;
  /// Adds `cycles` setpoints, each `step` after the one before; their number costs no time.
  void extrapolate(std::int64_t cycles, double step) noexcept;
  /// The setpoint that the actual position of this cycle belongs to, `delay_cycles` old: interpolated linearly between
  /// two cycles; the oldest one until the history is long enough.
  [[nodiscard]] double followed() const noexcept;
  /// The setpoint of an actual position that was measured `later_cycles` after its usual time (0 or more): that much
  /// younger than followed(), beyond the newest one at the last velocity.
  [[nodiscard]] double followed_later(double later_cycles) const noexcept;
  /// The setpoint `later_cycles` after the newest one, at the last velocity.
  [[nodiscard]] double continued(double later_cycles) const noexcept;
  /// The setpoint that is `cycles` older than the last one; up to whole_cycles() + 1.
  [[nodiscard]] double ago(std::size_t cycles) const noexcept;
  /// Whole cycles of the delay.
  [[nodiscard]] std::size_t whole_cycles() const noexcept { return whole_; }

 private:
  std::vector<double> positions_;
  std::size_t newest_ = 0;
  std::size_t filled_ = 0;
  std::size_t whole_;  ///< whole cycles of the delay
  double part_;        ///< fraction of a cycle in the delay
};

}  // namespace driveline::motion
