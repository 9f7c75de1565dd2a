#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "driveline/motion/cycle/sample_rings.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/snapshot/drain_thread.hpp"
#include "record/cycle_figures.hpp"
#include "record/recorder.hpp"
#include "record/status_feed.hpp"
#include "record/velocity_estimate.hpp"

namespace driveline::runtime {

/// Takes the samples of the cycle to those who use them: axes.csv, figures, telemetry, consumers of the application.
/// The cycle writes into rings; a thread empties them.
class RunSamples {
 public:
  explicit RunSamples(const LineConfig& config);

  /// Opens axes.csv in the folder of the results. Error: it cannot be written.
  [[nodiscard]] Result<void> open_recorder();
  /// Starts the thread. `listeners` get samples and the status of the line, and must outlive this. Call after
  /// open_recorder(). Error (kMachine): the thread cannot start.
  [[nodiscard]] Result<void> start(std::vector<snapshot::SampleConsumer*> listeners);
  /// Sets what the drives have told: scales of the recording; `estimated`: highest velocity of each axis whose drive
  /// does not report its velocity, in the units of the axis per second, 0 for the others.
  void complete(const std::vector<double>& estimated);
  /// Ends the thread after the last sample.
  void stop();
  /// Ends the thread and closes axes.csv: the line did not reach operation.
  void close();

  /// Returns the rings for the cycle.
  [[nodiscard]] motion::SampleRings rings() noexcept { return {&line_ring_, &axis_ring_}; }
  /// Whether the thread has taken all samples.
  [[nodiscard]] bool caught_up() const noexcept { return line_ring_.size() == 0 && axis_ring_.size() == 0; }
  /// Returns the recording; null before open_recorder() and after close().
  [[nodiscard]] Recorder* recorder() const noexcept { return recorder_.get(); }
  /// Returns the status of the line for the listeners; null before start().
  [[nodiscard]] StatusFeed* feed() const noexcept { return feed_.get(); }
  /// Returns the figures of the cycles. Call after start().
  [[nodiscard]] const CycleFigures& figures() const noexcept { return *figures_; }

 private:
  const LineConfig& config_;
  rt::SpscRing<snapshot::LineSample> line_ring_;
  rt::SpscRing<snapshot::AxisSample> axis_ring_;
  std::unique_ptr<StatusFeed> feed_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<CycleFigures> figures_;
  std::unique_ptr<VelocityEstimate> velocities_;
  std::unique_ptr<snapshot::DrainThread> drain_;
};

}  // namespace driveline::runtime
