#include "axis_line.hpp"

#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "driveline/canopen_client/nmt_commands.hpp"
#include "driveline/canopen_client/sdo_client.hpp"
#include "driveline/motion/axis/startup_sdos.hpp"
#include "driveline/trajectory/path.hpp"
#include "support/must.hpp"

namespace driveline::bus_test {
namespace {

using canopen::Frame;
using canopen::NodePlan;
using canopen::PdoExchange;
using canopen::PdoPlan;
using motion::cia402::Mode;

constexpr std::uint8_t kFirstNode = 3;
constexpr std::uint32_t kModesOnCan = 0x67;  ///< 1, 2, 3, 6, 7 (MSD manual 12.2)

std::vector<PdoPlan> plans_of(const std::vector<motion::PdoMapping>& mappings, std::uint16_t base,
                              std::initializer_list<std::uint16_t> with_sync) {
  std::vector<PdoPlan> plans;
  for (const auto& mapping : mappings) {
    auto& plan = plans.emplace_back();
    plan.number = static_cast<std::uint16_t>(mapping.index - base + 1);
    plan.objects = mapping.objects;
    if (std::find(with_sync.begin(), with_sync.end(), plan.number) != with_sync.end()) continue;
    plan.transmission = 255;
    plan.exchange = PdoExchange::kOnChange;
  }
  return plans;
}

NodePlan node_plan(std::size_t axis, const CanAxesOptions& options) {
  auto pdos = motion::can_axis_pdo_configuration();
  if (options.profile) {
    pdos.outputs.push_back({0x1602, {{0x607A, 0, 32}, {0x6081, 0, 32}}});
    pdos.outputs.push_back({0x1603, {{0x60FF, 0, 32}, {0x6083, 0, 32}}});
  }
  if (options.velocity) pdos.inputs.push_back({0x1A02, {{0x606C, 0, 32}}});
  NodePlan node;
  node.name = "axis" + std::to_string(axis);
  node.id = static_cast<std::uint8_t>(kFirstNode + axis);
  node.rpdos = plans_of(pdos.outputs, 0x1600, {2});
  node.tpdos = plans_of(pdos.inputs, 0x1A00, {1, 3});
  node.startup_sdos = {motion::startup_sdo(0x1006, 0, static_cast<std::uint32_t>(options.period / microseconds{1}))};
  // P 306, the cycle of the setpoints in ms, which must be that of 1006h and 60C2h (MSD manual 7.4.2); P 370, the cubic
  // spline; P 1516, the inertia for the feed-forward.
  const float period_ms = std::chrono::duration<float, std::milli>(options.period).count();
  const auto inertia = static_cast<float>(slaves::MotorParameters{}.inertia_kg_m2);
  node.startup_sdos.push_back(motion::startup_sdo(0x2132, 0, std::bit_cast<std::uint32_t>(period_ms)));
  node.startup_sdos.push_back(motion::startup_sdo(0x2172, 0, std::uint8_t{3}));
  node.startup_sdos.push_back(motion::startup_sdo(0x25EC, 0, std::bit_cast<std::uint32_t>(inertia)));
  for (const auto& sdo : motion::cia402_startup_sdos(options.period)) node.startup_sdos.push_back(sdo);
  node.startup_sdos.push_back(motion::mode_sdo(Mode::kInterpolatedPosition));
  for (const auto& sdo : options.startup) node.startup_sdos.push_back(sdo);
  return node;
}

/// As the path of an axis of LineOperation.
trajectory::Interpolator make_can_path(std::size_t axes) {
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
      positions[i] = 0.1 + 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * part)) / static_cast<double>(1 + i % 4);
    }
    if (!builder.add_point(part * CanAxisLine::kPathSeconds, positions)) throw std::runtime_error("point");
  }
  return trajectory::Interpolator::clamped_spline(*must(builder.build()));
}

/// Sends what the master needs to configure a drive, in the order of CiA 301 7.5.2.35: a PDO is off while it changes.
class Configurer {
 public:
  Configurer(canopen::BusLink& link, std::uint8_t node) : client_(link, node) {}

