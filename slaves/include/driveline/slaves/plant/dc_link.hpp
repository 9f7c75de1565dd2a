#pragma once

namespace driveline::slaves {

/// Supply of a power stage. The defaults fit a small drive (ours).
struct DcLinkParameters {
  double capacitance_f = 470e-6;      ///< capacitance of the DC link
  double chopper_volts = 780.0;       ///< above this voltage the brake resistor dissipates energy
  double brake_resistor_ohm = 100.0;  ///< 0: no brake resistor
  double standby_w = 20.0;            ///< power consumption of the drive itself
};

/// DC link between mains rectifier and power stage: a capacitor whose voltage the rectifier supports, which the motor
/// discharges and charges, and whose voltage a brake resistor limits.
class DcLink {
 public:
  /// Starts with mains and brake resistor connected, charged to `mains_volts`.
  DcLink(const DcLinkParameters& parameters, double mains_volts) noexcept;

  /// Runs a step of `step_s` with motor power `power_w`; negative: regenerative. \rtsafe
  void step(double power_w, double step_s) noexcept;
  /// Switches the mains contactor. Cancels force(). \rtsafe
  void set_mains(bool on) noexcept;
  /// \rtsafe
  void set_brake_resistor(bool connected) noexcept { resistor_ = connected; }
  /// Forces the voltage, 0 to 10 kV, independently of motor and mains; a value that is not finite counts as 0. \rtsafe
  void force(double volts) noexcept;

  /// Returns the present voltage. \rtsafe
  [[nodiscard]] double volts() const noexcept { return volts_; }
  /// Whether the mains are on. \rtsafe
  [[nodiscard]] bool mains() const noexcept { return mains_; }
  /// Whether the brake resistor is connected. \rtsafe
  [[nodiscard]] bool brake_resistor() const noexcept { return resistor_; }

 private:
  double volts_;
  double mains_volts_;
  DcLinkParameters parameters_;
  bool mains_ = true;
  bool resistor_ = true;
  bool forced_ = false;
};

}  // namespace driveline::slaves
