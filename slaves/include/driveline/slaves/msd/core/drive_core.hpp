#pragma once

#include <bitset>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/slaves/msd/core/actual_values.hpp"
#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/device_control.hpp"
#include "driveline/slaves/msd/core/display.hpp"
#include "driveline/slaves/msd/core/drive_bus.hpp"
#include "driveline/slaves/msd/core/drive_signals.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/motion.hpp"
#include "driveline/slaves/msd/core/motion_monitor.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/msd/core/parameter_store.hpp"
#include "driveline/slaves/msd/core/protection.hpp"
#include "driveline/slaves/msd/core/scripted_machine.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/msd/core/touch_probe.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/slaves/od/parameter_file.hpp"

namespace driveline::slaves::msd {

/// The Moog MSD servo drive, or one of its variants, with motor and load, as the MSD manual describes it: object
/// dictionary, CiA 402 state machine, all modes of operation, terminals, faults. It knows no bus: a front end writes
/// setpoints into the dictionary and reads actual values out of it, reports the state of its bus, and receives faults.
///
/// Belongs to one thread. Times are counted from the first call of advance().
class DriveCore final : private MachineEvents {
 public:
  /// `table` is made of drive_rows() and the rows of the bus; table and bus must outlive this. Takes stored parameters
  /// from their file, if there is one. Motor parameters are sanitized(). The drive runs from the first restart() on.
  DriveCore(const MsdParameters& parameters, const DictionaryTable& table, DriveBus& bus);
  DriveCore(const DriveCore&) = delete;  // its parts refer to one another
  DriveCore& operator=(const DriveCore&) = delete;
  ~DriveCore() override = default;

  /// \name For the front end of the bus
  /// @{

  /// Switches the drive on, or off and on again: stored parameters, state machine from the start. Not for use in the
  /// cycle.
  void restart();
  /// Runs control loops and timers up to `now`. \rtsafe
  void advance(std::chrono::nanoseconds now) noexcept;
  /// The bus has entered `state`. \rtsafe
  void enter_network_state(NetworkState state) noexcept;
  /// The bus has written the objects of its process data: control word, setpoints. \rtsafe
  void outputs_written() noexcept;
  /// Raises a fault of the bus. \rtsafe
  void raise(Fault fault) noexcept;
  /// When the present control cycle ends, on the clock of advance(); none before its first call. \rtsafe
  [[nodiscard]] std::optional<std::chrono::nanoseconds> cycle_end() const noexcept;
  /// Synchronises the control cycles with the clock of the bus: one ends at `end`. \rtsafe
  void align_cycle(std::chrono::nanoseconds end) noexcept { clock_.align(end); }

  /// Checks a value that is written over the bus. Saves parameters, because the answer depends on the result.
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw);
  /// The value has been written.
  void written(const EntryRow& row);
  /// The parameters that can be stored, as they are now: one per line.
  [[nodiscard]] std::string parameter_set() const { return write_parameters(dictionary_); }
  /// Takes a set of parameters and stores it, whole or not at all. Refused: a line that is no parameter of this drive,
  /// values that contradict each other, a file that cannot be written.
  [[nodiscard]] tl::expected<void, ParameterFileError> take_parameter_set(std::string_view text);
  /// The drive has this firmware from the next restart() on.
  void install_firmware(FirmwareVersion version) noexcept { store_.install_firmware(version); }
  /// That runs now. \rtsafe
  [[nodiscard]] FirmwareVersion firmware() const noexcept { return store_.facts().firmware; }
  /// The power section is on from Switched on (MSD manual 10.1.3, transition 3), the motor has current from Operation
  /// enabled on. \rtsafe
  [[nodiscard]] bool power_stage_on() const noexcept;
  /// The motor is under control. \rtsafe
  [[nodiscard]] bool power_on() const noexcept { return control_.power().power_on(); }
  /// Values as they are now. \rtsafe
  [[nodiscard]] ObjectDictionary& dictionary() noexcept { return dictionary_; }
  /// Values as they are now. \rtsafe
  [[nodiscard]] const ObjectDictionary& dictionary() const noexcept { return dictionary_; }
  /// @}

  /// \name The machine around the drive
  /// Terminals: any input, hardware enable ENPO, safe torque off ISDSH (true: torque permitted). Connected are, at the
  /// start, mains, ENPO and ISDSH. \rtsafe
  /// @{

