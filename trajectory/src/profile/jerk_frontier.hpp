#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "boundary.hpp"

namespace driveline::trajectory {

/// The motions with limited jerk that get farthest in a given time. See trajectory/README.md, "How profiles are found".
/// One of them: the jerk is +1, 0, -1, 0 (at the largest velocity), -1, 0, +1.
struct JerkShape {
  double peak;         ///< acceleration at the end of the first phase
  double peak_hold_s;  ///< how long it is held
  double cruise_s;     ///< how long the largest velocity is held
  double trough;       ///< acceleration before the last phase
  double trough_hold_s;
};

/// The motions of a range of durations without a gap, in the order of their durations.
class JerkStretch {
 public:
  enum class Begin : std::uint8_t {
    kPeak,    ///< the first motion rises to a peak and falls to the acceleration of the end
    kTrough,  ///< the first motion falls to a trough and rises to the acceleration of the end
  };
  enum class Extent : std::uint8_t {
    kShort,  ///< accelerations of both ends have the same sign, and none on the way has the other
    kMain,   ///< without an end
  };

  JerkStretch(const Boundary& boundary, Begin begin, Extent extent) noexcept;

  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }
  [[nodiscard]] double longest_s() const noexcept;
  /// Where the shortest motion gets.
  [[nodiscard]] double shortest_way() const noexcept { return shortest_way_; }

  /// One of the farthest motions.
  struct Point {
    double duration_s;
    std::size_t piece;
    double parameter;
  };

  [[nodiscard]] Point shortest() const noexcept { return {shortest_s_, 0, pieces_[0].from}; }
  /// The first one, not shorter than `from_s`, from which on they get at least to `displacement` (`reached`) or no
  /// longer get there (not `reached`). None: not in this stretch.
  [[nodiscard]] std::optional<Point> next(double displacement, double from_s, bool reached) const noexcept;
  /// That of a duration within the stretch.
  [[nodiscard]] Point at(double duration_s) const noexcept;
  [[nodiscard]] double displacement(const Point& point) const noexcept { return displacement_of(canonical(point)); }
  [[nodiscard]] PhaseList phases(const Point& point) const noexcept;

 private:
  // What changes from one motion to the next, and so what the parameter of a piece is.
  enum class Kind : std::uint8_t {
    kFree,    // peak - trough
    kPeak,    // largest acceleration - trough, the peak is held
    kTrough,  // peak + largest deceleration, the trough is held
    kBoth,    // time at the peak, peak and trough are held
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
  double base_s_;            // duration less twice the swing of the acceleration
  double before_top_ = 0.0;  // square of the peak that leads to the largest velocity
  double behind_top_ = 0.0;  // square of the trough that leads away from it
  std::array<Piece, 6> pieces_;
  std::size_t count_ = 0;
  double shortest_s_ = 0.0;
  double shortest_way_ = 0.0;
};

/// All motions that get farthest: one stretch of durations, or two with a gap between them.
class JerkFrontier {
 public:
  using Stretch = JerkStretch;
  static constexpr bool kJumps = false;  ///< the acceleration

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
