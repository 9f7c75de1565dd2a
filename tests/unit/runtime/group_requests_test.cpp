// Requests to groups of axes of a line on virtual time: permitted callers, refusals, and the group staying on its path
// whatever happens to the caller.
#include "driveline/runtime/groups/group_requests.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "failure_of.hpp"
#include "make_axis_request.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::AxisRequest;
using motion::GroupState;
using motion::PlcopenState;
using motion::RequestPhase;
using std::chrono::milliseconds;
using testing::Contains;
using testing::HasSubstr;
using trajectory::PathMove;
using Verb = ClientGroupRequest::Verb;

ClientGroupRequest ask(Verb verb, double share = 1.0) {
  ClientGroupRequest request;
  request.verb = verb;
  request.share = share;
  return request;
}

ClientGroupRequest move_to(double x, double y, double feed = 0.0) {
  ClientGroupRequest request;
  request.verb = Verb::kMove;
  request.move.path.target = {x, y};
  request.move.path.feed = feed;
  return request;
}

PathMove line_to(double x, double y, double tolerance = 0.0) {
  PathMove move;
  move.target = {x, y};
  move.feed = std::numeric_limits<double>::infinity();
  move.tolerance = tolerance;
  return move;
}

/// Setpoints of two axes in each cycle, m; called by another thread.
class Way final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> /*samples*/) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      if (sample.axis > 1) continue;
      at_.at(sample.axis) = sample.target_position;
      if (sample.axis != 1) continue;
      points.push_back(at_);
      states.push_back(sample.plcopen_state);
      count = points.size();
    }
  }
  /// The last point in the group: without power the target is the actual position, off by some increments.
  [[nodiscard]] std::array<double, 2> end() const {
    for (auto i = points.size(); i-- > 0;) {
      if (states[i] == snapshot::SampledPlcopenState::kSynchronizedMotion) return points[i];
    }
    return {-1.0, -1.0};
  }
  std::atomic<std::size_t> count = 0;  // also read while the line runs
  std::vector<std::array<double, 2>> points;
  std::vector<snapshot::SampledPlcopenState> states;

 private:
  std::array<double, 2> at_{};
};

class Hand final : public Observer {
 public:
  void event(const Event& event) override {
    told.push_back(describe(event));
    events.push_back(event);
  }
  void poll() override {
    if (on_look) on_look();
  }
  std::vector<std::string> told;
  std::vector<Event> events;
  std::function<void()> on_look;
};

class GroupByHand : public test::TemporaryDirectory {
 protected:
  void open(const std::string& more = "", const std::string& keys = "") {
    std::string text = "[line]\ncycle_us = 1000\n[recovery]\naxes = \"continue\"\n";
    // On the wire y is the last one, so that the others stay reachable without it.
    for (const auto* name : {"x", "z", "y"}) text += std::string("[[slave]]\nname = \"") + name + "\"\n";
    for (const auto* name : {"x", "y", "z"}) {
      text += std::string("[[axis]]\nname = \"") + name +
              "\"\nfeed_mm_per_revolution = 10\nunit = \"mm\"\nmax_velocity = 500\nmax_acceleration = 5000\n"
              "max_jerk = 1000000\n" +
              keys;
    }
    text += "[[axis_group]]\nname = \"plotter\"\naxes = [\"x\", \"y\"]\nmax_feed = 100\n";
    auto opened = virtual_line(text + more, directory);
    ASSERT_TRUE(opened) << describe(opened.error());
    line = std::move(*opened);
    line->observe(hand);
    line->add(way);
  }
  /// The report of the group, of an axis; the default one as long as the line is not in operation.
  [[nodiscard]] motion::GroupReport look() { return line->groups().status(0).report.value_or(motion::GroupReport{}); }
  [[nodiscard]] motion::AxisReport look(std::size_t axis) {
    return line->axes().status(axis).report.value_or(motion::AxisReport{});
  }
  [[nodiscard]] GroupState state() { return look().state; }
  [[nodiscard]] double place(std::size_t axis) { return line->groups().status(0).setpoint.at(axis); }
  [[nodiscard]] std::uint64_t submit(const ClientGroupRequest& request, const std::string& who = "hand") {
    const auto taken = line->groups().submit(caller(who), 0, request);
    EXPECT_TRUE(taken) << describe(line->groups().event_group(0), taken.error());
    return taken.value_or(0);
  }
  [[nodiscard]] std::string refusal(const ClientGroupRequest& request, const std::string& who = "hand") {
    const auto taken = line->groups().submit(caller(who), 0, request);
    return taken ? "" : describe(line->groups().event_group(0), taken.error());
  }
  [[nodiscard]] bool over(std::uint64_t request) { return line->groups().progress(0, request).report.over(); }
  [[nodiscard]] RequestPhase phase(std::uint64_t request) { return line->groups().progress(0, request).report.phase; }
  /// Why a request failed.
  [[nodiscard]] std::string failure(std::uint64_t request) {
    const auto progress = line->groups().progress(0, request);
    return progress.refusal ? describe(line->groups().event_group(0), *progress.refusal) : "";
  }

