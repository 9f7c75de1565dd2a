#include "jerk_frontier.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace driveline::trajectory {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Newton's method ends when the next step would be within rounding: each step squares the error.
constexpr double kNewtonStep = 1e-9;
constexpr int kMaxSteps = 80;
/// Relative difference below which changes of velocity are equal.
constexpr double kSameChange = 1e-12;
/// Relative rounding error of sums of velocities.
constexpr double kLastDigits = 4e-15;

double square(double x) noexcept {
  return x * x;
}

double root(double x) noexcept {
  return x > 0.0 ? std::sqrt(x) : 0.0;
}

/// Both zeros of 3 w^2 + 4 c w + k2, as x = sqrt(w), k2 >= 0.
std::array<double, 2> turns_of_free(double c, double k2) noexcept {
  const double discriminant = 4.0 * c * c - 3.0 * k2;
  if (c >= 0.0 || discriminant <= 0.0) {
    return {kNever, kNever};
  }
  const double q = std::sqrt(discriminant) - 2.0 * c;
  return {std::sqrt(k2 / q), std::sqrt(q / 3.0)};
}

/// Both zeros of 2 y^2 - 3 limit y + m.
std::array<double, 2> turns_of_held(double limit, double m) noexcept {
  const double discriminant = 9.0 * limit * limit - 8.0 * m;
  if (discriminant <= 0.0) {
    return {kNever, kNever};
  }
  const double larger = (3.0 * limit + std::sqrt(discriminant)) / 4.0;
  return {m / (2.0 * larger), larger};
}

/// Displacement gained while one acceleration is held and the other one goes from y0 to y = y0 + step.
double gain_of_held(double limit, double m, double y0, double step) noexcept {
  const double y = y0 + step;
  const double sum = y + y0;
  const double squares = y * y + y0 * y0;
  return step / limit * (m * sum / 2.0 - limit * (squares + y * y0) + squares * sum / 2.0);
}

double slope_of_held(double limit, double m, double y) noexcept {
  return y / limit * (m + y * (2.0 * y - 3.0 * limit));
}

}  // namespace

JerkStretch::JerkStretch(const Boundary& boundary, Begin begin, Extent extent) noexcept
    : b_(begin == Begin::kPeak ? boundary : boundary.reversed()), is_reversed_(begin == Begin::kTrough) {
  k_ = b_.v1 - b_.v0 + (b_.a0 - b_.a1) * (b_.a0 + b_.a1) / 2.0;
  base_s_ = b_.a1 - b_.a0;
  // Ignore a peak that results from rounding: with small accelerations at the ends it would take long.
  const double least = std::max(b_.a0, b_.a1);
  const double squared = k_ + square(b_.a1);
  const double digits = kLastDigits * (std::abs(b_.v0) + std::abs(b_.v1) + square(b_.a0) + square(b_.a1));
  const bool is_straight = least >= 0.0 && squared <= square(least) + digits;
  const double apex = is_straight ? least : std::max(root(squared), least);
  const bool is_held = apex > b_.rise;
  double from = b_.rise - b_.a1;
  if (!is_held) {
    from = apex - b_.a1;
    k_ = from * (apex + b_.a1);
  }
  extent == Extent::kMain ? add_main(from, is_held) : add_short(from, is_held);
  const JerkShape first = shape(pieces_[0].kind, pieces_[0].from);
  shortest_s_ = duration_s(pieces_[0].kind, pieces_[0].from);
  shortest_way_ = displacement_of(first);
}

void JerkStretch::add_short(double from, bool is_peak_held) noexcept {
  if (is_peak_held) {
    const double to = k_ / (b_.rise + root(square(b_.rise) - k_));
    add(Kind::kPeak, from, to);
    from = to;
  }
  add(Kind::kFree, from, k_ / (b_.a0 + root(square(b_.a0) - k_)));
}

void JerkStretch::add(Kind kind, double from, double to) noexcept {
  pieces_[count_++] = {kind, from, std::max(from, to)};
}

