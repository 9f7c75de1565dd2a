#include "driveline/motion/drive/cia402_link.hpp"

#include "drive/drive_entries.hpp"
#include "driveline/motion/drive/axis_objects.hpp"

namespace driveline::motion {
namespace {

using snapshot::AxisState;

/// Bit n is set if all objects of mode n are mapped.
std::uint32_t possible_modes(const PdoConfiguration& pdos, bool needs_torque_offset) {
  using cia402::Mode;
  std::uint32_t modes = 0;
  for (const auto mode :
       {Mode::kProfilePosition, Mode::kVelocity, Mode::kProfileVelocity, Mode::kHoming, Mode::kInterpolatedPosition,
        Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    if (missing_objects(mode, pdos, needs_torque_offset).empty()) modes |= 1U << static_cast<unsigned>(mode);
  }
  return modes;
}

/// State of an ideal drive without faults that executes the control word at once.
AxisState state_by(std::uint16_t control_word) noexcept {
  switch (control_word & cia402::command::kEnableOperation) {
    case cia402::command::kShutdown:
      return AxisState::kReadyToSwitchOn;
    case cia402::command::kSwitchOn:
      return AxisState::kSwitchedOn;
    case cia402::command::kEnableOperation:
      return AxisState::kOperationEnabled;
    default:
      return AxisState::kSwitchOnDisabled;
  }
}

/// 6041h in this state (CiA 402-2, "State coding").
std::uint16_t status_word_of(AxisState state) noexcept {
  constexpr std::uint16_t kSwitchOnDisabled = 0x0040;
  constexpr std::uint16_t kReadyToSwitchOn = 0x0021;
  constexpr std::uint16_t kSwitchedOn = 0x0023;
  constexpr std::uint16_t kOperationEnabled = 0x0027;
  switch (state) {
    case AxisState::kReadyToSwitchOn:
      return kReadyToSwitchOn;
    case AxisState::kSwitchedOn:
      return kSwitchedOn;
    case AxisState::kOperationEnabled:
      return kOperationEnabled;
    default:
      return kSwitchOnDisabled;
  }
}

}  // namespace

Cia402Link::Cia402Link(const ImagePlace& place, const PdoConfiguration& pdos, const Settings& settings)
    : scales_(settings.scales),
      profile_targets_only_(settings.profile_targets_only),
      possible_modes_(possible_modes(pdos, settings.needs_torque_offset)),
      control_(entry<std::uint16_t>(pdos.outputs, place.output_offset, 0x6040)),
      mode_(entry<std::int8_t>(pdos.outputs, place.output_offset, 0x6060)),
      target_position_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x607A)),
      interpolation_data_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x60C1, 1)),
      target_velocity_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x60FF)),
      velocity_offset_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x60B1)),
      target_torque_(entry<std::int16_t>(pdos.outputs, place.output_offset, 0x6071)),
      torque_offset_(entry<std::int16_t>(pdos.outputs, place.output_offset, 0x60B2)),
      status_(entry<std::uint16_t>(pdos.inputs, place.input_offset, 0x6041)),
      mode_display_(entry<std::int8_t>(pdos.inputs, place.input_offset, 0x6061)),
      actual_position_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x6064)),
      actual_velocity_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x606C)),
      following_error_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x60F4)),
      actual_torque_(entry<std::int16_t>(pdos.inputs, place.input_offset, 0x6077)),
      error_code_(entry<std::uint16_t>(pdos.inputs, place.input_offset, 0x603F)),
      demand_position_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x6062)),
      demand_velocity_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x606B)),
      demand_torque_(entry<std::int16_t>(pdos.inputs, place.input_offset, 0x6074)),
      digital_inputs_(entry<std::uint32_t>(pdos.inputs, place.input_offset, 0x60FD)),
      probe_(place, pdos),
      profile_(place, pdos, settings.profile) {}

