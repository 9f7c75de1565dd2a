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

/// A switch of the machine: it sets an input terminal while the motor shaft is between two positions.
struct MachineSwitch {
  Input input = Input::kIsd00;   ///< terminal that it is connected to
  double from_rad = 0.0;         ///< start of the active range, motor shaft position
  double to_rad = 0.0;           ///< end of the active range; both are included
  bool normally_closed = false;  ///< break contact: the input is 0 within the range, 1 outside
};

/// Parameters of an individual drive.
struct MsdParameters {
  Variant variant = Variant::kMsd;          ///< determines identity, firmware and dictionary
  std::optional<FirmwareVersion> firmware;  ///< 100Ah; empty: of the variant. Affects PDOs of odd length.
  std::string name = "X-Axis";              ///< P 3, at most 100 characters
  std::uint32_t serial_number = 1;          ///< 1018h:04
  MotorParameters motor;                    ///< rotor, load, encoder
  ControllerParameters controller;          ///< set P 320, P 321, P 351 and P 360; the limits come from 6072h and 6080h
  double initial_position_rad = 0.0;        ///< initial position of the motor shaft
  double dc_link_volts = 560.0;             ///< DC link voltage with mains; rectified 400 V, ours
  std::vector<MachineSwitch> switches;      ///< switches that follow the axis
  std::vector<ScriptedSignal> inputs;       ///< inputs that follow a script
  std::chrono::nanoseconds homing_time_out = std::chrono::minutes{2};  ///< homing fails after this time; ours
  ThermalParameters thermal;                                           ///< thermal model of motor and power stage
  DcLinkParameters dc_link;                                            ///< supply of the power stage
  std::chrono::hours operating_hours{0};                               ///< before this run; sent in emergencies
  /// File that stores the parameters between runs; empty: none. An unusable file causes fault 02 05 at the start.
  std::string parameter_file;
  std::chrono::nanoseconds start_up_time = std::chrono::milliseconds{1};  ///< self-test; the real drive: seconds
  /// Duration of the self-test after a reset to factory settings (MSD manual 7.5.4: about 10 s).
  std::chrono::nanoseconds factory_start_up_time = std::chrono::seconds{10};
  std::uint32_t file_password = 0;  ///< password for reading and writing files over the bus; 0: none
  std::chrono::nanoseconds flash_time = std::chrono::milliseconds{20};  ///< until a new firmware is stored; ours
  std::chrono::nanoseconds save_time = std::chrono::milliseconds{1};    ///< until 200Bh sub 1 is 0 again

  /// Returns `firmware`, or the default of the variant. \rtsafe
  [[nodiscard]] FirmwareVersion firmware_version() const noexcept { return firmware.value_or(facts(variant).firmware); }
};

}  // namespace driveline::slaves::msd
