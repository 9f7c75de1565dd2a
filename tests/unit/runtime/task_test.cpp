// Tasks of an application in the cycle of a line: input, driven axes, refusals.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "driveline/runtime/line.hpp"
#include "failure_of.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using motion::TaskCycle;
using motion::TaskTiming;
using testing::HasSubstr;

constexpr auto kSlaves = "[[slave]]\nname = \"x\"\nmodel = \"msd\"\n[[slave]]\nname = \"y\"\nmodel = \"msd\"\n";
constexpr auto kTorqueAxes =
    "[[axis]]\nname = \"x\"\nslave = \"x\"\nmode = \"cst\"\nvelocity_gain = 0.1\n"
    "[[axis]]\nname = \"y\"\nslave = \"y\"\nmode = \"cst\"\nvelocity_gain = 0.1\n";
constexpr auto kPositionAxes =
    "[[axis]]\nname = \"x\"\nslave = \"x\"\n[[axis]]\nname = \"y\"\nslave = \"y\"\nmax_velocity = 60\n";

/// Spring and damper that pull an axis by torque to a position 1 rad from its start.
class Pull final : public Task {
 public:
  Result<void> prepare(const TaskSetup& setup) override {
    for (const auto& axis : setup.axes) axes_.push_back(axis);
    return {};
  }
  void update(const TaskCycle& now) noexcept override {
    for (const auto& axis : axes_) {
      const auto& inputs = now.axes[axis.number].inputs();
      if (!axis.drive->followed()) {
        // The line is shut down after the last command.
        if (!began_) begin = inputs.position;
        continue;
      }
      began_ = true;
      place = inputs.position;
      const double torque = 0.5 * (begin + 1.0 - inputs.position) - 0.02 * inputs.velocity;
      axis.drive->command({inputs.position, inputs.velocity, 0.0, torque});
    }
  }
  double begin = 0.0;
  double place = 0.0;

 private:
  std::vector<TaskAxis> axes_;
  bool began_ = false;
};

/// Moves an axis along a ramp of positions.
class Ramp final : public Task {
 public:
  double velocity = 2.0;          ///< rad/s
  double wrong_after_s = 1000.0;  ///< then not a number

  Result<void> prepare(const TaskSetup& setup) override {
    axis_ = setup.axes[0];
    return {};
  }
  void update(const TaskCycle& now) noexcept override {
    if (!axis_.drive->followed()) {
      place_ = now.axes[axis_.number].inputs().position;
      time_s_ = 0.0;
      return;
    }
    const double step_s = std::chrono::duration<double>(now.elapsed).count();
    time_s_ += step_s;
    place_ += velocity * step_s;
    if (time_s_ > wrong_after_s) place_ = std::numeric_limits<double>::quiet_NaN();
    axis_.drive->command({place_, velocity, 0.0});
  }

 private:
  TaskAxis axis_;
  double place_ = 0.0;
  double time_s_ = 0.0;
};

/// Checks all of its inputs.
class Witness final : public Task {
 public:
  explicit Witness(std::string variable = {}) : variable_(std::move(variable)) {}
  Result<void> prepare(const TaskSetup& setup) override {
    slaves = setup.config.slaves.size();
    if (variable_.empty()) return {};
    const auto found = setup.process_data.entry<std::int32_t>(variable_);
    if (!found) return fail(ErrorKind::kSetting, ecat_master::describe(found.error()));
    entry_ = *found;
    return {};
  }
  void update(const TaskCycle& now) noexcept override {
    ++calls;
    missed += now.missed;
    if (calls > 1) steps_wrong += now.elapsed == now.grid - last_grid_ ? 0 : 1;
    if (calls > 1 && now.system_time_ns) {
      const auto step = static_cast<std::int64_t>(*now.system_time_ns - last_system_time_);
      dc_steps_wrong += std::abs(step - now.elapsed.count()) < 1000 ? 0 : 1;
    }
    last_grid_ = now.grid;
    last_system_time_ = now.system_time_ns.value_or(0);
    has_system_time = now.system_time_ns.has_value();
    for (const bool valid : now.valid) all_valid = all_valid && valid;
    if (entry_) increments = entry_->get(now.inputs);
    if (now.axes.empty()) return;
    position = now.axes[0].inputs().position;
    most_ahead = std::max(most_ahead, now.setpoints[0].position - position);
    scale = now.axes[0].config().increments_per_unit;
  }
  std::size_t slaves = 0;
  std::uint64_t calls = 0;
  std::int64_t missed = 0;
  int steps_wrong = 0;
  int dc_steps_wrong = 0;
  bool has_system_time = false;
  bool all_valid = true;
  std::int32_t increments = 0;
  double position = 0.0;
  double most_ahead = 0.0;  ///< largest lead of the setpoint over the position, rad
  double scale = 0.0;

