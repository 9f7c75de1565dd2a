// Influences of the machine on the drive: terminals, motor, supply, ambient temperature.
#include "driveline/slaves/msd/core/drive_core.hpp"

namespace driveline::slaves::msd {

std::int32_t DriveCore::shown_position(std::int64_t increments) const noexcept {
  return motion_.settings().range.wrap(motion_.position_at(increments));
}

void DriveCore::set_input(Input input, bool level) noexcept {
  terminal_changed(input, level, motion_.motor().position_rad());
}

/// Touch probes latch at the change, a reset input acknowledges a fault.
void DriveCore::terminal_changed(Input input, bool level, double position_rad) noexcept {
  if (terminals_.level(input) == level) return;
  complete_publication();
  disturb();
  const InputSignals before = terminals_.signals();
  terminals_.set(input, level);
  const InputSignals& now = terminals_.signals();
  for (std::size_t i = 0; i < now.probe.size(); ++i) {
    if (now.probe[i] == before.probe[i]) continue;
    probe_.edge(i, now.probe[i], shown_position(motion_.motor().encoder_count(position_rad)));
  }
  if ((input == Input::kEnpo && level) || (now.fault_reset && !before.fault_reset)) acknowledge();
}

void DriveCore::set_machine_input(MachineInput input, double value) noexcept {
  const bool on = value >= 0.5;
  complete_publication();
  switch (input) {
    case MachineInput::kDcLink:
      return set_dc_link_voltage(value);
    case MachineInput::kMains:
      return protection_.dc_link().set_mains(on);
    case MachineInput::kBrakeResistor:
      return protection_.dc_link().set_brake_resistor(on);
    case MachineInput::kMotorShort:
      return motion_.motor().set_short_circuit(on);
    case MachineInput::kEncoderCable:
      return motion_.motor().set_encoder_connected(on);
    case MachineInput::kAxisBlocked:
      return motion_.motor().set_blocked(on);
    case MachineInput::kLoad:
      return motion_.motor().set_load(value);
    case MachineInput::kAmbient:
      return protection_.thermal().set_ambient(value);
    case MachineInput::kButtons:
      if (on) press_buttons();
      return;
    case MachineInput::kPositionError:
      return actual_values_.set_position_error(value);
    case MachineInput::kPositionHeld:
      return actual_values_.hold_position(on);
    case MachineInput::kRam:
      return set_cause(Fault::kInternalRam, !on);
  }
}

double DriveCore::machine_input_value(MachineInput input) const noexcept {
  const ServoMotor& motor = motion_.motor();
  const auto level = [](bool on) { return on ? 1.0 : 0.0; };
  switch (input) {
    case MachineInput::kDcLink:
      return protection_.dc_link().volts();
    case MachineInput::kMains:
      return level(protection_.dc_link().mains());
    case MachineInput::kBrakeResistor:
      return level(protection_.dc_link().brake_resistor());
    case MachineInput::kMotorShort:
      return level(motor.short_circuit());
    case MachineInput::kEncoderCable:
      return level(motor.encoder_connected());
    case MachineInput::kAxisBlocked:
      return level(motor.mechanics().blocked());
    case MachineInput::kLoad:
      return motor.mechanics().load_nm();
    case MachineInput::kAmbient:
      return protection_.thermal().ambient_c();
    case MachineInput::kPositionError:
      return static_cast<double>(actual_values_.position_error());
    case MachineInput::kPositionHeld:
      return level(actual_values_.position_held());
    case MachineInput::kRam:
      return level(!causes_.test(static_cast<std::size_t>(Fault::kInternalRam)));
    case MachineInput::kButtons:
      break;
  }
  return 0.0;
}

}  // namespace driveline::slaves::msd
