#include "axes/line_couplings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/setup/composition.hpp"

namespace driveline::runtime {
namespace {

using motion::Couplings;
using motion::MasterSignal;
using motion::RequestPhase;
using trajectory::CouplingLaw;
using trajectory::CouplingState;
using Kind = CouplingOrder::Kind;

/// Factor by which the actual velocity of an axis may exceed that of its setpoints.
constexpr double kOvershoot = 1.5;
/// CiA 402: position demand, internal and actual value.
constexpr std::uint16_t kFirstOwnPosition = 0x6062;
constexpr std::uint16_t kLastOwnPosition = 0x6064;

double seconds_of(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

trajectory::TrackerSettings tracker_of(const LineConfig& config, double max_velocity) {
  trajectory::TrackerSettings settings;
  settings.period_s = seconds_of(config.period);
  settings.max_velocity = max_velocity;
  settings.most_missing = config.max_lost_cycles;
  return settings;
}

/// Returns the index of the [[slave]] table with this name; none: there is no such table.
std::optional<std::size_t> table_of(const LineConfig& config, const std::string& slave) {
  const auto found =
      std::find_if(config.slaves.begin(), config.slaves.end(), [&](const auto& one) { return one.name == slave; });
  if (found == config.slaves.end()) return std::nullopt;
  return static_cast<std::size_t>(found - config.slaves.begin());
}

}  // namespace

std::string_view to_text(CouplingState state) noexcept {
  switch (state) {
    case CouplingState::kIdle:
      return "not coupled";
    case CouplingState::kWaiting:
      return "waiting";
    case CouplingState::kRunningIn:
      return "running in";
    case CouplingState::kCatchingUp:
      return "catching up";
    case CouplingState::kInSync:
      return "in synchronism";
    case CouplingState::kReleased:
      return "released";
  }
  return "?";
}

Result<std::unique_ptr<LineCouplings>> LineCouplings::make(const LineConfig& config, motion::SingleAxes& axes,
                                                           const ecat_master::ProcessVariables& variables,
                                                           const InputAge& input_age) {
  std::unique_ptr<LineCouplings> made(new LineCouplings(config));
  if (auto added = made->add_signals(axes, variables, input_age); !added) return tl::unexpected(added.error());
  made->couplings_ = std::make_unique<Couplings>(axes, made->pairs_, config.period);
  return made;
}

Result<void> LineCouplings::add_signals(motion::SingleAxes& axes, const ecat_master::ProcessVariables& variables,
                                        const InputAge& input_age) {
  for (const auto& coupling : plan_.couplings) {
    auto& pair = pairs_.emplace_back();
    pair.slave = coupling.slave;
    pair.master = coupling.axis.value_or(Couplings::Pair::kNoAxis);
    pair.on_loss = coupling.on_loss;
    if (coupling.encoder) {
      if (auto added = add_encoder(coupling, variables, input_age); !added) return added;
    } else if (coupling.actual) {
      const auto& axis = config_.axes[*coupling.axis];
      auto tracker = tracker_of(config_, kOvershoot * axis.limits.max_velocity);
      tracker.noise = 1.0 / axis.increments_per_unit;
      const trajectory::FollowLimits bounds{{tracker.max_velocity, std::numeric_limits<double>::infinity()}};
      signals_.push_back(std::make_unique<MasterSignal>(
          axes.axis(*coupling.axis), exchange_divider(config_, config_.slaves[axis.slave]), tracker, bounds));
      pair.older_s = seconds_of(input_age(axis.slave));
    }
    if (coupling.encoder || coupling.actual) pair.signal = signals_.back().get();
    const auto& slave = config_.axes[coupling.slave];
    if (pair.signal != nullptr && !slave.is_virtual()) pair.older_s -= seconds_of(input_age(slave.slave));
  }
  return {};
}

Result<void> LineCouplings::add_encoder(const CouplingConfig& coupling, const ecat_master::ProcessVariables& variables,
                                        const InputAge& input_age) {
  const auto& encoder = plan_.encoders[*coupling.encoder];
  const auto variable = variables.find(encoder.position);
  if (!variable) return fail(ErrorKind::kSetting, describe(variable.error()), encoder.position_place);
  if (variable->output) {
    return fail(ErrorKind::kSetting, fmt::format("{} is an output, an input is expected", variable->text()),
                encoder.position_place);
  }
  const auto bits = variables.bits(encoder.position);
  if (!bits) return fail(ErrorKind::kSetting, describe(bits.error()), encoder.position_place);
  const auto table = table_of(config_, variable->slave_name);
  const auto& slave = config_.axes[coupling.slave];
  const bool own = table == slave.slave && variable->index >= motion::object_of_drive(kFirstOwnPosition, slave.drive) &&
                   variable->index <= motion::object_of_drive(kLastOwnPosition, slave.drive);
  if (own) {
    return fail(
        ErrorKind::kSetting,
        fmt::format("{} is the position of \"{}\": an axis cannot be its own master", variable->text(), slave.name),
        coupling.place);
  }
  MasterSignal::Encoder settings;
  settings.entry = *bits;
  settings.slave = variable->slave;
  settings.increments_per_unit = encoder.reversed ? -encoder.increments_per_unit : encoder.increments_per_unit;
  const auto all = std::int64_t{1} << variable->bits;
  settings.range = encoder.range.value_or(all);
  if (settings.range > all) {
    return fail(ErrorKind::kSetting,
                fmt::format("range_increments is {}, but {} has {} bits and a maximum of {}", settings.range,
                            variable->text(), variable->bits, all),
                encoder.position_place);
  }
  if (table) settings.divider = exchange_divider(config_, config_.slaves[*table]);
  auto tracker = tracker_of(config_, encoder.max_velocity);
  tracker.cutoff_hz = encoder.cutoff_hz;
  tracker.noise = encoder.noise_increments / encoder.increments_per_unit;
  const trajectory::FollowLimits bounds{
      {encoder.max_velocity, encoder.max_acceleration.value_or(std::numeric_limits<double>::infinity())}};
  signals_.push_back(std::make_unique<MasterSignal>(settings, tracker, bounds));
  pairs_.back().older_s = seconds_of(encoder.latency);
  if (table) pairs_.back().older_s += seconds_of(input_age(*table));
  return {};
}

bool LineCouplings::coupled(std::size_t slave) const noexcept {
  return couplings_->report(slave).state != CouplingState::kIdle;
}

std::uint64_t LineCouplings::submit(std::size_t slave, const CouplingOrder& order) {
  if (order.kind == Kind::kPhase) {
    const auto number = order.relative ? couplings_->shift_phase_by(slave, order.phase, order.limits)
                                       : couplings_->shift_phase_to(slave, order.phase, order.limits);
    return number == 0 ? 0 : number | kPhaseBit;
  }
  if (order.kind == Kind::kOut) return couplings_->disengage(slave);
  const bool gear = order.kind == Kind::kGearIn;
  const auto law = gear ? CouplingLaw::gear(order.ratio, order.at.value_or(0.0), order.to)
                        : CouplingLaw::cam(*plan_.cams[order.cam].cam, order.master_zero, order.slave_zero);
  const auto catch_up = gear ? trajectory::CatchUp::kVelocity : trajectory::CatchUp::kPosition;
  const auto number =
      order.at ? couplings_->engage_at(slave, law, {*order.at, order.over}) : couplings_->engage(slave, law, catch_up);
  if (number != 0) orders_[slave] = number;
  return number;
}

bool LineCouplings::is_order(std::size_t slave, std::uint64_t number) const {
  const auto found = orders_.find(slave);
  return found != orders_.end() && found->second == number;
}

bool LineCouplings::phase_taken(std::size_t slave, std::uint64_t number) const noexcept {
  return couplings_->report(slave).phase_number >= (number & ~kPhaseBit);
}

motion::RequestReport LineCouplings::judge(std::size_t slave, std::uint64_t number,
                                           motion::RequestReport report) const {
  if (!is_phase(number)) {
    if (report.phase != RequestPhase::kReached || !is_order(slave, number)) return report;
    if (couplings_->report(slave).state != CouplingState::kInSync) report.phase = RequestPhase::kActive;
    return report;
  }
  const auto now = couplings_->report(slave);
  const auto asked = number & ~kPhaseBit;
  if (now.phase_number > asked) return {RequestPhase::kAborted, motion::AxisError::kNone};
  const bool lost = now.state == CouplingState::kIdle || (now.phase_number == asked && now.phase_refused);
  if (lost) return {RequestPhase::kError, motion::AxisError::kNothingToDo};
  const bool done = now.phase_number == asked && now.phase_reached;
  return {done ? RequestPhase::kDone : RequestPhase::kActive, motion::AxisError::kNone};
}

trajectory::CouplingRefusal LineCouplings::refusal(std::size_t slave) const noexcept {
  return couplings_->report(slave).refusal;
}

CouplingStatus LineCouplings::status(std::size_t slave) const {
  const auto& coupling = *plan_.of(slave);
  const auto now = couplings_->report(slave);
  CouplingStatus status;
  status.master = coupling.axis ? config_.axes[*coupling.axis].name : plan_.encoders[*coupling.encoder].name;
  status.master_unit =
      coupling.axis ? motion::position_unit(config_.axes[*coupling.axis]) : *plan_.encoders[*coupling.encoder].unit;
  status.state = now.state;
  status.master_position = now.master;
  status.phase = now.phase;
  status.losses = now.losses;
  return status;
}

}  // namespace driveline::runtime
