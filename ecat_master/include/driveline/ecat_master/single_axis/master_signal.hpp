#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/ecat_master/process_data/pdo_entry.hpp"
#include "driveline/trajectory/limited_axis.hpp"
#include "driveline/trajectory/position_tracker.hpp"
#include "driveline/trajectory/setpoint.hpp"

namespace driveline::ecat_master {

class SingleAxis;

/// Something measured that leads the slaves of couplings: the position in an entry of the process data of any slave (an
/// encoder), or the actual position of an axis. Filtered and extrapolated by a trajectory::PositionTracker.
///
/// Belongs to the cycle once that runs; everything but the constructors is \rtsafe.
class MasterSignal {
 public:
  /// The entry of an encoder and how it counts.
  struct Encoder {
    PdoBits entry{};                             ///< of the inputs
    std::size_t slave = 0;                       ///< position on the line
    double increments_per_unit = 1.0;            ///< per rad or m, with the sign of its direction
    std::int64_t range = std::int64_t{1} << 32;  ///< increments until it begins anew, at least 2
    std::uint32_t divider = 1;                   ///< the slave is exchanged in every n-th cycle
  };

  /// An encoder. `bounds`: what it does at most; the velocity is also that of `tracker`. `tracker`: its period is that
  /// of the line's cycle, and its missing steps are cycles; both are brought to the exchanges of the slave.
  MasterSignal(const Encoder& encoder, const trajectory::TrackerSettings& tracker,
               const trajectory::FollowLimits& bounds) noexcept;
  /// The actual position of an axis with a drive, which must outlive it; also of one without power, that is turned by
  /// hand. `divider`: as that of an encoder; `tracker` and `bounds` as above.
  MasterSignal(const SingleAxis& axis, std::uint32_t divider, const trajectory::TrackerSettings& tracker,
               const trajectory::FollowLimits& bounds) noexcept;

  /// Of every cycle; as MotionControl::read_inputs(), behind the axes.
  void read_inputs(std::span<const std::byte> image, std::span<const bool> valid, std::span<const bool> fresh) noexcept;
  /// Behind periods without a cycle.
  void skip(std::int64_t missed) noexcept;

  /// Its position is known.
  [[nodiscard]] bool leads() const noexcept { return tracker_.valid(); }
  /// Where it is so much later than the exchange of this cycle, in s; as requests count, of an axis.
  [[nodiscard]] trajectory::AxisSetpoint at(double later_s) const noexcept;
  /// What it does at most.
  [[nodiscard]] const trajectory::FollowLimits& bounds() const noexcept { return bounds_; }
  /// Positions that could not be, so far.
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
  std::int64_t count_ = 0;  ///< goes on where the entry begins anew
};

}  // namespace driveline::ecat_master
