// Faults, warnings and their acknowledgement, monitoring, what the display shows.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::nanoseconds;

constexpr double kOvervoltageVolts = 850.0;  ///< ours
constexpr double kAmplifierMaxC = 85.0;      ///< ours
constexpr double kWarningMarginK = 5.0;      ///< ours
constexpr double kWarningShare = 0.9;        ///< of the I2t limit, ours
constexpr double kVoltageMargin = 1.1;       ///< of the undervoltage limit, ours
constexpr double kMillisecondS = 1e-3;

/// Device Help: 110 % with THERM; the FREQ integrator is full at 100 %.
double overload_trip_percent(const OverloadLimits& limits) noexcept {
  return limits.thermal ? 110.0 : 100.0;
}

}  // namespace

/// The reset acts on the edge, also when both levels lie between two evaluations.
void MsdDrive::watch_fault_reset() noexcept {
  const auto word = dictionary_.get<std::uint16_t>(kControlWord);
  const bool rising = (word & ~last_control_word_ & control_word::kFaultReset) != 0;
  last_control_word_ = word;
  if (rising && remote()) acknowledge();
}

/// The first fault stands until it is acknowledged; a later one can only make the reaction harder.
void MsdDrive::raise(Fault fault) noexcept {
  const FaultFacts& f = facts(fault);
  if (fault_) {
    if (f.coast) power_.fault(option_codes(), true);
    return;
  }
  fault_ = fault;
  const auto hours = std::clamp<std::int64_t>(
      parameters_.operating_hours.count() + running_time() / std::chrono::hours(1), 0, kMaxOperatingHours);
  coe_.raise(record_fault(dictionary_, f, static_cast<std::uint32_t>(hours)));
  dictionary_.text(fault_text_) = f.text;
  power_.fault(option_codes(), f.coast);
}

bool MsdDrive::motor_temperature_monitored() const noexcept {
  return dictionary_.get<std::uint16_t>(kMotorTemperatureSensor) != 0;
}

/// Faults whose cause can still be there when they are acknowledged.
bool MsdDrive::cause_persists(Fault fault) const noexcept {
  if (causes_.test(static_cast<std::size_t>(fault))) return true;
  switch (fault) {
    case Fault::kInvalidConfiguration:
      return !timing_valid() || !sync0_matches() || rhythm_.wrong();
    case Fault::kParameterList:
      return !parameters_consistent() || !parameter_file_good_;
    case Fault::kEepromData:
      return !eeprom_good_;
    case Fault::kDcLinkUndervoltage:
      return !dc_link();
    case Fault::kEncoder:
      return !motion_.motor().encoder_connected();
    case Fault::kDcLinkOvervoltage:
      return dc_link_.volts() > kOvervoltageVolts;
    case Fault::kMotorOverload:
      return thermal_.overload_percent() >= overload_trip_percent(overload_limits_);
    case Fault::kMotorTemperature:
      return motor_temperature_monitored() && thermal_.motor_c() >= dictionary_.get<float>(kMotorTemperatureMax);
    case Fault::kAmplifierTemperature:
      return thermal_.amplifier_c() >= kAmplifierMaxC;
    default:
      return false;
  }
}

/// Acknowledges a fault; a cause that persists raises it again at once (MSD manual 13.3).
void MsdDrive::acknowledge() noexcept {
  if (!power_.acknowledge()) return;
  const auto was = fault_;
  fault_.reset();
  coe_.raise(record_acknowledgement(dictionary_));
  dictionary_.text(fault_text_).clear();
  if (was && cause_persists(*was)) raise(*was);
}

void MsdDrive::monitor_following_error() noexcept {
  const auto window = dictionary_.get<std::uint32_t>(kFollowingErrorWindow);
  const bool outside = window != kWindowOff && std::abs(motion_.following_error()) > window;
  following_error_time_ = outside ? following_error_time_ + kProcessDataPeriod : nanoseconds{0};
  following_error_ =
      outside && following_error_time_ > std::chrono::milliseconds(dictionary_.get<std::uint16_t>(kFollowingErrorTime));
  if (following_error_) raise(Fault::kFollowingError);
}

/// A limit switch stops what moves towards it; away from it the axis is free. Homing uses the switches itself.
void MsdDrive::monitor_limit_switches() noexcept {
  const InputSignals& signals = terminals_.signals();
  if (!signals.positive_limit && !signals.negative_limit) return;
  if (motion_.command() != MotionCommand::kFollow || modes_.mode() == OperationMode::kHoming) return;
  const int direction = motion_.direction();
  if (signals.positive_limit && direction > 0) raise(Fault::kPositiveLimitSwitch);
  if (signals.negative_limit && direction < 0) raise(Fault::kNegativeLimitSwitch);
}

