// A CAN line from its description to its report, on virtual time: path, requests, faults.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>

#include "can/node_feed.hpp"
#include "driveline/canopen_master/can_master.hpp"
#include "driveline/runtime/can/can_session.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/wire/al.hpp"
#include "failure_of.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// Two drives: an MSD, and a ServoOne whose node-ID and scale differ.
constexpr auto kTwoOnCan = R"([line]
name = "two"
[bus]
type = "can"
max_lost_ms = 20
[telemetry]
enabled = false
[output]
plots = false
[[slave]]
name = "x"
node = 5
[[slave]]
name = "y"
node = 9
model = "servoone"
[[axis]]
name = "x"
unit = "deg"
[[axis]]
name = "y"
)";

/// Along a path, with which the other axis waits for one that is lost.
constexpr auto kTwoPath = "[recovery]\naxes = \"hold\"\n[path]\nfile = \"two.csv\"\nrelative = true\n";

class CanListener final : public Observer {
 public:
  void event(const Event& event) override { told.push_back(describe(event)); }
  void poll() override {
    if (on_look) on_look(++looks);
  }
  std::vector<std::string> told;
  std::function<void(int)> on_look;
  int looks = 0;
};

/// The report of a run, which must reach operation.
RunReport run(Line& line, const Line::RunSettings& settings = {}) {
  return std::move(*must(line.run(settings)));
}