void JerkStretch::add_main(double from, bool is_peak_held) noexcept {
  before_top_ = std::max(0.0, b_.top - b_.v0 + square(b_.a0) / 2.0);
  behind_top_ = std::max(0.0, b_.top - b_.v1 + square(b_.a1) / 2.0);
  if (is_peak_held) {
    if (b_.a1 <= 0.0 || k_ >= square(b_.rise)) {
      add_rest(Kind::kPeak, from);
      return;
    }
    // The trough falls from the end acceleration until the peak need not be held any more.
    const double to = k_ / (b_.rise + root(square(b_.rise) - k_));
    add(Kind::kPeak, from, to);
    from = to;
  }
  const double rise2 = square(b_.rise);
  const double fall2 = square(b_.fall);
  if (before_top_ <= rise2 && behind_top_ <= fall2) {
    add(Kind::kFree, from, std::sqrt(before_top_) + std::sqrt(behind_top_));
    add(Kind::kCruise, 0.0, kNever);
  } else if (rise2 - k_ <= fall2) {
    add(Kind::kFree, from, b_.rise + root(rise2 - k_));
    add_rest(Kind::kPeak, pieces_[count_ - 1].to);
  } else {
    add(Kind::kFree, from, b_.fall + root(fall2 + k_));
    add_rest(Kind::kTrough, pieces_[count_ - 1].to);
  }
}

void JerkStretch::add_rest(Kind held, double from) noexcept {
  const double rise2 = square(b_.rise);
  const double fall2 = square(b_.fall);
  if (held == Kind::kPeak) {
    add(held, from, b_.rise + std::min(b_.fall, std::sqrt(behind_top_)));
  } else {
    add(held, from, b_.fall + std::min(b_.rise, std::sqrt(before_top_)));
  }
  if (before_top_ > rise2 && behind_top_ > fall2) {
    add(Kind::kBoth, std::max(0.0, (k_ + fall2 - rise2) / b_.rise), (before_top_ - rise2) / b_.rise);
  }
  if (std::isfinite(b_.top)) {
    add(Kind::kCruise, 0.0, kNever);
  }
}

JerkShape JerkStretch::shape(Kind kind, double parameter) const noexcept {
  switch (kind) {
    case Kind::kFree: {
      const double peak = parameter > 0.0 ? (parameter + k_ / parameter) / 2.0 : b_.a1;
      return {peak, 0.0, 0.0, peak - parameter, 0.0};
    }
    case Kind::kPeak: {
      const double trough = b_.rise - parameter;
      return {b_.rise, std::max(0.0, (k_ + square(trough) - square(b_.rise)) / b_.rise), 0.0, trough, 0.0};
    }
    case Kind::kTrough: {
      const double peak = parameter - b_.fall;
      return {peak, 0.0, 0.0, -b_.fall, std::max(0.0, (square(peak) - square(b_.fall) - k_) / b_.fall)};
    }
    case Kind::kBoth: {
      const double fall_s = (square(b_.rise) - square(b_.fall) + b_.rise * parameter - k_) / b_.fall;
      return {b_.rise, parameter, 0.0, -b_.fall, std::max(0.0, fall_s)};
    }
    case Kind::kCruise:
      break;
  }
  const double rise2 = square(b_.rise);
  const double fall2 = square(b_.fall);
  return {std::min(b_.rise, std::sqrt(before_top_)), std::max(0.0, (before_top_ - rise2) / b_.rise), parameter,
          -std::min(b_.fall, std::sqrt(behind_top_)), std::max(0.0, (behind_top_ - fall2) / b_.fall)};
}

double JerkStretch::duration_s(Kind kind, double parameter) const noexcept {
  const JerkShape s = shape(kind, parameter);
  return base_s_ + 2.0 * (s.peak - s.trough) + s.peak_hold_s + s.cruise_s + s.trough_hold_s;
}

double JerkStretch::parameter(Kind kind, double duration_s) const noexcept {
  const double swings_s = duration_s - base_s_;
  switch (kind) {
    case Kind::kFree:
      return swings_s / 2.0;
    case Kind::kPeak:
      return root(b_.rise * swings_s - k_);
    case Kind::kTrough:
      return root(b_.fall * swings_s + k_);
    case Kind::kBoth:
      return (b_.fall * (swings_s - 2.0 * (b_.rise + b_.fall)) - square(b_.rise) + square(b_.fall) + k_) /
             (b_.rise + b_.fall);
    case Kind::kCruise:
      break;
  }
  return duration_s - this->duration_s(Kind::kCruise, 0.0);
}

double JerkStretch::longest_s() const noexcept {
  const Piece& last = pieces_[count_ - 1];
  return std::isfinite(last.to) ? duration_s(last.kind, last.to) : kNever;
}

JerkStretch::Point JerkStretch::at(double duration_s) const noexcept {
  std::size_t i = 0;
  while (i + 1 < count_ && this->duration_s(pieces_[i].kind, pieces_[i].to) < duration_s) {
    ++i;
  }
  const Piece& piece = pieces_[i];
  return {duration_s, i, std::clamp(parameter(piece.kind, duration_s), piece.from, piece.to)};
}

