// The delta robot of the examples: its script on simulated drives, judged by their demands (6062h, 606Bh) and by the
// terminals of a drive (208Fh). The path of the tool is computed only with formulas of this file: three spheres around
// the knees.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "driveline/runtime/line.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "script/axis_script.hpp"
#include "script_operator.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using Point = std::array<double, 3>;  // mm

constexpr double kPeriod = 500e-6;
constexpr double kDegree = std::numbers::pi / 180.0;
/// Dimensions of examples/delta.toml, mm.
constexpr double kBase = 200.0;
constexpr double kPlatform = 45.0;
constexpr double kArm = 250.0;
constexpr double kRod = 600.0;
/// Error due to whole increments of three joints and the interpolation of the drives, mm.
constexpr double kOnPath = 0.03;
/// Tolerance of the rounded corners of examples/delta.jsonl, mm.
constexpr double kTolerance = 15.0;
constexpr Point kPark{0.0, 0.0, -560.0};

std::filesystem::path example(const std::string& name) {
  return std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / name;
}

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double apart(const Point& a, const Point& b) {
  return std::sqrt(dot(minus(a, b), minus(a, b)));
}

/// Position of the knee of an arm, moved inwards by the platform, so that all rods end in one point.
Point knee_of(std::size_t arm, double angle) {
  const double around = 120.0 * kDegree * static_cast<double>(arm);
  const double out = kBase - kPlatform + kArm * std::cos(angle);
  return {out * std::cos(around), out * std::sin(around), -kArm * std::sin(angle)};
}

/// The point at the distance of a rod from all knees, by Newton's method from a point below.
Point tool_of(const std::array<double, 3>& joints) {
  Point at{0.0, 0.0, -600.0};
  for (int round = 0; round < 20; ++round) {
    std::array<Point, 3> rods{};
    Point wrong{};
    for (std::size_t i = 0; i < 3; ++i) {
      rods[i] = minus(at, knee_of(i, joints[i]));
      wrong[i] = 0.5 * (dot(rods[i], rods[i]) - kRod * kRod);
    }
    // Cramer's rule for rods * step = wrong.
    const auto determinant = [](const std::array<Point, 3>& m) {
      return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    };
    const double whole = determinant(rods);
    for (std::size_t i = 0; i < 3; ++i) {
      auto replaced = rods;
      for (std::size_t k = 0; k < 3; ++k) replaced[k][i] = wrong[k];
      at[i] -= determinant(replaced) / whole;
    }
  }
  return at;
}

double from_line(const Point& at, const Point& a, const Point& b) {
  const auto way = minus(b, a);
  const double share = std::clamp(dot(minus(at, a), way) / dot(way, way), 0.0, 1.0);
  return apart(at, {a[0] + share * way[0], a[1] + share * way[1], a[2] + share * way[2]});
}

