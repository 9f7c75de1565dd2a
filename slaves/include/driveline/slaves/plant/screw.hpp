#pragma once

namespace driveline::slaves {

/// Errors of a screw or gear.
struct ScrewParameters {
  double wave_rad = 0.0;         ///< amplitude of the periodic error
  double wave_length_rad = 1.0;  ///< period of this error in shaft angle; above 0
  double stretch = 0.0;          ///< error per distance: the excess length of the screw, e.g. by its temperature
  double backlash_rad = 0.0;     ///< shaft angle before the load follows a reversal
};

/// A load driven by a screw with pitch error and backlash: its position as a function of the shaft's. Load positions
/// are in rad of a shaft with an exact screw. Friction holds the load while the shaft is in the backlash.
class Screw {
 public:
  /// Starts with a load that has been moved to this position in positive direction.
  Screw(const ScrewParameters& parameters, double shaft_rad) noexcept;

  /// Turns the shaft to this position, without a reversal in between. \rtsafe
  void turn(double shaft_rad) noexcept;
  /// Returns the position of the load. \rtsafe
  [[nodiscard]] double load_rad() const noexcept { return position_of(nut_rad_); }
  /// Returns the position of the load when the shaft reaches this position in positive direction. \rtsafe
  [[nodiscard]] double position_of(double shaft_rad) const noexcept;

 private:
  ScrewParameters parameters_;
  double nut_rad_;  ///< shaft position that moved the load to its position
};

}  // namespace driveline::slaves
