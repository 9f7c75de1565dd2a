#pragma once

#include <chrono>

#include "driveline/rt/cycle_timer.hpp"

namespace driveline::motion {

/// One cycle of a bus on a fixed grid: its exchange of process data, and the axes. A CycleRunner runs it.
class Cycle {
 public:
  virtual ~Cycle() = default;
  /// Period of the grid.
  [[nodiscard]] virtual std::chrono::nanoseconds period() const noexcept = 0;
  /// First instant of the grid, not before `earliest`. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds first_grid(std::chrono::nanoseconds earliest) const noexcept = 0;
  /// Work of the next cycle that can be done between wake-up and grid instant; cycle() does it if it has not been done.
  /// \rtsafe
  virtual void prepare() noexcept = 0;
  /// Runs one cycle. \rtsafe
  virtual void cycle(const rt::CycleStart& start) noexcept = 0;
  /// Correction of the grid before the next cycle. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds grid_shift() const noexcept = 0;

 protected:
  Cycle() = default;
  Cycle(const Cycle&) = default;             ///< for derived classes
  Cycle& operator=(const Cycle&) = default;  ///< for derived classes
};

}  // namespace driveline::motion
