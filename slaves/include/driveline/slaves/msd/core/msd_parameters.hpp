#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "driveline/slaves/msd/core/drive_signals.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/plant/dc_link.hpp"
#include "driveline/slaves/plant/servo_controller.hpp"
#include "driveline/slaves/plant/servo_motor.hpp"
#include "driveline/slaves/plant/thermal_model.hpp"

namespace driveline::slaves::msd {

/// A switch of the machine: it drives an input terminal while the motor shaft is between two positions.
struct MachineSwitch {
  Input input = Input::kIsd00;   ///< terminal it is wired to
  double from_rad = 0.0;         ///< active from here, motor shaft
  double to_rad = 0.0;           ///< to here, both included
  bool normally_closed = false;  ///< a break contact: the input is 0 in between, 1 outside
};

/// Parameters of a single drive.
struct MsdParameters {
  Variant variant = Variant::kMsd;          ///< decides about identity, firmware and dictionary
  std::optional<FirmwareVersion> firmware;  ///< 100Ah; none: that of the variant. Decides about PDOs of odd length.
  std::string name = "X-Axis";              ///< P 3, at most 100 characters
  std::uint32_t serial_number = 1;          ///< 1018h:04
  MotorParameters motor;                    ///< rotor, load, encoder
  ControllerParameters controller;      ///< become P 320, P 321, P 351 and P 360; its limits come from 6072h and 6080h
  double initial_position_rad = 0.0;    ///< of the motor shaft at the start
  double dc_link_volts = 560.0;         ///< with mains; rectified 400 V, ours
  std::vector<MachineSwitch> switches;  ///< switches that follow the axis
  std::vector<ScriptedSignal> inputs;   ///< inputs that follow a script
  std::chrono::nanoseconds homing_time_out = std::chrono::minutes{2};  ///< ours; then homing fails
  ThermalParameters thermal;                                           ///< of motor and power stage
  DcLinkParameters dc_link;                                            ///< what the power stage is supplied from
  std::chrono::hours operating_hours{0};                               ///< before this run; emergencies carry them
  /// Where stored parameters are kept between runs; empty: nowhere. A file that cannot be used is fault 02 05 at start.
  std::string parameter_file;
  std::chrono::nanoseconds start_up_time = std::chrono::milliseconds{1};  ///< of the self-test; the real drive: seconds
  /// The same after a reset to factory settings (MSD manual 7.5.4: about 10 s).
  std::chrono::nanoseconds factory_start_up_time = std::chrono::seconds{10};
  std::uint32_t file_password = 0;  ///< that files ask for which are read or written over the bus; 0: none
  std::chrono::nanoseconds flash_time = std::chrono::milliseconds{20};  ///< until a new firmware is kept; ours
  std::chrono::nanoseconds save_time = std::chrono::milliseconds{1};    ///< until 200Bh sub 1 is 0 again

  /// `firmware`, or that of the variant. \rtsafe
  [[nodiscard]] FirmwareVersion firmware_version() const noexcept { return firmware.value_or(facts(variant).firmware); }
};

}  // namespace driveline::slaves::msd
