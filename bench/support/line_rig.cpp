#include "support/line_rig.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"
#include "support/environment.hpp"
#include "support/retry.hpp"

namespace driveline::bench {
namespace {

using std::chrono::nanoseconds;

/// Cycles that the telemetry rings hold.
constexpr std::size_t kRingCycles = 512;

/// Half a second at 125 us: a shorter absence of the machine shows in the figures, but does not end the measurement.
constexpr std::uint32_t kBadCycleLimit = 4000;

template <typename T>
void require(const tl::expected<T, trajectory::PathError>& done) {
  if (!done) throw std::runtime_error(done.error().message());
}

void require(const ecat_master::Result<void>& done) {
  if (!done) throw std::runtime_error(ecat_master::describe(done.error()));
}

/// A point every millisecond, as in a path file.
trajectory::Path make_path(const std::vector<motion::AxisConfig>& axes, nanoseconds duration) {
  trajectory::PathBuilder builder;
  for (const auto& axis : axes) require(builder.add_axis({axis.name, trajectory::AxisKind::kRotary}));
  std::vector<double> positions(axes.size());
  for (std::int64_t ms = 0; ms <= duration / std::chrono::milliseconds{1}; ++ms) {
    const double time_s = static_cast<double>(ms) * 1e-3;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const double frequency_hz = 1.0 + 0.01 * static_cast<double>(i);
      positions[i] = 1.5 * (1.0 - std::cos(2.0 * std::numbers::pi * frequency_hz * time_s));
    }
    require(builder.add_point(time_s, positions));
  }
  auto path = builder.build();
  require(path);
  return std::move(*path);
}

}  // namespace

LineRings::LineRings(std::size_t axes) : lines_(kRingCycles), axes_(kRingCycles * axes) {}

void LineRings::drain() {
  std::array<snapshot::LineSample, 8> lines;
  std::array<snapshot::AxisSample, 64> axes;
  while (lines_.pop(lines) > 0) {
  }
  while (axes_.pop(axes) > 0) {
  }
}

trajectory::Interpolator sines(const std::vector<motion::AxisConfig>& axes, nanoseconds duration) {
  return trajectory::Interpolator::clamped_spline(make_path(axes, duration));
}

runtime::LineConfig describe_line(std::size_t axes, nanoseconds period) {
  runtime::LineConfig config;
  config.period = period;
  config.max_lost_cycles = kBadCycleLimit;
  config.path.emplace();
  for (std::size_t i = 0; i < axes; ++i) {
    auto& axis = config.axes.emplace_back();
    axis.name = fmt::format("axis{}", i);
    axis.slave = i;
    axis.inertia = slaves::MotorParameters{}.inertia_kg_m2;
    config.slaves.emplace_back().name = axis.name;
  }
  return config;
}

LineRig::LineRig(rt::Clock& clock, std::size_t axes, nanoseconds path_duration, nanoseconds period)
    : clock_(clock),
      path_duration_(path_duration),
      config_(describe_line(axes, period)),
      line_(clock, runtime::make_simulated_slaves(config_), kNoDelays),
      heap_of_line_(heap_bytes()),
      port_(line_),
      rings_(axes),
      master_(port_, clock, runtime::master_settings(config_)) {}

void LineRig::make_motion() {
  const auto before = heap_bytes();
  auto path = sines(config_.axes, path_duration_);
  heap_of_path_ = heap_bytes() - before;
  motion_ = std::make_unique<motion::Motion>(runtime::make_axes(config_, master_), std::move(path),
                                             runtime::motion_settings(config_));
}

std::size_t LineRig::heap_of_master() const {
  return heap_bytes() - heap_of_line_ - heap_of_path_;
}

void LineRig::configure() {
  require(master_.scan());
  require(master_.configure(runtime::make_slave_plans(config_)));
}

void LineRig::to_operational(motion::MotionControl& motion, const ecat_master::Master::MakeRunner& make_runner) {
  const auto started =
      master_.start_cycle(&motion, rings_.ends(), runtime::cycle_settings(config_, master_), make_runner);
  if (!started) throw std::runtime_error(started.error().message());
  require(master_.go_operational());
}

template <typename There>
void LineRig::pass_until(const There& there, const char* failure) {
  const auto deadline = clock_.now() + std::chrono::seconds{5};
  while (!there()) {
    if (clock_.now() > deadline) throw std::runtime_error(failure);
    master_.pass(std::chrono::milliseconds{1});
    drain();
  }
}

void LineRig::count_from_here() {
  master_.core()->count(false);
  master_.pass(2 * config_.period);
  master_.core()->count(true);
}

void LineRig::bring_up(const ecat_master::Master::MakeRunner& make_runner) {
  configure();
  make_motion();
  to_operational(*motion_, make_runner);
  motion_->request_start();
  pass_until([this] { return motion_->phase() == motion::MotionPhase::kFollowing; }, "the axes did not reach the path");
  count_from_here();
}

void LineRig::bring_up_single_axes(const ecat_master::Master::MakeRunner& make_runner) {
  configure();
  single_axes_ = std::make_unique<motion::SingleAxes>(runtime::make_axes(config_, master_),
                                                      runtime::single_axis_settings(config_));
  to_operational(*single_axes_, make_runner);
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    if (single_axes_->submit(i, {.command = motion::AxisCommand::kPower}) == 0)
      throw std::runtime_error("the queue has no room for the power of every axis");
  }
  const auto enabled = [this] {
    for (std::size_t i = 0; i < config_.axes.size(); ++i) {
      if (single_axes_->axis_report(i).state != motion::PlcopenState::kStandstill) return false;
    }
    return true;
  };
  pass_until(enabled, "the axes were not enabled");
  count_from_here();
}

void LineRig::drain() {
  rings_.drain();
}

void LineRig::check_motion() const {
  if (single_axes_ && single_axes_->failed()) throw Disturbed("an axis has failed during the measurement");
  if (motion_ && motion_->phase() != motion::MotionPhase::kFollowing) {
    const auto failure = motion_->failure();
    throw Disturbed(
        fmt::format("the axes left the path during the measurement: {}, cause {} (axis {}, status word 0x{:04X}, error "
                    "code 0x{:04X})",
                    to_text(motion_->phase()), static_cast<int>(failure.cause), failure.axis, failure.status_word,
                    failure.error_code));
  }
}

void LineRig::check() {
  check_motion();
  const auto& statistics = master_.core()->statistics();
  if (statistics.lost_frames + statistics.wkc_errors > 0) {
    throw Disturbed(fmt::format("{} frames lost and {} wrong working counters during the measurement",
                                statistics.lost_frames, statistics.wkc_errors));
  }
}

}  // namespace driveline::bench
