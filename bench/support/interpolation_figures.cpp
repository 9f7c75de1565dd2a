#include "support/interpolation_figures.hpp"

#include <fmt/format.h>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "driveline/trajectory/interpolation_method.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/setpoint_stream.hpp"
#include "driveline/trajectory/stream_curve.hpp"
#include "support/realtime.hpp"
#include "support/samples.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using trajectory::AxisSetpoint;
using trajectory::InterpolationMethod;
using trajectory::StreamMethod;

constexpr double kCycleS = 125e-6;
constexpr int kCyclesPerPoint = 8;
constexpr int kCyclesAtATime = 64;  ///< cycles per sample: a single one takes less than the clock resolves
constexpr int kMeasurements = 4000;
constexpr int kPoints = 2000;
constexpr std::uint64_t kSeed = 20260716;
constexpr double kCubicAimNs = 3.0;
constexpr double kOtherAimNs = 6.0;
constexpr std::size_t kAimedAxes = 32;

/// Moves all axes in small steps, within the limits of a stream.
class Walk {
 public:
  explicit Walk(std::size_t axes) : engine_(kSeed), positions_(axes), velocities_(axes) {}

  void step() {
    std::uniform_real_distribution<double> change(-1.0, 1.0);
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      velocities_[i] = 0.95 * velocities_[i] + 0.01 * change(engine_);
      positions_[i] += velocities_[i] * kCycleS * kCyclesPerPoint;
    }
  }
  [[nodiscard]] const std::vector<double>& positions() const { return positions_; }
  [[nodiscard]] const std::vector<double>& velocities() const { return velocities_; }

 private:
  std::mt19937_64 engine_;
  std::vector<double> positions_;
  std::vector<double> velocities_;
};

trajectory::Path make_path(std::size_t axes) {
  trajectory::PathBuilder builder;
  const auto require = [](const auto& result) {
    if (!result) throw std::runtime_error(result.error().message());
  };
  for (std::size_t i = 0; i < axes; ++i) {
    require(builder.add_axis({fmt::format("a{}", i), trajectory::AxisKind::kRotary, nullptr}));
  }
  Walk walk(axes);
  for (int k = 0; k < kPoints; ++k) {
    require(builder.add_point(k * kCyclesPerPoint * kCycleS, walk.positions()));
    walk.step();
  }
  auto path = builder.build();
  require(path);
  return std::move(*path);
}

/// ns per axis and cycle; `cycle` is called with the number of the cycle.
template <typename Cycle>
Summary measure(std::size_t axes, int batches, Cycle cycle) {
  std::vector<double> samples;
  Rests rests;
  int number = 0;
  for (int batch = 0; batch < batches; ++batch) {
    rests.take_when_due(now_ns());
    const double begin = now_ns();
    for (int i = 0; i < kCyclesAtATime; ++i) cycle(number++);
    samples.push_back((now_ns() - begin - reading_cost_ns()) / kCyclesAtATime);
  }
  return divided(summarize(std::move(samples)), static_cast<double>(axes));
}

/// The time along the path, which is repeated.
double path_time_s(int cycle) {
  return cycle % ((kPoints - 1) * kCyclesPerPoint) * kCycleS;
}

/// The floor: cubics with the same numbers of axes and segments.
Baseline bare_cubics(std::size_t axes, int batches) {
  std::vector<double> coefficients(static_cast<std::size_t>(kPoints) * 4 * axes);
  std::mt19937_64 engine(kSeed);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  for (double& coefficient : coefficients) coefficient = value(engine);
  std::vector<AxisSetpoint> out(axes);
  const auto cycle = [&](int number) {
    const int place = number % ((kPoints - 1) * kCyclesPerPoint);
    const double t = place % kCyclesPerPoint * kCycleS;
    const double* const c = &coefficients[static_cast<std::size_t>(place / kCyclesPerPoint) * 4 * axes];
    for (std::size_t i = 0; i < axes; ++i) {
      const double c1 = c[axes + i];
      const double c2 = c[2 * axes + i];
      const double c3 = c[3 * axes + i];
      out[i] = {c[i] + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3), 2.0 * c2 + 6.0 * t * c3};
    }
    keep(out.front());
  };
  return {"bare_cubics", measure(axes, batches, cycle)};
}

bool is_cubic(InterpolationMethod method) {
  return method == InterpolationMethod::kHermite || method == InterpolationMethod::kNaturalSpline ||
         method == InterpolationMethod::kClampedSpline || method == InterpolationMethod::kBSpline;
}

bool is_cubic(StreamMethod method) {
  return method == StreamMethod::kHermite || method == StreamMethod::kCubic || method == StreamMethod::kBSpline;
}

/// Aim of the interpolation alone.
template <typename Method>
std::optional<double> aim_of(Method method, std::size_t axes) {
  if (axes != kAimedAxes) return std::nullopt;
  return is_cubic(method) ? kCubicAimNs : kOtherAimNs;
}

