#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace driveline::ecat_master {

/// Exchanges by which spline interpolation lags behind the setpoints: it needs the next one as well.
inline constexpr unsigned kSplinePeriods = 2;

/// The delays between a cyclic position setpoint and the motion of the shaft.
struct SetpointWay {
  std::chrono::nanoseconds period{0};  ///< of the line's cycle
  std::uint32_t divider = 1;           ///< the drive is exchanged in every n-th cycle
  /// Exchanges until the drive has arrived at a setpoint it has received: 1 with linear interpolation, else
  /// kSplinePeriods.
  unsigned interpolation = 1;
  /// From the exchange to the SYNC0 at which the drive takes its setpoints over; none: it takes them at once.
  std::optional<std::chrono::nanoseconds> to_sync0{};
};

/// Cycles from the one that computes a setpoint to the one that reads the actual position that belongs to it.
[[nodiscard]] double setpoint_delay_cycles(const SetpointWay& way) noexcept;

/// The setpoints of the last cycles, to compare actual positions with. Memory is taken by the constructor; the rest is
/// \rtsafe.
class SetpointHistory {
 public:
  /// `delay_cycles`: how far to look back, 0 or more, not necessarily whole cycles.
  explicit SetpointHistory(double delay_cycles);

  /// The setpoint of this cycle.
  void push(double position) noexcept;
  /// The setpoint that the actual position of this cycle belongs to, from `delay_cycles` ago: interpolated linearly
  /// between two cycles, that of the first cycle until there are enough.
  [[nodiscard]] double followed() const noexcept;
  /// That of so many cycles before the last one, up to whole_cycles() and one more.
  [[nodiscard]] double ago(std::size_t cycles) const noexcept;
  /// Whole cycles of the delay.
  [[nodiscard]] std::size_t whole_cycles() const noexcept { return whole_; }

 private:
  std::vector<double> positions_;
  std::size_t newest_ = 0;
  std::size_t filled_ = 0;
  std::size_t whole_;  ///< cycles of the delay
  double part_;        ///< fraction of a cycle in the delay
};

}  // namespace driveline::ecat_master