/// Distance from the whole circle through three points.
double from_circle(const Point& at, const Point& a, const Point& b, const Point& c) {
  const auto u = minus(b, a);
  const auto v = minus(c, a);
  const double uu = dot(u, u);
  const double vv = dot(v, v);
  const double uv = dot(u, v);
  const double square = uu * vv - uv * uv;
  const double p = 0.5 * vv * (uu - uv) / square;
  const double q = 0.5 * uu * (vv - uv) / square;
  const Point center{a[0] + p * u[0] + q * v[0], a[1] + p * u[1] + q * v[1], a[2] + p * u[2] + q * v[2]};
  const Point square_to{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double height = dot(minus(at, center), square_to) / std::sqrt(dot(square_to, square_to));
  const auto from_center = minus(at, center);
  const double beside = std::sqrt(std::max(0.0, dot(from_center, from_center) - height * height));
  return std::hypot(height, beside - apart(a, center));
}

/// The lines of examples/delta.jsonl; its arc is checked separately.
const std::vector<std::pair<Point, Point>> kLines{{kPark, {-150, 0, -570}},
                                                  {{-150, 0, -570}, {-150, 0, -620}},
                                                  {{-150, 0, -580}, {150, 0, -580}},
                                                  {{150, 0, -580}, {150, 0, -620}},
                                                  {{-100, 60, -580}, {-100, 60, -620}},
                                                  {{-100, 60, -580}, {150, -60, -580}},
                                                  {{150, -60, -570}, {150, -60, -620}},
                                                  {{150, -60, -570}, kPark}};
const std::array<Point, 3> kArc{{{150, 0, -580}, {0, 100, -565}, {-100, 60, -580}}};
/// Its rounded corners.
const std::vector<Point> kCorners{{-150, 0, -570},  {-150, 0, -580},  {150, 0, -580},
                                  {-100, 60, -580}, {150, -60, -580}, {150, -60, -570}};

double beside_path(const Point& at) {
  double least = from_circle(at, kArc[0], kArc[1], kArc[2]);
  for (const auto& [a, b] : kLines) least = std::min(least, from_line(at, a, b));
  return least;
}

bool near_corner(const Point& at) {
  constexpr double kNear = 60.0;
  return std::any_of(kCorners.begin(), kCorners.end(), [&](const Point& corner) { return apart(at, corner) < kNear; });
}

/// Outputs of the drives in a cycle.
struct Told {
  std::array<double, 3> demand{};  ///< 6062h, rad
  std::uint32_t terminals = 0;     ///< 208Fh of the first drive
};

/// Reads the process data in every cycle.
class Witness final : public runtime::Task {
 public:
  Witness() { told.reserve(40'000); }
  runtime::Result<void> prepare(const runtime::TaskSetup& setup) override {
    constexpr std::array<const char*, 3> kDemands{"a1.6062", "a2.6062", "a3.6062"};
    for (std::size_t i = 0; i < 3; ++i) demands_[i] = *setup.process_data.entry<std::int32_t>(kDemands.at(i));
    terminals_ = *setup.process_data.entry<std::uint32_t>("a1.208F");
    return {};
  }
  void update(const motion::TaskCycle& cycle) noexcept override {
    if (told.size() == told.capacity()) return;
    Told now;
    for (std::size_t i = 0; i < 3; ++i)
      now.demand[i] = demands_[i].get(cycle.inputs) / 1048576.0 * 2.0 * std::numbers::pi;
    now.terminals = terminals_.get(cycle.inputs);
    told.push_back(now);
  }
  std::vector<Told> told;

 private:
  std::array<motion::PdoEntry<std::int32_t>, 3> demands_;
  motion::PdoEntry<std::uint32_t> terminals_;
};

/// The highest velocity that each drive demands (606Bh); called by another thread.
class Velocities final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> /*samples*/) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      auto& most = highest.at(sample.axis);
      most = std::max(most, std::abs(sample.demand_velocity));
    }
  }
  std::array<double, 3> highest{};
};

class DeltaExample : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    test::TemporaryDirectory::SetUp();
    auto config = must(runtime::load_line_config(example("delta.toml")));
    config->output.directory = directory / "out";
    auto script = must(AxisScript::read(example("delta.txt"), {config->axes, config->axis_groups}));
    runtime::Line::Options options;
    options.virtual_time = true;
    auto line = must(runtime::Line::from_config(*config, options));
    ScriptOperator hand(**line, std::move(*script));
    (*line)->observe(hand);
    (*line)->add(velocities);
    ASSERT_TRUE((*line)->add(witness, {"witness"}));
    runtime::Line::RunSettings settings;
    settings.duration_s = 60.0;
    const auto made = must((*line)->run(settings));
    EXPECT_EQ(hand.problem, "");
    EXPECT_TRUE(hand.over);
    EXPECT_EQ(made->failure(), nullptr);
    report = *made;
    for (const auto& told : witness.told) tools.push_back(tool_of(told.demand));
    find_path();
  }

  /// From the departure of the tool from the start of the file to its return.
  void find_path() {
    const auto parked = [](const Point& tool) { return apart(tool, kPark) < kOnPath; };
    const auto start = std::find_if(tools.begin(), tools.end(), parked);
    const auto left = std::find_if_not(start, tools.end(), parked);
    const auto back = std::find_if(left, tools.end(), parked);
    ASSERT_NE(back, tools.end());
    begin = static_cast<std::size_t>(left - tools.begin());
    end = static_cast<std::size_t>(back - tools.begin());
  }

  Witness witness;
  Velocities velocities;
  std::optional<runtime::RunReport> report;
  std::vector<Point> tools;  ///< positions from the demands of the drives
  std::size_t begin = 0;
  std::size_t end = 0;
};

