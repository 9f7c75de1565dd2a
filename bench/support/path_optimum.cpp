#include "support/path_optimum.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

// The motion along a stretch without stops is t -> u -> s. u is a parameter of the path, and s(u) is given: the length
// of the path, but near a stop s is cubic in u, as it is in time at constant jerk. The unknown is W(u) = (du/dt)^2, a
// quadratic spline with continuous first derivative. With the derivatives q', q'', q''' of the position of an axis by
// u,
//   velocity      q' sqrt(W)
//   acceleration  q' W'/2 + q'' W
//   jerk          sqrt(W) (q' W''/2 + 3/2 q'' W' + q''' W)
//   duration      integral of du / sqrt(W).
// An interior-point method minimises the duration: Newton's method on the duration plus the logarithms of the remaining
// part of every limit, whose weight decreases. Only the jerk is not convex in W; its second derivative is omitted
// (Gauss-Newton), which changes the steps to the optimum but not its position.

namespace driveline::bench {
namespace {

using trajectory::ContourSettings;
using trajectory::GroupVector;
using trajectory::PathGeometry;
using trajectory::ShapedPiece;

constexpr std::size_t kCoefficients = 3;  ///< coefficients of the spline on an interval
using Coefficients = std::array<double, kCoefficients>;

/// The pieces of a stretch between two stops.
using Pieces = std::span<const ShapedPiece>;

/// s and its derivatives by u.
struct Place {
  double s, first, second, third;
};

/// The function s(u): cubic, in two halves, until it has covered `kNearStop` at either end.
class Parameter {
 public:
  explicit Parameter(double length) : length_(length), near_(std::min(kNearStop, 0.5 * length)) {}

  [[nodiscard]] double near() const { return near_; }
  [[nodiscard]] double end() const { return length_ + 2.0 * near_; }
  /// The parameter u of a position that is not near a stop.
  [[nodiscard]] double of(double s) const { return s + near_; }
  /// `middle`: of the interval in question, because third derivatives jump at its ends.
  [[nodiscard]] Place at(double u, double middle) const {
    if (middle > 0.5 * end()) {
      const auto back = rise(end() - u, end() - middle);
      return {length_ - back.s, back.first, -back.second, back.third};
    }
    return rise(u, middle);
  }

 private:
  static constexpr double kNearStop = 1e-3;

  [[nodiscard]] Place rise(double u, double middle) const {
    const double rate = 1.0 / (near_ * near_);
    if (middle < near_) return {rate * u * u * u / 6.0, rate * u * u / 2.0, rate * u, rate};
    if (middle < 2.0 * near_) {
      const double left = 2.0 * near_ - u;
      return {u - near_ + rate * left * left * left / 6.0, 1.0 - rate * left * left / 2.0, rate * left, -rate};
    }
    return {u - near_, 1.0, 0.0, 0.0};
  }