 private:
  std::string variable_;
  std::optional<motion::PdoEntry<std::int32_t>> entry_;
  std::chrono::nanoseconds last_grid_{};
  std::uint64_t last_system_time_ = 0;
};

/// The largest steps of the setpoints, by axis.
class Steps final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      if (sample.axis >= 2 || sample.state != snapshot::AxisState::kOperationEnabled) continue;
      auto& last = last_[sample.axis];
      const double step = std::abs(target_of(sample) - last.value_or(target_of(sample)));
      highest[sample.axis] = std::max(highest[sample.axis], step);
      last = target_of(sample);
    }
  }
  static double target_of(const snapshot::AxisSample& sample) { return sample.target_position; }
  double highest[2] = {0.0, 0.0};

 private:
  std::optional<double> last_[2];
};

class TaskTest : public test::TemporaryDirectory {
 protected:
  [[nodiscard]] std::unique_ptr<Line> open(const std::string& text) {
    auto line = virtual_line(text, directory);
    EXPECT_TRUE(line) << describe(line.error());
    return std::move(*line);
  }
  [[nodiscard]] static RunReport run(Line& line, double duration_s) {
    Line::RunSettings settings;
    settings.duration_s = duration_s;
    auto report = line.run(settings);
    EXPECT_TRUE(report) << describe(report.error());
    return report ? *report : RunReport{};
  }
  /// The error of a call that must be refused.
  static std::string refusal(const Result<void>& result) {
    EXPECT_FALSE(result);
    if (result) return {};
    EXPECT_EQ(result.error().kind, ErrorKind::kCall);
    return describe(result.error());
  }
};

TEST_F(TaskTest, AControllerDrivesAnAxisByTorqueInEveryCycle) {
  auto line = open(std::string(kSlaves) + kTorqueAxes);
  Pull pull;
  ASSERT_TRUE(line->add(pull, {"pull", {}, {"x"}}));
  const auto report = run(*line, 2.0);
  EXPECT_EQ(failure_of(report), "");
  EXPECT_NEAR(pull.place, pull.begin + 1.0, 0.1);
  ASSERT_EQ(report.tasks.size(), 1U);
  EXPECT_EQ(report.tasks[0].name, "pull");
  EXPECT_GE(report.tasks[0].figures.calls, report.statistics.cycles);
  EXPECT_EQ(report.tasks[0].figures.cost.count(), report.tasks[0].figures.calls);
}

TEST_F(TaskTest, TheSameAtOneKilohertz) {
  auto line = open(std::string(kSlaves) + kTorqueAxes);
  Pull pull;
  ASSERT_TRUE(line->add(pull, {"pull", {8, 5}, {"y"}}));
  const auto report = run(*line, 2.0);
  EXPECT_EQ(failure_of(report), "");
  EXPECT_NEAR(pull.place, pull.begin + 1.0, 0.1);
  EXPECT_NEAR(static_cast<double>(report.tasks[0].figures.calls), static_cast<double>(report.statistics.cycles) / 8.0,
              static_cast<double>(report.statistics.cycles) / 100.0);
}