  /// By name, see drive_signals.hpp.
  [[nodiscard]] DriveSignals& signals() noexcept { return signals_; }
  /// By name, read only.
  [[nodiscard]] const DriveSignals& signals() const noexcept { return signals_; }
  /// Level of a terminal from now on. \rtsafe
  void set_input(Input input, bool level) noexcept;
  /// Level of an output terminal. \rtsafe
  [[nodiscard]] bool output(Output output) const noexcept { return terminals_.output(output); }
  /// Level of an input terminal. \rtsafe
  [[nodiscard]] bool input(Input input) const noexcept { return terminals_.level(input); }
  /// Hardware enable; a rising level acknowledges a fault. \rtsafe
  void set_enpo(bool on) noexcept { set_input(Input::kEnpo, on); }
  /// Safe torque off: false takes the torque away. \rtsafe
  void set_isdsh(bool on) noexcept { set_input(Input::kIsdsh, on); }
  /// Mains on or off: the voltage of MsdParameters, or 0 V. \rtsafe
  void set_dc_link(bool present) noexcept { set_dc_link_voltage(present ? mains_volts_ : 0.0); }
  /// Volts at the power stage from now on; below P 701[12] an undervoltage. Nothing below 0, NaN is 0. \rtsafe
  void set_dc_link_voltage(double volts) noexcept { protection_.force_voltage(volts); }
  /// An input that changes at this time of the line's clock, also between control cycles: touch probes latch where the
  /// axis is then. In order of time; false when too many changes wait. \rtsafe
  bool schedule_input(Input input, bool level, std::chrono::nanoseconds at) noexcept {
    return machine_.schedule(input, level, at);
  }
  /// Sets an input from the machine that is no terminal. \rtsafe
  void set_machine_input(MachineInput input, double value) noexcept;
  /// \rtsafe
  [[nodiscard]] double machine_input_value(MachineInput input) const noexcept;
  /// Detaches this input from scripts and switches. \rtsafe
  void release_input(std::size_t input) noexcept { machine_.release(input); }
  /// Sets or removes the cause of a fault that the model does not simulate. While it is there the fault cannot be
  /// acknowledged. \rtsafe
  void set_cause(Fault fault, bool present) noexcept { causes_.set(static_cast<std::size_t>(fault), present); }
  /// Warms up motor and power stage as by this current for this time, in rated currents; for tests and scripts. \rtsafe
  void heat(double current, std::chrono::seconds time) noexcept { protection_.heat(current, time); }
  /// The two buttons under the display: acknowledges a fault (MSD manual 13.2). \rtsafe
  void press_buttons() noexcept { acknowledge(); }
  /// @}

  /// \name Truth of the model, for tests and displays
  /// @{

  /// Of the motor shaft, as it is, not as the encoder counts it. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return motion_.motor().position_rad(); }
  /// Of the motor shaft. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return motion_.motor().velocity_rad_s(); }
  /// At the motor shaft. \rtsafe
  [[nodiscard]] double torque_nm() const noexcept { return motion_.motor().torque_nm(); }
  /// Speed that the bus sends as feed-forward (60B1h), whether it is used or not. \rtsafe
  [[nodiscard]] double external_velocity_rad_s() const noexcept { return motion_.external_velocity_rad_s(); }
  /// The same of the torque (60B2h). \rtsafe
  [[nodiscard]] double external_torque_nm() const noexcept { return motion_.external_torque_nm(); }
  /// What it demands of its motor, and by what settings. \rtsafe
  [[nodiscard]] const Motion& motion() const noexcept { return motion_; }
  /// Of the CiA 402 state machine. \rtsafe
  [[nodiscard]] PowerState state() const noexcept { return control_.power().state(); }
  [[nodiscard]] std::uint16_t status() const noexcept;  ///< 6041h
  /// The fault that stands until it is acknowledged: the first one when there were several. \rtsafe
  [[nodiscard]] std::optional<Fault> fault() const noexcept { return faults_.standing(); }
  /// What the seven-segment display shows, without its flashing: "5.", "S2", "Er 14 01" (MSD manual 4.7).
  [[nodiscard]] std::string display() const;
  /// What is lit at this moment, points and flashing included.
  [[nodiscard]] DisplayFrame display_now() const noexcept;
  /// Time in control cycles since the first one. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds running_time() const noexcept { return clock_.running_time(); }
  [[nodiscard]] std::uint32_t warnings() const noexcept { return protection_.warnings(); }  ///< P 34
  /// What was wrong with the parameter file, if fault 02 05 is about it.
  [[nodiscard]] const ParameterFileError& parameter_file_error() const noexcept { return store_.error(); }
  /// As in MsdParameters; P 3 may be another by now. \rtsafe
  [[nodiscard]] const std::string& name() const noexcept { return store_.facts().name; }
  /// \rtsafe
  [[nodiscard]] Variant variant() const noexcept { return store_.facts().variant; }
  /// @}

 private:
  // MachineEvents
  void terminal_changed(Input input, bool level, double position_rad) noexcept override;
  void machine_input_changed(MachineInput input, double value) noexcept override { set_machine_input(input, value); }

  void apply_settings() noexcept;
  void step() noexcept;
  void step_control() noexcept;
  void step_outputs() noexcept;
  void control_touch_probe() noexcept;
  void monitor() noexcept;
  void monitor_protection() noexcept;
  void publish() noexcept;
  void finish_saving() noexcept;
  [[nodiscard]] bool starting() const noexcept { return start_left_.count() > 0; }
  [[nodiscard]] std::int32_t shown_position(std::int64_t increments) const noexcept;

  void watch_fault_reset() noexcept;
  void acknowledge() noexcept;
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept;
  [[nodiscard]] bool store_parameters();
  [[nodiscard]] PowerState shown_state() const noexcept;
  [[nodiscard]] DisplayContent display_content() const noexcept;

  DriveBus* bus_;
  ObjectDictionary dictionary_;
  Motion motion_;
  ParameterStore store_;
  Terminals terminals_;
  TouchProbe probe_;
  DeviceControl control_{dictionary_, terminals_, motion_};
  Protection protection_;
  MotionMonitor monitor_{dictionary_, motion_};
  FaultRecord faults_{dictionary_};
  ScriptedMachine machine_;
  DriveSignals signals_{*this};
  ActualValues actual_values_;
  Display display_;
  ControlClock clock_;
  std::bitset<static_cast<std::size_t>(Fault::kCount)> causes_;
  std::chrono::nanoseconds start_left_{0};  ///< of the self-test
  std::chrono::nanoseconds homing_time_out_;
  std::chrono::hours operating_hours_;  ///< before this run
  double mains_volts_;
  std::uint16_t last_control_word_ = 0;
  NetworkState network_state_ = NetworkState::kInitialising;
  bool settings_changed_ = true;
  bool initialise_control_ = true;  ///< the next settings bring the units of the factor group into force
};

}  // namespace driveline::slaves::msd