class CanRun : public test::TemporaryDirectory {
 protected:
  [[nodiscard]] std::unique_ptr<Line> open(const std::string& text) {
    return std::move(*must(virtual_line(text, directory)));
  }
  /// The example, whose output and candump log go to folders of their own.
  [[nodiscard]] std::unique_ptr<Line> example(const std::string& name) {
    Line::Options options;
    options.virtual_time = true;
    options.adjust = [this, name](LineConfig& config) -> Result<void> {
      config.output.directory = directory / name;
      config.output.capture = directory / (name + ".log");
      config.output.plots = false;
      config.telemetry.enabled = false;
      return {};
    };
    return std::move(*must(Line::from_file(DRIVELINE_EXAMPLES_DIR "/can8.toml", options)));
  }
  [[nodiscard]] std::string content(const std::string& name) const {
    std::ifstream file(directory / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(CanRun, FollowsThePathOfEightAxes) {
  auto line = example("out");
  CanListener listener;
  line->observe(listener);
  const auto report = run(*line);
  EXPECT_EQ(failure_of(report), "");
  EXPECT_EQ(report.state, "Operational");
  EXPECT_EQ(report.period, std::chrono::milliseconds{2});
  EXPECT_GT(report.statistics.cycles, 5000U);
  EXPECT_EQ(report.statistics.missed_periods, 0U);
  EXPECT_EQ(report.statistics.wkc_errors, 0U);
  EXPECT_EQ(report.statistics.lost_frames, 0U);
  ASSERT_EQ(report.axes.size(), 8U);
  for (const auto& axis : report.axes) {
    EXPECT_GT(axis.following_error_max, 0.0) << axis.name;
    EXPECT_LT(axis.following_error_max / axis.increments_per_unit, 0.05) << axis.name;
    EXPECT_EQ(axis.unavailable_cycles, 0U) << axis.name;
  }
  ASSERT_TRUE(report.can);
  EXPECT_EQ(report.can->bit_rate, 1'000'000U);
  EXPECT_EQ(report.can->lost_pdos, 0U);
  EXPECT_EQ(report.can->late_pdos, 0U);
  EXPECT_EQ(report.can->emergencies, 0U);
  // The arithmetic of docs/canopen.md: 72 % without stuff bits, at most 87 %.
  EXPECT_NEAR(report.can->planned_load, 0.72, 0.01);
  EXPECT_NEAR(report.can->worst_load, 0.87, 0.01);
  EXPECT_GT(report.bus_load.samples, 5000U);
  EXPECT_GT(report.bus_load.mean, 0.70);
  EXPECT_LT(report.bus_load.mean, 0.87);
  EXPECT_LT(report.bus_load.maximum, 1.0);
  EXPECT_THAT(listener.told, Contains("8 slaves found"));
  EXPECT_THAT(listener.told, Contains("all in Operational"));
  EXPECT_EQ(listener.told.back(), "all in Pre-operational");
}

TEST_F(CanRun, TwoRunsWriteTheSameLog) {
  for (const auto* name : {"first", "second"}) {
    auto line = example(name);
    EXPECT_EQ(failure_of(run(*line, {.duration_s = 0.5})), "");
  }
  const auto first = content("first.log");
  EXPECT_GT(first.size(), 100'000U);
  EXPECT_TRUE(first == content("second.log"));
}

TEST_F(CanRun, WhatBelongsToEtherCatIsNotThere) {
  auto line = open(kTwoOnCan);
  EXPECT_EQ(line->session(), nullptr);
  ASSERT_NE(line->can_session(), nullptr);
  CanListener listener;
  listener.on_look = [&](int look) {
    if (look != 1) return;
    EXPECT_EQ(line->master(), nullptr);
    EXPECT_NE(line->can_master(), nullptr);
    EXPECT_FALSE(line->eoe());
    EXPECT_THAT(failure_text(line->diagnose()), HasSubstr("the line is a CAN line"));
  };
  line->observe(listener);
  EXPECT_EQ(failure_of(run(*line, {.duration_s = 0.1})), "");
  EXPECT_GT(listener.looks, 0);
  EXPECT_EQ(line->can_master(), nullptr) << "the line has ended";
}

TEST_F(CanRun, ALineThatIsTooMuchForItsBusIsRefused) {
  auto line =
      open(std::string(kTwoOnCan).replace(std::string(kTwoOnCan).find("max_lost_ms"), 0, "bit_rate = 125000\n"));
  EXPECT_THAT(failure_text(line->run({})), HasSubstr("2 axes need"));
}

TEST_F(CanRun, ANodeThatIsNotThereIsNamed) {
  auto line = open(std::string(kTwoOnCan) + "[[fault]]\nkind = \"power-off\"\nslave = \"y\"\n");
  EXPECT_THAT(failure_text(line->run({})), HasSubstr("(y)"));
}

/// By default the first lost node ends the run.
TEST_F(CanRun, ALostNodeEndsTheRun) {
  auto line = open(std::string(kTwoOnCan) + "[[fault]]\nat_ms = 3000\nkind = \"power-off\"\nslave = \"x\"\n");
  const auto report = run(*line, {.duration_s = 5.0});
  EXPECT_NE(failure_of(report), "");
  EXPECT_GT(report.duration_s, 0.5);
  EXPECT_LT(report.duration_s, 4.9);
}

/// With [recovery] a drive that was switched off and on is configured again and goes on along the path, without a
/// restart of the run.
TEST_F(CanRun, APowerCycleOfANodeIsRecovered) {
  write(directory / "two.csv", "time[s],x[deg],y[rad]\n0,0,0\n4,200,5\n8,0,0\n");
  auto line = open(std::string(kTwoOnCan) + kTwoPath +
                   "[[fault]]\nat_ms = 3000\nfor_ms = 500\nkind = \"power-off\"\nslave = \"x\"\n");
  const auto report = run(*line);
  EXPECT_EQ(failure_of(report), "");
  EXPECT_EQ(report.recoveries, 1U);
  EXPECT_EQ(report.state, "Operational");
  std::vector<canopen::MasterEvent::Kind> kinds;
  for (const auto& event : report.events) {
    const auto* changed = event.as<events::NodeChanged>();
    if (changed != nullptr && changed->name == "x") kinds.push_back(changed->event.kind);
  }
  EXPECT_THAT(kinds,
              testing::ElementsAre(canopen::MasterEvent::Kind::kNodeLost, canopen::MasterEvent::Kind::kNodeRebooted,
                                   canopen::MasterEvent::Kind::kNodeBack));
  EXPECT_GT(report.duration_s, 8.2) << "y has waited on the path";
  EXPECT_LT(report.axes[0].following_error_max / report.axes[0].increments_per_unit, 1.0);
}

/// A broken cable takes both drives away at once, and the adapter may be bus off; all return when it is mended.
TEST_F(CanRun, ABrokenCableIsBridged) {
  write(directory / "two.csv", "time[s],x[deg],y[rad]\n0,0,0\n4,200,5\n8,0,0\n");
  auto line = open(std::string(kTwoOnCan) + kTwoPath +
                   "[[fault]]\nat_ms = 3000\nfor_ms = 800\nkind = \"cable-break\"\nslave = \"y\"\n");
  const auto report = run(*line);
  EXPECT_EQ(failure_of(report), "");
  EXPECT_EQ(report.recoveries, 2U);
  EXPECT_EQ(report.state, "Operational");
}

TEST_F(CanRun, ADriveThatIsBusOffIsTold) {
  auto line = open(std::string(kTwoOnCan) +
                   "[recovery]\naxes = \"hold\"\n[[fault]]\nat_ms = 3000\nkind = \"bus-off\"\nslave = \"y\"\n");
  CanListener listener;
  line->observe(listener);
  const auto report = run(*line, {.duration_s = 8.0});
  EXPECT_GE(report.can->lost_pdos, 1U);
  const auto is_of_y = [](const Event& event) {
    const auto* changed = event.as<events::NodeChanged>();
    return changed != nullptr && changed->name == "y";
  };
  EXPECT_TRUE(std::any_of(report.events.begin(), report.events.end(), is_of_y));
}

TEST_F(CanRun, AnOptionalNodeThatIsMissingDoesNotHinderTheOthers) {
  auto text = std::string(kTwoOnCan);
  text.replace(text.find("node = 9\n"), 9, "node = 9\noptional = true\n");
  auto line = open(text + "[[fault]]\nkind = \"power-off\"\nfor_ms = 4000\nslave = \"y\"\n");
  CanListener listener;
  line->observe(listener);
  const auto report = run(*line, {.duration_s = 10.0});
  EXPECT_THAT(listener.told, Contains(HasSubstr("slave 1 (y): is not connected")));
  EXPECT_EQ(failure_of(report), "");
}

/// The telemetry of a run, as its consumers get it.
class Samples final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> samples) override {
    line.insert(line.end(), samples.begin(), samples.end());
  }
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) axis.at(sample.axis).push_back(sample);
  }
  std::vector<snapshot::LineSample> line;
  std::array<std::vector<snapshot::AxisSample>, 2> axis;
};

