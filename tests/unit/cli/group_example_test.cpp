// The example of a group: its script on the simulated line, judged by the demands of the drives.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "driveline/runtime/line.hpp"
#include "script/axis_script.hpp"
#include "script_operator.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

/// Demands of both drives (6062h), cycle by cycle; called by another thread.
class Demand final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> /*samples*/) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      at_.at(sample.axis) = sample.demand_position;
      if (sample.axis == 1) points.push_back(at_);
    }
  }
  std::vector<std::array<double, 2>> points;

 private:
  std::array<double, 2> at_{};
};

std::string text_of(const std::string& file) {
  std::ifstream stream(std::string(DRIVELINE_EXAMPLES_DIR) + "/" + file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

void replace_all(std::string& text, const std::string& part, const std::string& by) {
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + by.size()))
    text.replace(at, part.size(), by);
}

/// The line of the example, with drives that also report their demands.
std::string telling_line() {
  auto text = text_of("plotter.toml");
  for (const std::string name : {"x", "y"}) {
    replace_all(text, "[[slave]]\nname = \"" + name + "\"\n",
                "[[slave]]\nname = \"" + name +
                    "\"\npdo = [{ index = 0x1600, entries = [\"0x6040:0:16\", \"0x6060:0:8\", \"0x607A:0:32\"] }, "
                    "{ index = 0x1A00, entries = [\"0x6041:0:16\", \"0x6061:0:8\", \"0x6064:0:32\"] }, "
                    "{ index = 0x1A01, entries = [\"0x6062:0:32\", \"0x606B:0:32\"] }]\n");
  }
  return text;
}

double length(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  return std::hypot(to[0] - from[0], to[1] - from[1]);
}

/// Distance from the contour of the example up to its spline, m; the contour is that of examples/contour.jsonl.
double beside_contour(const std::array<double, 2>& at) {
  const auto from_line = [&at](std::array<double, 2> a, std::array<double, 2> b) {
    const double l = length(a, b);
    const double share =
        std::clamp(((at[0] - a[0]) * (b[0] - a[0]) + (at[1] - a[1]) * (b[1] - a[1])) / (l * l), 0.0, 1.0);
    return length(at, {a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])});
  };
  const auto from_circle = [&at](std::array<double, 2> center, double radius) {
    return std::abs(length(at, center) - radius);
  };
  // The circle through (150, 200), (80, 170) and (50, 100).
  const std::array circle{0.1525, 0.0975};
  return std::min({from_line({0.0, 0.0}, {0.3, 0.0}), from_circle({0.3, 0.1}, 0.1), from_line({0.3, 0.2}, {0.15, 0.2}),
                   from_circle(circle, length(circle, {0.15, 0.2})), from_line({0.05, 0.1}, {0.0, 0.0})});
}

class GroupExample : public test::TemporaryDirectory {};

TEST_F(GroupExample, TheDrivesFollowTheContourWithinTheLimitsOfTheirAxes) {
  auto config = must(runtime::parse_line_config(telling_line(), directory / "line.toml"));
  config->output.directory = directory / "out";
  auto script = must(AxisScript::parse(text_of("plotter.txt"), std::string(DRIVELINE_EXAMPLES_DIR) + "/plotter.txt",
                                       {config->axes, config->axis_groups}));
  runtime::Line::Options options;
  options.virtual_time = true;
  auto line = must(runtime::Line::from_config(*config, options));
  ScriptOperator hand(**line, std::move(*script));
  Demand demand;
  (*line)->observe(hand);
  (*line)->add(demand);
  runtime::Line::RunSettings settings;
  settings.duration_s = 60.0;
  const auto report = must((*line)->run(settings));
  EXPECT_EQ(hand.problem, "");
  EXPECT_TRUE(hand.over);
  EXPECT_EQ(report->failure(), nullptr);

  // From the start of the contour on, with the axes at the origin.
  const auto& points = demand.points;
  constexpr double kNear = 2e-6;
  constexpr double kPeriod = 1e-3;
  const auto origin = [&](const auto& at) { return length(at, {0.0, 0.0}) < kNear; };
  const auto start = std::find_if(points.begin(), points.end(), origin);
  ASSERT_NE(start, points.end());
  auto there = std::find_if_not(start, points.end(), origin);
  const auto back = std::find_if(there, points.end(), origin);
  ASSERT_NE(back, points.end()) << "the contour ends where it began, before the spline";
  double beside = 0.0;
  for (auto at = there; at != back; ++at) beside = std::max(beside, beside_contour(*at));
  // The corner between the lines and arcs is rounded within 0.5 mm, plus increments and the drive's own interpolation.
  EXPECT_LT(beside, 0.5e-3 + 5e-6);
  double fastest = 0.0;
  for (auto at = start + 1; at != points.end(); ++at) {
    const auto& before = *(at - 1);
    fastest = std::max(fastest, length(before, *at) / kPeriod);
    EXPECT_LT(std::abs((*at)[0] - before[0]) / kPeriod, 0.8 * 1.001);
  }
  EXPECT_NEAR(fastest, 0.5 * 1.5, 0.02) << "max_feed, and 150 % of it";
  // During the hold the axes are at standstill for a while.
  std::size_t standing = 0;
  for (auto at = there + 1; at != back; ++at) standing += length(*(at - 1), *at) < 1e-9 ? 1 : 0;
  EXPECT_GT(standing, 100U);
  EXPECT_NEAR(points.back()[1], points[points.size() - 2][1], 1e-6);
}

}  // namespace
}  // namespace driveline::cli
