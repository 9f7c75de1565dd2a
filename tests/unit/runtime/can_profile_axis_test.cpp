// Axes on a CAN bus whose drives have no interpolated position mode and plan their motions themselves: by what 6502h
// says in the data sheet of the drive, or by the line description.
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <numbers>

#include "driveline/esi/eds_file.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "failure_of.hpp"
#include "make_axis_request.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::PlcopenState;
using motion::RequestPhase;
using testing::HasSubstr;

/// Data sheet of a drive of CiA 402 without 60C1h, whose 6502h has this value, little-endian.
std::string profile_drive_eds(const std::string& supported_modes) {
  auto file = slaves::msd::can_description();
  file.device.vendor_id = 0x555;
  file.device.product_code = 0x402;
  auto& objects = file.device.objects;
  std::erase_if(objects, [](const esi::Object& object) { return object.index == 0x60C1 || object.index == 0x60C2; });
  for (auto& object : objects) {
    if (object.index == 0x6502) object.entries.at(0).default_hex = supported_modes;
    if (object.index != 0x1018) continue;
    object.entries.at(1).default_hex = "55050000";
    object.entries.at(2).default_hex = "02040000";
  }
  return esi::write_eds(file, "drive.eds");
}

constexpr auto kHead = R"([line]
name = "one"
[bus]
type = "can"
[telemetry]
enabled = false
[output]
plots = false
)";
constexpr auto kByEds = "[[slave]]\nname = \"x\"\nnode = 5\nmodel = \"eds\"\neds = \"drive.eds\"\n";
constexpr auto kMsd = "[[slave]]\nname = \"x\"\nnode = 5\n";
constexpr auto kAxis = "[[axis]]\nname = \"x\"\nmax_velocity = 12\nmax_acceleration = 240\n";

/// Steps one after the other, one look at the line at a time; the run stops after the last.
class Steps final : public Observer {
 public:
  explicit Steps(Line& line) : line_(line) {}
  void event(const Event& event) override { told.push_back(describe(event)); }
  void poll() override {
    if (line_.axes().status(0).report && next_ < steps.size() && steps[next_]()) ++next_;
    if (next_ == steps.size()) line_.request_stop();
  }
  /// Requests `command`, and waits for `phase`.
  void ask_until(AxisCommand command, double target, RequestPhase phase) {
    steps.emplace_back([this, command, target] {
      const auto owner = line_.axes().status(0).owner;
      if (state() == PlcopenState::kDisabled || (!owner.empty() && owner != "test")) return false;
      last_ = must(line_.axes().submit(caller("test"), 0, ask(command, target))).value();
      return true;
    });
    steps.emplace_back([this, phase] {
      const auto report = line_.axes().progress(0, last_).report;
      if (report.phase != phase && report.over()) {
        ADD_FAILURE() << to_text(report.phase) << ": " << to_text(report.error);
      }
      return report.phase == phase || report.over();
    });
  }
  void wait(int looks) {
    steps.emplace_back([left = looks]() mutable { return --left < 0; });
  }
  void note_position(double& place) {
    steps.emplace_back([this, &place] {
      place = report().position;
      return true;
    });
  }
  [[nodiscard]] motion::AxisReport report() { return line_.axes().status(0).report.value_or(motion::AxisReport{}); }
  [[nodiscard]] PlcopenState state() { return report().state; }

  std::vector<std::function<bool()>> steps;
  std::vector<std::string> told;

 private:
  Line& line_;
  std::size_t next_ = 0;
  std::uint64_t last_ = 0;
};

class CanProfileAxis : public test::TemporaryDirectory {
 protected:
  [[nodiscard]] std::unique_ptr<Line> open(const std::string& text) {
    return std::move(*must(virtual_line(kHead + text, directory)));
  }
  void write_drive(const std::string& supported_modes) {
    write(directory / "drive.eds", profile_drive_eds(supported_modes));
  }
  [[nodiscard]] std::string refusal(const std::string& text) {
    const auto config = parse_line_config(kHead + text, directory / "line.toml");
    return config ? "" : describe(config.error());
  }
  /// Moves, is halted on the way, and jogs.
  void move_and_halt(Line& line) {
    Steps steps(line);
    line.observe(steps);
    double from = 0.0;
    double there = 0.0;
    double halted = 0.0;
    double later = 0.0;
    double back = 0.0;
    double jogged = 0.0;
    steps.wait(20);
    steps.note_position(from);
    steps.ask_until(AxisCommand::kMoveRelative, 2.5, RequestPhase::kDone);
    steps.note_position(there);
    steps.ask_until(AxisCommand::kMoveRelative, 30.0, RequestPhase::kActive);
    steps.wait(20);
    steps.ask_until(AxisCommand::kHalt, 0.0, RequestPhase::kDone);
    steps.note_position(halted);
    steps.wait(40);
    steps.note_position(later);
    steps.ask_until(AxisCommand::kMoveAbsolute, 1.25, RequestPhase::kDone);
    steps.note_position(back);
    steps.ask_until(AxisCommand::kMoveVelocity, -3.5, RequestPhase::kReached);
    steps.wait(20);
    steps.ask_until(AxisCommand::kHalt, 0.0, RequestPhase::kDone);
    steps.note_position(jogged);
    const auto report = *must(line.run({.duration_s = 30.0}));
    EXPECT_EQ(failure_of(report), "");
    EXPECT_LT(report.duration_s, 20.0) << "all steps were taken";
    EXPECT_NEAR(there - from, 2.5, 0.02);
    EXPECT_GT(halted - there, 0.5);
    EXPECT_LT(halted - there, 25.0);
    EXPECT_NEAR(later, halted, 0.02) << "it does not go on to its old target";
    EXPECT_NEAR(back, 1.25, 0.02);
    EXPECT_LT(jogged, 0.5);
  }
};

