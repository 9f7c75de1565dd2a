#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/trajectory/limited_axis.hpp"
#include "driveline/trajectory/position_tracker.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::motion {

class SingleAxis;

/// A measured position that leads the slaves of couplings: an entry in the process data of any slave (an encoder), or
/// the actual position of an axis. Filtered and extrapolated by a trajectory::PositionTracker.
///
/// Used by the cycle thread only once the cycle runs; everything except the constructors is \rtsafe.
class MasterSignal {
 public:
  /// The entry of an encoder and its scale.
  struct Encoder {
    PdoBits entry{};                             ///< entry in the inputs
    std::size_t slave = 0;                       ///< position on the line
    double increments_per_unit = 1.0;            ///< increments per rad or m, signed by the direction
    std::int64_t range = std::int64_t{1} << 32;  ///< increments until the count wraps, at least 2
    std::uint32_t divider = 1;                   ///< the slave is exchanged in every n-th cycle
  };

  /// An encoder. `bounds`: its highest motion; the velocity also limits `tracker`. `tracker`: its period is the cycle
  /// time of the line, and its missing steps are counted in cycles; both are converted to exchanges of the slave.
  MasterSignal(const Encoder& encoder, const trajectory::TrackerSettings& tracker,
               const trajectory::FollowLimits& bounds) noexcept;
  /// The actual position of an axis with a drive, which must outlive this object; the axis may be without power and
  /// turned by hand. `divider` as in Encoder; `tracker` and `bounds` as above.
  MasterSignal(const SingleAxis& axis, std::uint32_t divider, const trajectory::TrackerSettings& tracker,
               const trajectory::FollowLimits& bounds) noexcept;

  /// Call in every cycle, after the inputs of the axes are read; parameters as in MotionControl::read_inputs().
  void read_inputs(std::span<const std::byte> image, std::span<const bool> valid, std::span<const bool> fresh) noexcept;
  /// Accounts for `missed` periods without a cycle.
  void skip(std::int64_t missed) noexcept;

  /// Whether the position is known.
  [[nodiscard]] bool leads() const noexcept { return tracker_.valid(); }
  /// State `later_s` seconds after the exchange of this cycle; for an axis in request positions.
  [[nodiscard]] trajectory::AxisSetpoint at(double later_s) const noexcept;
  /// Highest motion of the signal.
  [[nodiscard]] const trajectory::FollowLimits& bounds() const noexcept { return bounds_; }
  /// Number of implausible positions so far.
  [[nodiscard]] std::uint64_t leaps() const noexcept { return tracker_.leaps(); }

 private:
  void take(bool good) noexcept;
  void count(std::span<const std::byte> image) noexcept;

  Encoder encoder_{};
  const SingleAxis* axis_ = nullptr;
  trajectory::FollowLimits bounds_{};
  trajectory::PositionTracker tracker_{};
  double period_s_;
  std::int64_t waiting_ = 0;  ///< cycles since the last exchange
  std::optional<std::int64_t> raw_{};
  std::int64_t count_ = 0;  ///< continues where the entry wraps
};

}  // namespace driveline::motion
