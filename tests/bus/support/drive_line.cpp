#include "drive_line.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "driveline/runtime/devices/msd_device.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/trajectory/path.hpp"

namespace driveline::bus_test {

namespace {

/// Position of drive n at power-on: never at the start of its path.
double initial_position_rad(std::size_t n) {
  return -0.25 * static_cast<double>(n % 4);
}

std::uint32_t serial_number(std::size_t n) {
  return static_cast<std::uint32_t>(1000 + n);
}

template <typename T, typename E>
T or_throw(tl::expected<T, E> value) {
  if (!value) throw std::runtime_error("the test's own path is refused");
  return std::move(*value);
}

trajectory::Interpolator make_path(std::size_t axes, double amplitude_rad) {
  trajectory::PathBuilder builder;
  for (std::size_t i = 0; i < axes; ++i) {
    if (!builder.add_axis({"axis" + std::to_string(i), trajectory::AxisKind::kRotary}))
      throw std::runtime_error("axis");
  }
  constexpr int kPoints = 101;
  std::vector<double> positions(axes);
  for (int point = 0; point < kPoints; ++point) {
    const double part = static_cast<double>(point) / (kPoints - 1);
    for (std::size_t i = 0; i < axes; ++i) {
      const double amplitude = amplitude_rad / static_cast<double>(1 + i % 4);
      positions[i] = 0.1 + amplitude * 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * part));
    }
    if (!builder.add_point(part * LineOperation::kPathSeconds, positions)) throw std::runtime_error("point");
  }
  return trajectory::Interpolator::clamped_spline(or_throw(builder.build()));
}

constexpr std::size_t kRingSamples = std::size_t{1} << 15;

}  // namespace

DriveLine::DriveLine(std::size_t drives, const slaves::SlaveOptions& options, const slaves::LineOptions& line_options,
                     std::optional<slaves::Wiring> wiring, slaves::msd::Variant variant, double first_position_rad,
                     const std::vector<slaves::msd::MachineSwitch>& switches)
    : clock(milliseconds{1}) {
  std::vector<std::unique_ptr<slaves::Slave>> made;
  for (std::size_t i = 0; i < drives; ++i) {
    slaves::msd::MsdParameters parameters;
    parameters.variant = variant;
    parameters.name = "drive " + std::to_string(i);
    parameters.serial_number = serial_number(i);
    parameters.initial_position_rad = first_position_rad + initial_position_rad(i);
    parameters.switches = switches;
    auto drive = std::make_unique<slaves::msd::MsdDrive>(parameters);
    drives_.push_back(&drive->core());
    made.push_back(std::make_unique<slaves::Slave>(std::move(drive), options));
  }
  line_ = std::make_unique<slaves::SimulatedLine>(clock, std::move(made), line_options, std::move(wiring));
}

wire::AlStatusCode DriveLine::al_status_code(std::size_t position) {
  return static_cast<wire::AlStatusCode>(slave(position).esc().memory().get(wire::reg::kAlStatusCode));
}

bool DriveLine::all_in(wire::AlState state) noexcept {
  for (std::size_t i = 0; i < size(); ++i) {
    if (slave(i).state() != state) return false;
  }
  return true;
}

void DriveLine::leave_alone(nanoseconds duration) {
  clock.advance(duration);
  line_->advance(clock.now());
}

runtime::LineConfig LineOperation::describe(std::size_t drives, const RunOptions& options) {
  runtime::LineConfig config;
  config.period = options.period;
  config.max_lost_cycles = options.max_lost_cycles;
  config.recovery.axes = options.on_loss;
  auto& path = config.path.emplace();
  path.repeat = options.repeat;
  path.late = options.late;
  path.relative = options.relative;
  config.process_data.layout = options.layout.layout;
  for (const auto& group : options.layout.groups) config.process_data.groups.push_back({{}, group});
  if (options.acyclic_bytes != 0) config.acyclic_bytes = options.acyclic_bytes;
  slaves::msd::MsdParameters parameters;
  parameters.variant = options.variant;
  const auto device = std::make_shared<runtime::MsdDevice>(parameters);
  for (std::size_t i = 0; i < drives; ++i) {
    auto& slave = config.slaves.emplace_back();
    slave.name = "drive " + std::to_string(i);
    slave.device = device;
    slave.group = i % options.groups;
    if (options.plan_serials) slave.plan.serial = ecat_master::IdentityRule::equal(serial_number(i));
    slave.plan.sdos = options.startup;
    slave.plan.pdos = options.pdos;
    slave.plan.hot_connect = std::count(options.hot_connect.begin(), options.hot_connect.end(), i) > 0;
    if (options.every_third_without_lrw && i % 3 == 1) slave.plan.lrw = false;
    config.axes.push_back(axis(i, options));
  }
  return config;
}

/// Settings that a description does not contain, because only tests change them.
ecat_master::Master::Settings LineOperation::master_settings() const {
  auto settings = runtime::master_settings(config_);
  settings.state_timeout = options_.state_timeout;
  settings.accept_swapped_ports = options_.accept_swapped_ports;
  return settings;
}

