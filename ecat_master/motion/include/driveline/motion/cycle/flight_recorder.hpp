#pragma once

#include <atomic>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::motion {

/// Records the last cycles in fixed memory and stops shortly after a fault, so that the cycles before and after it can
/// be written to a file.
///
/// record() is for the cycle; trigger() and frozen() are for any thread; the rest is for one ordinary thread, while
/// frozen() or while no cycle runs.
class FlightRecorder {
 public:
  /// Default number of cycles stored.
  static constexpr std::size_t kCycles = 2048;
  /// Number of these cycles that are recorded after the trigger.
  static constexpr std::size_t kCyclesAfter = 256;

  /// Record of an axis in a cycle; units as in snapshot::AxisSample.
  struct AxisRecord {
    double target_position = 0.0;                                   ///< rad, or m for linear axes
    double actual_position = 0.0;                                   ///< rad, or m for linear axes
    float target_velocity = 0.0F;                                   ///< rad/s, or m/s
    float actual_velocity = 0.0F;                                   ///< rad/s, or m/s
    float target_torque = 0.0F;                                     ///< Nm, or N
    float actual_torque = 0.0F;                                     ///< Nm, or N
    float following_error = 0.0F;                                   ///< rad, or m
    std::uint16_t control_word = 0;                                 ///< 6040h
    std::uint16_t status_word = 0;                                  ///< 6041h
    std::int8_t mode = 0;                                           ///< 6061h
    snapshot::AxisState state = snapshot::AxisState::kUnavailable;  ///< CiA 402 state of the drive
  };

  /// Allocates all memory.
  explicit FlightRecorder(std::size_t axes, std::size_t cycles = kCycles);

  /// Records a cycle; does nothing while frozen. \rtsafe
  void record(const snapshot::LineSample& line, std::span<const Axis> axes) noexcept;
  /// Stops recording after kCyclesAfter further cycles. Only the first trigger counts. \rtsafe
  void trigger() noexcept { triggered_.store(true, std::memory_order_release); }
  /// Whether the records after a trigger are complete. \rtsafe
  [[nodiscard]] bool frozen() const noexcept { return frozen_.load(std::memory_order_acquire); }

  /// Number of cycles recorded; write_csv() writes the oldest first.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Column headings of an axis, and the unit of its positions.
  struct AxisLabel {
    std::string name;                                ///< name of the axis
    const trajectory::PositionUnit* unit = nullptr;  ///< unit, named in the headings; null: rad or m, not named
    double increments_per_unit = 0.0;                ///< drive increments per rad or m, for additional columns; 0: none
  };
  /// Writes one row per cycle and one column per figure; `axes` has a label for each axis. The clock difference has a
  /// column only if a clock was locked in one of the cycles, and the load of the bus only if one was measured.
  /// Increments are the last columns.
  void write_csv(std::ostream& out, std::span<const AxisLabel> axes) const;
  /// Discards all records and starts recording again.
  void rearm() noexcept;

 private:
  [[nodiscard]] std::size_t slot(std::size_t age) const noexcept;
  void write_header(std::ostream& out, std::span<const AxisLabel> axes, bool clocks, bool load) const;

  std::size_t axes_;
  std::vector<snapshot::LineSample> lines_;
  std::vector<AxisRecord> axis_records_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
  std::size_t after_ = 0;
  std::atomic<bool> triggered_{false};
  std::atomic<bool> frozen_{false};
};

}  // namespace driveline::motion
