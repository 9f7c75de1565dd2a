#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <utility>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/slaves/plant/dc_link.hpp"
#include "driveline/slaves/plant/thermal_model.hpp"

namespace driveline::slaves::msd {

/// Protection of motor and power stage: DC link voltage, temperatures, I2t, overcurrent, and the warnings that precede
/// the faults. The limits are in the object dictionary.
class Protection {
 public:
  /// Dictionary and motion must outlive this. Starts cold, with mains.
  Protection(ObjectDictionary& dictionary, DriveMotion& motion, const MsdParameters& parameters) noexcept;

  /// Applies new settings of the dictionary. \rtsafe
  void configure() noexcept;
  /// Runs one millisecond. \rtsafe
  void step() noexcept;
  /// Clears the warnings, as at power-on. \rtsafe
  void reset() noexcept {
    warnings_ = 0;
    changed_ = true;
  }
  /// Publishes the warning texts from P 33[1] on, P 34, and the values that the warnings refer to, if anything has
  /// changed since the last call. \rtsafe
  void publish() noexcept {
    if (std::exchange(changed_, false)) publish_all();
  }

  /// Whether the current in the motor cables exceeds the limit of the motor. \rtsafe
  [[nodiscard]] bool overcurrent() const noexcept;
  /// Whether the power stage has enough voltage (P 701[12]). \rtsafe
  [[nodiscard]] bool dc_link_present() const noexcept {
    return dc_link_.volts() >= dc_link_limit_volts_ && dc_link_.volts() > 0.0;
  }
  /// The faults that are looked for once per millisecond, in this order.
  static constexpr std::array kFound{Fault::kMotorOverload, Fault::kMotorTemperature, Fault::kAmplifierTemperature,
                                     Fault::kDcLinkOvervoltage, Fault::kEncoder};
  /// Whether the cause of at least one of them is present. \rtsafe
  [[nodiscard]] bool finds_fault() const noexcept;
  /// Whether the cause of a fault that this class detects persists. \rtsafe
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept;
  /// Returns P 34. \rtsafe
  [[nodiscard]] std::uint32_t warnings() const noexcept { return warnings_; }

  /// Forces the DC link voltage, independently of the mains. \rtsafe
  void force_voltage(double volts) noexcept;
  /// Heats motor and power stage like this current, in rated currents, during this time. \rtsafe
  void heat(double current, std::chrono::seconds time) noexcept;
  /// Returns the DC link, for mains and brake resistor. \rtsafe
  [[nodiscard]] DcLink& dc_link() noexcept {
    changed_ = true;
    return dc_link_;
  }
  /// \rtsafe
  [[nodiscard]] const DcLink& dc_link() const noexcept { return dc_link_; }
  /// Returns the thermal model, to set the ambient temperature. \rtsafe
  [[nodiscard]] ThermalModel& thermal() noexcept {
    changed_ = true;
    return thermal_;
  }
  /// \rtsafe
  [[nodiscard]] const ThermalModel& thermal() const noexcept { return thermal_; }

 private:
  void publish_all() noexcept;
  void set_warning(Warning warning, bool on) noexcept;
  void find_warnings() noexcept;
  [[nodiscard]] double overload_trip_percent() const noexcept;
  [[nodiscard]] bool motor_temperature_monitored() const noexcept;

  ObjectDictionary* dictionary_;
  DriveMotion* motion_;
  double overcurrent_a_;  ///< amplitude
  std::uint32_t warnings_ = 0;
  std::uint32_t shown_warnings_ = 0;
  bool changed_ = true;      ///< the dictionary does not have the values of publish() yet
  std::uint16_t text_slot_;  ///< text slot of the first warning, P 33[1]
  DcLink dc_link_;
  double dc_link_limit_volts_ = 0.0;
  ThermalModel thermal_;
  OverloadLimits limits_;
};

}  // namespace driveline::slaves::msd
