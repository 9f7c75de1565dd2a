#pragma once

namespace driveline::slaves {

/// What a screw, or a gear, makes wrong.
struct ScrewParameters {
  double wave_rad = 0.0;         ///< amplitude of an error that comes again and again
  double wave_length_rad = 1.0;  ///< after which it does, turned by the shaft; above 0
  double stretch = 0.0;          ///< error per way: what the screw is too long, as by its temperature
  double backlash_rad = 0.0;     ///< that the shaft turns before the load follows the other way
};

/// A load behind a screw with pitch error and backlash: where it is, as the shaft turns. Positions of the load are in
/// rad of a shaft whose screw were exact. Its friction holds it while the shaft is in the backlash.
class Screw {
 public:
  /// The load has been moved there with rising positions.
  Screw(const ScrewParameters& parameters, double shaft_rad) noexcept;

  /// The shaft has turned to this place, without turning round on the way. \rtsafe
  void turn(double shaft_rad) noexcept;
  /// Where the load is. \rtsafe
  [[nodiscard]] double load_rad() const noexcept { return position_of(nut_rad_); }
  /// Where the load is when the shaft has come to this place with rising positions. \rtsafe
  [[nodiscard]] double position_of(double shaft_rad) const noexcept;

 private:
  ScrewParameters parameters_;
  double nut_rad_;  ///< place of the shaft that has moved it there
};

}  // namespace driveline::slaves