  /// Enables the group, takes it to the origin of x and y, and then executes one step after the other, each until it
  /// returns true; then ends the run.
  RunReport run(std::vector<std::function<bool()>> steps) {
    std::uint64_t request = 0;
    steps.insert(steps.begin(), {
                                    [this] {
                                      return look(0).state == PlcopenState::kStandstill &&
                                             look(1).state == PlcopenState::kStandstill &&
                                             line->axes().status(1).owner.empty();
                                    },
                                    [this, &request] {
                                      request = submit(ask(Verb::kEnable));
                                      return true;
                                    },
                                    [this, &request] { return over(request); },
                                    [this, &request] {
                                      request = submit(move_to(0.0, 0.0));
                                      return true;
                                    },
                                    [this, &request] { return over(request); },
                                });
    std::size_t next = 0;
    hand.on_look = [this, &steps, &next] {
      while (next < steps.size() && steps[next]()) ++next;
      if (next == steps.size()) line->request_stop();
    };
    Line::RunSettings settings;
    settings.duration_s = 20.0;
    auto report = line->run(settings);
    hand.on_look = {};
    EXPECT_TRUE(report) << describe(report.error());
    EXPECT_EQ(next, steps.size()) << "a step was never done";
    return report ? std::move(*report) : RunReport{};
  }
  /// Discards the recorded points.
  [[nodiscard]] std::function<bool()> forget_the_way() {
    return [this] {
      from = way.count;
      return true;
    };
  }
  /// Largest distance of the axes from the line from the origin through that point since forget_the_way().
  [[nodiscard]] double beside(double x, double y) const {
    double worst = 0.0;
    for (auto i = from; i < way.points.size(); ++i) {
      const auto& at = way.points[i];
      worst = std::max(worst, std::abs(at[0] * y - at[1] * x) / std::hypot(x, y));
    }
    return worst;
  }

  std::unique_ptr<Line> line;
  Hand hand;
  Way way;
  std::size_t from = 0;
};

constexpr double kExact = 1e-9;      // m
constexpr double kOnThePath = 2e-8;  // m, for setpoints of the drives: 10 nm are an increment

TEST_F(GroupByHand, MovesStraightAndTellsOfIt) {
  open();
  std::uint64_t request = 0;
  const auto report = run({
      forget_the_way(),
      [&] {
        request = submit(move_to(0.03, 0.04, 0.05));
        return true;
      },
      [&] {
        EXPECT_THAT(line->groups().status(0).owner, "hand");
        EXPECT_EQ(line->axes().status(1).owner, "hand") << "who takes a group takes its axes";
        EXPECT_EQ(line->axes().status(2).owner, "") << "and no others";
        return over(request);
      },
      [&] {
        EXPECT_EQ(phase(request), RequestPhase::kDone);
        EXPECT_EQ(state(), GroupState::kStandby);
        EXPECT_NEAR(place(0), 0.03, kExact);
        EXPECT_NEAR(place(1), 0.04, kExact);
        return true;
      },
  });
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(beside(3.0, 4.0), kOnThePath);
  EXPECT_THAT(way.states, Contains(snapshot::SampledPlcopenState::kSynchronizedMotion));
  EXPECT_THAT(hand.told, Contains("hand: group plotter: move to x 30 mm, y 40 mm, feed 50 mm/s"));
  EXPECT_THAT(hand.told, Contains("hand: group plotter: enable"));
}