  double length_;
  double near_;
};

/// Geometry and spline values at a point of the path, by u.
struct Point {
  std::size_t interval = 0;
  double weight = 0.0;  ///< weight in the integral
  Coefficients value{}, slope{}, bend{};
  GroupVector first{}, second{}, third{};
};

struct Problem {
  std::size_t axes = 0;
  std::size_t unknowns = 0;
  std::vector<Point> points;
};

/// Ends of the intervals: dense where the path is curved or near a stop, wider with the distance from there.
std::vector<double> knots_of(Pieces pieces, const Parameter& parameter, double length, int fineness) {
  constexpr int kNearStop = 16;
  constexpr double kFinest = 1e-4;
  constexpr double kCoarsest = 2e-3;
  constexpr double kGrowth = 0.08;
  std::vector<std::pair<double, double>> bent{{0.0, 0.0}, {length, length}};
  double begin = 0.0;
  for (const auto& [piece, feed, move, stops, events] : pieces) {
    if (!piece.is_line()) bent.emplace_back(begin, begin + piece.length());
    begin += piece.length();
  }
  const double near = parameter.near();
  std::vector<double> knots{0.0};
  const auto divide = [&](double until, double count) {
    const double from = knots.back();
    const int parts = fineness * std::max(1, static_cast<int>(std::ceil(count)));
    for (int k = 1; k <= parts; ++k) knots.push_back(k == parts ? until : from + (until - from) * k / parts);
  };
  divide(near, kNearStop);
  divide(2.0 * near, kNearStop);
  begin = 0.0;
  for (const auto& shaped : pieces) {
    const double end = begin + shaped.piece.length();
    const double low = std::max(begin, near);
    const double high = std::min(end, length - near);
    if (high > low + 1e-12) {
      if (!shaped.piece.is_line()) {
        constexpr double kOnBend = 24.0;
        divide(parameter.of(high), std::max(kOnBend, (high - low) / (0.5 * kCoarsest)));
      } else {
        for (double s = low; s < high;) {
          double distance = length;
          for (const auto& [from, to] : bent) distance = std::min(distance, std::max({0.0, from - s, s - to}));
          const double ahead = high - s;
          // Towards the end of the line the intervals become shorter again.
          const double step = std::clamp(kGrowth * std::min(distance, 0.93 * ahead), kFinest, kCoarsest);
          s = step * 1.5 > ahead ? high : s + step;
          divide(parameter.of(s), 1.0);
        }
      }
    }
    begin = end;
  }
  divide(parameter.end() - near, kNearStop);
  divide(parameter.end(), kNearStop);
  return knots;
}

/// The three splines that are not zero on an interval, and their derivatives.
void evaluate_splines(const std::vector<double>& knots, std::size_t k, double u, Point& point) {
  const double begin = knots[k];
  const double end = knots[k + 1];
  const double before = k > 0 ? knots[k - 1] : begin;
  const double behind = k + 2 < knots.size() ? knots[k + 2] : end;
  const double low = 1.0 / ((end - before) * (end - begin));
  const double high = 1.0 / ((behind - begin) * (end - begin));
  const double left = end - u;
  const double gone = u - begin;
  point.value = {left * left * low, 0.0, gone * gone * high};
  point.slope = {-2.0 * left * low, 0.0, 2.0 * gone * high};
  point.bend = {2.0 * low, 0.0, 2.0 * high};
  point.value[1] = 1.0 - point.value[0] - point.value[2];
  point.slope[1] = -point.slope[0] - point.slope[2];
  point.bend[1] = -point.bend[0] - point.bend[2];
}

/// `weights`: of equidistant points on an interval, including both ends.
Problem problem_of(Pieces pieces, std::size_t axes, int fineness, std::span<const double> weights) {
  double length = 0.0;
  for (const auto& shaped : pieces) length += shaped.piece.length();
  const Parameter parameter(length);
  const auto knots = knots_of(pieces, parameter, length, fineness);
  Problem problem{axes, knots.size() + 1, {}};
  std::size_t index = 0;
  double begin = 0.0;
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double width = knots[k + 1] - knots[k];
    const double middle = knots[k] + 0.5 * width;
    while (index + 1 < pieces.size() && parameter.at(middle, middle).s > begin + pieces[index].piece.length()) {
      begin += pieces[index++].piece.length();
    }
    for (std::size_t place = 0; place < weights.size(); ++place) {
      const double u = knots[k] + width * static_cast<double>(place) / static_cast<double>(weights.size() - 1);
      Point point;
      point.interval = k;
      point.weight = width * weights[place];
      evaluate_splines(knots, k, u, point);
      const auto [s, first, second, third] = parameter.at(u, middle);
      const auto there = pieces[index].piece.at(std::clamp(s - begin, 0.0, pieces[index].piece.length()));
      for (std::size_t i = 0; i < axes; ++i) {
        point.first[i] = there.first[i] * first;
        point.second[i] = there.second[i] * first * first + there.first[i] * second;
        point.third[i] =
            there.third[i] * first * first * first + 3.0 * there.second[i] * first * second + there.first[i] * third;
      }
      problem.points.push_back(point);
    }
  }
  return problem;
}

double product(const Coefficients& row, const double* unknowns) {
  return row[0] * unknowns[0] + row[1] * unknowns[1] + row[2] * unknowns[2];
}

/// The used share of a limit, and its gradient by the coefficients.
struct Use {
  double value;
  Coefficients gradient;
};

/// Calls `take` with each used share at a point: squares of velocities (without sign), accelerations and jerks.
template <typename Take>
void for_each_use(const Point& point, const double* x, const ContourSettings& settings, const Take& take) {
  const double value = product(point.value, x);
  const double slope = product(point.slope, x);
  const double bend = product(point.bend, x);
  const double root = std::sqrt(value);
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& limits = settings.limits[i];
    const double first = point.first[i];
    const double second = point.second[i];
    const double third = point.third[i];
    const double square = first * first / (limits.max_velocity * limits.max_velocity);
    const double linear = 0.5 * first * bend + 1.5 * second * slope + third * value;
    Use velocity{square * value, {}};
    Use acceleration{(0.5 * first * slope + second * value) / limits.max_acceleration, {}};
    Use jerk{root * linear / limits.max_jerk, {}};
    for (std::size_t c = 0; c < kCoefficients; ++c) {
      velocity.gradient[c] = square * point.value[c];
      acceleration.gradient[c] = (0.5 * first * point.slope[c] + second * point.value[c]) / limits.max_acceleration;
      jerk.gradient[c] =
          (root * (0.5 * first * point.bend[c] + 1.5 * second * point.slope[c] + third * point.value[c]) +
           0.5 * linear / root * point.value[c]) /
          limits.max_jerk;
    }
    take(velocity, 1.0);
    take(acceleration, 2.0);
    take(jerk, 3.0);
  }
}

