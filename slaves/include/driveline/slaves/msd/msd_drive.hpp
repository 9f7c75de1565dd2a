#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/device.hpp"
#include "driveline/slaves/mailbox/coe_server.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/drive_signals.hpp"
#include "driveline/slaves/msd/faults.hpp"
#include "driveline/slaves/msd/indicators.hpp"
#include "driveline/slaves/msd/mode_control.hpp"
#include "driveline/slaves/msd/motion.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/slaves/msd/setpoint_rhythm.hpp"
#include "driveline/slaves/msd/terminals.hpp"
#include "driveline/slaves/msd/touch_probe.hpp"
#include "driveline/slaves/od/parameter_file.hpp"
#include "driveline/slaves/od/pdo_map.hpp"
#include "driveline/slaves/plant/dc_link.hpp"
#include "driveline/slaves/plant/thermal_model.hpp"

namespace driveline::slaves::msd {

/// A switch of the machine: it drives an input terminal while the motor shaft is between two positions.
struct MachineSwitch {
  Input input = Input::kIsd00;   ///< terminal it is wired to
  double from_rad = 0.0;         ///< active from here, motor shaft
  double to_rad = 0.0;           ///< to here, both included
  bool normally_closed = false;  ///< a break contact: the input is 0 in between, 1 outside
};

/// What tells one drive from another.
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
  std::chrono::nanoseconds save_time = std::chrono::milliseconds{1};  ///< until 200Bh sub 1 is 0 again
};

/// The Moog MSD servo drive, or one of its variants, with motor and load behind an EtherCAT slave controller: all its
/// modes of operation, object dictionary, CoE, CiA 402 state machine, terminals, faults and fall-back as in the MSD
/// manual.
///
/// Belongs to the thread that drives the line. Times are counted from the first call of advance().
class MsdDrive final : public Device, public DeviceSignals, private DictionaryOwner {
 public:
  /// Takes stored parameters from their file, if there is one, and starts as restart() does, with mains on, ENPO
  /// and ISDSH connected and the other terminals low. Motor parameters are sanitized().
  explicit MsdDrive(const MsdParameters& parameters = {});
  MsdDrive(const MsdDrive&) = delete;  // the CoE server refers to the dictionary in here
  MsdDrive& operator=(const MsdDrive&) = delete;
  ~MsdDrive() override = default;

  /// What ESI and SII say about every drive of this type (serial number 0).
  [[nodiscard]] static esi::DeviceDescription description(Variant variant = Variant::kMsd) {
    return device_description(variant);
  }