Summary path_cost(const trajectory::Path& path, InterpolationMethod method, int batches) {
  auto curve = trajectory::Interpolator::make(path, method);
  std::vector<AxisSetpoint> out(path.axes().size());
  return measure(out.size(), batches, [&](int cycle) {
    curve.evaluate(path_time_s(cycle), out);
    keep(out.front());
  });
}

/// Precomputed setpoints of a stream: forth and back, so that repeating them causes no step.
class StreamedWalk {
 public:
  explicit StreamedWalk(std::size_t axes) : setpoints_(kMade, std::vector<trajectory::StreamPoint>(axes)) {
    Walk walk(axes);
    for (std::size_t k = 0; k < kMade / 2; ++k) {
      walk.step();
      for (std::size_t i = 0; i < axes; ++i) {
        setpoints_[k][i] = {walk.positions()[i], walk.velocities()[i], 0.0};
        setpoints_[kMade - 1 - k][i] = {walk.positions()[i], -walk.velocities()[i], 0.0};
      }
    }
  }

  /// The setpoints that arrive in a cycle; null: none arrive.
  [[nodiscard]] const std::vector<trajectory::StreamPoint>* of(int cycle) const {
    if (cycle % kCyclesPerPoint != 0) return nullptr;
    return &setpoints_[static_cast<std::size_t>(cycle / kCyclesPerPoint) % kMade];
  }

 private:
  static constexpr std::size_t kMade = 512;
  std::vector<std::vector<trajectory::StreamPoint>> setpoints_;
};

/// Delay of the curve behind the arriving setpoints, in s.
double delay_s(StreamMethod method) {
  return static_cast<double>(facts_of(method).delay + 1) * kCyclesPerPoint * kCycleS;
}

/// The curve alone: accepts new setpoints, computes coefficients and evaluates; without checks and limits.
Summary curve_cost(StreamMethod method, std::size_t axes, int batches) {
  constexpr std::size_t kRoom = 16;
  trajectory::StreamCurve curve(method, axes, kRoom, kCyclesPerPoint * kCycleS);
  const StreamedWalk walk(axes);
  std::vector<AxisSetpoint> out(axes);
  bool reached = false;
  const auto cost = measure(axes, batches, [&](int cycle) {
    const double now_s = cycle * kCycleS;
    if (const auto* setpoints = walk.of(cycle)) curve.add(now_s, *setpoints);
    reached = curve.advance(now_s - delay_s(method));
    if (curve.begun()) curve.evaluate(now_s - delay_s(method), out);
    keep(out.front());
  });
  if (!reached) throw std::runtime_error("a curve that was measured did not reach the present");
  return cost;
}

/// The complete stream: setpoints are checked, joined, and followed within the limits.
Summary stream_cost(StreamMethod method, std::size_t axes, int batches) {
  trajectory::StreamSettings settings;
  settings.method = method;
  settings.delay_s = delay_s(method);
  trajectory::SetpointStream stream(settings, std::vector<trajectory::FollowLimits>(axes, {{1e3, 1e6}, 1e9}));
  stream.begin(0.0, std::vector<double>(axes));
  const StreamedWalk walk(axes);
  std::vector<AxisSetpoint> out(axes);
  const auto cost = measure(axes, batches, [&](int cycle) {
    const double now_s = cycle * kCycleS;
    if (const auto* setpoints = walk.of(cycle)) (void)stream.push(now_s, *setpoints);
    (void)stream.evaluate(now_s, out);
    keep(out.front());
  });
  if (stream.state() != trajectory::StreamState::kFollowing || stream.counters().underruns != 0) {
    throw std::runtime_error("a stream that was measured did not follow its setpoints");
  }
  return cost;
}

}  // namespace

void add_interpolation_figures(Report& report, const Options& options) {
  constexpr std::array<std::pair<StreamMethod, std::string_view>, 6> kStreams{{{StreamMethod::kHold, "hold"},
                                                                               {StreamMethod::kLinear, "linear"},
                                                                               {StreamMethod::kHermite, "hermite"},
                                                                               {StreamMethod::kCubic, "cubic"},
                                                                               {StreamMethod::kQuintic, "quintic"},
                                                                               {StreamMethod::kBSpline, "bspline"}}};
  const int batches = options.count(kMeasurements);
  for (const std::size_t axes : {std::size_t{1}, std::size_t{8}, std::size_t{32}, std::size_t{128}}) {
    const auto path = make_path(axes);
    const Baseline floor = bare_cubics(axes, batches);
    const auto add = [&](std::string_view kind, std::string_view name, const Summary& cost, std::optional<double> aim) {
      report.add({fmt::format("{}_{}_{}_axes", kind, name, axes), "cost_per_axis", "ns", cost, aim, floor});
    };
    for (const auto& facts : trajectory::interpolation_methods()) {
      add("path", facts.name, path_cost(path, facts.method, batches), aim_of(facts.method, axes));
    }
    for (const auto& [method, name] : kStreams) {
      add("curve", name, curve_cost(method, axes, batches), aim_of(method, axes));
      add("stream", name, stream_cost(method, axes, batches), std::nullopt);
    }
  }
}

}  // namespace driveline::bench
