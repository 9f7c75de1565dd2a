#pragma once

#include <atomic>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::ecat_master {

/// Keeps the last cycles in fixed memory and stops a little after a fault, so that the cycles before and after it can
/// be written to a file.
///
/// record() belongs to the cycle; trigger() and frozen() to any thread; the rest to one ordinary thread, while frozen()
/// or while no cycle runs.
class FlightRecorder {
 public:
  /// Cycles that are kept, unless the constructor is told otherwise.
  static constexpr std::size_t kCycles = 2048;
  /// Of them, recorded after the trigger.
  static constexpr std::size_t kCyclesAfter = 256;

  /// One axis in one cycle; units as in snapshot::AxisSample.
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

  /// All memory is taken here.
  explicit FlightRecorder(std::size_t axes, std::size_t cycles = kCycles);

  /// Takes the record of a cycle; does nothing while frozen. \rtsafe
  void record(const snapshot::LineSample& line, std::span<const Axis> axes) noexcept;
  /// Lets the recording run on for kCyclesAfter cycles and then stand still. The first trigger counts. \rtsafe
  void trigger() noexcept { triggered_.store(true, std::memory_order_release); }
  /// True once the records after a trigger are complete. \rtsafe
  [[nodiscard]] bool frozen() const noexcept { return frozen_.load(std::memory_order_acquire); }

  /// Cycles that are recorded, oldest first in write_csv().
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// How the columns of one axis are headed, and in which unit its positions are written.
  struct AxisLabel {
    std::string name;                                ///< of the axis
    const trajectory::PositionUnit* unit = nullptr;  ///< the headings name it; null: rad or m, which they do not name
    double increments_per_unit = 0.0;  ///< drive increments per rad or m, for columns of their own; 0: none
  };
  /// One row per cycle, one column per figure; `axes` has a label for each axis. The clock difference has a column
  /// only if a clock was locked in one of the cycles. Increments stand behind everything else.
  void write_csv(std::ostream& out, std::span<const AxisLabel> axes) const;
  /// Forgets everything and records again.
  void rearm() noexcept;

 private:
  [[nodiscard]] std::size_t slot(std::size_t age) const noexcept;
  void write_header(std::ostream& out, std::span<const AxisLabel> axes, bool clocks) const;

  std::size_t axes_;
  std::vector<snapshot::LineSample> lines_;
  std::vector<AxisRecord> axis_records_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
  std::size_t after_ = 0;
  std::atomic<bool> triggered_{false};
  std::atomic<bool> frozen_{false};
};

}  // namespace driveline::ecat_master