  // Device
  /// Identity, memory and EEPROM image of the variant.
  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override;
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override;
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override;
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override;
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override;
  void mailbox_request(std::span<const std::byte> mailbox) override { mailbox_.request(mailbox); }
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte> out) override { return mailbox_.reply(out, al_state_); }
  void advance(std::chrono::nanoseconds now) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds process_data_period() const noexcept override;
  [[nodiscard]] SyncDemand sync_demand() const noexcept override;
  void sync_event(SyncSignal signal, std::chrono::nanoseconds time) noexcept override;
  void eeprom_loaded(std::span<const std::byte> image, bool valid) noexcept override;
  void sync_margin(const SyncMargin& margin) noexcept override;
  [[nodiscard]] DeviceSignals* signals() noexcept override { return this; }

  // DeviceSignals, see drive_signals.hpp
  /// See drive_signal_count().
  [[nodiscard]] std::size_t signal_count(Way way) const noexcept override;
  /// See drive_signal_name().
  [[nodiscard]] std::string signal_name(SignalPlace place) const override;
  [[nodiscard]] tl::expected<SignalPlace, SignalNameError> find_signal(Way way, std::string_view name) const override;
  [[nodiscard]] tl::expected<void, SignalValueError> check_signal_value(std::size_t input, double value) const override;
  void set_signal(std::size_t input, double value) noexcept override;
  [[nodiscard]] double signal(SignalPlace place) const noexcept override;

  // The terminals: any input, hardware enable ENPO, safe torque off ISDSH (true: torque permitted), mains. \rtsafe
  /// Level of a terminal from now on.
  void set_input(Input input, bool level) noexcept;
  /// Level of an output terminal. \rtsafe
  [[nodiscard]] bool output(Output output) const noexcept { return terminals_.output(output); }
  /// Hardware enable; a rising level acknowledges a fault. \rtsafe
  void set_enpo(bool on) noexcept { set_input(Input::kEnpo, on); }
  /// Safe torque off: false takes the torque away. \rtsafe
  void set_isdsh(bool on) noexcept { set_input(Input::kIsdsh, on); }
  /// Mains on or off: the voltage of MsdParameters, or 0 V. \rtsafe
  void set_dc_link(bool present) noexcept { set_dc_link_voltage(present ? parameters_.dc_link_volts : 0.0); }
  /// Volts at the power stage from now on; below P 701[12] an undervoltage. Nothing below 0, NaN is 0. \rtsafe
  void set_dc_link_voltage(double volts) noexcept {
    dc_link_.force(volts);
    motion_.set_dc_link_voltage(dc_link_.volts());
  }
  /// An input that changes at this time of the line's clock, also between control cycles: touch probes latch where the
  /// axis is then. In order of time; false when too many changes wait. \rtsafe
  bool schedule_input(Input input, bool level, std::chrono::nanoseconds at) noexcept;
  /// The cause of a fault that the model does not have by itself: comes and goes. While it is there the fault cannot be
  /// acknowledged. \rtsafe
  void set_cause(Fault fault, bool present) noexcept { causes_.set(static_cast<std::size_t>(fault), present); }
  /// Warms up motor and power stage as by this current for this time, in rated currents; for tests and scripts. \rtsafe
  void heat(double current, std::chrono::seconds time) noexcept;
  /// The two buttons under the display: acknowledges a fault (MSD manual 13.2). \rtsafe
  void press_buttons() noexcept { acknowledge(); }

  /// Switches the drive off and on again: stored parameters, state machine from the start, INIT. Not for use in the
  /// cycle.
  void restart() override;

  // Truth of the model, for tests and displays.
  /// Of the motor shaft, as it is, not as the encoder counts it. \rtsafe
  [[nodiscard]] double position_rad() const noexcept { return motion_.motor().position_rad(); }
  /// Of the motor shaft. \rtsafe
  [[nodiscard]] double velocity_rad_s() const noexcept { return motion_.motor().velocity_rad_s(); }
  /// At the motor shaft. \rtsafe
  [[nodiscard]] double torque_nm() const noexcept { return motion_.motor().torque_nm(); }
  /// Of the CiA 402 state machine. \rtsafe
  [[nodiscard]] PowerState state() const noexcept { return power_.state(); }
  [[nodiscard]] std::uint16_t status() const noexcept;  ///< 6041h
  /// The fault that stands until it is acknowledged: the first one when there were several. \rtsafe
  [[nodiscard]] std::optional<Fault> fault() const noexcept { return fault_; }
  /// What the seven-segment display shows, without its flashing: "5.", "S2", "Er 14 01" (MSD manual 4.7).
  [[nodiscard]] std::string display() const;
  /// What is lit at this moment, points and flashing included.
  [[nodiscard]] DisplayFrame display_now() const noexcept;
  /// The RUN LED is lit at this moment. \rtsafe
  [[nodiscard]] bool run_led_now() const noexcept { return run_led(al_state_, running_time()); }
  [[nodiscard]] std::uint32_t warnings() const noexcept { return warnings_; }  ///< P 34
  /// What was wrong with the parameter file, if fault 02 05 is about it.
  [[nodiscard]] const ParameterFileError& parameter_file_error() const noexcept { return parameter_file_error_; }
  /// As in MsdParameters; P 3 may be another by now. \rtsafe
  [[nodiscard]] const std::string& name() const noexcept { return parameters_.name; }
  /// \rtsafe
  [[nodiscard]] Variant variant() const noexcept { return parameters_.variant; }
  /// Values as they are now. \rtsafe
  [[nodiscard]] const ObjectDictionary& dictionary() const noexcept { return dictionary_; }
  /// For its counters. \rtsafe
  [[nodiscard]] const MailboxServer& mailbox() const noexcept { return mailbox_; }

 private:
  // DictionaryOwner
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  /// The power section is on from Switched on (MSD manual 10.1.3, transition 3), the motor has current from Operation
  /// enabled on.
  [[nodiscard]] bool power_stage_on() const noexcept override {
    return power_.power_on() || power_.state() == PowerState::kSwitchedOn;
  }

  void write_device_facts(ObjectDictionary& dictionary) const;
  [[nodiscard]] FirmwareVersion firmware() const noexcept {
    return parameters_.firmware.value_or(facts(parameters_.variant).firmware);
  }
  /// False: the parameter file could not be written, which is a fault.
  [[nodiscard]] bool store_parameters();
  void load_stored_parameters();
  void publish_warnings() noexcept;
  void publish_motor_values() noexcept;
  void build_process_data() noexcept;
  void decode_outputs(std::span<const std::byte> data) noexcept;
  void enter_al_state(wire::AlState state) noexcept;
  [[nodiscard]] bool timing_valid() const noexcept;
  [[nodiscard]] bool sync0_matches() const noexcept;
  void monitor_setpoint_cycle() noexcept;
  [[nodiscard]] std::uint32_t steps_per_setpoint() const noexcept;
  [[nodiscard]] bool remote() const noexcept;
  [[nodiscard]] bool references_from_bus() const noexcept;
  [[nodiscard]] bool power_ready() const noexcept;
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept;
  [[nodiscard]] OptionCodes option_codes() const noexcept;

  [[nodiscard]] bool parameters_consistent() const noexcept;
  [[nodiscard]] bool consistent_with(const EntryRow& row, std::uint64_t raw) const noexcept;
  [[nodiscard]] bool dc_link() const noexcept {
    return dc_link_.volts() >= dc_link_limit_volts_ && dc_link_.volts() > 0.0;
  }
  [[nodiscard]] bool starting() const noexcept { return start_left_.count() > 0; }
  [[nodiscard]] std::chrono::nanoseconds running_time() const noexcept {
    return static_cast<std::int64_t>(steps_) * kControlStep;
  }
  [[nodiscard]] PowerState shown_state() const noexcept;
  [[nodiscard]] DisplayContent display_content() const noexcept;
  [[nodiscard]] bool motor_temperature_monitored() const noexcept;
  [[nodiscard]] std::int32_t shown_position(std::int64_t increments) const noexcept;

  void apply_settings() noexcept;
  void apply_motor_data(MotionSettings& s) noexcept;
  void evaluate_switches() noexcept;
  void change_input(Input input, bool level, double position_rad) noexcept;
  void apply_scheduled_inputs() noexcept;
  void start_scripts(std::chrono::nanoseconds now) noexcept;
  void follow_scripts() noexcept;
  void change_between_steps(Input input, bool level, std::chrono::nanoseconds at) noexcept;
  void control_touch_probe() noexcept;
  void monitor_protection() noexcept;
  void monitor_current() noexcept;
  void set_machine_input(MachineInput input, double value) noexcept;
  [[nodiscard]] double machine_input_value(MachineInput input) const noexcept;
  void set_warning(Warning warning, bool on) noexcept;
  void finish_commands() noexcept;
  void apply_setpoints() noexcept;
  [[nodiscard]] Setpoints setpoints() const noexcept;
  void watch_fault_reset() noexcept;
  void acknowledge() noexcept;
  void raise(Fault fault) noexcept;
  void power_step() noexcept;
  void control_brake() noexcept;
  void follow_brake_output() noexcept;
  [[nodiscard]] bool brake_at_rest() const noexcept;
  [[nodiscard]] bool brake_settled() const noexcept;
  [[nodiscard]] bool brake_closed() const noexcept { return brake_energised_ != brake_at_rest(); }
  [[nodiscard]] ModeControl::Conditions mode_conditions() const noexcept;
  void monitor_following_error() noexcept;
  void monitor_limit_switches() noexcept;
  void publish() noexcept;
  [[nodiscard]] std::uint16_t status_word() const noexcept;

  static constexpr std::chrono::nanoseconds kNever = std::chrono::nanoseconds::max();

  MsdParameters parameters_;
  DeviceProfile profile_;
  PdoLimits pdo_limits_ = kPdoLimits;
  ObjectDictionary dictionary_;
  ObjectDictionary stored_;  ///< what survives a restart
  CoeServer coe_;
  MailboxServer mailbox_;
  PdoMap rx_map_;
  PdoMap tx_map_;
  PowerStateMachine power_;
  Motion motion_;
  ModeControl modes_{dictionary_};
  Terminals terminals_;

  std::optional<Fault> fault_;
  DcLink dc_link_;
  double overcurrent_a_ = 0.0;  ///< amplitude
  double dc_link_limit_volts_ = 0.0;
  std::bitset<static_cast<std::size_t>(Fault::kCount)> causes_;
  ThermalModel thermal_;
  OverloadLimits overload_limits_;
  TouchProbe probe_;
  std::int64_t position_error_ = 0;  ///< MachineInput::kPositionError
  struct ScheduledInput {
    Input input = Input::kIsd00;
    bool level = false;
    std::chrono::nanoseconds at{0};
  };
  std::array<ScheduledInput, 16> scheduled_{};
  std::chrono::nanoseconds script_due_ = kNever;  ///< when the next scripted input jumps
  std::chrono::nanoseconds script_start_{0};
  std::chrono::nanoseconds start_left_{0};
  std::chrono::nanoseconds save_left_{0};
  ParameterFileError parameter_file_error_;
  std::chrono::nanoseconds shown_since_{0};  ///< running time when the display last changed its content
  /// Running time when the output changed; before the first time the brake has been closed for ever.
  std::chrono::nanoseconds brake_since_ = -std::chrono::hours(24);
  SetpointRhythm rhythm_;                     ///< of the process data
  std::chrono::nanoseconds last_sync0_{0};    ///< the last pulse
  std::chrono::nanoseconds sync0_period_{0};  ///< between the last two; 0: there were none
  std::chrono::nanoseconds following_error_time_{0};
  std::optional<std::chrono::nanoseconds> next_step_;
  std::uint64_t steps_ = 0;
  // Small ones together: a line may have hundreds of drives.
  std::uint32_t scheduled_count_ = 0;
  std::uint32_t warnings_ = 0;
  std::uint32_t shown_warnings_ = 0;
  std::uint16_t fault_text_ = 0;  ///< string slots of P 33[0] and of the first warning, P 33[1]
  std::uint16_t warning_text_ = 0;
  std::uint16_t last_control_word_ = 0;
  wire::AlState al_state_ = wire::AlState::kInit;
  PowerState shown_state_ = PowerState::kNotReadyToSwitchOn;
  bool position_held_ = false;  ///< MachineInput::kPositionHeld
  bool parameter_file_good_ = true;
  bool eeprom_good_ = true;          ///< of the slave controller: can be loaded, and is that of this drive
  bool stored_are_factory_ = false;  ///< the next start takes the time of a reset to factory settings
  bool brake_open_ = false;          ///< what the brake control wants
  bool brake_energised_ = false;     ///< the output the brake hangs at
  bool settings_changed_ = true;
  bool initialise_control_ = true;  ///< the next settings bring the units of the factor group into force
  bool factory_reset_pending_ = false;
  bool following_error_ = false;
};

}  // namespace driveline::slaves::msd
