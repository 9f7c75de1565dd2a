#include "driveline/slaves/msd/core/protection.hpp"

#include <algorithm>
#include <numbers>

#include "driveline/slaves/msd/core/drive_settings.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr double kOvervoltageVolts = 850.0;  ///< ours
constexpr double kAmplifierMaxC = 85.0;      ///< ours
constexpr double kWarningMarginK = 5.0;      ///< ours
constexpr double kWarningShare = 0.9;        ///< share of the I2t limit that raises a warning; ours
constexpr double kVoltageMargin = 1.1;       ///< multiple of the undervoltage limit that raises a warning; ours
constexpr double kOvercurrentShare = 2.0;    ///< multiple of the current at peak torque; ours
constexpr double kMillisecondS = 1e-3;
constexpr std::uint16_t kWarningTexts = 8;  ///< P 33[1-8]

}  // namespace

Protection::Protection(ObjectDictionary& dictionary, DriveMotion& motion, const MsdParameters& parameters) noexcept
    : dictionary_(&dictionary),
      motion_(&motion),
      overcurrent_a_(kOvercurrentShare * motion.motor().rated_characteristic().max_current_a),
      text_slot_(dictionary.table().find(kMessagesIndex, 1)->slot),
      dc_link_(parameters.dc_link, parameters.dc_link_volts),
      thermal_(parameters.thermal) {
  motion_->set_dc_link_voltage(dc_link_.volts());
}

void Protection::configure() noexcept {
  dc_link_limit_volts_ = dictionary_->get(kValue.undervoltage_limit);
  limits_ = overload_limits(*dictionary_, motion_->motor().parameters().rated_current_a);
}

/// Device Help: THERM trips at 110 %; the FREQ integrator trips at 100 %.
double Protection::overload_trip_percent() const noexcept {
  return limits_.thermal ? 110.0 : 100.0;
}

bool Protection::motor_temperature_monitored() const noexcept {
  return dictionary_->get(kValue.motor_temperature_sensor) != 0;
}

bool Protection::cause_persists(Fault fault) const noexcept {
  switch (fault) {
    case Fault::kDcLinkUndervoltage:
      return !dc_link_present();
    case Fault::kDcLinkOvervoltage:
      return dc_link_.volts() > kOvervoltageVolts;
    case Fault::kMotorOverload:
      return thermal_.overload_percent() >= overload_trip_percent();
    case Fault::kMotorTemperature:
      return motor_temperature_monitored() && thermal_.motor_c() >= dictionary_->get(kValue.motor_temperature_max);
    case Fault::kAmplifierTemperature:
      return thermal_.amplifier_c() >= kAmplifierMaxC;
    case Fault::kEncoder:
      return !motion_->motor().encoder_connected();
    default:
      return false;
  }
}

bool Protection::finds_fault() const noexcept {
  return std::any_of(kFound.begin(), kFound.end(), [this](Fault fault) { return cause_persists(fault); });
}

/// A short circuit is detected as soon as the power stage drives current; without power it is not detected.
bool Protection::overcurrent() const noexcept {
  return motion_->phase_current_a(dc_link_.volts()) > overcurrent_a_;
}

void Protection::force_voltage(double volts) noexcept {
  changed_ = true;
  dc_link_.force(volts);
  motion_->set_dc_link_voltage(dc_link_.volts());
}

void Protection::heat(double current, std::chrono::seconds time) noexcept {
  changed_ = true;
  for (std::int64_t i = 0; i < time.count(); ++i) thermal_.step(current, 0.0, limits_, 1.0);
}

void Protection::step() noexcept {
  changed_ = true;
  const ServoMotor& motor = motion_->motor();
  const double frequency_hz = motor.velocity_rad_s() * motor.parameters().pole_pairs / (2.0 * std::numbers::pi);
  const double rated_a = std::numbers::sqrt2 * motor.parameters().rated_current_a;
  thermal_.step(motor.current_a() / rated_a, frequency_hz, limits_, kMillisecondS);
  dc_link_.step(motion_->power_w(), kMillisecondS);
  motion_->set_dc_link_voltage(dc_link_.volts());
  find_warnings();
}

void Protection::find_warnings() noexcept {
  const double motor_max = dictionary_->get(kValue.motor_temperature_max);
  set_warning(Warning::kOverload, thermal_.overload_percent() >= kWarningShare * overload_trip_percent());
  set_warning(Warning::kAmplifierTemperature, thermal_.amplifier_c() >= kAmplifierMaxC - kWarningMarginK);
  set_warning(Warning::kMotorTemperature,
              motor_temperature_monitored() && thermal_.motor_c() >= motor_max - kWarningMarginK);
  set_warning(Warning::kDcLinkUndervoltage,
              dc_link_present() && dc_link_.volts() < kVoltageMargin * dc_link_limit_volts_);
}

void Protection::set_warning(Warning warning, bool on) noexcept {
  const std::uint32_t bit = 1U << static_cast<unsigned>(warning);
  warnings_ = on ? warnings_ | bit : warnings_ & ~bit;
}

void Protection::publish_all() noexcept {
  dictionary_->set(kValue.overload_integrator, static_cast<float>(thermal_.overload_percent()));
  dictionary_->set(kValue.motor_temperature, static_cast<float>(thermal_.motor_c()));
  dictionary_->set(kValue.dc_link_voltage, saturate<std::uint32_t>(dc_link_.volts() * 1e3));
  dictionary_->set(kValue.dc_link_volts, static_cast<float>(dc_link_.volts()));
  if (warnings_ == shown_warnings_) return;
  shown_warnings_ = warnings_;
  dictionary_->set(kValue.warnings, warnings_);
  std::uint16_t slot = text_slot_;
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((warnings_ >> bit & 1U) != 0) dictionary_->text(slot++) = text(static_cast<Warning>(bit));
  }
  for (; slot < text_slot_ + kWarningTexts; ++slot) dictionary_->text(slot).clear();
}

}  // namespace driveline::slaves::msd
