// Random sequences of requests to two groups and their axes, faults, lost frames and missed periods: the demands of
// simulated drives obey the limits of their axes in any case, and every request ends.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "demand_watch.hpp"
#include "group_line.hpp"
#include "support/campaign.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Fault;

constexpr std::size_t kAxes = 12;  ///< 2 that follow contours, 9 that follow lines, and a single one
constexpr std::size_t kContourAxes = 2;
constexpr std::size_t kLineAxes = 9;
constexpr int kCycles = 6000;
constexpr trajectory::AxisLimits kLimits{50.0, 1000.0};
constexpr std::size_t kCommands = static_cast<std::size_t>(GroupCommand::kForward) + 1;

std::vector<AxisGroupSettings> configs() {
  AxisGroupSettings contour{"contour", {0, 1}, 256};
  AxisGroupSettings lines{"lines", {}};
  for (std::size_t i = 0; i < kLineAxes; ++i) lines.axes.push_back(kContourAxes + i);
  return {contour, lines};
}

/// Coverage of the campaign.
struct Coverage {
  std::array<std::uint64_t, kCommands> done{};  ///< requests by command
  std::array<std::uint64_t, 16> errors{};       ///< requests and moves by GroupError
  std::array<std::uint64_t, 5> states{};        ///< cycles by GroupState
  std::uint64_t moves_done = 0;
  std::uint64_t judged = 0;
};

/// Options of a seed; mostly position modes.
RunOptions options(unsigned seed) {
  auto made = single_options();
  if (seed % 4 == 2) made.mode = motion::cia402::Mode::kCyclicVelocity;
  if (seed % 4 == 3) made.mode = motion::cia402::Mode::kCyclicTorque;
  return made;
}

class GroupSequence {
 public:
  GroupSequence(unsigned seed, Coverage& coverage)
      : random_(seed), coverage_(coverage), line_(kAxes, configs(), options(seed)) {
    for (std::size_t i = 0; i < kAxes; ++i) watches_.emplace_back(line_.drives.drive(i), kLimits);
  }

