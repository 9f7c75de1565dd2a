// Requests to the axes of a line on virtual time, and the resulting motion.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "driveline/runtime/event.hpp"
#include "failure_of.hpp"
#include "make_axis_request.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"
namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::PlcopenState;
using std::chrono::milliseconds;
using testing::Contains;
/// Observes a line, and calls a function in each poll until that returns true.
class Hand final : public Observer {
 public:
  void event(const Event& event) override { told.push_back(describe(event)); }
  void poll() override {
    if (on_look) on_look();
  }
  std::vector<std::string> told;
  std::function<void()> on_look;
};

class LineByHand : public test::TemporaryDirectory {
 protected:
  void open(const std::string& more = "", const std::string& keys = "") {
    std::string text = "[line]\ncycle_us = 1000\n";
    for (const auto* name : {"x", "y"}) text += std::string("[[slave]]\nname = \"") + name + "\"\n";
    for (const auto* name : {"x", "y"}) {
      text += std::string("[[axis]]\nname = \"") + name +
              "\"\nunit = \"deg\"\nmax_velocity = 720\nmax_acceleration = 7200\n" + keys;
    }
    auto opened = virtual_line(text + more, directory);
    ASSERT_TRUE(opened) << describe(opened.error());
    line = std::move(*opened);
    line->observe(hand);
  }
  /// The report of an axis; the default one as long as the line is not in operation.
  [[nodiscard]] motion::AxisReport look(std::size_t axis) {
    return line->axes().status(axis).report.value_or(motion::AxisReport{});
  }
  [[nodiscard]] PlcopenState state(std::size_t axis) { return look(axis).state; }
  [[nodiscard]] bool over(std::size_t axis, std::uint64_t request) {
    return line->axes().progress(axis, request).report.over();
  }
  RunReport run(bool enable = true) {
    Line::RunSettings settings;
    settings.duration_s = 10.0;
    settings.enable = enable;
    auto report = line->run(settings);
    EXPECT_TRUE(report) << describe(report.error());
    return report ? std::move(*report) : RunReport{};
  }

  std::unique_ptr<Line> line;
  Hand hand;
};

TEST_F(LineByHand, MovesOneAxisWhileTheOtherHoldsItsPlace) {
  open();
  std::uint64_t request = 0;
  double from = 0.0;
  double to = 0.0;
  double other = 0.0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (request == 0 && state(0) == PlcopenState::kStandstill && axes.status(0).owner.empty()) {
      from = look(0).position;
      other = look(1).position;
      request = axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.5)).value();
    }
    if (request == 0 || !over(0, request)) return;
    to = look(0).position;
    other -= look(1).position;
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(report.duration_s, 5.0);
  EXPECT_NEAR(to - from, 1.5, 0.01);
  EXPECT_NEAR(other, 0.0, 0.01);
  EXPECT_THAT(hand.told, Contains("hand: axis x: move_relative by 85.9437 deg"));
  EXPECT_THAT(hand.told, Contains("there is no [path]: the axes are enabled and hold their positions"));
  EXPECT_EQ(hand.told.back(), "all in INIT");
}

TEST_F(LineByHand, AxesStayOffUntilTheyAreAskedFor) {
  open();
  int looks = 0;
  std::uint64_t request = 0;
  hand.on_look = [&] {
    ++looks;
    if (looks == 50) {
      EXPECT_EQ(state(0), PlcopenState::kDisabled);
      request = line->axes().submit(caller("hand"), 0, ask(AxisCommand::kPower)).value();
    }
    if (request == 0 || !over(0, request)) return;
    EXPECT_EQ(state(0), PlcopenState::kStandstill);
    EXPECT_EQ(state(1), PlcopenState::kDisabled);
    line->request_stop();
  };
  EXPECT_EQ(failure_of(run(false)), "") << "nobody wanted the other one";
  EXPECT_GT(looks, 50);
}

TEST_F(LineByHand, WhoDiesWhileAnAxisMovesStopsIt) {
  open();
  int moving = 0;
  bool left = false;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (moving == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
    if (moving++ == 0) static_cast<void>(axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveVelocity, 3.0)));
    if (moving == 20) {
      EXPECT_EQ(state(0), PlcopenState::kContinuousMotion);
      axes.leave("hand", true);
      left = true;
    }
    if (!left || state(0) != PlcopenState::kStandstill) return;
    EXPECT_NEAR(look(0).velocity, 0.0, 0.2);
    EXPECT_EQ(axes.status(0).owner, "");
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_TRUE(left);
  EXPECT_LT(report.duration_s, 5.0) << "it has come to rest";
}