PhaseList JerkStretch::phases(const Point& point) const noexcept {
  JerkShape s = canonical(point);
  double a0 = b_.a0;
  double a1 = b_.a1;
  if (is_reversed_) {
    s = {-s.trough, s.trough_hold_s, s.cruise_s, -s.peak, s.peak_hold_s};
    a0 = -b_.a1;
    a1 = -b_.a0;
  }
  PhaseList list;
  list.push(s.peak - a0, a0, 1.0);
  list.push(s.peak_hold_s, s.peak, 0.0);
  if (s.cruise_s > 0.0) {
    list.push(s.peak, s.peak, -1.0);
    list.push(s.cruise_s, 0.0, 0.0);
    list.push(-s.trough, 0.0, -1.0);
  } else {
    list.push(s.peak - s.trough, s.peak, -1.0);
  }
  list.push(s.trough_hold_s, s.trough, 0.0);
  list.push(a1 - s.trough, s.trough, 1.0);
  return list;
}

double JerkStretch::displacement_of(const JerkShape& s) const noexcept {
  const double up_s = s.peak - b_.a0;
  double way = up_s * (b_.v0 + up_s * (2.0 * b_.a0 + s.peak) / 6.0);
  double velocity = b_.v0 + up_s * (b_.a0 + s.peak) / 2.0;
  way += s.peak_hold_s * (velocity + s.peak_hold_s * s.peak / 2.0);
  velocity += s.peak_hold_s * s.peak;
  if (s.cruise_s > 0.0) {
    way += s.cruise_s * b_.top;
  }
  const double down_s = s.peak - s.trough;
  way += down_s * (velocity + down_s * (2.0 * s.peak + s.trough) / 6.0);
  velocity += down_s * (s.peak + s.trough) / 2.0;
  way += s.trough_hold_s * (velocity + s.trough_hold_s * s.trough / 2.0);
  velocity += s.trough_hold_s * s.trough;
  const double back_s = b_.a1 - s.trough;
  return way + back_s * (velocity + back_s * (2.0 * s.trough + b_.a1) / 6.0);
}

double JerkStretch::slope(const Piece& piece, double x) const noexcept {
  switch (piece.kind) {
    case Kind::kFree:
      return b_.v0 + b_.v1 - (square(b_.a0) + square(b_.a1)) / 2.0 + 0.75 * x * x +
             (x > 0.0 ? square(k_ / x) / 4.0 : 0.0);
    case Kind::kPeak:
      return slope_of_held(b_.rise, square(b_.rise) + 2.0 * b_.v1 - square(b_.a1), x);
    case Kind::kTrough:
      return slope_of_held(b_.fall, square(b_.fall) + 2.0 * b_.v0 - square(b_.a0), x);
    case Kind::kBoth: {
      const double held = b_.v0 + (square(b_.rise) - square(b_.a0)) / 2.0 + b_.rise * x;
      return (1.0 + b_.rise / b_.fall) * (held + b_.rise * (b_.rise + b_.fall) / 2.0);
    }
    case Kind::kCruise:
      break;
  }
  return b_.top;
}

double JerkStretch::gain(const Piece& piece, double from, double step) const noexcept {
  switch (piece.kind) {
    case Kind::kFree: {
      const double c = b_.v0 + b_.v1 - (square(b_.a0) + square(b_.a1)) / 2.0;
      const double hyperbola = from > 0.0 ? k_ / from * (k_ / (from + step)) : 0.0;
      return step * (c + (3.0 * from * (from + step) + step * step + hyperbola) / 4.0);
    }
    case Kind::kPeak:
      return gain_of_held(b_.rise, square(b_.rise) + 2.0 * b_.v1 - square(b_.a1), from, step);
    case Kind::kTrough:
      return gain_of_held(b_.fall, square(b_.fall) + 2.0 * b_.v0 - square(b_.a0), from, step);
    case Kind::kBoth:
      return step * (slope(piece, from) + (1.0 + b_.rise / b_.fall) * b_.rise * step / 2.0);
    case Kind::kCruise:
      break;
  }
  return step * b_.top;
}