/// A symmetric matrix with two diagonals on either side of the main one, and a right-hand side.
struct Banded {
  explicit Banded(std::size_t n) : rows(n), right(n, 0.0) {}

  std::vector<Coefficients> rows;  ///< the diagonal and the two after it
  std::vector<double> right;

  /// Solves by L D L^T, which destroys the matrix. The solution is in `right`.
  void solve() {
    const std::size_t n = rows.size();
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t below = 1; below < kCoefficients && k + below < n; ++below) {
        const double factor = rows[k][below] / rows[k][0];
        for (std::size_t c = below; c < kCoefficients; ++c) rows[k + below][c - below] -= factor * rows[k][c];
        right[k + below] -= factor * right[k];
      }
    }
    for (std::size_t k = n; k-- > 0;) {
      for (std::size_t c = 1; c < kCoefficients && k + c < n; ++c) right[k] -= rows[k][c] * right[k + c];
      right[k] /= rows[k][0];
    }
  }
};

/// Duration and barrier; infinite if a limit is exceeded.
double cost_of(const Problem& problem, const std::vector<double>& x, const ContourSettings& settings, double weight) {
  double total = 0.0;
  for (const auto& point : problem.points) {
    const double* const there = &x[point.interval];
    const double value = product(point.value, there);
    if (!(value > 0.0)) return HUGE_VAL;
    total += weight * point.weight / std::sqrt(value);
    double left = 1.0;
    for_each_use(point, there, settings, [&](const Use& use, double) {
      left = std::abs(use.value) < 1.0 ? left * (1.0 - use.value * use.value) : -HUGE_VAL;
    });
    if (!(left > 0.0)) return HUGE_VAL;
    total -= std::log(left);
  }
  return total;
}

/// One Newton step; false: no further improvement.
bool improve(const Problem& problem, std::vector<double>& x, const ContourSettings& settings, double weight,
             double& cost) {
  Banded system(problem.unknowns);
  for (const auto& point : problem.points) {
    const double* const there = &x[point.interval];
    const double value = product(point.value, there);
    const double root = std::sqrt(value);
    const auto add = [&](const Coefficients& gradient, double first, double second) {
      for (std::size_t c = 0; c < kCoefficients; ++c) {
        system.right[point.interval + c] -= first * gradient[c];
        for (std::size_t d = c; d < kCoefficients; ++d) {
          system.rows[point.interval + c][d - c] += second * gradient[c] * gradient[d];
        }
      }
    };
    add(point.value, -0.5 * weight * point.weight / (value * root),
        0.75 * weight * point.weight / (value * value * root));
    for_each_use(point, there, settings, [&](const Use& use, double) {
      const double left = 1.0 - use.value * use.value;
      add(use.gradient, 2.0 * use.value / left, 2.0 * (1.0 + use.value * use.value) / (left * left));
    });
  }
  const auto descent = system.right;
  system.solve();
  double decrement = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) decrement += descent[k] * system.right[k];
  constexpr double kNothing = 1e-2;
  if (!(decrement > kNothing)) return false;
  std::vector<double> tried(x.size());
  constexpr int kHalvings = 20;
  constexpr double kArmijo = 1e-3;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double share = std::ldexp(1.0, -halving);
    for (std::size_t k = 0; k < x.size(); ++k) tried[k] = x[k] + share * system.right[k];
    const double next = cost_of(problem, tried, settings, weight);
    if (!(next < cost - kArmijo * share * decrement)) continue;
    x.swap(tried);
    cost = next;
    return true;
  }
  return false;
}

/// The duration after slowing down the whole motion until every limit is kept at every point.
double duration_of(const Problem& problem, const std::vector<double>& x, const ContourSettings& settings) {
  double duration_s = 0.0;
  double slower = 0.0;
  for (const auto& point : problem.points) {
    const double* const there = &x[point.interval];
    duration_s += point.weight / std::sqrt(product(point.value, there));
    for_each_use(point, there, settings, [&](const Use& use, double degree) {
      // The first share is the square of a velocity.
      slower = std::max(slower, std::pow(std::abs(use.value), 1.0 / std::max(2.0, degree)));
    });
  }
  return duration_s * slower;
}