TEST_F(TaskTest, PositionsOfASlowTaskReachTheDriveWithoutSteps) {
  auto line = open(std::string(kSlaves) + kPositionAxes);
  Ramp ramp;
  Steps steps;
  line->add(steps);
  ASSERT_TRUE(line->add(ramp, {"ramp", {8, 0}, {"x"}}));
  const auto report = run(*line, 1.0);
  EXPECT_EQ(failure_of(report), "");
  EXPECT_GT(steps.highest[0], 0.9 * 2.0 * 125e-6);
  EXPECT_LT(steps.highest[0], 1.1 * 2.0 * 125e-6) << "rad in one cycle, not the eight of a call";
  EXPECT_LT(steps.highest[1], 1e-9) << "an axis that nobody drives holds its place";
  EXPECT_GT(report.axes[0].following_error_max, 0.0) << "telemetry and figures are those of any axis";
}

TEST_F(TaskTest, WhatATaskCommandsIsKeptWithinTheLimits) {
  auto line = open(std::string(kSlaves) + kPositionAxes);
  Ramp ramp;
  ramp.velocity = 100.0;
  ASSERT_TRUE(line->add(ramp, {"ramp", {}, {"y"}}));
  const auto fast = run(*line, 1.0);
  EXPECT_THAT(failure_of(fast), HasSubstr("y"));
  EXPECT_THAT(fast.files, testing::Contains(testing::Key("flight_recorder_csv")));
  line.reset();
  auto other = open(std::string(kSlaves) + kPositionAxes);
  Ramp wrong;
  wrong.wrong_after_s = 0.1;
  ASSERT_TRUE(other->add(wrong, {"ramp", {8, 0}, {"x"}}));
  EXPECT_THAT(failure_of(run(*other, 1.0)), HasSubstr("x"));
}

TEST_F(TaskTest, IsGivenTimesProcessDataAndAxes) {
  auto line = open(std::string("[dc]\n") + kSlaves + kPositionAxes);
  Ramp ramp;
  Witness before("x.position_actual_value");
  Witness behind;
  ASSERT_TRUE(line->add(ramp, {"ramp", {}, {"x"}}));
  ASSERT_TRUE(line->add(before, {"before", {}, {}}));
  ASSERT_TRUE(line->add(behind, {"behind", {4, 1, TaskTiming::Order::kAfterMotion}, {}}));
  EXPECT_EQ(failure_of(run(*line, 1.0)), "");
  EXPECT_EQ(before.slaves, 2U);
  EXPECT_TRUE(before.has_system_time);
  EXPECT_EQ(before.dc_steps_wrong, 0);
  EXPECT_NEAR(static_cast<double>(before.calls), 4.0 * static_cast<double>(behind.calls), 4.0);
  EXPECT_EQ(before.missed, 0);
  EXPECT_NEAR(before.position, before.increments / before.scale, 1e-9) << "SI units and process data are the same";
  // The drive lags its setpoints by two cycles; a task after the motion sees one more cycle.
  EXPECT_NEAR(behind.most_ahead - before.most_ahead, 2.0 * 125e-6, 50e-6);
}

TEST_F(TaskTest, RunsOnALineWithoutAxesAndClocks) {
  auto line = open(kSlaves);
  Witness witness;
  ASSERT_TRUE(line->add(witness, {"witness", {}, {}}));
  EXPECT_EQ(failure_of(run(*line, 0.1)), "");
  EXPECT_GE(witness.calls, 800U);
  EXPECT_FALSE(witness.has_system_time);
  EXPECT_EQ(witness.steps_wrong, 0);
}

