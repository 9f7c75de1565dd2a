// A line from its description to its report, as used by an application.
#include "driveline/runtime/line.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "driveline/runtime/files/output_file.hpp"
#include "failure_of.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using motion::SetpointCycle;
using testing::Contains;
using testing::HasSubstr;
using trajectory::AxisSetpoint;

constexpr auto kSlave = "[[slave]]\nname = \"x\"\nmodel = \"msd\"\n";
constexpr auto kAxis = "[[axis]]\nname = \"x\"\nslave = \"x\"\n";

/// Pulls an axis by torque to a position 1 rad from its start, for a second.
class Spring final : public motion::SetpointSource {
 public:
  explicit Spring(std::size_t axes) : axes_(axes) {}
  [[nodiscard]] std::size_t axis_count() const noexcept override { return axes_; }
  void rewind(std::span<AxisSetpoint> first) noexcept override { goal_ = first[0].position + 1.0; }
  void begin(bool) noexcept override {}
  void end() noexcept override {}
  void run(bool) noexcept override {}
  void fall_behind(double) noexcept override {}
  [[nodiscard]] double behind_s() const noexcept override { return 0.0; }
  [[nodiscard]] bool next(const SetpointCycle& cycle, std::span<AxisSetpoint> setpoints) noexcept override {
    const auto& now = cycle.axes[0].inputs();
    place = now.position;
    const double torque = 0.5 * (goal_ - now.position) - 0.02 * now.velocity;
    setpoints[0] = {now.position, now.velocity, 0.0, torque};
    return cycle.time_s < 1.0;
  }
  [[nodiscard]] double goal() const noexcept { return goal_; }
  double place = 0.0;

 private:
  std::size_t axes_;
  double goal_ = 0.0;
};

class Counter final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> samples) override { lines_seen += samples.size(); }
  void axes(std::span<const snapshot::AxisSample> samples) override { axes_seen += samples.size(); }
  void set_line_status(const snapshot::LineStatus& status) override { highest = std::max(highest, status.state); }
  std::size_t lines_seen = 0;
  std::size_t axes_seen = 0;
  snapshot::LineState highest = snapshot::LineState::kDown;
};

class Listener final : public Observer {
 public:
  void event(const Event& event) override { told.push_back(describe(event)); }
  void poll() override {
    if (on_look) on_look(++looks);
  }
  std::vector<std::string> told;
  std::function<void(int)> on_look;
  int looks = 0;
};

class LineTest : public test::TemporaryDirectory {
 protected:
  [[nodiscard]] Result<std::unique_ptr<Line>> open(const std::string& text) { return virtual_line(text, directory); }
};

TEST_F(LineTest, RunsAndReports) {
  write(directory / "x.csv", "time[s],x[rad]\n0,0\n0.2,0.5\n0.4,0\n");
  auto line = must(open(std::string(kSlave) + kAxis + "[path]\nfile = \"x.csv\"\nrelative = true\n"));
  Counter counter;
  Listener listener;
  (*line)->add(counter);
  (*line)->observe(listener);
  const auto report = must((*line)->run());
  EXPECT_EQ(failure_of(*report), "");
  EXPECT_EQ(report->state, "OP");
  ASSERT_EQ(report->axes.size(), 1U);
  EXPECT_GT(report->axes[0].following_error_max, 0.0);
  EXPECT_GT(report->statistics.cycles, 3000U);
  EXPECT_GE(counter.lines_seen, report->statistics.cycles);
  EXPECT_EQ(counter.axes_seen, counter.lines_seen);
  EXPECT_EQ(counter.highest, snapshot::LineState::kOp);
  EXPECT_THAT(listener.told, Contains("1 slave found"));
  EXPECT_THAT(listener.told, Contains("all in OP"));
  EXPECT_EQ(listener.told.back(), "all in INIT");
  EXPECT_TRUE(report->files.contains("axes_csv"));
}

TEST_F(LineTest, TellsOfAFaultWithItsFactsAndTime) {
  write(directory / "x.csv", "time[s],x[rad]\n0,0\n10,1\n");
  auto line = must(open(std::string(kSlave) + kAxis +
                        "[path]\nfile = \"x.csv\"\nrelative = true\n"
                        "[[fault]]\nat_ms = 1000\nkind = \"power-off\"\nslave = \"x\"\n"));
  Listener listener;
  (*line)->observe(listener);
  const auto report = must((*line)->run({.duration_s = 5.0, .force = false}));
  const auto* failure = report->failure();
  ASSERT_NE(failure, nullptr);
  const auto* stopped = failure->as<events::AxesStopped>();
  ASSERT_NE(stopped, nullptr) << describe(*failure);
  EXPECT_EQ(stopped->axis.name, "x");
  EXPECT_EQ(stopped->failure.cause, motion::MotionFailure::Cause::kCommunication);
  ASSERT_TRUE(failure->time);
  EXPECT_GT(*failure->time, std::chrono::milliseconds{100});
  EXPECT_LT(*failure->time, std::chrono::seconds{2});
  EXPECT_THAT(listener.told, Contains(describe(*failure)));
  for (const auto& event : report->events) EXPECT_NE(event.severity, Severity::kProgress) << describe(event);
}