double achieved_on(Pieces pieces, const ContourSettings& settings, int fineness) {
  constexpr std::array<double, 3> kSimpson{1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
  const auto problem = problem_of(pieces, settings.axes, fineness, kSimpson);
  // Start so slowly that half of every limit remains.
  double most = HUGE_VAL;
  std::vector<double> x(problem.unknowns, 1.0);
  for (const auto& point : problem.points) {
    for_each_use(point, &x[point.interval], settings, [&](const Use& use, double degree) {
      constexpr double kHalf = 0.5;
      if (use.value != 0.0) most = std::min(most, std::pow(kHalf / std::abs(use.value), 2.0 / std::max(2.0, degree)));
    });
  }
  std::fill(x.begin(), x.end(), most);
  constexpr double kFirstWeight = 1e2;
  constexpr double kGrowth = 6.0;
  constexpr int kRounds = 9;
  constexpr int kMaxSteps = 25;
  double weight = kFirstWeight;
  for (int round = 0; round < kRounds; ++round, weight *= kGrowth) {
    double cost = cost_of(problem, x, settings, weight);
    for (int step = 0; step < kMaxSteps && improve(problem, x, settings, weight, cost); ++step) {
    }
  }
  constexpr std::size_t kPlaces = 17;
  std::array<double, kPlaces> trapezes{};
  trapezes.fill(1.0 / (kPlaces - 1));
  trapezes.front() *= 0.5;
  trapezes.back() *= 0.5;
  return duration_of(problem_of(pieces, settings.axes, fineness, trapezes), x, settings);
}

/// The geometry on a fine grid.
struct Grid {
  std::vector<PathGeometry> points;
  std::vector<double> steps;  ///< to the next point
};

Grid grid_of(Pieces pieces) {
  constexpr double kStep = 2e-5;
  Grid grid;
  for (const auto& shaped : pieces) {
    const double length = shaped.piece.length();
    const int count = static_cast<int>(std::clamp(length / kStep, 60.0, 20'000.0));
    for (int k = 0; k < count; ++k) {
      // Sample inside the piece, so that curvatures that jump at its ends are on the correct side.
      grid.points.push_back(shaped.piece.at(length * (k + 0.5) / count));
      grid.steps.push_back(length / count);
    }
  }
  return grid;
}

/// The range of accelerations along the path at the square of a speed; empty (low > high): the speed is too high.
std::pair<double, double> range_at(const PathGeometry& point, double speed2, const ContourSettings& settings) {
  std::pair<double, double> range{-1e12, 1e12};
  for (std::size_t i = 0; i < settings.axes; ++i) {
    const auto& limits = settings.limits[i];
    const double f = point.first[i];
    const double bend = point.second[i] * speed2;
    if (f * f * speed2 > limits.max_velocity * limits.max_velocity * (1.0 + 1e-12)) return {1.0, -1.0};
    if (std::abs(f) < 1e-12) {
      if (std::abs(bend) > limits.max_acceleration) return {1.0, -1.0};
      continue;
    }
    const double one = (limits.max_acceleration - bend) / f;
    const double other = (-limits.max_acceleration - bend) / f;
    range = {std::max(range.first, std::min(one, other)), std::min(range.second, std::max(one, other))};
  }
  return range;
}

/// Backwards: the highest speed at each point from which the rest is feasible; forwards: as fast as this allows.
double bound_on(Pieces pieces, const ContourSettings& settings) {
  constexpr int kBisections = 45;
  const auto grid = grid_of(pieces);
  const std::size_t n = grid.points.size();
  std::vector<double> most2(n + 1, 0.0);
  for (std::size_t k = n; k-- > 0;) {
    double low = 0.0;
    double high = 100.0;
    for (int round = 0; round < kBisections; ++round) {
      const double middle = 0.5 * (low + high);
      const auto [hardest, softest] = range_at(grid.points[k], middle, settings);
      const bool can = hardest <= softest && middle + 2.0 * hardest * grid.steps[k] <= most2[k + 1];
      (can ? low : high) = middle;
    }
    most2[k] = low;
  }
  double duration_s = 0.0;
  double speed2 = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const double fastest2 = speed2 + 2.0 * range_at(grid.points[k], speed2, settings).second * grid.steps[k];
    const double next2 = std::clamp(fastest2, 0.0, most2[k + 1]);
    duration_s += 2.0 * grid.steps[k] / (std::sqrt(speed2) + std::sqrt(next2));
    speed2 = next2;
  }
  return duration_s;
}

}  // namespace

PathOptimum path_optimum(const std::vector<ShapedPiece>& pieces, const ContourSettings& settings, int fineness) {
  PathOptimum out;
  std::size_t first = 0;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (!pieces[k].stops && k + 1 < pieces.size()) continue;
    const Pieces stretch = Pieces(pieces).subspan(first, k + 1 - first);
    out.achieved_s += achieved_on(stretch, settings, fineness);
    out.bound_s += bound_on(stretch, settings);
    first = k + 1;
  }
  return out;
}

}  // namespace driveline::bench