DriveCounts Cia402Link::read(std::span<const std::byte> image, bool fresh, AxisInputs& inputs) noexcept {
  probe_.read(image, fresh);
  status_word_ = take(status_, image);
  inputs.status_word = status_word_;
  inputs.error_code = take(error_code_, image);
  inputs.mode = take(mode_display_, image);
  inputs.state = cia402::decode_state(status_word_);
  inputs.follows = (status_word_ & cia402::status_bit::kFollowsSetpoints) != 0;
  inputs.velocity = take(actual_velocity_, image) / scales_.increments;
  inputs.torque = take(actual_torque_, image) * scales_.nm_per_permille;
  inputs.drive_following_error = take(following_error_, image) / scales_.increments;
  if (demand_velocity_) inputs.demand_velocity = take(demand_velocity_, image) / scales_.increments;
  if (demand_torque_) inputs.demand_torque = take(demand_torque_, image) * scales_.nm_per_permille;
  if (digital_inputs_) inputs.digital_inputs = take(digital_inputs_, image);
  DriveCounts counts{take(actual_position_, image)};
  if (demand_position_) counts.demand = take(demand_position_, image);
  return counts;
}

std::uint16_t Cia402Link::word_for(const DriveTargets& targets) const noexcept {
  // Fault reset acts on the rising edge of bit 7, so it is set for one request and cleared by the next.
  if (targets.reset_fault) return cia402::command::kFaultReset;
  const auto command = cia402::next_control_word(targets.state, targets.goal);
  // Set the bit together with the command to enable: a drive that is enabled without it brakes until it gets it.
  if (targets.mode == cia402::Mode::kInterpolatedPosition && command == cia402::command::kEnableOperation) {
    return command | cia402::command_bit::kInterpolate;
  }
  const bool enabled = targets.state == AxisState::kOperationEnabled && targets.goal == cia402::Goal::kEnabled;
  return enabled ? command | request_bits_ : command;
}

void Cia402Link::write(std::span<std::byte> image, const DriveTargets& targets) noexcept {
  control_word_ = word_for(targets);
  put(control_, image, control_word_);
  put(mode_, image, static_cast<std::int8_t>(targets.mode));
  const auto is_due = [&](cia402::Mode mode) { return !profile_targets_only_ || targets.mode == mode; };
  if (is_due(cia402::Mode::kProfilePosition)) put(target_position_, image, targets.position);
  put(interpolation_data_, image, targets.position);
  put(velocity_offset_, image, saturate<std::int32_t>(targets.velocity_offset * scales_.increments));
  if (is_due(cia402::Mode::kProfileVelocity)) {
    put(target_velocity_, image, saturate<std::int32_t>(targets.velocity * scales_.increments));
  }
  const double permille = 1.0 / scales_.nm_per_permille;
  const auto offset = saturate<std::int16_t>(targets.torque_offset * permille);
  put(torque_offset_, image, offset);
  // Round the sum only once.
  put(target_torque_, image, saturate<std::int16_t>(saturate<std::int16_t>(targets.torque * permille) - offset));
  probe_.write(image);
  profile_.write(image);
}

void Cia402Link::obey(AxisInputs& inputs) noexcept {
  inputs.state = state_by(control_word_);
  inputs.status_word = status_word_ = status_word_of(inputs.state);
}

void Cia402Link::begin_homing() noexcept {
  homing_.start(status_word_);
  request_bits_ = cia402::command_bit::kHomingStart;
}

void Cia402Link::begin_positioning(ProfileHandshake::Change change) noexcept {
  target_.start_position(change);
  request_bits_ = target_.command_bits() | (request_bits_ & cia402::command_bit::kHalt);
}

void Cia402Link::begin_velocity() noexcept {
  target_.start_velocity(status_word_);
  request_bits_ = target_.command_bits();
}

void Cia402Link::begin_velocity_on_ramp(double velocity) noexcept {
  profile_.set_target(velocity);
  target_.start_velocity(status_word_, cia402::command_bit::kFollowRamp);
  request_bits_ = target_.command_bits();
}

ProfileHandshake::State Cia402Link::target_progress(std::chrono::nanoseconds since) noexcept {
  const auto state = target_.judge(status_word_, since);
  // A drive that was halted would go on to its old target (CiA 402-2), so halt ends only when it has the new one.
  const unsigned halt = target_.under_way() ? 0U : request_bits_ & cia402::command_bit::kHalt;
  request_bits_ = static_cast<std::uint16_t>(target_.command_bits() | halt);
  return state;
}

}  // namespace driveline::motion