/// The drives do not send 606Ch, so the velocity is that of the positions.
TEST_F(CanRun, SamplesTellWhatAxesAndBusDo) {
  write(directory / "two.csv", "time[s],x[deg],y[rad]\n0,0,0\n4,200,5\n8,0,0\n");
  auto line = open(std::string(kTwoOnCan) + kTwoPath);
  Samples samples;
  line->add(samples);
  EXPECT_EQ(failure_of(run(*line)), "");
  ASSERT_GT(samples.line.size(), 4000U);
  const auto& last = samples.line[samples.line.size() / 2];
  EXPECT_EQ(last.expected_working_counter, 2U) << "one TPDO of each drive with SYNC";
  EXPECT_EQ(last.working_counter, 2U);
  EXPECT_GT(last.round_trip_ns, 0);
  EXPECT_GT(last.bus_load, 0.15F);
  EXPECT_LT(last.bus_load, 0.3F);
  EXPECT_EQ(last.bus_receive_errors, 0U);
  EXPECT_FALSE(last.dc_locked);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& axis = samples.axis.at(i);
    ASSERT_GT(axis.size(), 4000U) << i;
    double way = axis.front().actual_position;
    double fastest = 0.0;
    const auto half = axis.size() / 2;  // at its end the path is where it began
    for (std::size_t k = 1; k <= half; ++k) {
      way += axis[k].actual_velocity * static_cast<double>(axis[k].time_ns - axis[k - 1].time_ns) * 1e-9;
      fastest = std::max(fastest, std::abs(axis[k].actual_velocity));
    }
    EXPECT_NEAR(way, axis[half].actual_position, 0.01) << i;
    EXPECT_GT(way, 2.0) << i;
    EXPECT_GT(fastest, 1.0) << i;
    EXPECT_LT(fastest, 4.0) << i;
  }
}

TEST_F(CanRun, SamplesTellTheErrorCountersOfTheAdapter) {
  auto line = open(std::string(kTwoOnCan) + "[[fault]]\nat_ms = 3000\nkind = \"bit-error\"\nid = 0x185\ncount = 25\n");
  Samples samples;
  line->add(samples);
  run(*line, {.duration_s = 4.0});
  const auto disturbed = std::count_if(samples.line.begin(), samples.line.end(),
                                       [](const auto& sample) { return sample.bus_receive_errors > 0; });
  EXPECT_GT(disturbed, 0);
  EXPECT_LT(disturbed, 500) << "good frames count down";
}