  void write(std::uint16_t index, std::uint8_t subindex, std::span<const std::byte> data) {
    if (!failure.empty()) return;
    if (const auto done = client_.download({index, subindex}, data); !done) failure = describe(done.error());
  }
  template <typename T>
  void write_number(std::uint16_t index, std::uint8_t subindex, T value) {
    write(index, subindex, bytes::to_le_bytes(value));
  }
  void write_pdo(const PdoPlan& pdo, std::uint16_t communication, std::uint16_t mapping, std::uint32_t identifier) {
    const auto number = static_cast<std::uint16_t>(pdo.number - 1);
    const auto parameter = static_cast<std::uint16_t>(communication + number);
    const auto map = static_cast<std::uint16_t>(mapping + number);
    write_number(parameter, 1, identifier | canopen::CobId::kInvalid);
    write_number(map, 0, std::uint8_t{0});
    std::uint8_t entry = 0;
    for (const auto& object : pdo.objects) write_number(map, ++entry, object.raw());
    write_number(map, 0, entry);
    write_number(parameter, 2, pdo.transmission);
    write_number(parameter, 1, identifier);
  }
  std::string failure;

 private:
  canopen::SdoClient client_;
};

}  // namespace

canopen::SendStatus LossyCanPort::send(const Frame& frame) noexcept {
  bus_.advance(clock_.now());
  if (refuse && refuse(frame)) return canopen::SendStatus::kBusy;
  ++counters_.sent;
  if (lose_sent && lose_sent(frame)) return canopen::SendStatus::kSent;
  if (!controller_->send(frame)) return canopen::SendStatus::kBusy;
  bus_.advance(clock_.now());
  return canopen::SendStatus::kSent;
}

std::optional<canopen::ReceivedFrame> LossyCanPort::receive() noexcept {
  bus_.advance(clock_.now());
  if (arrived_.empty()) return std::nullopt;
  const auto frame = arrived_.front();
  arrived_.pop_front();
  return frame;
}

bool LossyCanPort::wait_readable(nanoseconds deadline) noexcept {
  for (;;) {
    bus_.advance(clock_.now());
    if (!arrived_.empty()) return true;
    if (clock_.now() >= deadline) return false;
    clock_.sleep_until(std::min(deadline, bus_.next_event()));
  }
}

void LossyCanPort::receive(const Frame& frame, nanoseconds now) {
  add(frame, now);
  if (lose_received && lose_received(frame)) return;
  arrived_.push_back({frame, now});
}

/// FNV-1a.
void LossyCanPort::add(const Frame& frame, nanoseconds now) noexcept {
  const auto mix = [this](std::uint64_t value) { sum_ = (sum_ ^ value) * 0x100'0000'01B3; };
  mix(static_cast<std::uint64_t>(now.count()));
  mix(frame.identifier.value);
  for (const auto byte : frame.payload()) mix(std::to_integer<std::uint64_t>(byte));
}

CanAxisLine::CanAxisLine(const CanAxesOptions& options) : options_(options) {
  plan_.period = options.period;
  for (std::size_t i = 0; i < options.axes; ++i) {
    slaves::msd::MsdParameters parameters;
    parameters.variant = options.variant;
    parameters.initial_position_rad = 0.01 * static_cast<double>(i);
    parameters.switches = options.switches;
    const auto node = static_cast<std::uint8_t>(kFirstNode + i);
    drives_.push_back(std::make_unique<slaves::msd::MsdCanDrive>(
        parameters, slaves::msd::CanConnection{slaves::msd::DipSwitch{node}, {}, microseconds{500}}));
    bus_.attach(drives_.back()->device());
    plan_.nodes.push_back(node_plan(i, options));
  }
}

std::string CanAxisLine::configure(std::size_t axis) {
  const auto& node = plan_.nodes[axis];
  canopen::BusLink link(port_, clock);
  Configurer configurer(link, node.id);
  for (const auto& sdo : node.startup_sdos) configurer.write(sdo.index, sdo.subindex, sdo.data);
  for (const auto& pdo : node.rpdos) {
    configurer.write_pdo(pdo, 0x1400, 0x1600, canopen::predefined::kRxPdo.at(pdo.number - 1U) + node.id);
  }
  for (const auto& pdo : node.tpdos) {
    const auto identifier = canopen::predefined::kTxPdo.at(pdo.number - 1U) + node.id;
    configurer.write_pdo(pdo, 0x1800, 0x1A00, identifier | canopen::CobId::kNoRemote);
  }
  return configurer.failure;
}

