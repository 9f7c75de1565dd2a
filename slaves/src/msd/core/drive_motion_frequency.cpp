// U/f operation: the profile generator determines the frequency, the characteristic the voltage.
#include <algorithm>
#include <cmath>

#include "driveline/slaves/msd/core/control_clock.hpp"
#include "driveline/slaves/msd/core/drive_motion.hpp"

namespace driveline::slaves::msd {

void DriveMotion::start_frequency_control() noexcept {
  const CurrentLoop& current = motor_.current_loop();
  const double speed = motor_.velocity_rad_s();
  const double electrical = motor_.parameters().pole_pairs * speed;
  const double rotor = motor_.electrical_angle_rad();
  const double angle =
      rotor + current.voltage_angle_rad(frequency_control_.characteristic_v(electrical), motor_.torque_nm(), speed);
  frequency_control_.start({current.d_voltage_v(), current.q_voltage_v(), rotor}, angle, electrical);
}

/// The generator determines the frequency; the rotor is not checked (MSD manual 12.2.2).
void DriveMotion::step_frequency_control(bool brake_closed) noexcept {
  generator_.step(kControlStepS);
  const double most = settings_.controller.max_velocity_rad_s;
  const double speed = std::clamp(generator_.state().velocity, -most, most);
  limited_ = std::abs(generator_.state().velocity) > most;
  const CurrentLoop& current = motor_.current_loop();
  motor_.step(frequency_control_.step(motor_.parameters().pole_pairs * speed,
                                      {current.current_a(), current.active_current_a()}),
              brake_closed);
  // The next mode continues with this torque.
  const double peak = motor_.parameters().peak_torque_nm / settings_.torque_per_demand;
  controller_.set_available_torque(-peak, peak);
  torque_demand_nm_ = controller_.step({ControllerSetpoint::Loop::kTorque, 0.0, 0.0, torque_nm()});
}

}  // namespace driveline::slaves::msd