  /// The first finding; empty: there is none.
  [[nodiscard]] std::string execute() {
    for (std::size_t group = 0; group < 2; ++group) submit(group, GroupCommand::kEnable);
    for (int i = 0; i < kCycles; ++i) {
      if (chance(200)) ask();
      if (chance(250)) move();
      if (chance(600)) ask_axis();
      if (chance(2500)) fail();
      keep_going();
      if (chance(200)) {
        stall(1 + static_cast<int>(pick(chance(60) ? 12 : 5)));
      } else {
        lost_ = chance(100) ? 1 + static_cast<int>(pick(chance(60) ? 12 : 4)) : std::max(lost_ - 1, 0);
        line_.lose_back = lost_ > 0;
        line_.lose_out = lost_ > 0 && chance(2);
        cycle();
      }
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        const auto& finding = watches_[axis].finding();
        if (!finding.empty()) return "axis " + std::to_string(axis) + ", cycle " + std::to_string(i) + ": " + finding;
      }
    }
    return come_to_an_end();
  }

 private:
  [[nodiscard]] std::size_t pick(std::size_t of) { return random_() % of; }
  [[nodiscard]] bool chance(std::size_t one_in) { return pick(one_in) == 0; }
  [[nodiscard]] double number(double from, double to) { return std::uniform_real_distribution(from, to)(random_); }

  void look() {
    for (auto& watch : watches_) watch.look(line_.drives.clock.now());
  }
  void cycle() {
    line_.groups->plan();
    line_.operation.cycle();
    line_.settle();
    look();
    for (std::size_t group = 0; group < 2; ++group)
      ++coverage_.states[static_cast<std::size_t>(line_.group_state(group))];
  }
  void stall(int periods) {
    for (int i = 0; i < periods; ++i) {
      line_.drives.leave_alone(kSinglePeriod);
      look();
    }
    line_.drives.leave_alone(microseconds{15});
    cycle();
  }

  void submit(std::size_t group, GroupCommand command, double value = 0.0) {
    asked_.push_back({line_.groups->submit(group, {command, value}), static_cast<int>(command)});
  }
  void ask() {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    // Requests that end a path are rare, so that paths are followed.
    const auto any = static_cast<GroupCommand>(pick(kCommands));
    const bool ends = any == GroupCommand::kDisable || any == GroupCommand::kStop || any == GroupCommand::kHalt;
    const auto command = ends && !chance(4) ? GroupCommand::kSetOverride : any;
    submit(pick(2), command, chance(20) ? kNan : number(-0.1, 2.1));
  }
  /// Submits a move, sometimes an invalid one.
  void move() {
    const auto group = pick(2);
    GroupMove move;
    move.path.feed = chance(30) ? -1.0 : number(5.0, 100.0);
    move.relative = chance(2);
    move.buffer = chance(8) ? GroupBuffer::kAborting : chance(2) ? GroupBuffer::kBuffered : GroupBuffer::kBlending;
    move.continues = chance(3);
    if (group == 1) {
      for (std::size_t i = 0; i < kLineAxes - (chance(20) ? 1 : 0); ++i) move.target.push_back(number(-1.0, 1.0));
    } else {
      move.path.target = {number(-1.0, 1.0), number(-1.0, 1.0)};
      move.path.via = {number(-1.0, 1.0), number(-1.0, 1.0)};
      if (chance(3)) move.path.kind = PathMove::Kind::kArcVia;
      if (chance(2)) move.path.tolerance = number(0.0, 0.3);
      if (chance(4)) {
        move.path.kind = PathMove::Kind::kSpline;
        move.path.points = {move.path.via, move.path.target};
      }
    }
    asked_.push_back({line_.groups->move(group, move), -1});
  }
  void ask_axis() {
    static constexpr std::array kAsked{AxisCommand::kHalt,  AxisCommand::kStop,         AxisCommand::kReleaseStop,
                                       AxisCommand::kPower, AxisCommand::kMoveVelocity, AxisCommand::kTouchProbe,
                                       AxisCommand::kReset, AxisCommand::kFollow};
    AxisRequest request;
    request.command = kAsked[pick(kAsked.size())];
    request.on = chance(2);
    request.target_si = number(-20.0, 20.0);
    static_cast<void>(line_.axes().submit(pick(kAxes), request));
  }
  void fail() {
    static constexpr std::array kFaults{Fault::kFollowingError, Fault::kMotorTemperature, Fault::kOvercurrent};
    const auto axis = pick(kAxes);
    line_.drives.drive(axis).raise(kFaults[pick(kFaults.size())]);
    // The group is enabled again before its axis has been reset.
    if (chance(3)) submit(axis < kContourAxes ? 0 : 1, GroupCommand::kDisable);
  }

  /// Re-enables groups that are disabled or in GroupErrorStop, because these have nothing to judge.
  void keep_going() {
    if (!chance(50)) return;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      const auto state = line_.state(axis);
      if (state == PlcopenState::kErrorStop) static_cast<void>(line_.submit(request(AxisCommand::kReset), axis));
      if (state == PlcopenState::kDisabled) static_cast<void>(line_.submit(power(true), axis));
      if (state == PlcopenState::kStopping) static_cast<void>(line_.submit(request(AxisCommand::kReleaseStop), axis));
      if (state == PlcopenState::kContinuousMotion) static_cast<void>(line_.submit(request(AxisCommand::kHalt), axis));
    }
    for (std::size_t group = 0; group < 2; ++group) {
      const auto report = line_.groups->group_report(group);
      if (report.state == GroupState::kErrorStop) submit(group, GroupCommand::kReset);
      if (report.state == GroupState::kDisabled) submit(group, GroupCommand::kEnable);
      if (report.state == GroupState::kStopping) submit(group, GroupCommand::kReleaseStop);
      if (report.interrupted) submit(group, GroupCommand::kContinue);
      if (report.backwards) submit(group, GroupCommand::kForward);
      if (report.override_factor < 0.2) submit(group, GroupCommand::kSetOverride, 1.0);
    }
  }

  /// Checks that every request ends, if necessary by a stop of its group.
  [[nodiscard]] std::string come_to_an_end() {
    line_.lose_back = false;
    line_.lose_out = false;
    for (std::size_t group = 0; group < 2; ++group) submit(group, GroupCommand::kStop);
    for (int i = 0; i < 12'000; ++i) line_.cycle();
    for (const auto& [id, command] : asked_) {
      const auto report = line_.groups->report(id);
      if (id == 0) continue;
      if (!report.over())
        return "request " + std::to_string(id) + " (" + std::to_string(command) + ") is " +
               std::string(to_text(report.phase)) + " for ever";
      ++coverage_.errors[static_cast<std::size_t>(report.error)];
      if (report.phase != RequestPhase::kDone) continue;
      if (command < 0) ++coverage_.moves_done;
      if (command >= 0) ++coverage_.done[static_cast<std::size_t>(command)];
    }
    for (std::size_t i = 0; i < kContourAxes + kLineAxes; ++i) {
      if (std::abs(line_.axes().axis_report(i).velocity) > 0.01) return "axis " + std::to_string(i) + " does not stand";
    }
    for (const auto& watch : watches_) coverage_.judged += watch.judged();
    return {};
  }

  struct Asked {
    std::uint64_t id;
    int command;  ///< -1: a move
  };

  std::mt19937 random_;
  Coverage& coverage_;
  GroupLine line_;
  std::vector<DemandWatch> watches_;
  std::vector<Asked> asked_;
  int lost_ = 0;
};

/// Number of sequences that cover everything.
constexpr unsigned kCovering = 16;

TEST(GroupCampaign, DrivesDemandNoMoreThanTheirAxesMayAndEveryRequestEnds) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(kCovering));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  Coverage coverage;
  int failed = 0;
  constexpr int kEnough = 20;  // failures to report
  for (unsigned seed = first; seed < first + runs && failed < kEnough; ++seed) {
    GroupSequence sequence(seed, coverage);
    const auto finding = sequence.execute();
    EXPECT_EQ(finding, "") << "seed " << seed;
    if (!finding.empty()) ++failed;
  }
  if (runs < kCovering || failed > 0) return;
  for (std::size_t i = 0; i < kCommands; ++i)
    EXPECT_GT(coverage.done[i], 0U) << to_text(static_cast<GroupCommand>(i)) << ": always refused";
  for (std::size_t i = 0; i < coverage.states.size(); ++i)
    EXPECT_GT(coverage.states[i], 0U) << to_text(static_cast<GroupState>(i));
  for (const auto error :
       {GroupError::kNotEnabled, GroupError::kErrorStop, GroupError::kStopping, GroupError::kNotFinite,
        GroupError::kOverLimit, GroupError::kNothingToDo, GroupError::kBadMove, GroupError::kAxisNotEnabled,
        GroupError::kAxisErrorStop, GroupError::kAxisFailed, GroupError::kAxisAsked})
    EXPECT_GT(coverage.errors[static_cast<std::size_t>(error)], 0U) << to_text(error) << ": never";
  EXPECT_GT(coverage.moves_done, 20U);
  EXPECT_GT(coverage.judged, std::uint64_t{runs} * kCycles) << "the axes hardly moved: nothing was judged";
}

}  // namespace
}  // namespace driveline::bus_test
