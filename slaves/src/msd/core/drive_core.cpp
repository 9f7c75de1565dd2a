// Start, settings, control cycles and display of the drive.
#include "driveline/slaves/msd/core/drive_core.hpp"

#include "driveline/slaves/msd/core/drive_settings.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::nanoseconds;

/// After a longer gap (supply off) the motor has come to rest.
constexpr nanoseconds kMaxCatchUp = std::chrono::seconds{10};

}  // namespace

DriveCore::DriveCore(const MsdParameters& parameters, const DictionaryTable& table, DriveBus& bus, ProfileKind profile)
    : bus_(&bus),
      dictionary_(table),
      motion_(parameters.motor, parameters.initial_position_rad),
      store_(table, parameters, motion_.motor()),
      machine_(parameters, terminals_, motion_.motor(), *this),
      protection_(dictionary_, motion_, parameters),
      control_(dictionary_, terminals_, motion_, profile),
      homing_time_out_(parameters.homing_time_out),
      operating_hours_(parameters.operating_hours),
      mains_volts_(parameters.dc_link_volts) {}

void DriveCore::restart() {
  disturb();
  store_.restore(dictionary_);
  control_.reset();
  faults_.reset();
  monitor_.reset();
  terminals_.clear_outputs();
  protection_.reset();
  probe_ = {};
  start_left_ = store_.take_start_up_time();
  display_.restart(running_time());
  initialise_control_ = true;
  apply_settings();
  control_.follow_brake(running_time());
  motion_.restart_encoder();
  motion_.select(MotionCommand::kOff, MotionSource::kNone, false);
  publish();
  if (!store_.good()) raise(Fault::kParameterList);
}

/// Changed units take effect at the next start of the control (MSD manual 10.3).
void DriveCore::apply_settings() noexcept {
  settings_changed_ = false;
  const bool initialise = std::exchange(initialise_control_, false);
  const ServoMotor& motor = motion_.motor();
  const Scaling scaling = initialise ? control_.profile().initialise_units(motor.parameters().encoder_increments)
                                     : motion_.settings().scaling;
  follow_motor_data(dictionary_);
  MotionSettings settings = motion_settings(dictionary_, motor, variant(), scaling);
  control_.profile().complete(settings);
  motion_.configure(settings);
  control_.prepare_setpoints();  // in the units that are in effect now
  terminals_.configure(dictionary_);
  protection_.configure();
}

void DriveCore::enter_network_state(NetworkState state) noexcept {
  disturb();
  network_state_ = state;
  dictionary_.set(kValue.nmt_state, static_cast<std::uint8_t>(starting() ? NetworkState::kBootUp : state));
  monitor_.restart_rhythm(clock_.cycles());
}

void DriveCore::restore_parameters(std::uint16_t first, std::uint16_t last) {
  disturb();
  store_.restore(dictionary_, first, last);
  settings_changed_ = true;
}

void DriveCore::commands_written() noexcept {
  if (quiet_ && commands() != quiet_commands_) disturb();
  watch_fault_reset();
}

void DriveCore::outputs_written() noexcept {
  commands_written();
  monitor_.setpoints_came(clock_.cycles());
  control_.apply_setpoints();
}

std::optional<nanoseconds> DriveCore::cycle_end() const noexcept {
  if (!clock_.started()) return std::nullopt;
  return clock_.cycle_end();
}

bool DriveCore::power_stage_on() const noexcept {
  return power_on() || state() == PowerState::kSwitchedOn;
}

void DriveCore::advance(nanoseconds now) noexcept {
  if (!clock_.started()) {
    clock_.start(now);
    machine_.pass_switches();
    machine_.start(now, clock_.cycle_end());
  }
  clock_.limit_backlog(now, kMaxCatchUp);
  bool stepped = false;
  for (; clock_.cycle_end() <= now; clock_.count()) {
    step();
    stepped = true;
  }
  if (stepped) publish();
}

/// Runs one control cycle. A quiet one leaves out what could change nothing, see nothing_can_change().
void DriveCore::step() noexcept {
  const bool process_data = clock_.process_data_cycle();
  if (!quiet_) {
    order_axis(process_data);
  } else if (process_data) {
    control_.watch_target();
  }
  move_axis();
  if (!quiet_) step_outputs();
  if (process_data) {
    monitor();
    finish_saving();
  }
  if (clock_.millisecond()) monitor_protection();
  if (process_data && !quiet_ && nothing_can_change()) {
    quiet_ = true;
    quiet_commands_ = commands();
  }
}

/// Evaluates commands, settings and terminals: what the axis does in this control cycle.
void DriveCore::order_axis(bool process_data) noexcept {
  if (process_data) step_control();
  if (control_.step_homing(homing_time_out_)) raise(Fault::kHoming);
  control_.profile().control(probe_);
  control_.follow_brake(running_time());
  brake_closed_ = control_.brake().closed(running_time());
}

/// Moves the axis; the events that it causes, and those of this time, may end quiet operation.
void DriveCore::move_axis() noexcept {
  motion_.step(brake_closed_);
  machine_.pass_switches();
  if (motion_.motor().passed_index()) probe_.zero_pulse(shown_position(*motion_.motor().index_pulse()));
  machine_.pass_time(clock_.cycle_end());
}

