#pragma once

namespace driveline::slaves {

/// The supply of a power stage. Defaults are those of a small drive (ours).
struct DcLinkParameters {
  double capacitance_f = 470e-6;      ///< of the capacitor
  double chopper_volts = 780.0;       ///< above it the brake resistor takes energy out
  double brake_resistor_ohm = 100.0;  ///< 0: there is none
  double standby_w = 20.0;            ///< power consumption of the drive itself
};

/// The DC link between mains rectifier and power stage: a capacitor that the rectifier keeps from falling below its
/// voltage, that the motor loads and charges, and that a brake resistor keeps from rising for ever.
class DcLink {
 public:
  /// With mains and brake resistor, charged to `mains_volts`.
  DcLink(const DcLinkParameters& parameters, double mains_volts) noexcept;

  /// `step_s` while the motor takes `power_w`; negative: gives back. \rtsafe
  void step(double power_w, double step_s) noexcept;
  /// The mains contactor. Ends what force() did. \rtsafe
  void set_mains(bool on) noexcept;
  /// \rtsafe
  void set_brake_resistor(bool connected) noexcept { resistor_ = connected; }
  /// A voltage from outside, 0 to 10 kV, which stays whatever the motor does; what is not finite is 0. \rtsafe
  void force(double volts) noexcept;

  /// Present voltage. \rtsafe
  [[nodiscard]] double volts() const noexcept { return volts_; }
  /// The mains are there. \rtsafe
  [[nodiscard]] bool mains() const noexcept { return mains_; }
  /// The brake resistor is connected. \rtsafe
  [[nodiscard]] bool brake_resistor() const noexcept { return resistor_; }

 private:
  DcLinkParameters parameters_;
  double mains_volts_;
  double volts_;
  bool mains_ = true;
  bool resistor_ = true;
  bool forced_ = false;
};

}  // namespace driveline::slaves
