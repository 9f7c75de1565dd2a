// The flying saw of the examples: a saw that cuts endless material while both move, judged by the demands of its
// simulated drives (6062h, 606Bh).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
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

constexpr std::size_t kSaw = 0;
constexpr std::size_t kBlade = 1;
constexpr double kMm = 1e-3;
constexpr double kPeriod = 500e-6;
/// Cycles by which a drive's reports (6062h, 6064h) are older than the setpoints of the same sample.
constexpr std::size_t kCyclesBehind = 3;
/// Cut positions of the material minus those of the carriage, m: at= minus to= of examples/flying_saw.txt.
constexpr std::array kCuts{0.44, 0.84, 1.24};
/// Largest distance between saw and material while the blade is in it, m.
constexpr double kTolerance = 1e-6;
/// max_jerk of both in examples/flying_saw.toml, m/s^3.
constexpr double kSawJerk = 100.0;
constexpr double kBladeJerk = 200.0;
/// Below this position the blade is in the material, m.
constexpr double kTouches = 1.0 * kMm;

std::filesystem::path example(const std::string& name) {
  return std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / name;
}

/// 6062h and 606Bh in addition to the objects of an axis.
motion::PdoConfiguration with_demands() {
  return {{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}},
           {0x1601, {{0x60FF, 0, 32}, {0x60B1, 0, 32}}},
           {0x1602, {{0x6071, 0, 16}, {0x60B2, 0, 16}}}},
          {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
           {0x1A01, {{0x606C, 0, 32}, {0x6062, 0, 32}}},
           {0x1A02, {{0x6077, 0, 16}, {0x606B, 0, 32}}}}};
}

/// Every cycle of all three axes.
class Samples final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> /*samples*/) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) of.at(sample.axis).push_back(sample);
  }
  std::array<std::vector<snapshot::AxisSample>, 3> of;
};

/// Largest magnitudes of a drive's demands, as differences over `kWindow` cycles, because positions are whole
/// increments.
struct Demand {
  static constexpr std::size_t kWindow = 8;
  explicit Demand(const std::vector<snapshot::AxisSample>& samples) {
    std::vector<double> places;
    for (const auto& sample : samples) {
      if (sample.state == snapshot::AxisState::kOperationEnabled) places.push_back(sample.demand_position);
      velocity_told = std::max(velocity_told, std::abs(sample.demand_velocity));
    }
    const double time = kPeriod * kWindow;
    for (std::size_t i = 2 * kWindow; i < places.size(); ++i) {
      const double now = (places[i] - places[i - kWindow]) / time;
      const double before = (places[i - kWindow] - places[i - 2 * kWindow]) / time;
      velocity = std::max(velocity, std::abs(now));
      acceleration = std::max(acceleration, std::abs(now - before) / time);
      if (i < 3 * kWindow) continue;
      const double first = (places[i - 2 * kWindow] - places[i - 3 * kWindow]) / time;
      jerk = std::max(jerk, std::abs(now - 2.0 * before + first) / (time * time));
    }
  }
  double velocity = 0.0;
  double velocity_told = 0.0;
  double acceleration = 0.0;
  double jerk = 0.0;
};

/// Position of the drive when it is enabled.
double first_place(const std::vector<snapshot::AxisSample>& samples) {
  const auto found = std::find_if(samples.begin(), samples.end(), [](const auto& sample) {
    return sample.state == snapshot::AxisState::kOperationEnabled;
  });
  return found == samples.end() ? 0.0 : found->demand_position;
}

/// Positions of the saw on the material, from `member` of its samples: one list per cut, with every cycle in which the
/// blade is in the material.
std::vector<std::vector<double>> places_of_cuts(const Samples& samples, double snapshot::AxisSample::*member) {
  const auto& [saw, blade, material] = samples.of;
  const auto count = std::min({saw.size(), blade.size(), material.size()});
  const double base = first_place(blade);
  std::vector<std::vector<double>> cuts;
  bool cutting = false;
  for (std::size_t i = kCyclesBehind; i < count; ++i) {
    const bool deep = blade[i].demand_position - base > kTouches;
    if (deep && !cutting) cuts.emplace_back();
    cutting = deep;
    if (deep) cuts.back().push_back(material[i - kCyclesBehind].target_position - saw[i].*member);
  }
  return cuts;
}

class FlyingSaw : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    runtime::Line::Options options;
    options.virtual_time = true;
    options.adjust = [this](runtime::LineConfig& config) -> runtime::Result<void> {
      for (auto& slave : config.slaves) slave.plan.pdos = with_demands();
      config.output.directory = directory / "out";
      config.output.plots = false;
      return {};
    };
    auto line = must(runtime::Line::from_file(example("flying_saw.toml"), options));
    const auto& config = (*line)->config();
    auto script =
        must(AxisScript::read(example("flying_saw.txt"), {config.axes, config.axis_groups, &config.couplings}));
    ScriptOperator hand(**line, std::move(*script));
    (*line)->observe(hand);
    (*line)->add(samples);
    limits_saw = config.axes[kSaw].limits;
    limits_blade = config.axes[kBlade].limits;
    runtime::Line::RunSettings settings;
    settings.duration_s = 60.0;
    const auto report = must((*line)->run(settings));
    EXPECT_EQ(hand.problem, "");
    EXPECT_TRUE(hand.over);
    EXPECT_EQ(report->failure(), nullptr);
  }

  Samples samples;
  trajectory::AxisLimits limits_saw;
  trajectory::AxisLimits limits_blade;
};

void expect_within(const Demand& demand, const trajectory::AxisLimits& limits, double max_jerk) {
  EXPECT_LE(demand.velocity, 1.001 * limits.max_velocity);
  EXPECT_LE(demand.velocity_told, 1.001 * limits.max_velocity);
  EXPECT_LE(demand.acceleration, 1.005 * limits.max_acceleration);
  EXPECT_LE(demand.jerk, 1.05 * max_jerk);
  // Drives that hardly move would prove nothing.
  EXPECT_GE(demand.acceleration, 0.3 * limits.max_acceleration);
  EXPECT_GE(demand.velocity_told, 0.3 * limits.max_velocity);
}

TEST_F(FlyingSaw, ItsDrivesDemandNoMoreThanTheLimitsOfTheirAxes) {
  expect_within(Demand(samples.of[kSaw]), limits_saw, kSawJerk);
  expect_within(Demand(samples.of[kBlade]), limits_blade, kBladeJerk);
}

TEST_F(FlyingSaw, CutsInSynchronismAtTheSamePlaceOfTheMaterialWhateverItsVelocity) {
  const auto cuts = places_of_cuts(samples, &snapshot::AxisSample::demand_position);
  ASSERT_EQ(cuts.size(), std::size(kCuts));
  for (std::size_t cut = 0; cut < cuts.size(); ++cut) {
    EXPECT_GT(cuts[cut].size(), 200U);
    for (const double place : cuts[cut]) ASSERT_NEAR(place, kCuts[cut], kTolerance) << "cut " << cut;
  }
}

TEST_F(FlyingSaw, ItsShaftIsWithTheMaterialToo) {
  const auto cuts = places_of_cuts(samples, &snapshot::AxisSample::actual_position);
  ASSERT_EQ(cuts.size(), std::size(kCuts));
  for (std::size_t cut = 0; cut < cuts.size(); ++cut) {
    for (const double place : cuts[cut]) ASSERT_NEAR(place, kCuts[cut], kTolerance) << "cut " << cut;
  }
}

}  // namespace
}  // namespace driveline::cli
