#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "support/line_rig.hpp"

namespace driveline::bench {

/// The drives of a line that follow a path in CSP with a cubic spline, without slave controllers: takes outputs,
/// executes two control steps, returns inputs.
class DriveCycles {
 public:
  /// `cycles`: upper limit of the cycles of all calls of prepare().
  DriveCycles(std::size_t drives, int cycles);

  /// Computes the outputs of the next `batch` cycles; in CSP they do not depend on the inputs of the drives.
  void prepare(std::size_t batch);
  /// Executes the prepared cycles in all drives.
  void execute();
  /// Passes the inputs of the last executed cycle to the axes.
  void read_inputs();
  /// Throws if the axes have left their path: the figures would be invalid.
  void check() { rig_.check(); }
  [[nodiscard]] std::size_t drives() noexcept { return rig_.line().size(); }

 private:
  void step(std::span<const std::byte> outputs);

  rt::VirtualClock clock_;
  LineRig rig_;
  std::vector<slaves::Device*> devices_;
  std::unique_ptr<bool[]> valid_;
  std::vector<std::vector<std::byte>> outputs_;  ///< outputs that the prepared cycles send
  std::int64_t cycle_ = 0;
  std::chrono::nanoseconds time_{};
};

}  // namespace driveline::bench