TEST_F(DeltaExample, TheToolGoesAlongItsPathAndTheJointsKeepTheirLimits) {
  double worst = 0.0;
  double worst_in_corner = 0.0;
  std::size_t away = 0;
  for (auto k = begin; k < end; ++k) {
    const double beside = beside_path(tools[k]);
    auto& figure = near_corner(tools[k]) ? worst_in_corner : worst;
    figure = std::max(figure, beside);
    away += near_corner(tools[k]) ? 0 : 1;
  }
  EXPECT_GT(away, 200U);
  EXPECT_LT(worst, kOnPath);
  EXPECT_LT(worst_in_corner, kTolerance + kOnPath);
  EXPECT_GT(worst_in_corner, 1.0) << "the corners are rounded";
  for (const Point& place : {Point{-150, 0, -620}, {150, 0, -620}, {-100, 60, -620}, {150, -60, -620}}) {
    const auto there =
        std::count_if(tools.begin(), tools.end(), [&](const Point& tool) { return apart(tool, place) < kOnPath; });
    EXPECT_GT(there, 0.018 / kPeriod) << "it stands where it picks and places";
  }
  // The limits of the joints, in position, velocity and, by differences over some cycles, acceleration.
  constexpr std::size_t kWindow = 8;
  constexpr double kTime = kPeriod * kWindow;
  double fastest = 0.0;
  double fastest_tool = 0.0;
  double sharpest = 0.0;
  for (std::size_t k = 2 * kWindow; k < witness.told.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double now = witness.told[k].demand[i];
      const double before = witness.told[k - kWindow].demand[i];
      EXPECT_GE(now, -30.0 * kDegree - 1e-5);
      EXPECT_LE(now, 95.0 * kDegree + 1e-5);
      fastest = std::max(fastest, std::abs(now - before) / kTime);
      sharpest =
          std::max(sharpest, std::abs(now - 2.0 * before + witness.told[k - 2 * kWindow].demand[i]) / (kTime * kTime));
    }
    fastest_tool = std::max(fastest_tool, apart(tools[k], tools[k - 1]) / kPeriod);
  }
  EXPECT_LE(fastest, 900.0 * kDegree);
  EXPECT_LE(sharpest, 25000.0 * kDegree * 1.01);
  EXPECT_GT(fastest, 200.0 * kDegree);
  for (const double highest : velocities.highest) {
    EXPECT_LE(highest, 900.0 * kDegree);
    EXPECT_GT(highest, 100.0 * kDegree);
  }
  EXPECT_LE(fastest_tool, 3000.0 * 1.01) << "max_feed";
  EXPECT_GT(fastest_tool, 1500.0);
  // During the hold the tool is at standstill on its path.
  std::size_t standing = 0;
  for (auto k = begin + 1; k < end; ++k) standing += apart(tools[k], tools[k - 1]) < 1e-9 ? 1 : 0;
  EXPECT_GT(standing, 0.1 / kPeriod);
  // Afterwards it passes the point of the last arc.
  const Point via{50, 50, -580};
  EXPECT_LT(std::accumulate(tools.begin(), tools.end(), 1e9,
                            [&](double least, const Point& tool) { return std::min(least, apart(tool, via)); }),
            1.0);
  ASSERT_EQ(report->axis_groups.size(), 1U);
  ASSERT_EQ(report->axis_groups[0].place.size(), 3U);
  EXPECT_NEAR(report->axis_groups[0].place[2], -0.56, 1e-9);
}

TEST_F(DeltaExample, TheValvesSwitchAtTheirPlacesAndStayInBetween) {
  constexpr std::uint32_t kVacuum = 1;
  constexpr std::uint32_t kBlow = 2;
  /// A change of the terminals, and the position of the tool at that time.
  struct Change {
    std::uint32_t terminals;
    Point tool;
  };
  std::vector<Change> changes;
  for (std::size_t k = 1; k < tools.size(); ++k) {
    const auto now = witness.told[k].terminals & (kVacuum | kBlow);
    if (now != (witness.told[k - 1].terminals & (kVacuum | kBlow))) changes.push_back({now, tools[k]});
  }
  // Picks 10 mm before the lowest point, releases at standstill, and blows until it is 5 mm up again.
  const std::vector<Change> expected{{kVacuum, {-150, 0, -610}},  {kBlow, {150, 0, -620}},   {0, {150, 0, -615}},
                                     {kVacuum, {-100, 60, -610}}, {kBlow, {150, -60, -620}}, {0, {150, -60, -615}}};
  ASSERT_EQ(changes.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(changes[i].terminals, expected[i].terminals) << i;
    // There are one or two cycles between a setpoint, the demand of its drive, and the terminals.
    EXPECT_LT(apart(changes[i].tool, expected[i].tool), 3.0) << i;
  }
}

}  // namespace
}  // namespace driveline::cli