/// 6502h: modes 1, 3 and 6.
TEST_F(CanProfileAxis, ADriveWithoutModeSevenPositionsByItself) {
  write_drive("25000000");
  auto line = open(std::string(kByEds) + kAxis);
  EXPECT_EQ(line->config().axes.at(0).mode, motion::cia402::Mode::kProfilePosition);
  move_and_halt(*line);
}

TEST_F(CanProfileAxis, AnMsdPositionsByItselfWhereItsAxisSaysSo) {
  auto line = open(std::string(kMsd) + kAxis + "mode = \"pp\"\n");
  move_and_halt(*line);
}

/// 6502h: mode 3.
TEST_F(CanProfileAxis, ADriveWithModeThreeAloneTurnsAtVelocities) {
  write_drive("04000000");
  auto line = open(std::string(kByEds) + kAxis);
  EXPECT_EQ(line->config().axes.at(0).mode, motion::cia402::Mode::kProfileVelocity);
  Steps steps(*line);
  line->observe(steps);
  double from = 0.0;
  double on_the_way = 0.0;
  double stopped = 0.0;
  double later = 0.0;
  steps.wait(20);
  steps.note_position(from);
  steps.ask_until(AxisCommand::kMoveVelocity, 4.5, RequestPhase::kReached);
  steps.wait(25);
  steps.note_position(on_the_way);
  steps.ask_until(AxisCommand::kHalt, 0.0, RequestPhase::kDone);
  steps.note_position(stopped);
  steps.wait(25);
  steps.note_position(later);
  steps.steps.emplace_back([&] {
    EXPECT_EQ(steps.state(), PlcopenState::kStandstill);
    const auto id = line->axes().submit(caller("test"), 0, ask(AxisCommand::kMoveAbsolute, 1.5));
    EXPECT_TRUE(id);
    return true;
  });
  steps.wait(5);
  const auto report = *must(line->run({.duration_s = 20.0}));
  EXPECT_EQ(failure_of(report), "");
  EXPECT_GT(on_the_way - from, 1.0);
  EXPECT_GE(stopped, on_the_way);
  EXPECT_NEAR(later, stopped, 0.02);
  EXPECT_THAT(steps.told, testing::Contains(HasSubstr("the drive does not support the required mode (6502h)")));
}

TEST_F(CanProfileAxis, WhatNeedsSetpointsIsRefusedWithASentence) {
  write_drive("05000000");
  auto line = open(std::string(kByEds) + kAxis);
  Steps steps(*line);
  line->observe(steps);
  std::vector<std::string> refusals;
  steps.wait(20);
  steps.steps.emplace_back([&] {
    for (const auto command : {AxisCommand::kMoveAdditive, AxisCommand::kMoveSuperimposed, AxisCommand::kSetOverride,
                               AxisCommand::kSetMode, AxisCommand::kHomeByProbe}) {
      const auto sent = line->axes().submit(caller("test"), 0, ask(command, 0.5));
      if (!sent) refusals.push_back(describe(events::event_axis(line->config().axes.at(0)), sent.error()));
    }
    return true;
  });
  EXPECT_EQ(failure_of(*must(line->run({.duration_s = 5.0}))), "");
  ASSERT_EQ(refusals.size(), 5U);
  for (const auto& refusal : refusals) {
    EXPECT_EQ(refusal,
              "axis x: the request needs setpoints, but its drive plans its motions itself; move, jog, home, halt and "
              "stop are possible");
  }
}

TEST_F(CanProfileAxis, WhatGivesSetpointsToAllAxesIsRefused) {
  class Push final : public Task {
   public:
    Result<void> prepare(const TaskSetup& /*setup*/) override { return {}; }
    void update(const motion::TaskCycle& /*now*/) noexcept override {}
  };
  write_drive("05000000");
  auto line = open(std::string(kByEds) + kAxis);
  Push push;
  ASSERT_TRUE(line->add(push, {.name = "push", .timing = {}, .drives = {"x"}}));
  EXPECT_THAT(failure_text(line->run({.duration_s = 1.0})),
              HasSubstr("the task of this run gives setpoints to all axes, but the drive of \"x\" plans its motions "
                        "itself (mode \"pp\")"));
}

/// 6502h: mode 6 alone.
TEST_F(CanProfileAxis, AModeThatTheDriveDoesNotHaveIsRefused) {
  write_drive("20000000");
  EXPECT_THAT(refusal(std::string(kByEds) + kAxis),
              HasSubstr("slave: 6502h of \"x\" is 0x00000020 in its data sheet: it does not have \"ip\" (interpolated "
                        "position), \"pp\" (profile position) or \"pv\" (profile velocity)"));
  write_drive("04000000");
  EXPECT_THAT(refusal(std::string(kByEds) + kAxis + "mode = \"ip\"\n"),
              HasSubstr("mode: 6502h of \"x\" is 0x00000004 in its data sheet: it does not have mode \"ip\""));
}

}  // namespace
}  // namespace driveline::runtime
