#pragma once

#include <algorithm>
#include <bitset>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "driveline/slaves/msd/core/actual_values.hpp"
#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/device_control.hpp"
#include "driveline/slaves/msd/core/display.hpp"
#include "driveline/slaves/msd/core/drive_bus.hpp"
#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/drive_signals.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
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

/// The Moog MSD servo drive, or one of its variants, with motor and load, as described by the MSD manual: object
/// dictionary, CiA 402 state machine, all modes of operation, terminals, faults. It is independent of the bus: a front
/// end writes setpoints to the dictionary and reads actual values from it, reports the state of its bus, and receives
/// faults.
///
/// Belongs to one thread. Times are relative to the first call of advance().
class DriveCore final : private MachineEvents {
 public:
  /// `table` consists of drive_rows() and the rows of the bus; table and bus must outlive this. Loads stored parameters
  /// from their file, if it exists. Motor parameters are sanitized(). The drive runs after the first restart(). With
  /// ProfileKind::kSercos the table consists of sercos_drive_rows() and the rows of the bus.
  DriveCore(const MsdParameters& parameters, const DictionaryTable& table, DriveBus& bus,
            ProfileKind profile = ProfileKind::kCia402);
  DriveCore(const DriveCore&) = delete;  // the parts refer to one another
  DriveCore& operator=(const DriveCore&) = delete;
  ~DriveCore() override = default;

  /// \name For the front end of the bus
  /// @{

