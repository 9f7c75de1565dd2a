// Scripts that move axes and groups of a CAN line on virtual time: the same words and units as on EtherCAT.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#include "driveline/runtime/config/line_config.hpp"
#include "script_operator.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kTwoAxesOnCan = R"([line]
name = "two"
[bus]
type = "can"
max_lost_ms = 20
[telemetry]
enabled = false
[[slave]]
name = "turn"
node = 5
[[slave]]
name = "slide"
node = 9
model = "servoone"
[[axis]]
name = "turn"
unit = "deg"
max_velocity = 3600
max_acceleration = 90000
[[axis]]
name = "slide"
feed_mm_per_revolution = 20
unit = "mm"
max_velocity = 800
max_acceleration = 8000
)";

/// Keeps the last and the highest position of each axis.
class Places final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> /*samples*/) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      last.at(sample.axis) = sample.actual_position;
      most.at(sample.axis) = std::max(most.at(sample.axis), sample.actual_position);
    }
  }
  std::array<double, 2> last{};
  std::array<double, 2> most{};
};

class CanScript : public test::TemporaryDirectory {
 protected:
  /// Runs a script on a line; returns the sentence of the failure, empty: there is none.
  std::string run(const std::string& description, const std::string& words, const std::string& file) {
    auto config = must(runtime::parse_line_config(description, directory / "line.toml"));
    config->output.directory = directory / "out";
    auto script = must(AxisScript::parse(words, file, {config->axes, config->axis_groups, &config->couplings}));
    runtime::Line::Options options;
    options.virtual_time = true;
    auto line = must(runtime::Line::from_config(*config, options));
    ScriptOperator hand(**line, std::move(*script));
    (*line)->observe(hand);
    (*line)->add(places);
    const auto report = must((*line)->run({.duration_s = 60.0}));
    EXPECT_EQ(hand.problem, "");
    EXPECT_TRUE(hand.over);
    EXPECT_TRUE(report->can);
    EXPECT_EQ(report->can->lost_pdos, 0U);
    return report->failure() == nullptr ? "" : runtime::describe(*report->failure());
  }
  Places places;
};

TEST_F(CanScript, MovesJogsHaltsAndHomes) {
  EXPECT_EQ(run(std::string(kTwoAxesOnCan),
                "turn move by=90deg velocity=720deg/s\nslide move 40mm\nwait all\n"
                "turn jog 20rpm\nsleep 0.5s\nturn halt\nwait turn\n"
                "slide override 50%\nslide move by=-15mm\nwait slide\nturn home\nwait turn\n",
                "moves.txt"),
            "");
  constexpr double kTurn = 0.5 * 3.14159265358979;
  EXPECT_GT(places.most[0], kTurn + 0.5) << "jogged after the move";
  EXPECT_NEAR(places.last[1], 0.025, 1e-4);
  EXPECT_NEAR(places.most[1], 0.040, 1e-4);
}

TEST_F(CanScript, AGroupFollowsItsContourAtOneMillisecond) {
  const auto read = [](const char* name) {
    std::ifstream file(std::string(DRIVELINE_EXAMPLES_DIR) + "/" + name);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  auto description = read("plotter.toml");
  const auto bus = description.find("[bus]\n");
  ASSERT_NE(bus, std::string::npos);
  description.insert(bus + 6, "type = \"can\"\n");
  EXPECT_EQ(run(description, read("plotter.txt"), std::string(DRIVELINE_EXAMPLES_DIR) + "/plotter.txt"), "");
  EXPECT_GT(places.most[0], 0.2);
}

}  // namespace
}  // namespace driveline::cli
