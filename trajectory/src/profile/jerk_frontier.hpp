#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "boundary.hpp"

namespace driveline::trajectory {

/// A motion with limited jerk that moves farthest in a given time. See trajectory/README.md, "How profiles are found".
/// The jerk is +1, 0, -1, 0 (at the largest velocity), -1, 0, +1.
struct JerkShape {
  double peak;         ///< acceleration at the end of the first phase
  double peak_hold_s;  ///< time for which the peak is held
  double cruise_s;     ///< time for which the largest velocity is held
  double trough;       ///< acceleration before the last phase
  double trough_hold_s;
};

/// The farthest motions for a range of durations without a gap, in order of duration.
class JerkStretch {
 public:
  enum class Begin : std::uint8_t {
    kPeak,    ///< the first motion rises to a peak and falls to the end acceleration
    kTrough,  ///< the first motion falls to a trough and rises to the end acceleration
  };
  enum class Extent : std::uint8_t {
    kShort,  ///< both end accelerations have the same sign, and no acceleration in between has the other
    kMain,   ///< unbounded
  };

  JerkStretch(const Boundary& boundary, Begin begin, Extent extent) noexcept;

  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }
  [[nodiscard]] double longest_s() const noexcept;
  /// Displacement of the shortest motion.
  [[nodiscard]] double shortest_way() const noexcept { return shortest_way_; }

  /// One of the farthest motions.
  struct Point {
    double duration_s;
    std::size_t piece;
    double parameter;
  };

  [[nodiscard]] Point shortest() const noexcept { return {shortest_s_, 0, pieces_[0].from}; }
  /// The first motion, not shorter than `from_s`, from which on the displacement is at least `displacement` (`reached`)
  /// or less (not `reached`). nullopt: not in this stretch.
  [[nodiscard]] std::optional<Point> next(double displacement, double from_s, bool reached) const noexcept;
  /// The motion of a duration within the stretch.
  [[nodiscard]] Point at(double duration_s) const noexcept;
  [[nodiscard]] double displacement(const Point& point) const noexcept { return displacement_of(canonical(point)); }
  [[nodiscard]] PhaseList phases(const Point& point) const noexcept;

 private:
  // The quantity that changes from one motion to the next: the parameter of a piece.
  enum class Kind : std::uint8_t {
    kFree,    // peak - trough
    kPeak,    // largest acceleration - trough; the peak is held
    kTrough,  // peak + largest deceleration; the trough is held
    kBoth,    // time at the peak; peak and trough are held
    kCruise,  // time at the largest velocity
  };
  struct Piece {
    Kind kind;
    double from;
    double to;
  };

  void add(Kind kind, double from, double to) noexcept;
  void add_short(double from, bool is_peak_held) noexcept;
  void add_main(double from, bool is_peak_held) noexcept;
  void add_rest(Kind held, double from) noexcept;
  [[nodiscard]] double duration_s(Kind kind, double parameter) const noexcept;
  [[nodiscard]] double parameter(Kind kind, double duration_s) const noexcept;
  [[nodiscard]] JerkShape shape(Kind kind, double parameter) const noexcept;
  [[nodiscard]] JerkShape canonical(const Point& point) const noexcept {
    return shape(pieces_[point.piece].kind, point.parameter);
  }
  [[nodiscard]] Point point(std::size_t piece, double parameter) const noexcept {
    return {duration_s(pieces_[piece].kind, parameter), piece, parameter};
  }
  [[nodiscard]] double displacement_of(const JerkShape& shape) const noexcept;
  [[nodiscard]] double gain(const Piece& piece, double from, double step) const noexcept;
  [[nodiscard]] double slope(const Piece& piece, double parameter) const noexcept;
  [[nodiscard]] std::array<double, 2> turns(const Piece& piece) const noexcept;
  [[nodiscard]] double solve(const Piece& piece, double from, double low, double high, double wanted) const noexcept;

  Boundary b_;
  bool is_reversed_;
  double k_;                 // peak^2 - trough^2 while neither is held
  double base_s_;            // duration minus twice the swing of the acceleration
  double before_top_ = 0.0;  // square of the peak that leads to the largest velocity
  double behind_top_ = 0.0;  // square of the trough that leads away from the largest velocity
  std::array<Piece, 6> pieces_;
  std::size_t count_ = 0;
  double shortest_s_ = 0.0;
  double shortest_way_ = 0.0;
};

/// All farthest motions: one stretch of durations, or two with a gap between them.
class JerkFrontier {
 public:
  using Stretch = JerkStretch;
  static constexpr bool kJumps = false;  ///< whether the acceleration jumps

  explicit JerkFrontier(const Boundary& boundary) noexcept;

  [[nodiscard]] bool has_short_stretch() const noexcept { return has_short_; }
  [[nodiscard]] JerkStretch short_stretch() const noexcept { return {b_, short_begin_, JerkStretch::Extent::kShort}; }
  [[nodiscard]] JerkStretch main_stretch() const noexcept { return {b_, main_begin_, JerkStretch::Extent::kMain}; }

 private:
  Boundary b_;
  bool has_short_ = false;
  JerkStretch::Begin short_begin_{};
  JerkStretch::Begin main_begin_{};
};

}  // namespace driveline::trajectory