TEST_F(LineTest, TellsWhatTheDrivesOfASlaveSay) {
  const std::string slave =
      "[[slave]]\nname = \"y\"\ndevice = \"SD1\"\nesi = \"" DRIVELINE_EXAMPLES_DIR "/soe_drive.xml\"\n";
  auto line =
      must(open("[recovery]\naxes = \"hold\"\n" + slave + "[[fault]]\nat_ms = 1000\nfor_ms = 400\nkind = \"drop\"\n"));
  Listener listener;
  (*line)->observe(listener);
  const auto report = must((*line)->run({.duration_s = 3.0, .force = false}));
  std::vector<unsigned> drives;
  for (const auto& event : report->events) {
    const auto* said = event.as<events::SoeMessage>();
    if (said == nullptr) continue;
    drives.push_back(said->record.drive);
    EXPECT_TRUE(event.time);
    EXPECT_THAT(listener.told, Contains(describe(event)));
  }
  EXPECT_THAT(drives, testing::ElementsAre(0, 1));
  EXPECT_THAT(listener.told, Contains("slave 0 (y): drive 1: emergency 0x7500, error register 0x10, 00 00 00 00 00"));
}

TEST_F(LineTest, FollowsAControllerOfItsUser) {
  auto line = must(open(std::string(kSlave) + kAxis + "mode = \"cst\"\nvelocity_gain = 0.1\n"));
  Spring spring(1);
  ASSERT_TRUE((*line)->use(spring));
  const auto report = must((*line)->run());
  EXPECT_EQ(failure_of(*report), "");
  EXPECT_NEAR(spring.place, spring.goal(), 0.1);
  EXPECT_GT(report->duration_s, 1.0) << "it ends when its source does";
  EXPECT_LT(report->duration_s, 2.0);
}

TEST_F(LineTest, EndsWhenItIsAskedTo) {
  auto line = must(open(std::string(kSlave) + kAxis));
  Listener listener;
  std::size_t slaves = 0;
  listener.on_look = [&](int look) {
    if (look == 20) slaves = (*line)->diagnose()->slaves.size();
    if (look == 30) (*line)->request_stop();
  };
  (*line)->observe(listener);
  const auto report = must((*line)->run());
  EXPECT_EQ(failure_of(*report), "");
  EXPECT_EQ(slaves, 1U) << "it answers while it runs";
  EXPECT_NEAR(report->duration_s, 0.58, 0.03);
  EXPECT_EQ(listener.told.back(), "all in INIT");
}

/// They were those of a copy that is never exchanged, and therefore always 0.
TEST_F(LineTest, ReportsTheInputsOfALineWithoutAxesAsTheyWereAtTheEnd) {
  std::filesystem::copy_file(std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / "terminals.xml",
                             directory / "terminals.xml");
  auto line =
      must(open("[[slave]]\nname = \"ai\"\nesi = \"terminals.xml\"\ndevice = \"AI2\"\n"
                "[[slave.input]]\nentry = \"Channel 1/Value\"\nvalue = 1234\n"));
  Line::RunSettings shortly;
  shortly.duration_s = 0.05;
  const auto report = must((*line)->run(shortly));
  EXPECT_TRUE(std::any_of(report->inputs.begin(), report->inputs.end(),
                          [](const InputValue& input) { return input.bits == 16 && input.value == 1234U; }));
}

TEST_F(LineTest, MisuseIsAnErrorWithItsFacts) {
  auto line = must(open(std::string(kSlave) + kAxis));
  EXPECT_EQ((*line)->diagnose().error().kind, ErrorKind::kCall) << "before it runs";
  Spring two(2);
  const auto wrong = (*line)->use(two);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().kind, ErrorKind::kCall);
  EXPECT_THAT(describe(wrong.error()), HasSubstr("moves 2 axes, the line has 1"));
  Line::RunSettings shortly;
  shortly.duration_s = 0.05;
  ASSERT_TRUE((*line)->run(shortly));
  EXPECT_EQ((*line)->diagnose().error().kind, ErrorKind::kCall) << "after it has run";
  EXPECT_EQ((*line)->run().error().kind, ErrorKind::kCall) << "a second run takes a second line";
  Spring one(1);
  EXPECT_EQ((*line)->use(one).error().kind, ErrorKind::kCall);
}

TEST_F(LineTest, FilesThatAreNotThereOrWrongAreNamed) {
  const auto missing = Line::from_file(directory / "no.toml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::kFile);
  EXPECT_EQ(missing.error().file, directory / "no.toml");
  write(directory / "wrong.toml", std::string(kSlave) + "colour = \"red\"\n");
  const auto wrong = Line::from_file(directory / "wrong.toml");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().kind, ErrorKind::kFile);
  EXPECT_EQ(wrong.error().line, 4U);
  EXPECT_THAT(files(), testing::ElementsAre("wrong.toml")) << "nothing is half-started";
}

TEST_F(LineTest, AnotherRunsFolderIsAnErrorAndLeavesTheLineAlone) {
  std::filesystem::create_directory(directory / "out");
  const auto lock = must(FolderLock::take(directory / "out"));
  auto line = must(open(std::string(kSlave) + kAxis));
  const auto report = (*line)->run();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, ErrorKind::kFolderBusy);
}

}  // namespace
}  // namespace driveline::runtime