/// Setpoints that are interpolated over another time than the one they come in (MSD manual 7.4.2, 11.2). Modes with the
/// internal profile generator do without.
void MsdDrive::monitor_setpoint_cycle() noexcept {
  const MotionSource source = motion_.source();
  const bool cyclic = source == MotionSource::kCyclicPosition || source == MotionSource::kCyclicVelocity ||
                      source == MotionSource::kCyclicTorque;
  if (!cyclic || motion_.command() != MotionCommand::kFollow) return;
  if (rhythm_.wrong() || !timing_valid()) raise(Fault::kInvalidConfiguration);
}

void MsdDrive::set_warning(Warning warning, bool on) noexcept {
  const std::uint32_t bit = 1U << static_cast<unsigned>(warning);
  warnings_ = on ? warnings_ | bit : warnings_ & ~bit;
}

void MsdDrive::heat(double current, std::chrono::seconds time) noexcept {
  for (std::int64_t i = 0; i < time.count(); ++i) thermal_.step(current, 0.0, overload_limits_, 1.0);
}

/// A short circuit is seen as soon as the power stage drives it; without power there is nothing to see.
void MsdDrive::monitor_current() noexcept {
  if (motion_.phase_current_a(dc_link_.volts()) > overcurrent_a_) raise(Fault::kOvercurrent);
}

/// Once per millisecond: temperatures, I2t, voltages, causes from outside.
void MsdDrive::monitor_protection() noexcept {
  const auto& motor = motion_.motor();
  const double frequency_hz = motor.velocity_rad_s() * motor.parameters().pole_pairs / (2.0 * std::numbers::pi);
  const double rated_a = std::numbers::sqrt2 * motor.parameters().rated_current_a;
  thermal_.step(motor.current_a() / rated_a, frequency_hz, overload_limits_, kMillisecondS);

  dc_link_.step(motion_.power_w(), kMillisecondS);
  motion_.set_dc_link_voltage(dc_link_.volts());

  const double trip = overload_trip_percent(overload_limits_);
  const double motor_max = dictionary_.get<float>(kMotorTemperatureMax);
  set_warning(Warning::kOverload, thermal_.overload_percent() >= kWarningShare * trip);
  set_warning(Warning::kAmplifierTemperature, thermal_.amplifier_c() >= kAmplifierMaxC - kWarningMarginK);
  set_warning(Warning::kMotorTemperature,
              motor_temperature_monitored() && thermal_.motor_c() >= motor_max - kWarningMarginK);
  set_warning(Warning::kDcLinkUndervoltage, dc_link() && dc_link_.volts() < kVoltageMargin * dc_link_limit_volts_);

  for (const Fault fault : {Fault::kMotorOverload, Fault::kMotorTemperature, Fault::kAmplifierTemperature,
                            Fault::kDcLinkOvervoltage, Fault::kEncoder}) {
    if (!fault_ && cause_persists(fault)) raise(fault);
  }
  if (causes_.none()) return;
  for (std::size_t i = 0; i < causes_.size(); ++i) {
    if (causes_.test(i) && (!fault_ || facts(static_cast<Fault>(i)).coast)) raise(static_cast<Fault>(i));
  }
}

/// The display calls "not ready" what has no DC link voltage (MSD manual 4.7); the state machine is further (10.1.3).
PowerState MsdDrive::shown_state() const noexcept {
  const bool unpowered = power_.state() == PowerState::kSwitchOnDisabled && !dc_link();
  return unpowered ? PowerState::kNotReadyToSwitchOn : power_.state();
}

DisplayContent MsdDrive::display_content() const noexcept {
  DisplayContent content;
  content.state = shown_state();
  content.starting = starting();
  content.reset = starting() && start_left_ > parameters_.start_up_time / 2;
  content.safe_torque_off = !terminals_.level(Input::kIsdsh);
  if (fault_) content.fault = {facts(*fault_).number, facts(*fault_).location, cause_persists(*fault_)};
  return content;
}

DisplayFrame MsdDrive::display_now() const noexcept {
  return display_frame(display_content(), running_time() - shown_since_);
}

std::string MsdDrive::display() const {
  const auto two_digits = [](unsigned value) {
    return std::string{static_cast<char>('0' + value / 10), static_cast<char>('0' + value % 10)};
  };
  if (power_.state() == PowerState::kFault && fault_) {
    const FaultFacts& f = facts(*fault_);
    return (cause_persists(*fault_) ? "Er. " : "Er ") + two_digits(f.number) + " " + two_digits(f.location);
  }
  std::string text(1, static_cast<char>('0' + static_cast<int>(shown_state())));
  if (power_stage_on()) text += '.';
  return terminals_.level(Input::kIsdsh) ? text : "S" + text;
}

}  // namespace driveline::slaves::msd
