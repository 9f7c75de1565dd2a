#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path.hpp"

namespace driveline::trajectory::test {

/// Random numbers with a fixed seed, which is printed when a test fails (see DRIVELINE_TRACE_SEED) and can be replaced
/// by the environment variable DRIVELINE_TEST_SEED.
class Random {
 public:
  Random() : seed_(read_seed()), engine_(seed_) {}

  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  /// Evenly distributed over the magnitudes.
  double magnitude(double low, double high) { return std::exp(real(std::log(low), std::log(high))); }
  std::size_t index(std::size_t low, std::size_t high) {
    return std::uniform_int_distribution<std::size_t>(low, high)(engine_);
  }

 private:
  static std::uint64_t read_seed() {
    const char* text = std::getenv("DRIVELINE_TEST_SEED");
    return text == nullptr ? 20240607 : std::strtoull(text, nullptr, 10);
  }

  std::uint64_t seed_;
  std::mt19937_64 engine_;
};

#define DRIVELINE_TRACE_SEED(random, round) \
  SCOPED_TRACE("DRIVELINE_TEST_SEED=" + std::to_string((random).seed()) + ", round " + std::to_string(round))

/// Aborts the test unless the result is a success.
inline void require(const tl::expected<void, PathError>& result) {
  if (!result) {
    throw std::runtime_error(result.error().message());
  }
}

inline std::string axis_name(std::size_t index) {
  return std::string("a").append(std::to_string(index));
}

/// A path of rotary axes named a0, a1, ...; one row of positions per time.
inline Path make_path(std::span<const double> times_s, const std::vector<std::vector<double>>& rows) {
  PathBuilder builder;
  for (std::size_t i = 0; i < rows.front().size(); ++i) {
    require(builder.add_axis({axis_name(i), AxisKind::kRotary}));
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    require(builder.add_point(times_s[k], rows[k]));
  }
  return builder.build().value();
}

/// A path of a single axis, sampled from a function.
template <typename Function>
Path sample_path(std::span<const double> times_s, Function position) {
  std::vector<std::vector<double>> rows;
  for (const double t : times_s) {
    rows.push_back({position(t)});
  }
  return make_path(times_s, rows);
}

/// Non-uniform knots (steps from 5 to 50 ms) and positions within +-10 rad, for 1 to 9 axes.
inline Path random_path(Random& random, std::size_t min_points, std::size_t max_points) {
  const std::size_t points = random.index(min_points, max_points);
  const std::size_t axes = random.index(1, 9);
  std::vector<double> times_s;
  std::vector<std::vector<double>> rows(points, std::vector<double>(axes));
  double time_s = random.real(-5.0, 5.0);
  for (auto& row : rows) {
    times_s.push_back(time_s);
    time_s += random.real(0.005, 0.05);
    for (double& position : row) {
      position = random.real(-10.0, 10.0);
    }
  }
  return make_path(times_s, rows);
}

inline std::vector<AxisSetpoint> evaluate_all(Interpolator& interpolator, double time_s) {
  std::vector<AxisSetpoint> out(interpolator.axes().size());
  interpolator.evaluate(time_s, out);
  return out;
}

/// Evaluates the first axis.
inline AxisSetpoint evaluate_one(Interpolator& interpolator, double time_s) {
  return evaluate_all(interpolator, time_s).front();
}

inline void expect_setpoint(const AxisSetpoint& actual, const AxisSetpoint& expected) {
  EXPECT_EQ(actual.position, expected.position);
  EXPECT_EQ(actual.velocity, expected.velocity);
  EXPECT_EQ(actual.acceleration, expected.acceleration);
}

}  // namespace driveline::trajectory::test