  /// Switches the drive on, or off and on again: restores stored parameters and restarts the state machine. Not for use
  /// in the cycle.
  void restart();
  /// Returns the remaining time of the self-test, during which the drive is not ready; 0 after it. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds start_up_left() const noexcept {
    return std::max(start_left_, std::chrono::nanoseconds{0});
  }
  /// Restores the stored parameters with an index from `first` to `last`, while the drive continues.
  void restore_parameters(std::uint16_t first, std::uint16_t last);
  /// Runs control loops and timers up to `now`. \rtsafe
  void advance(std::chrono::nanoseconds now) noexcept;
  /// Called when the bus has entered `state`. \rtsafe
  void enter_network_state(NetworkState state) noexcept;
  /// Called when the bus has written its process data objects: control word, setpoints. \rtsafe
  void outputs_written() noexcept;
  /// Called when the bus has written process data objects of which none is a cyclic setpoint. \rtsafe
  void commands_written() noexcept;
  /// Raises a fault of the bus. \rtsafe
  [[gnu::cold]] void raise(Fault fault) noexcept;
  /// Returns the end of the current control cycle on the clock of advance(); nullopt before its first call. \rtsafe
  [[nodiscard]] std::optional<std::chrono::nanoseconds> cycle_end() const noexcept;
  /// Synchronises the control cycles with the clock of the bus: a cycle ends at `end`. \rtsafe
  void align_cycle(std::chrono::nanoseconds end) noexcept { clock_.align(end); }

  /// Checks a value written over the bus. Also saves parameters, because the answer depends on the result.
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw);
  /// Called after the value was written.
  void written(const EntryRow& row);
  /// Returns the current values of all storable parameters, one per line.
  [[nodiscard]] std::string parameter_set() const { return write_parameters(dictionary_); }
  /// Sets and stores a set of parameters, completely or not at all. Refuses lines that are not parameters of this
  /// drive, contradicting values, and a file that cannot be written.
  [[nodiscard]] tl::expected<void, ParameterFileError> take_parameter_set(std::string_view text);
  /// Installs a firmware version that becomes active at the next restart().
  void install_firmware(FirmwareVersion version) noexcept { store_.install_firmware(version); }
  /// Returns the active firmware version. \rtsafe
  [[nodiscard]] FirmwareVersion firmware() const noexcept { return store_.facts().firmware; }
  /// Whether the power section is on: from Switched on (MSD manual 10.1.3, transition 3); the motor has current only
  /// from Operation enabled on. \rtsafe
  [[nodiscard]] bool power_stage_on() const noexcept;
  /// Returns the drive profile. \rtsafe
  [[nodiscard]] DriveProfile& profile() noexcept {
    disturb();
    return control_.profile();
  }
  /// Applies new settings and units in the next process data cycle, as a start of the control does. \rtsafe
  void initialise_units() noexcept {
    disturb();
    settings_changed_ = initialise_control_ = true;
  }
  /// Whether the motor is under control. \rtsafe
  [[nodiscard]] bool power_on() const noexcept { return control_.profile().power_on(); }
  /// Returns the values of the drive. From the first call on, advance() publishes all actual values, since the caller
  /// may keep the reference. \rtsafe
  [[nodiscard]] ObjectDictionary& dictionary() noexcept {
    publish_all_from_now();
    disturb();
    return dictionary_;
  }
  /// Returns the values of the drive, read only; otherwise like the above. \rtsafe
  [[nodiscard]] const ObjectDictionary& dictionary() const noexcept {
    publish_all_from_now();
    return dictionary_;
  }
  /// Returns the values of the drive with all actual values as of the end of the last advance(). They are complete
  /// until the next one. \rtsafe
  [[nodiscard]] const ObjectDictionary& complete_values() const noexcept {
    complete_publication();
    return dictionary_;
  }
  /// Returns the values of the drive; of the actual values only the groups of send() are those of the last advance().
  /// \rtsafe
  [[nodiscard]] ObjectDictionary& process_values() noexcept { return dictionary_; }
  /// Returns the same, read only. \rtsafe
  [[nodiscard]] const ObjectDictionary& process_values() const noexcept { return dictionary_; }
  /// Selects the actual values that every advance() publishes, because the bus sends them in its cycle: the others wait
  /// until they are read. Initially every cycle publishes all. \rtsafe
  void send(ValueGroups groups) noexcept {
    complete_publication();
    sent_ = groups.with(ValueGroup::kPosition);
  }
  /// Publishes the actual values that wait; to be called before the bus reads others than those of send(). \rtsafe
  void complete_publication() const noexcept {
    if (!waiting_.empty()) publish_groups(std::exchange(waiting_, ValueGroups()));
  }
  /// @}

  /// \name The machine around the drive
  /// Terminals: all inputs, hardware enable ENPO, safe torque off ISDSH (true: torque permitted). Mains, ENPO and ISDSH
  /// are connected initially. \rtsafe
  /// @{

  /// Returns the signals by name, see drive_signals.hpp.
  [[nodiscard]] DriveSignals& signals() noexcept { return signals_; }
  /// Returns the signals by name, read only.
  [[nodiscard]] const DriveSignals& signals() const noexcept { return signals_; }
  /// Sets the level of an input terminal. \rtsafe
  void set_input(Input input, bool level) noexcept;
  /// Returns the level of an output terminal. \rtsafe
  [[nodiscard]] bool output(Output output) const noexcept { return terminals_.output(output); }
  /// Returns the level of an input terminal. \rtsafe
  [[nodiscard]] bool input(Input input) const noexcept { return terminals_.level(input); }
  /// Sets the hardware enable; a rising level acknowledges a fault. \rtsafe
  void set_enpo(bool on) noexcept { set_input(Input::kEnpo, on); }
  /// Sets safe torque off: false removes the torque. \rtsafe
  void set_isdsh(bool on) noexcept { set_input(Input::kIsdsh, on); }
  /// Switches the mains: DC link voltage of MsdParameters, or 0 V. \rtsafe
  void set_dc_link(bool present) noexcept { set_dc_link_voltage(present ? mains_volts_ : 0.0); }
  /// Forces the DC link voltage in V; below P 701[12]: undervoltage. Negative values and NaN count as 0. \rtsafe
  void set_dc_link_voltage(double volts) noexcept {
    disturb();
    protection_.force_voltage(volts);
  }
  /// Schedules a change of an input at this time of the line's clock, also between control cycles: touch probes latch
  /// the position of the axis at that time. Changes take effect in order of time; returns false when too many changes
  /// wait. \rtsafe
  bool schedule_input(Input input, bool level, std::chrono::nanoseconds at) noexcept {
    return machine_.schedule(input, level, at);
  }
  /// Sets an input from the machine that is not a terminal. \rtsafe
  void set_machine_input(MachineInput input, double value) noexcept;
  /// \rtsafe
  [[nodiscard]] double machine_input_value(MachineInput input) const noexcept;
  /// Detaches this input from its script and switches. \rtsafe
  void release_input(std::size_t input) noexcept { machine_.release(input); }
  /// Sets or removes the cause of a fault that the model does not simulate. The fault cannot be acknowledged while its
  /// cause is present. \rtsafe
  void set_cause(Fault fault, bool present) noexcept { causes_.set(static_cast<std::size_t>(fault), present); }
  /// Heats motor and power stage like this current, in rated currents, during this time; for tests and scripts. \rtsafe
  void heat(double current, std::chrono::seconds time) noexcept { protection_.heat(current, time); }
  /// Presses the two buttons below the display: acknowledges a fault (MSD manual 13.2). \rtsafe
  void press_buttons() noexcept { acknowledge(); }
  /// @}

  /// \name True state of the model, for tests and displays
  /// @{

  /// Returns the actual position of the motor shaft, not the encoder's count. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return motion_.motor().position_rad(); }
  /// Returns the velocity of the motor shaft. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return motion_.motor().velocity_rad_s(); }
  /// Returns the torque at the motor shaft. \rtsafe
  [[nodiscard]] double torque_nm() const noexcept { return motion_.motor().torque_nm(); }
  /// Returns the speed that the bus sends as feed-forward (60B1h), even if it is not used. \rtsafe
  [[nodiscard]] double external_velocity_rad_s() const noexcept { return motion_.external_velocity_rad_s(); }
  /// Returns the torque that the bus sends as feed-forward (60B2h), even if it is not used. \rtsafe
  [[nodiscard]] double external_torque_nm() const noexcept { return motion_.external_torque_nm(); }
  /// Returns the motion control, with its demands and settings. \rtsafe
  [[nodiscard]] const DriveMotion& motion() const noexcept { return motion_; }
  /// Returns the state of the drive. \rtsafe
  [[nodiscard]] PowerState state() const noexcept { return control_.profile().state(); }
  /// Returns the status as last published; CiA 402: 6041h. \rtsafe
  [[nodiscard]] std::uint16_t status() const noexcept { return control_.profile().status(); }
  /// Returns the fault that is active until it is acknowledged: the first one if there were several. \rtsafe
  [[nodiscard]] std::optional<Fault> fault() const noexcept { return faults_.standing(); }
  /// Returns the text on the seven-segment display, without its flashing: "5.", "S2", "Er 14 01" (MSD manual 4.7).
  [[nodiscard]] std::string display() const;
  /// Returns the lit segments of the display at this time, including points and flashing.
  [[nodiscard]] DisplayFrame display_now() const noexcept;
  /// Returns the duration of all control cycles since the first one. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds running_time() const noexcept { return clock_.running_time(); }
  [[nodiscard]] std::uint32_t warnings() const noexcept { return protection_.warnings(); }  ///< P 34
  /// Whether the next control cycle only moves and watches the axis, because the rest could change nothing. \rtsafe
  [[nodiscard]] bool quiet() const noexcept { return quiet_; }
  /// Returns the error in the parameter file that caused fault 02 05, if any.
  [[nodiscard]] const ParameterFileError& parameter_file_error() const noexcept { return store_.error(); }
  /// Returns the name in MsdParameters; P 3 may have changed. \rtsafe
  [[nodiscard]] const std::string& name() const noexcept { return store_.facts().name; }
  /// \rtsafe
  [[nodiscard]] Variant variant() const noexcept { return store_.facts().variant; }
  /// @}

 private:
  // MachineEvents
  void terminal_changed(Input input, bool level, double position_rad) noexcept override;
  void machine_input_changed(MachineInput input, double value) noexcept override { set_machine_input(input, value); }

  void apply_settings() noexcept;
  /// Commands that process data can change without a call of written().
  struct Commands {
    std::uint64_t profile = 0;  ///< DriveProfile::commands()
    std::uint32_t outputs = 0;
    friend bool operator==(const Commands&, const Commands&) = default;
  };

  void step() noexcept;
  void order_axis(bool process_data) noexcept;
  void move_axis() noexcept;
  [[nodiscard]] Commands commands() const noexcept;
  [[nodiscard]] bool nothing_can_change() const noexcept;
  void disturb() noexcept { quiet_ = states_shown_ = false; }
  void step_control() noexcept;
  void step_outputs() noexcept;
  void monitor() noexcept;
  void monitor_protection() noexcept;
  void publish() noexcept;
  [[gnu::cold]] void publish_states() noexcept;
  void publish_groups(ValueGroups groups) const noexcept;
  [[gnu::noinline]] void publish_terminals(ValueGroups groups) const noexcept;
  void publish_all_from_now() const noexcept {
    all_read_ = true;
    complete_publication();
  }
  void finish_saving() noexcept;
  [[nodiscard]] bool starting() const noexcept { return start_left_.count() > 0; }
  [[nodiscard]] std::int32_t shown_position(std::int64_t increments) const noexcept;

  void watch_fault_reset() noexcept;
  [[gnu::cold]] void acknowledge() noexcept;
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept;
  [[nodiscard]] bool store_parameters();
  [[nodiscard]] PowerState shown_state() const noexcept;
  [[nodiscard]] DisplayContent display_content() const noexcept;

  DriveBus* bus_;
  mutable ObjectDictionary dictionary_;  ///< const functions complete its actual values
  DriveMotion motion_;
  ParameterStore store_;
  // From the end of the machine to the terminals is what every cycle uses, so that it shares few cache lines.
  ScriptedMachine machine_;
  ActualValues actual_values_;
  ControlClock clock_;
  Commands quiet_commands_;                ///< when `quiet_` was set
  ValueGroups sent_ = ValueGroups::all();  ///< actual values that the bus sends in its cycle
  mutable ValueGroups waiting_;            ///< actual values that are not in the dictionary yet
  mutable bool all_read_ = false;          ///< all of them may be read at any time
  bool quiet_ = false;                     ///< nothing but the axis moves, see quiet()
  bool states_shown_ = false;  ///< the last publish_states() is valid, because the drive has been quiet since
  bool brake_closed_ = false;  ///< the brake holds the shaft in this control cycle
  MotionMonitor monitor_{dictionary_, motion_};
  Protection protection_;
  Terminals terminals_;
  DeviceControl control_;
  TouchProbe probe_;
  FaultRecord faults_{dictionary_};
  DriveSignals signals_{*this};
  Display display_;
  std::bitset<static_cast<std::size_t>(Fault::kCount)> causes_;
  std::chrono::nanoseconds start_left_{0};  ///< remaining time of the self-test
  std::chrono::nanoseconds homing_time_out_;
  std::chrono::hours operating_hours_;  ///< before this run of the program
  double mains_volts_;
  NetworkState network_state_ = NetworkState::kInitialising;
  bool settings_changed_ = true;
  bool initialise_control_ = true;  ///< the next apply_settings() applies the units of the factor group
};

}  // namespace driveline::slaves::msd