TEST_F(LineByHand, ARefusedTakeOverLeavesTheAxisAndItsMotionToItsOwner) {
  for (const int stays : {0, 1, 5}) {
    SCOPED_TRACE(stays);
    open();
    auto taker = caller("taker", milliseconds{500});
    taker.take_over = true;
    int moving = 0;
    std::uint64_t jog = 0;
    hand.on_look = [&] {
      auto& axes = line->axes();
      if (moving == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
      if (moving++ == 0) jog = axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveVelocity, 3.0)).value();
      // It homes at standstill only; the axis takes care of that.
      if (moving == 20) static_cast<void>(axes.submit(taker, 0, ask(AxisCommand::kHome)).value());
      if (moving == 20 + stays) axes.leave("taker", true);
      if (moving < 60) return;
      EXPECT_EQ(state(0), PlcopenState::kContinuousMotion);
      EXPECT_EQ(axes.progress(0, jog).report.phase, motion::RequestPhase::kReached);
      EXPECT_EQ(axes.status(0).owner, "hand");
      line->request_stop();
    };
    EXPECT_EQ(failure_of(run()), "");
    EXPECT_GE(moving, 60);
  }
}

TEST_F(LineByHand, WhoTakesOverAndGoesAtOnceLeavesTheAxisAtRest) {
  for (const int stays : {0, 1, 5}) {
    SCOPED_TRACE(stays);
    open();
    auto taker = caller("taker", milliseconds{500});
    taker.take_over = true;
    int moving = 0;
    hand.on_look = [&] {
      auto& axes = line->axes();
      if (moving == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
      if (moving++ == 0) static_cast<void>(axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveVelocity, 3.0)));
      if (moving == 20) static_cast<void>(axes.submit(taker, 0, ask(AxisCommand::kMoveVelocity, -3.0)).value());
      if (moving == 20 + stays) axes.leave("taker", true);
      if (moving < 200) return;
      EXPECT_EQ(state(0), PlcopenState::kStandstill);
      EXPECT_NE(axes.status(0).owner, "taker");
      line->request_stop();
    };
    EXPECT_EQ(failure_of(run()), "");
    EXPECT_GE(moving, 200);
  }
}

TEST_F(LineByHand, RequestThatTheAxisRefusesIsToldWithWhatToDo) {
  open();
  int looks = 0;
  hand.on_look = [&] {
    ++looks;
    if (looks == 10) static_cast<void>(line->axes().submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0)));
    if (looks == 20) line->request_stop();
  };
  const auto report = run(false);
  EXPECT_THAT(hand.told,
              Contains("hand: axis x: move_relative by 57.2958 deg: failed: the axis is not enabled; enable it "
                       "first"));
  EXPECT_EQ(failure_of(report), "") << "the line is well";
}

TEST_F(LineByHand, AnAxisHomesByItsDrive) {
  // Method 33: in negative direction to the next index pulse.
  open("[[slave.sdo]]\nindex = 0x6098\ntype = \"int8\"\nvalue = 33\n");
  std::uint64_t moved = 0;
  std::uint64_t homed = 0;
  bool homing = false;
  double place = 1e9;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (moved == 0 && state(1) == PlcopenState::kStandstill && axes.status(1).owner.empty())
      moved = axes.submit(caller("hand"), 1, ask(AxisCommand::kMoveRelative, 1.5)).value();
    if (moved != 0 && homed == 0 && over(1, moved))
      homed = axes.submit(caller("hand"), 1, ask(AxisCommand::kHome)).value();
    if (homed == 0) return;
    homing = homing || state(1) == PlcopenState::kHoming;
    if (!over(1, homed)) return;
    EXPECT_EQ(axes.progress(1, homed).report.phase, motion::RequestPhase::kDone);
    place = look(1).position;
    line->request_stop();
  };
  EXPECT_EQ(failure_of(run()), "");
  EXPECT_TRUE(homing);
  EXPECT_NEAR(place, 0.0, 0.2) << "it comes to rest a little behind the pulse";
  EXPECT_THAT(hand.told, Contains("hand: axis y: home"));
}

TEST_F(LineByHand, AnAxisIsLedByATorqueNoFasterThanItMay) {
  open("", "inertia = 3e-4\n");
  std::uint64_t pulled = 0;
  std::uint64_t halted = 0;
  int looks = 0;
  double fastest = 0.0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    if (pulled == 0 && (state(0) != PlcopenState::kStandstill || !axes.status(0).owner.empty())) return;
    auto request = ask(AxisCommand::kTorque, 0.5);
    request.velocity_si = 3.0;
    if (pulled == 0) pulled = axes.submit(caller("hand"), 0, request).value();
    fastest = std::max(fastest, look(0).velocity);
    if (++looks == 50) {
      EXPECT_EQ(state(0), PlcopenState::kContinuousMotion);
      EXPECT_EQ(axes.progress(0, pulled).report.phase, motion::RequestPhase::kReached);
      EXPECT_EQ(look(0).mode, 10);
      halted = axes.submit(caller("hand"), 0, ask(AxisCommand::kHalt)).value();
    }
    if (halted == 0 || !over(0, halted) || look(0).mode != 8) return;
    EXPECT_EQ(state(0), PlcopenState::kStandstill);
    line->request_stop();
  };
  const auto report = run();
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(report.duration_s, 5.0);
  EXPECT_GT(fastest, 1.0);
  EXPECT_LT(fastest, 3.1);
}