TEST_F(GroupByHand, HoldsResumesAndSlowsDownOnThePath) {
  open();
  std::uint64_t request = 0;
  int looks = 0;
  double held_at = 0.0;
  const auto report = run({
      forget_the_way(),
      [&] {
        request = submit(move_to(0.06, 0.08));
        return true;
      },
      [&] { return place(0) > 0.01; },
      // Any caller may hold it, but only the owner may resume.
      [&] {
        static_cast<void>(submit(ask(Verb::kHold), "somebody"));
        EXPECT_THAT(refusal(ask(Verb::kResume), "somebody"), HasSubstr("group plotter: axis x is commanded by hand"));
        return true;
      },
      [&] { return ++looks > 25; },
      [&] {
        held_at = place(0);
        looks = 0;
        return true;
      },
      [&] { return ++looks > 10; },
      [&] {
        EXPECT_EQ(place(0), held_at);
        EXPECT_LT(held_at, 0.05);
        EXPECT_TRUE(look().interrupted);
        static_cast<void>(submit(ask(Verb::kResume)));
        static_cast<void>(submit(ask(Verb::kOverride, 0.25)));
        looks = 0;
        return true;
      },
      [&] { return ++looks > 10; },
      [&] {
        EXPECT_NEAR(look().speed, 0.025, 1e-6) << "a quarter of max_feed";
        EXPECT_EQ(refusal(ask(Verb::kOverride, 2.5)), "group plotter: override 2.5 is outside 0 to 2");
        EXPECT_THAT(refusal(ask(Verb::kOverride, std::numeric_limits<double>::quiet_NaN())),
                    HasSubstr("override nan is outside 0 to 2"));
        static_cast<void>(submit(ask(Verb::kOverride, 2.0)));
        return true;
      },
      [&] { return over(request); },
  });
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(beside(3.0, 4.0), kOnThePath);
  EXPECT_NEAR(way.end()[0], 0.06, kOnThePath);
}

TEST_F(GroupByHand, AnAxisInAGroupTakesNoRequestsOfItsOwn) {
  open();
  std::uint64_t request = 0;
  std::uint64_t single = 0;
  AxisRequest by;
  by.command = AxisCommand::kMoveRelative;
  by.target_si = 0.01;
  const auto report = run({
      [&] {
        EXPECT_FALSE(line->axes().submit(caller("other"), 0, by)) << "its owner is that of the group";
        single = line->axes().submit(caller("hand"), 0, by).value_or(0);
        return single != 0;
      },
      [&] { return line->axes().progress(0, single).report.over(); },
      [&] {
        const auto progress = line->axes().progress(0, single);
        EXPECT_EQ(progress.report.error, motion::AxisError::kInGroup);
        EXPECT_EQ(place(0), 0.0);
        request = submit(ask(Verb::kDisable));
        return true;
      },
      [&] { return over(request); },
      [&] {
        EXPECT_EQ(state(), GroupState::kDisabled);
        single = line->axes().submit(caller("hand"), 0, by).value_or(0);
        return true;
      },
      [&] { return line->axes().progress(0, single).report.over(); },
      [&] {
        EXPECT_NEAR(place(0), 0.01, 1e-9) << "now it does";
        return true;
      },
  });
  EXPECT_EQ(failure_of(report), "");
}

TEST_F(GroupByHand, WhoDiesWhileItsGroupMovesStopsItOnThePath) {
  open();
  int looks = 0;
  double stopped_at = 0.0;
  const auto report = run({
      forget_the_way(),
      [&] {
        static_cast<void>(submit(move_to(0.06, 0.08)));
        return true;
      },
      [&] { return place(0) > 0.01; },
      [&] {
        line->groups().leave("hand", true);
        line->axes().leave("hand", true);
        return true;
      },
      [&] { return ++looks > 20; },
      [&] {
        stopped_at = place(0);
        looks = 0;
        EXPECT_EQ(state(), GroupState::kStandby);
        EXPECT_EQ(line->groups().status(0).owner, "");
        return true;
      },
      [&] { return ++looks > 5; },
      [&] {
        EXPECT_EQ(place(0), stopped_at);
        EXPECT_LT(stopped_at, 0.05);
        return true;
      },
      // The next caller owns it.
      [&] { return refusal(move_to(0.0, 0.0), "other").empty(); },
  });
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(beside(3.0, 4.0), kOnThePath);
}

TEST_F(GroupByHand, WhoIsNotHeardAnyMoreStopsItOnThePath) {
  open();
  int looks = 0;
  auto silent = caller("silent");
  silent.keep_alive = milliseconds{1};
  const auto report = run({
      forget_the_way(),
      [&] {
        line->axes().leave("hand", true);
        EXPECT_TRUE(line->groups().submit(silent, 0, move_to(0.3, 0.4)));
        std::this_thread::sleep_for(milliseconds{5});
        return true;
      },
      [&] { return line->groups().status(0).owner.empty(); },
      [&] { return ++looks > 20; },
      [&] {
        EXPECT_EQ(state(), GroupState::kStandby);
        EXPECT_LT(place(0), 0.2);
        return true;
      },
  });
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(beside(3.0, 4.0), kOnThePath);
  EXPECT_THAT(hand.told, Contains("axis x: silent no longer renews its lease: the axis stops"));
}