/// The nodes as top, DDS and recordings show them: each by its node-ID, with its identity and its state, also while it
/// is gone and when it is back.
TEST_F(CanRun, TheTelemetryHasTheNodesAndTheirStates) {
  auto line = open(std::string(kTwoOnCan) +
                   "[recovery]\naxes = \"hold\"\n[[fault]]\nat_ms = 3000\nfor_ms = 700\nkind = \"power-off\"\nslave = "
                   "\"y\"\n");
  CanListener listener;
  std::optional<NodeFeed> feed;
  std::vector<std::pair<bool, int>> states;  // of y: whether it answers, and its state
  snapshot::FeedSlave x;
  listener.on_look = [&](int look) {
    if (!feed) feed.emplace(*line->can_master(), line->can_session()->clock());
    if (!feed->poll(look == 1)) return;
    ASSERT_EQ(feed->condition().slaves.size(), 2U);
    x = feed->condition().slaves[0];
    const auto& y = feed->condition().slaves[1];
    const std::pair<bool, int> state(y.answers != 0, y.al_state);
    if (states.empty() || states.back() != state) states.push_back(state);
    if (look == 1) {
      EXPECT_TRUE(feed->set_owners({"a script", ""}));
      EXPECT_FALSE(feed->set_owners({"a script", ""}));
      EXPECT_EQ(feed->condition().owners.at(0).name.view(), "a script");
    }
  };
  line->observe(listener);
  run(*line, {.duration_s = 8.0});
  EXPECT_EQ(x.name.view(), "x");
  EXPECT_EQ(x.device.view(), "node 5");
  EXPECT_EQ(x.station, 5U);
  EXPECT_EQ(x.vendor_id, line->config().slaves[0].device->identity().vendor_id);
  EXPECT_EQ(x.product_code, line->config().slaves[0].device->identity().product_code);
  EXPECT_EQ(x.parent, snapshot::kFeedParentMaster);
  EXPECT_EQ(x.answers, 1U);
  constexpr auto kOp = static_cast<int>(wire::AlState::kOp);
  ASSERT_GE(states.size(), 3U);
  EXPECT_EQ(states.front(), std::pair(true, kOp));
  EXPECT_THAT(states, Contains(testing::Field(&std::pair<bool, int>::first, false)));
  EXPECT_EQ(states.back(), std::pair(true, kOp));
}

/// The controller of an application drives an axis over CAN by positions.
TEST_F(CanRun, AnOwnControllerDrivesAnAxis) {
  constexpr double kWay = 0.75;   // rad
  constexpr double kTurns = 2.5;  // rad/s
  class Swing final : public Task {
   public:
    Result<void> prepare(const TaskSetup& setup) override {
      axis_ = setup.axes[0];
      return {};
    }
    void update(const motion::TaskCycle& now) noexcept override {
      const double position = now.axes[axis_.number].inputs().position;
      if (!axis_.drive->followed()) {
        if (time_s_ == 0.0) rest_ = position;
        return;
      }
      time_s_ += std::chrono::duration<double>(now.elapsed).count();
      const double angle = kTurns * time_s_;
      axis_.drive->command({rest_ + kWay * (1.0 - std::cos(angle)), kWay * kTurns * std::sin(angle), 0.0});
      farthest = std::max(farthest, position - rest_);
    }
    double farthest = 0.0;

   private:
    TaskAxis axis_;
    double rest_ = 0.0;
    double time_s_ = 0.0;
  };
  auto line = open(kTwoOnCan);
  Swing swing;
  ASSERT_TRUE(line->add(swing, {.name = "swing", .timing = {.divider = 2}, .drives = {"x"}}));
  const auto report = run(*line, {.duration_s = 4.0});
  EXPECT_EQ(failure_of(report), "");
  EXPECT_NEAR(swing.farthest, 1.5, 0.02);
  EXPECT_LT(report.axes[0].following_error_max / report.axes[0].increments_per_unit, 0.05);
}

/// Copies and tasks see the process data by name.
TEST_F(CanRun, ProcessDataHaveNames) {
  class Look final : public Task {
   public:
    Result<void> prepare(const TaskSetup& setup) override {
      const auto found = setup.process_data.find("x.6064h");
      if (!found) return fail(ErrorKind::kSetting, describe(found.error()));
      name = setup.process_data.full_name(*found);
      return {};
    }
    void update(const motion::TaskCycle&) noexcept override { ++cycles; }
    std::string name;
    int cycles = 0;
  };
  auto line = open(kTwoOnCan);
  Look look;
  ASSERT_TRUE(line->add(look, {.name = "look"}));
  EXPECT_EQ(failure_of(run(*line, {.duration_s = 0.2})), "");
  EXPECT_THAT(look.name, Not(testing::IsEmpty()));
  EXPECT_GT(look.cycles, 90);
}

}  // namespace
}  // namespace driveline::runtime
