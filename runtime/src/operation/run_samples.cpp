#include "operation/run_samples.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;

/// Interval at which the rings are read: the longest delay of a sample before the consumers get it.
constexpr auto kDrainPeriod = std::chrono::microseconds{500};
/// Cycles that the rings hold: a quarter of a second at 8 kHz.
constexpr std::size_t kRingCycles = 2048;
constexpr std::size_t kMaxRingSamples = 1 << 17;

}  // namespace

RunSamples::RunSamples(const LineConfig& config)
    : config_(config),
      line_ring_(kRingCycles),
      axis_ring_(std::clamp<std::size_t>(config.axes.size() * kRingCycles, 1, kMaxRingSamples)) {}

Result<void> RunSamples::open_recorder() {
  const auto every = std::max<std::int64_t>(1, milliseconds{1} / config_.period);
  recorder_ = std::make_unique<Recorder>(
      config_.axes, config_.axes.empty() ? std::nullopt : std::optional(config_.output.directory / "axes.csv"),
      static_cast<std::uint64_t>(every), config_.output.increments, compensates_dead_time(config_));
  if (recorder_->problem()) return tl::unexpected(*recorder_->problem());
  return {};
}

Result<void> RunSamples::start(std::vector<snapshot::SampleConsumer*> listeners) {
  figures_ = std::make_unique<CycleFigures>(config_.period);
  feed_ = std::make_unique<StatusFeed>(listeners, config_.period);
  std::vector<snapshot::SampleConsumer*> consumers{recorder_.get(), figures_.get(), feed_.get()};
  consumers.insert(consumers.end(), listeners.begin(), listeners.end());
  velocities_ = std::make_unique<VelocityEstimate>(std::move(consumers));
  drain_ = std::make_unique<snapshot::DrainThread>(line_ring_, axis_ring_,
                                                   std::vector<snapshot::SampleConsumer*>{velocities_.get()},
                                                   snapshot::DrainConfig{.period = kDrainPeriod});
  if (auto started = drain_->start(); !started) return fail(ErrorKind::kMachine, describe(started.error()));
  return {};
}

void RunSamples::complete(const std::vector<double>& estimated) {
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    recorder_->set_scale(i, config_.axes[i].increments_per_unit);
  }
  velocities_->estimate(estimated);
}

void RunSamples::stop() {
  if (drain_) drain_->stop();
}

void RunSamples::close() {
  drain_.reset();
  recorder_.reset();
}

}  // namespace driveline::runtime
