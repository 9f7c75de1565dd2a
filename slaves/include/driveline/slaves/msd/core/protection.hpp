#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/motion.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/slaves/plant/dc_link.hpp"
#include "driveline/slaves/plant/thermal_model.hpp"

namespace driveline::slaves::msd {

/// Protection of motor and power stage: DC link voltage, temperatures, I2t, overcurrent, and the warnings that precede
/// the faults. The limits are in the object dictionary.
class Protection {
 public:
  /// Dictionary and motion must outlive this. Cold, with mains.
  Protection(ObjectDictionary& dictionary, Motion& motion, const MsdParameters& parameters) noexcept;

  /// New settings in the dictionary. \rtsafe
  void configure() noexcept;
  /// One millisecond. \rtsafe
  void step() noexcept;
  /// No warnings, as at power-on. \rtsafe
  void reset() noexcept { warnings_ = 0; }
  /// P 33[1] and behind, P 34, and the values that the warnings are about. \rtsafe
  void publish() noexcept;

  /// The motor's cables have more current than the motor can take. \rtsafe
  [[nodiscard]] bool overcurrent() const noexcept;
  /// There is voltage for the power stage (P 701[12]). \rtsafe
  [[nodiscard]] bool dc_link_present() const noexcept {
    return dc_link_.volts() >= dc_link_limit_volts_ && dc_link_.volts() > 0.0;
  }
  /// Whether the cause of a fault that is detected here persists. \rtsafe
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept;
  /// P 34. \rtsafe
  [[nodiscard]] std::uint32_t warnings() const noexcept { return warnings_; }

  /// Volts at the power stage from now on, whatever the mains do. \rtsafe
  void force_voltage(double volts) noexcept;
  /// Warms up motor and power stage as by this current for this time, in rated currents. \rtsafe
  void heat(double current, std::chrono::seconds time) noexcept;
  /// Mains and brake resistor. \rtsafe
  [[nodiscard]] DcLink& dc_link() noexcept { return dc_link_; }
  /// \rtsafe
  [[nodiscard]] const DcLink& dc_link() const noexcept { return dc_link_; }
  /// The thermal model, to set the ambient temperature. \rtsafe
  [[nodiscard]] ThermalModel& thermal() noexcept { return thermal_; }
  /// \rtsafe
  [[nodiscard]] const ThermalModel& thermal() const noexcept { return thermal_; }

 private:
  void set_warning(Warning warning, bool on) noexcept;
  void find_warnings() noexcept;
  [[nodiscard]] double overload_trip_percent() const noexcept;
  [[nodiscard]] bool motor_temperature_monitored() const noexcept;

  ObjectDictionary* dictionary_;
  Motion* motion_;
  DcLink dc_link_;
  ThermalModel thermal_;
  OverloadLimits limits_;
  double dc_link_limit_volts_ = 0.0;
  double overcurrent_a_;  ///< amplitude
  std::uint32_t warnings_ = 0;
  std::uint32_t shown_warnings_ = 0;
  std::uint16_t text_slot_;  ///< of the first warning, P 33[1]
};

}  // namespace driveline::slaves::msd