TEST_F(GroupByHand, WhoLeavesTheMotionToItselfKeepsTheAxesUntilItIsOver) {
  open();
  std::uint64_t request = 0;
  const auto report = run({
      [&] {
        request = submit(move_to(0.03, 0.04));
        line->groups().leave("hand", false);
        line->axes().leave("hand", false);
        return true;
      },
      [&] { return place(0) > 0.01; },
      [&] {
        EXPECT_THAT(refusal(move_to(0.0, 0.0), "other"), HasSubstr("axis x is commanded by hand"));
        return true;
      },
      [&] { return over(request); },
      [&] {
        EXPECT_NEAR(place(0), 0.03, kExact);
        return line->groups().status(0).owner.empty();
      },
  });
  EXPECT_EQ(failure_of(report), "");
}

TEST_F(GroupByHand, APathIsHandedOverInPiecesAndBlendsItsCorners) {
  open();
  constexpr std::size_t kMoves = 400;
  constexpr double kTolerance = 2e-4;
  // A staircase of 1 mm steps.
  std::vector<PathMove> moves;
  for (std::size_t i = 0; i < kMoves; ++i) {
    const std::size_t right = (i + 2) / 2;
    const std::size_t up = (i + 1) / 2;
    moves.push_back(line_to(1e-3 * static_cast<double>(right), 1e-3 * static_cast<double>(up), kTolerance));
  }
  std::size_t given = 0;
  std::size_t pieces = 0;
  std::uint64_t last = 0;
  const auto report = run({
      forget_the_way(),
      [&] {
        const auto rest = std::span(moves).subspan(given);
        const auto taken = line->groups().add_moves(caller("hand"), 0, rest, given == 0, true);
        EXPECT_TRUE(taken);
        if (!taken) return true;
        if (taken->count > 0) last = taken->first + taken->count - 1;
        given += taken->count;
        ++pieces;
        return given == kMoves;
      },
      [&] { return over(last); },
      [&] {
        EXPECT_EQ(phase(last), RequestPhase::kDone);
        EXPECT_NEAR(place(0), moves.back().target[0], kExact);
        return true;
      },
  });
  EXPECT_EQ(failure_of(report), "");
  EXPECT_GT(pieces, 1U);
  // Between the two lines through the corners, and never at standstill.
  double beside = 0.0;
  std::size_t standing = 0;
  for (auto i = from + 1; i < way.points.size(); ++i) {
    const auto& at = way.points[i];
    beside = std::max(beside, std::max(at[1] - at[0], at[0] - at[1] - 1e-3));
    const bool on_the_way = at[0] > 0.01 && at[0] < 0.19;
    if (on_the_way && at == way.points[i - 1]) ++standing;
  }
  EXPECT_LT(beside, kOnThePath);
  EXPECT_EQ(standing, 0U);
  EXPECT_EQ(std::count(hand.told.begin(), hand.told.end(), "hand: group plotter: path"), 1) << "one path is one event";
}

TEST_F(GroupByHand, APathThatWasStoppedIsNotGoneOnWithBesideIt) {
  open();
  const std::vector<PathMove> moves{line_to(0.05, 0.0), line_to(0.05, 0.05), line_to(0.0, 0.05)};
  const auto report = run({
      [&] {
        const auto taken = line->groups().add_moves(caller("hand"), 0, std::span(moves).first(2), true, false);
        EXPECT_TRUE(taken);
        return true;
      },
      [&] { return place(0) > 0.01; },
      [&] {
        static_cast<void>(submit(ask(Verb::kHalt), "somebody"));
        return true;
      },
      [&] { return state() == GroupState::kStandby; },
      [&] {
        const auto taken = line->groups().add_moves(caller("hand"), 0, std::span(moves).subspan(2), false, true);
        EXPECT_FALSE(taken);
        if (!taken) {
          EXPECT_EQ(describe(line->groups().event_group(0), taken.error()),
                    "group plotter: the path ended before this move; start a new path");
        }
        return true;
      },
  });
  EXPECT_EQ(failure_of(report), "");
  EXPECT_LT(way.end()[0], 0.05);
  EXPECT_NEAR(way.end()[1], 0.0, kOnThePath);
}