TEST_F(TaskTest, ATaskThatCannotGetReadyEndsTheRunBeforeAnythingMoves) {
  auto line = open(std::string(kSlaves) + kPositionAxes);
  Witness witness("x.position_of_the_moon");
  ASSERT_TRUE(line->add(witness, {"witness", {}, {}}));
  const auto report = line->run();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, ErrorKind::kSetting);
  EXPECT_THAT(describe(report.error()), HasSubstr("task \"witness\""));
  EXPECT_THAT(describe(report.error()), HasSubstr("position_of_the_moon"));
  EXPECT_EQ(witness.calls, 0U);
  EXPECT_THAT(files(), testing::IsEmpty()) << "nothing is half-started";
}

TEST_F(TaskTest, MisuseIsAnErrorWithItsFacts) {
  auto line = open(std::string(kSlaves) + kTorqueAxes);
  Pull one;
  Pull two;
  EXPECT_THAT(refusal(line->add(one, {"", {}, {}})), HasSubstr("needs a name"));
  EXPECT_THAT(refusal(line->add(one, {"one", {0, 0}, {}})), HasSubstr("the divider is 0; 1 (every cycle) or more"));
  EXPECT_THAT(refusal(line->add(one, {"one", {4, 4}, {}})), HasSubstr("phase 4 of a divider of 4; 0 to 3"));
  EXPECT_THAT(refusal(line->add(one, {"one", {}, {"w"}})),
              HasSubstr("no axis \"w\" to drive; the line has \"x\", \"y\""));
  EXPECT_THAT(refusal(line->add(one, {"one", {}, {"x", "x"}})), HasSubstr("driven by the task \"one\" already"));
  ASSERT_TRUE(line->add(one, {"one", {}, {"x"}})) << "nothing of the refused calls is left";
  EXPECT_THAT(refusal(line->add(two, {"one", {}, {"y"}})), HasSubstr("the name \"one\" belongs to another task"));
  EXPECT_THAT(refusal(line->add(one, {"two", {}, {"y"}})), HasSubstr("already added with the name \"one\""));
  EXPECT_THAT(refusal(line->add(two, {"two", {}, {"y", "x"}})), HasSubstr("axis \"x\" is driven by the task \"one\""));
  motion::DrivenAxes source({1, 1}, 125e-6);
  EXPECT_THAT(refusal(line->use(source)), HasSubstr("a task drives the axes"));
  static_cast<void>(run(*line, 0.05));
  EXPECT_THAT(refusal(line->add(two, {"two", {}, {"y"}})), HasSubstr("runs or has run"));
}

TEST_F(TaskTest, TwoSourcesOfSetpointsAreRefused) {
  write(directory / "x.csv", "time[s],x[rad],y[rad]\n0,0,0\n0.2,0.5,0\n");
  auto line = open(std::string(kSlaves) + kPositionAxes + "[path]\nfile = \"x.csv\"\n");
  Pull pull;
  EXPECT_THAT(refusal(line->add(pull, {"pull", {}, {"x"}})), HasSubstr("[path]"));
  EXPECT_TRUE(line->add(pull, {"pull", {}, {}})) << "one that drives nothing does no harm";
  auto other = open(std::string(kSlaves) + kPositionAxes);
  motion::DrivenAxes source({1, 1}, 125e-6);
  ASSERT_TRUE(other->use(source));
  EXPECT_THAT(refusal(other->add(pull, {"pull", {}, {"x"}})), HasSubstr("another source of setpoints"));
}

/// A task is passed while the line runs: the call comes from within it.
TEST_F(TaskTest, NoTaskIsAddedWhileTheLineRuns) {
  auto line = open(std::string(kSlaves) + kPositionAxes);
  Pull late;
  struct Adder final : Observer {
    void poll() override {
      if (told.empty()) told = refusal(line->add(*task, {"late", {}, {}}));
    }
    Line* line = nullptr;
    Task* task = nullptr;
    std::string told;
  } adder;
  adder.line = line.get();
  adder.task = &late;
  line->observe(adder);
  static_cast<void>(run(*line, 0.1));
  EXPECT_THAT(adder.told, HasSubstr("runs or has run"));
}

}  // namespace
}  // namespace driveline::runtime