LineOperation::LineOperation(DriveLine& drives, port::Port& port, const RunOptions& options)
    : drives_(drives),
      port_(port),
      options_(options),
      config_(describe(drives.size(), options)),
      line_ring_(options.samples ? kRingSamples : 1),
      axis_ring_(options.samples ? kRingSamples : 1),
      master_(std::make_unique<ecat_master::Master>(port_, drives.clock, master_settings())) {}

motion::AxisConfig LineOperation::axis(std::size_t position, const RunOptions& options) {
  motion::AxisConfig config;
  config.name = "axis" + std::to_string(position);
  config.slave = position;
  config.mode = options.mode;
  config.limits = {50.0, 1000.0};
  if (options.knows_torques) {
    config.inertia = slaves::MotorParameters{}.inertia_kg_m2;
    config.velocity_gain = 0.1;
  }
  config.setpoint_delay_cycles = options.setpoint_delay_cycles;
  config.adds_offsets = options.adds_offsets;
  config.follow_bit = options.follow_bit;
  config.supported_modes = options.supported_modes;
  config.velocity_count = options.velocity_count;
  config.software_limits = options.software_limits;
  config.following_error_window = options.following_error_window;
  config.max_torque = options.max_torque;
  config.range_min = options.range_min;
  config.range_max = options.range_max;
  config.modulo = options.modulo;
  config.feed_forward = options.feed_forward;
  config.reversed = options.reversed;
  config.compensation = options.compensation;
  if (config.compensation) config.limits = motion::limits_of_motion(config.limits, *config.compensation);
  return config;
}

ecat_master::SlavePlan LineOperation::plan(std::size_t position, const RunOptions& options) {
  return runtime::make_slave_plans(describe(position + 1, options))[position];
}

std::vector<ecat_master::SlavePlan> LineOperation::plans() const {
  return runtime::make_slave_plans(config_);
}

ecat_master::Result<void> LineOperation::to_safe_op() {
  if (auto done = master_->scan(); !done) return done;
  return master_->configure(plans());
}

motion::MotionControl& LineOperation::make_motion() {
  auto axes = runtime::make_axes(config_, *master_);
  if (options_.single_axes) {
    for (const auto& config : options_.virtual_axes) axes.emplace_back(config);
    motion::SingleAxes::Settings settings;
    settings.period = options_.period;
    settings.bad_cycle_limit = options_.max_lost_cycles;
    settings.enable_timeout = options_.enable_timeout;
    settings.homing_timeout = options_.homing_timeout;
    settings.target_timeout = options_.target_timeout;
    single_axes_ = std::make_unique<motion::SingleAxes>(std::move(axes), settings);
    if (options_.feed != nullptr) {
      std::vector<std::size_t> fed(options_.feed->axis_count());
      std::iota(fed.begin(), fed.end(), std::size_t{0});
      single_axes_->add_feed(*options_.feed, fed);
    }
    return *single_axes_;
  }
  auto settings = runtime::motion_settings(config_);
  settings.enable_timeout = options_.enable_timeout;
  motion_ =
      std::make_unique<motion::Motion>(std::move(axes), make_path(drives_.size(), options_.amplitude_rad), settings);
  return *motion_;
}

void LineOperation::start_cycle(ecat_master::Master::MakeRunner make_runner) {
  auto& motion = make_motion();
  auto settings = runtime::cycle_settings(config_, *master_);
  if (options_.task != nullptr) tasks_.add(*options_.task, {1, 0, options_.task_order});
  settings.tasks = &tasks_;
  settings.recorder = options_.recorder;
  settings.receive = options_.receive;
  settings.trace = options_.trace;
  if (options_.copies) settings.copies = options_.copies(*master_);
  traced_ = !make_runner;
  if (!make_runner) {
    make_runner = [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, drives_.clock);
    };
  }
  const motion::SampleRings rings =
      options_.samples ? motion::SampleRings{&line_ring_, &axis_ring_} : motion::SampleRings{};
  const auto started = master_->start_cycle(&motion, rings, settings, make_runner);
  if (!started) throw std::runtime_error(started.error().message());
}

ecat_master::Result<void> LineOperation::to_op() {
  if (auto done = to_safe_op(); !done) return done;
  start_cycle();
  auto done = master_->go_operational();
  drain();
  return done;
}

ecat_master::Result<void> LineOperation::to_motion() {
  auto done = to_op();
  if (done) motion_->request_start();
  return done;
}

void LineOperation::drain() {
  snapshot::AxisSample axis_sample;
  while (axis_ring_.try_pop(axis_sample)) axis_samples.push_back(axis_sample);
  snapshot::LineSample line_sample;
  while (line_ring_.try_pop(line_sample)) line_samples.push_back(line_sample);
}

void LineOperation::trace() {
  if (!traced_) return;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const auto& drive = drives_.drive(i);
    trace_.add(drive.motion().position_demand(), drive.motion().velocity_demand(), drive.velocity_rad_s());
  }
}

void LineOperation::run(nanoseconds duration) {
  const auto end = drives_.clock.now() + duration;
  do {
    master_->pass(nanoseconds{1});
    drain();
    trace();
  } while (drives_.clock.now() < end);
}

bool LineOperation::run_until(motion::MotionPhase phase, nanoseconds limit) {
  const auto end = drives_.clock.now() + limit;
  while (motion_->phase() != phase && drives_.clock.now() < end) cycle();
  return motion_->phase() == phase;
}

}  // namespace driveline::bus_test