TEST_F(GroupByHand, WhatCannotBeIsRefusedBeforeItMoves) {
  open("", "min_position = -50\nmax_position = 50\n");
  std::vector<PathMove> moves{line_to(0.01, 0.01), line_to(0.02, 0.06)};
  const auto report = run({
      forget_the_way(),
      [&] {
        EXPECT_EQ(refusal(move_to(0.02, 0.051)),
                  "group plotter: axis y: position 51 mm is outside -50 mm to 50 mm (min_position, "
                  "max_position)");
        auto arc = move_to(0.03, 0.0);
        arc.move.path.kind = PathMove::Kind::kArc;
        arc.move.path.center = {0.02, 0.0};
        EXPECT_THAT(refusal(arc), HasSubstr("group plotter: ")) << "it does not close";
        // Its end and its centre are within the limits, but its top is not.
        arc.move.path.target = {0.0, 0.0};
        arc.move.path.center = {0.0, 0.03};
        EXPECT_THAT(refusal(arc), HasSubstr("axis y: position"));
        EXPECT_THAT(refusal(move_to(std::numeric_limits<double>::quiet_NaN(), 0.0)), HasSubstr("group plotter: "));
        EXPECT_THAT(
            refusal(move_to(0.03, 0.04, 1e-300)),
            HasSubstr("group plotter: the move would take longer than 100000 s, the longest that is possible; a "
                      "feed of at least 0.000"));
        const auto taken = line->groups().add_moves(caller("hand"), 0, moves, true, true);
        EXPECT_TRUE(taken);
        EXPECT_EQ(taken ? taken->count : 0U, 1U) << "the second one is refused when it comes by itself";
        return true;
      },
      [&] { return state() == GroupState::kMoving; },
      [&] {
        const auto taken = line->groups().add_moves(caller("hand"), 0, std::span(moves).subspan(1), false, true);
        EXPECT_FALSE(taken);
        return true;
      },
      [&] { return state() == GroupState::kStandby; },
      [&] {
        EXPECT_NEAR(place(1), 0.01, kExact);
        return true;
      },
  });
  EXPECT_EQ(failure_of(report), "");
}

TEST_F(GroupByHand, TheLossOfOneDriveStopsTheOthersOnThePath) {
  open("[[fault]]\nat_ms = 4000\nkind = \"power-off\"\nslave = \"y\"\nfor_ms = 500\n");
  std::uint64_t request = 0;
  int looks = 0;
  double rests_at = 0.0;
  const auto report = run({
      forget_the_way(),
      [&] {
        request = submit(move_to(0.6, 0.8));
        return true;
      },
      [&] { return state() == GroupState::kErrorStop; },
      [&] { return ++looks > 75; },
      [&] {
        const auto now = *line->groups().status(0).report;
        EXPECT_EQ(now.error, motion::GroupError::kAxisFailed);
        EXPECT_EQ(now.failed_axis, 1U);
        rests_at = look(0).setpoint;
        EXPECT_GT(rests_at, 0.01) << "it was on its way";
        EXPECT_LT(rests_at, 0.5);
        EXPECT_THAT(failure(request), HasSubstr("group plotter: axis y: an axis has failed: "));
        EXPECT_EQ(refusal(move_to(0.0, 0.0)), "");
        request = submit(ask(Verb::kReset));
        return true;
      },
      [&] { return over(request); },
      [&] {
        EXPECT_EQ(phase(request), RequestPhase::kDone) << failure(request);
        EXPECT_EQ(state(), GroupState::kDisabled);
        EXPECT_NEAR(look(0).setpoint, rests_at, kExact);
        return true;
      },
  });
  EXPECT_THAT(hand.told, Contains(HasSubstr("group plotter: GroupErrorStop: axis y: an axis has failed: ")));
  EXPECT_THAT(hand.told, Contains("group plotter: reset"));
  // x brakes within its limit, although the position of y is unknown.
  double hardest = 0.0;
  for (auto i = from + 2; i < way.points.size(); ++i) {
    const double change = way.points[i][0] - 2.0 * way.points[i - 1][0] + way.points[i - 2][0];
    hardest = std::max(hardest, std::abs(change) * 1e6);
  }
  EXPECT_LT(hardest, 5.0 * 1.01);
  EXPECT_EQ(failure_of(report), "");
}

}  // namespace
}  // namespace driveline::runtime