std::string CanAxisLine::configure() {
  leave_alone(milliseconds{20});
  for (std::size_t axis = 0; axis < size(); ++axis) {
    if (auto failure = configure(axis); !failure.empty()) return failure;
  }
  canopen::BusLink link(port_, clock);
  canopen::NmtCommands nmt(link);
  if (const auto done = nmt.start(canopen::NmtCommands::kAll); !done) return describe(done.error());
  leave_alone(milliseconds{5});
  return {};
}

motion::AxisConfig CanAxisLine::axis(std::size_t place) const {
  motion::AxisConfig config;
  config.name = plan_.nodes[place].name;
  config.slave = place;
  config.mode = Mode::kInterpolatedPosition;
  config.period = options_.period;
  config.limits = options_.limits;
  config.supported_modes = kModesOnCan;
  config.follow_bit = true;
  config.loss_is_certain = true;
  config.setpoint_delay_cycles = options_.setpoint_delay_cycles.value_or(
      motion::can_setpoint_delay_cycles(options_.period, motion::kSplinePeriods));
  return config;
}

motion::MotionControl& CanAxisLine::make_motion() {
  std::vector<motion::Axis> axes;
  for (std::size_t i = 0; i < size(); ++i) axes.emplace_back(axis(i), image_->place(i), image_->configuration(i));
  if (options_.single_axes) {
    motion::SingleAxes::Settings settings;
    settings.period = options_.period;
    settings.bad_cycle_limit = options_.max_lost_cycles;
    single_axes_ = std::make_unique<motion::SingleAxes>(std::move(axes), settings);
    if (options_.feed != nullptr) {
      std::vector<std::size_t> fed(options_.feed->axis_count());
      std::iota(fed.begin(), fed.end(), std::size_t{0});
      single_axes_->add_feed(*options_.feed, fed);
    }
    return *single_axes_;
  }
  motion::Motion::Settings settings;
  settings.period = options_.period;
  settings.bad_cycle_limit = options_.max_lost_cycles;
  motion_ = std::make_unique<motion::Motion>(std::move(axes), make_can_path(size()), settings);
  return *motion_;
}

void CanAxisLine::start_cycle() {
  image_ = *must(canopen::PdoImage::build(plan_));
  auto& motion = make_motion();
  cycle_ =
      std::make_unique<canopen::CanCycle>(port_, clock, plan_, *image_, channel_, &motion,
                                          motion::SampleRings{&line_ring_, &axis_ring_}, canopen::CanCycle::Settings{});
  for (std::size_t i = 0; i < size(); ++i) cycle_->set_operational(i, true);
  runner_ = std::make_unique<motion::InlineRunner>(*cycle_, clock);
  static_cast<void>(runner_->start());
}

void CanAxisLine::run(nanoseconds duration) {
  const auto end = clock.now() + duration;
  do {
    runner_->pass(nanoseconds{1});
    drain();
  } while (clock.now() < end);
}

bool CanAxisLine::run_until(motion::MotionPhase phase, nanoseconds limit) {
  const auto end = clock.now() + limit;
  while (motion_->phase() != phase && clock.now() < end) cycle();
  return motion_->phase() == phase;
}

void CanAxisLine::leave_alone(nanoseconds duration) {
  clock.sleep_until(clock.now() + duration);
  bus_.advance(clock.now());
}

void CanAxisLine::drain() {
  snapshot::AxisSample axis_sample;
  while (axis_ring_.try_pop(axis_sample)) {
    if (samples) axis_samples.push_back(axis_sample);
  }
  snapshot::LineSample line_sample;
  while (line_ring_.try_pop(line_sample)) {
    if (samples) line_samples.push_back(line_sample);
  }
}

}  // namespace driveline::bus_test
