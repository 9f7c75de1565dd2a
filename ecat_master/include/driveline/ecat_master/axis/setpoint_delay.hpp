#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace driveline::ecat_master {

/// Exchanges that a spline through the setpoints lags behind them: it needs the next one as well.
inline constexpr unsigned kSplinePeriods = 2;

/// What keeps a cyclic position setpoint on its way to the shaft.
struct SetpointWay {
  std::chrono::nanoseconds period{0};  ///< of the line's cycle
  std::uint32_t divider = 1;           ///< the drive is exchanged in every n-th cycle
  /// Exchanges until the drive has arrived at a setpoint it has got: 1 when it goes to it on a line, kSplinePeriods.
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
  /// For looking back so many cycles, 0 at least.
  explicit SetpointHistory(double delay_cycles);

  /// The setpoint of this cycle.
  void push(double position) noexcept;
  /// The one that the actual position of this cycle belongs to: of `delay_cycles` ago, between two cycles on the line
  /// through both; of the first cycle before there are enough.
  [[nodiscard]] double followed() const noexcept;

 private:
  [[nodiscard]] double ago(std::size_t cycles) const noexcept;

  std::vector<double> positions_;
  std::size_t newest_ = 0;
  std::size_t filled_ = 0;
  std::size_t whole_;  ///< cycles of the delay
  double part_;        ///< of a cycle, the rest of it
};

}  // namespace driveline::ecat_master