TEST_F(LineByHand, NoRequestLeavesTheSoftwareLimits) {
  open("", "min_position = -90\nmax_position = 90\n");
  const auto turn = std::numbers::pi;
  struct Step {
    AxisRequest request;
    std::string refusal{};  ///< immediate refusal
  };
  const std::vector<Step> steps{
      {ask(AxisCommand::kMoveAbsolute, 3.0 * turn),
       "axis x: position 540 deg is outside -90 deg to 90 deg (min_position, max_position)"},
      {ask(AxisCommand::kMoveAbsolute, 0.25 * turn)},
      {ask(AxisCommand::kMoveRelative, 0.5 * turn),
       "axis x: position 135 deg is outside -90 deg to 90 deg (min_position, max_position)"},
      {ask(AxisCommand::kMoveVelocity, 2.0)},
      {ask(AxisCommand::kSetPosition, 0.0)},
      {ask(AxisCommand::kMoveAbsolute, 0.1),
       "axis x: position 5.72958 deg is outside -180 deg to 0 deg (min_position, max_position)"},
  };
  std::size_t next = 0;
  std::uint64_t request = 0;
  double highest = 0.0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    highest = std::max(highest, std::abs(look(0).velocity));
    const bool ready =
        request != 0 ? over(0, request) : state(0) == PlcopenState::kStandstill && axes.status(0).owner.empty();
    if (!ready) return;
    while (next < steps.size()) {
      const auto& step = steps[next++];
      const auto taken = axes.submit(caller("hand"), 0, step.request);
      EXPECT_EQ(taken ? "" : describe(events::event_axis(line->config().axes[0]), taken.error()), step.refusal);
      if (!taken) continue;
      request = *taken;
      return;
    }
    line->request_stop();
  };
  EXPECT_EQ(failure_of(run()), "");
  EXPECT_EQ(next, steps.size());
  EXPECT_THAT(hand.told,
              Contains("hand: axis x: move_velocity 114.592 deg/s: failed: it would leave its software limits, "
                       "-90 deg to 90 deg"))
      << "it has come to rest there";
  EXPECT_GT(highest, 1.0);
}

TEST_F(LineByHand, ARelativePathThatLeavesTheSoftwareLimitsIsRefusedWhereItBegins) {
  write(directory / "path.csv", "time[s],x[deg],y[deg]\n0,0,0\n1,30,30\n2,0,0\n");
  open("[path]\nfile = \"path.csv\"\nrelative = true\n", "min_position = -20\nmax_position = 20\n");
  double highest = 0.0;
  hand.on_look = [] {};
  const auto report = run();
  for (const auto& axis : report.axes) highest = std::max(highest, axis.following_error_max);
  EXPECT_EQ(failure_of(report),
            "axis x: would go to 30 deg; its software limits are -20 deg and 20 deg (min_position, max_position); all "
            "axes stopped within them");
  EXPECT_LT(report.duration_s, 2.0);
  EXPECT_LT(highest, 100.0) << "nothing has moved";
}

TEST_F(LineByHand, AxisThatFailsLeavesTheOthersAloneAndTheReportTells) {
  open("[recovery]\naxes = \"continue\"\n[[fault]]\nat_ms = 3000\nkind = \"power-off\"\nslave = \"y\"\nfor_ms = 500\n");
  int failed = 0;
  hand.on_look = [&] {
    if (state(1) != PlcopenState::kErrorStop) return;
    ++failed;
    EXPECT_EQ(state(0), PlcopenState::kStandstill);
  };
  const auto report = run();
  EXPECT_GT(failed, 0);
  EXPECT_GE(report.duration_s, 10.0) << "the run goes on";
  EXPECT_THAT(hand.told,
              Contains("axis y: ErrorStop: the drive does not answer, or has left Operation enabled; it stops, "
                       "the other axes continue"));
  EXPECT_EQ(failure_of(report),
            "axis y: was in ErrorStop at the end: the drive does not answer, or has left Operation enabled");
  EXPECT_THAT(hand.told, Contains("all in INIT"));
}

TEST_F(LineByHand, NobodyMovesTheAxesOfAPath) {
  write(directory / "path.csv", "time[s],x[deg],y[deg]\n0,0,0\n1,30,30\n2,0,0\n");
  open("[path]\nfile = \"path.csv\"\nrelative = true\n");
  std::vector<std::string> refusals;
  int looks = 0;
  hand.on_look = [&] {
    auto& axes = line->axes();
    // The first poll is before any motion.
    if (axes.status(0).owner.empty()) return;
    EXPECT_EQ(axes.status(0).owner, "path");
    const auto taken = axes.submit(caller("hand"), 0, ask(AxisCommand::kMoveRelative, 1.0));
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().owner, "path");
    if (++looks == 30) static_cast<void>(axes.submit(caller("hand"), 0, ask(AxisCommand::kStop)));
  };
  EXPECT_EQ(failure_of(run()), "");
  EXPECT_EQ(looks, 30) << "a stop ends the run in order";
  EXPECT_THAT(hand.told, Contains("stop requested: taking the line down"));
}

}  // namespace
}  // namespace driveline::runtime