std::array<double, 2> JerkStretch::turns(const Piece& piece) const noexcept {
  switch (piece.kind) {
    case Kind::kFree:
      return turns_of_free(b_.v0 + b_.v1 - (square(b_.a0) + square(b_.a1)) / 2.0, k_ * k_);
    case Kind::kPeak:
      return turns_of_held(b_.rise, square(b_.rise) + 2.0 * b_.v1 - square(b_.a1));
    case Kind::kTrough:
      return turns_of_held(b_.fall, square(b_.fall) + 2.0 * b_.v0 - square(b_.a0));
    case Kind::kBoth:
      return {piece.from - slope(piece, piece.from) / ((1.0 + b_.rise / b_.fall) * b_.rise), kNever};
    case Kind::kCruise:
      break;
  }
  return {kNever, kNever};
}

// The gain after `from` is monotonic between `low` and `high` and takes the value `wanted` there.
double JerkStretch::solve(const Piece& piece, double from, double low, double high, double wanted) const noexcept {
  if (piece.kind == Kind::kCruise) {
    return from + wanted / b_.top;
  }
  if (piece.kind == Kind::kBoth) {
    const double s = slope(piece, from);
    const double bend = (1.0 + b_.rise / b_.fall) * b_.rise;
    const double q = root(s * s + 2.0 * bend * wanted);
    // Rising to a larger gain, or falling to a smaller one.
    if (wanted > 0.0) {
      return from + (s > 0.0 ? 2.0 * wanted / (s + q) : (q - s) / bend);
    }
    return from + 2.0 * wanted / (s - q);
  }
  const bool rises = gain(piece, from, high - from) >= wanted;
  double x = high;
  if (piece.kind == Kind::kFree && low == from && wanted > 0.0) {
    x = std::min(high, from + std::cbrt(4.0 * wanted));
  }
  for (int i = 0; i < kMaxSteps; ++i) {
    const double error = gain(piece, from, x - from) - wanted;
    (error > 0.0) == rises ? high = x : low = x;
    const double step = error / slope(piece, x);
    const double next = x - step;
    if (std::abs(step) <= kNewtonStep * x && next >= low && next <= high) {
      return next;
    }
    x = next > low && next < high ? next : low + (high - low) / 2.0;
    if (!(high - low > 0.0)) {
      break;
    }
  }
  return x;
}

std::optional<JerkStretch::Point> JerkStretch::next(double displacement, double from_s, bool reached) const noexcept {
  Point start = from_s > shortest_s_ ? at(from_s) : shortest();
  double ahead = (from_s > shortest_s_ ? this->displacement(start) : shortest_way_) - displacement;
  if ((ahead >= 0.0) == reached) {
    return start;
  }
  for (std::size_t i = start.piece; i < count_; ++i) {
    const Piece& piece = pieces_[i];
    const double begin = i == start.piece ? start.parameter : piece.from;
    const std::array<double, 2> turn = turns(piece);
    double low = begin;
    for (const double end : {turn[0], turn[1], piece.to}) {
      if (!(end > low) || end > piece.to) {
        continue;
      }
      const double gained = ahead + gain(piece, begin, end - begin);
      if ((gained >= 0.0) == reached) {
        return point(i, solve(piece, begin, low, end, -ahead));
      }
      low = end;
      if (end == piece.to) {
        ahead = gained;
      }
    }
  }
  return std::nullopt;
}

JerkFrontier::JerkFrontier(const Boundary& boundary) noexcept : b_(boundary) {
  using Begin = JerkStretch::Begin;
  const double change = b_.v1 - b_.v0;
  // Change of the velocity while the acceleration goes directly to the end acceleration.
  const double straight = std::abs(b_.a1 - b_.a0) * (b_.a1 + b_.a0) / 2.0;
  const double squares = (square(b_.a0) + square(b_.a1)) / 2.0;
  const bool both_up = b_.a0 > 0.0 && b_.a1 > 0.0;
  const bool both_down = b_.a0 < 0.0 && b_.a1 < 0.0;
  // A direct change must not become a change that passes through zero acceleration because of rounding, since that
  // takes much longer.
  const double rounding = kSameChange * (std::abs(b_.v0) + std::abs(b_.v1) + squares);
  const bool rises = change - straight >= (both_up ? -rounding : both_down ? rounding : 0.0);
  main_begin_ = rises ? Begin::kPeak : Begin::kTrough;
  if ((rises && both_up && change < squares) || (!rises && both_down && change > -squares)) {
    has_short_ = true;
    short_begin_ = main_begin_;
    main_begin_ = rises ? Begin::kTrough : Begin::kPeak;
  }
}

}  // namespace driveline::trajectory