/// Whether order_axis() and step_outputs() would change nothing from the next control cycle on, until disturb(): a
/// fault, an input, a write to the dictionary, other commands in the process data, a failing DC link. They have no
/// other inputs: time acts on the brake, which rests, on stops and homing, which are not in progress, and on outputs,
/// which rest. Called after a process data cycle, which has applied all that was written before.
bool DriveCore::nothing_can_change() const noexcept {
  return control_.steady(protection_.dc_link_present(), running_time()) && terminals_.outputs_rest() &&
         control_.profile().rests(probe_);
}

DriveCore::Commands DriveCore::commands() const noexcept {
  return {control_.profile().commands(), dictionary_.get(kValue.physical_outputs)};
}

/// Runs device control after the end of the self-test.
void DriveCore::step_control() noexcept {
  if (settings_changed_) apply_settings();
  if (starting()) {
    start_left_ -= kProcessDataPeriod;
    return;
  }
  const bool dc_link = protection_.dc_link_present();
  if (power_on() && control_.enabled_by_hardware() && !dc_link) raise(Fault::kDcLinkUndervoltage);
  control_.select_mode();
  if (control_.step_state(dc_link, running_time())) {
    initialise_control_ = true;
    apply_settings();
  }
  control_.order(running_time());
  if (const auto found = control_.profile().takes_fault()) raise(*found);
}

void DriveCore::step_outputs() noexcept {
  terminals_.step_outputs({dictionary_.get(kValue.physical_outputs), dictionary_.get(kValue.output_mask),
                           control_.brake().open(), control_.profile().shows_limit(), clock_.millisecond()});
}

/// Resets commands after execution: 200Bh sub 1 becomes 0 when the data have been saved (MSD manual 7.5.3).
void DriveCore::finish_saving() noexcept {
  if (store_.finishes(kProcessDataPeriod)) dictionary_.set(kValue.save_parameters, std::uint8_t{0});
}

void DriveCore::publish() noexcept {
  if (!states_shown_) publish_states();
  const bool stopped_by_it = state() >= PowerState::kFaultReactionActive && fault() == Fault::kFollowingError;
  control_.profile().publish_motion({protection_.warnings() != 0, monitor_.following_error() || stopped_by_it},
                                    motion_);
  const ValueGroups now = all_read_ ? ValueGroups::all() : sent_;
  waiting_ = ValueGroups::all().without(now);
  publish_groups(now);
  protection_.publish();
}

/// Publishes what remains while the drive is quiet. The state of the network is published when it changes, too.
void DriveCore::publish_states() noexcept {
  states_shown_ = quiet_;
  control_.profile().publish_state(protection_.dc_link_present());
  dictionary_.set(kValue.nmt_state, static_cast<std::uint8_t>(starting() ? NetworkState::kBootUp : network_state_));
  display_.follow(shown_state(), running_time());
}

/// The values depend on motion, probe and terminals only, which change in advance() and by the machine: that completes
/// the publication first. New setpoints change none of these values before the next control cycle.
void DriveCore::publish_groups(ValueGroups groups) const noexcept {
  actual_values_.publish(groups, motion_, dictionary_);
  constexpr auto kOfTerminals = ValueGroups(ValueGroup::kTouchProbe).with(ValueGroup::kTerminals);
  if (!groups.common(kOfTerminals).empty()) publish_terminals(groups);
}

void DriveCore::publish_terminals(ValueGroups groups) const noexcept {
  if (groups.has(ValueGroup::kTouchProbe)) msd::publish(probe_, dictionary_);
  if (groups.has(ValueGroup::kTerminals)) msd::publish(terminals_, dictionary_);
}

/// Without DC link voltage the display shows "not ready" (MSD manual 4.7), although the state machine may have advanced
/// further (10.1.3).
PowerState DriveCore::shown_state() const noexcept {
  const bool unpowered = state() == PowerState::kSwitchOnDisabled && !protection_.dc_link_present();
  return unpowered ? PowerState::kNotReadyToSwitchOn : state();
}

DisplayContent DriveCore::display_content() const noexcept {
  DisplayContent content;
  content.state = shown_state();
  content.starting = starting();
  content.reset = starting() && start_left_ > store_.start_up_time() / 2;
  content.safe_torque_off = !terminals_.level(Input::kIsdsh);
  if (const auto f = fault()) content.fault = {facts(*f).number, facts(*f).location, cause_persists(*f)};
  return content;
}

DisplayFrame DriveCore::display_now() const noexcept {
  return display_.frame(display_content(), running_time());
}

std::string DriveCore::display() const {
  const auto two_digits = [](unsigned value) {
    return std::string{static_cast<char>('0' + value / 10), static_cast<char>('0' + value % 10)};
  };
  if (const auto f = fault(); f && state() == PowerState::kFault) {
    return (cause_persists(*f) ? "Er. " : "Er ") + two_digits(facts(*f).number) + " " + two_digits(facts(*f).location);
  }
  std::string text(1, static_cast<char>('0' + static_cast<int>(shown_state())));
  if (power_stage_on()) text += '.';
  return terminals_.level(Input::kIsdsh) ? text : "S" + text;
}

}  // namespace driveline::slaves::msd
