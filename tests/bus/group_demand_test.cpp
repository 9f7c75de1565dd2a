// Groups of axes as seen by their drives: the demands (6062h) are on the path and within the limits, whatever is
// requested and whatever fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "driveline/trajectory/path_shaper.hpp"
#include "group_line.hpp"

namespace driveline::bus_test {
namespace {

/// Targets are whole increments, 6e-6 rad, so three axes deviate that much from the path; the drives connect them by
/// splines.
constexpr double kOnPath = 2e-5;

/// 6062h of a drive, rad.
double demand(GroupLine& line, std::size_t axis) {
  return line.drives.drive(axis).dictionary().get(slaves::msd::kValue.position_demand) / kDemandIncrements;
}

GroupVector demands(GroupLine& line, std::size_t axes) {
  GroupVector made{};
  for (std::size_t i = 0; i < axes; ++i) made[i] = demand(line, i);
  return made;
}

/// The geometric path of some moves, as closely spaced points.
class PointsOfPath {
 public:
  PointsOfPath(const GroupVector& start, const std::vector<GroupMove>& moves) {
    trajectory::PathShaper shaper(kAxes, start);
    std::vector<trajectory::ShapedPiece> pieces;
    for (const auto& move : moves) {
      const auto added = shaper.add(move.path, pieces);
      if (!added) throw std::runtime_error(added.error().reason);
    }
    shaper.finish(pieces);
    for (const auto& shaped : pieces) {
      const auto count = static_cast<int>(std::ceil(shaped.piece.length() / kStep));
      for (int i = points_.empty() ? 0 : 1; i <= count; ++i)
        points_.push_back(shaped.piece.at(shaped.piece.length() * i / count).position);
      length_ += shaped.piece.length();
    }
  }

  [[nodiscard]] double length() const { return length_; }
  [[nodiscard]] const GroupVector& end() const { return points_.back(); }
  /// Distance of a position from the path, `periods` after the last one, and therefore close to it.
  [[nodiscard]] double from_path(const GroupVector& at, std::size_t periods = 1) {
    const auto window = kWindow * periods;
    const auto first = near_ > window ? near_ - window : 0;
    const auto last = std::min(near_ + window, points_.size() - 1);
    double best = 1e9;
    for (auto i = first; i < last; ++i) {
      if (const double found = apart(at, points_[i]); found < best) {
        best = found;
        near_ = i;
      }
    }
    const auto before = near_ > 0 ? near_ - 1 : 0;
    return std::min(from_line(at, points_[before], points_[near_]), from_line(at, points_[near_], points_[near_ + 1]));
  }
  [[nodiscard]] double share() const { return static_cast<double>(near_) / static_cast<double>(points_.size()); }

  static constexpr std::size_t kAxes = 3;

 private:
  static constexpr double kStep = 2e-4;
  static constexpr std::size_t kWindow = 60;

  std::vector<GroupVector> points_;
  std::size_t near_ = 0;
  double length_ = 0.0;
};

/// Lines with rounded and with sharp corners, arcs and splines, forth and back.
std::vector<GroupMove> random_path(std::mt19937_64& random, int count) {
  const auto number = [&random](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  std::vector<GroupMove> moves;
  for (int i = 0; i < count; ++i) {
    GroupMove move;
    move.path.target = {number(-2.0, 2.0), number(-2.0, 2.0), number(-2.0, 2.0)};
    move.path.feed = number(5.0, 60.0);
    move.path.tolerance = i % 4 == 3 ? 0.0 : number(0.01, 0.2);
    if (i % 5 == 2) {
      move.path.kind = PathMove::Kind::kArcVia;
      move.path.via = {number(-2.0, 2.0), number(-2.0, 2.0), number(-2.0, 2.0)};
    } else if (i % 5 == 4) {
      move.path.kind = PathMove::Kind::kSpline;
      for (int k = 0; k < 3; ++k) move.path.points.push_back({number(-2.0, 2.0), number(-2.0, 2.0), number(-2.0, 2.0)});
    }
    moves.push_back(move);
  }
  return moves;
}

/// Judges velocity, acceleration and jerk of the commanded positions, by differences.
class ToldJudge {
 public:
  ToldJudge(double max_velocity, double max_acceleration, double max_jerk)
      : limits_{max_velocity, max_acceleration, max_jerk} {}

  void look(double position) {
    constexpr double kPeriod = 125e-6;
    std::array<double, 4> now{position};
    for (std::size_t i = 0; i + 1 < now.size(); ++i) now[i + 1] = (now[i] - before_[i]) / kPeriod;
    before_ = now;
    if (++seen_ <= now.size()) return;
    for (std::size_t i = 0; i < limits_.size(); ++i) worst_[i] = std::max(worst_[i], std::abs(now[i + 1]) / limits_[i]);
  }
  void expect_obedience() const {
    EXPECT_LE(worst_[0], 1.0) << "velocity";
    EXPECT_LE(worst_[1], 1.0) << "acceleration";
    EXPECT_LE(worst_[2], 1.01) << "jerk";
  }
  /// Largest used share of a limit, to show that the test is effective.
  [[nodiscard]] double used() const { return std::max({worst_[0], worst_[1], worst_[2]}); }

 private:
  std::array<double, 3> limits_;
  std::array<double, 4> before_{};
  std::array<double, 3> worst_{};
  std::size_t seen_ = 0;
};

constexpr double kMaxVelocity = 50.0;
constexpr double kMaxAcceleration = 1000.0;
constexpr double kMaxJerk = AxisGroups::kShareOfAcceleration * kMaxAcceleration / 0.02;

TEST(GroupDemand, HoldOverrideReverseAndResumeAtAThousandRandomTimesStayOnThePath) {
  std::mt19937_64 random(20260718);
  const auto any = [&random](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  StandbyGroup line(PointsOfPath::kAxes);
  const auto moves = random_path(random, 24);
  PointsOfPath path(line.place(), moves);
  const auto first = line.groups->move_path(0, moves);
  ASSERT_NE(first, 0U);
  std::vector<ToldJudge> told(PointsOfPath::kAxes, ToldJudge(kMaxVelocity, kMaxAcceleration, kMaxJerk));
  double worst = 0.0;
  const auto cycles = [&](int count) {
    for (int i = 0; i < count; ++i) {
      line.cycle();
      worst = std::max(worst, path.from_path(demands(line, PointsOfPath::kAxes)));
      for (std::size_t axis = 0; axis < told.size(); ++axis) told[axis].look(line.setpoint(axis));
    }
  };
  int held = 0;
  int stood = 0;
  for (int event = 0; event < 1000; ++event) {
    cycles(any(1, 60));
    const bool interrupted = line.groups->group_report(0).interrupted;
    stood += std::abs(line.groups->group_report(0).speed) > 0.0 ? 0 : 1;
    switch (any(0, 4)) {
      case 0:
        held += interrupted ? 0 : 1;
        static_cast<void>(line.submit_to_group(interrupted ? GroupCommand::kContinue : GroupCommand::kInterrupt));
        break;
      case 1: {
        const bool back = path.share() > 0.8 || (path.share() > 0.2 && any(0, 2) == 0);
        static_cast<void>(line.submit_to_group(back ? GroupCommand::kReverse : GroupCommand::kForward));
        break;
      }
      default:
        static_cast<void>(line.submit_to_group(GroupCommand::kSetOverride, any(0, 5) == 0 ? 0.0 : 0.02 * any(0, 100)));
    }
  }
  static_cast<void>(line.submit_to_group(GroupCommand::kContinue));
  static_cast<void>(line.submit_to_group(GroupCommand::kForward));
  static_cast<void>(line.submit_to_group(GroupCommand::kSetOverride, 2.0));
  for (int i = 0; i < 400 && !line.groups->report(first + moves.size() - 1).over(); ++i) cycles(200);
  EXPECT_EQ(line.group_phase(first + moves.size() - 1), RequestPhase::kDone);
  EXPECT_LT(worst, kOnPath);
  EXPECT_GT(held, 50);
  EXPECT_LT(stood, 800);
  cycles(20);
  EXPECT_LT(apart(demands(line, PointsOfPath::kAxes), path.end()), kOnPath);
  for (const auto& each : told) {
    each.expect_obedience();
    EXPECT_GT(each.used(), 0.5);
  }
  line.expect_obedience();
}

/// The shares of their distances that the axes have covered; they must be equal at any time.
struct Shares {
  double apart = 0.0;  ///< largest difference between two axes
  double mean = 0.0;
};

/// A group of axes along a straight line, each with a distance of its own.
class WideLine : public GroupLine {
 public:
  explicit WideLine(std::size_t axes) : GroupLine(axes) {
    take_axes();
    for (std::size_t i = 0; i < axes; ++i) {
      from.push_back(demand(*this, i));
      to.push_back(from.back() + (i % 2 == 0 ? 1.0 : -1.0) * (4.0 + 0.25 * static_cast<double>(i)));
    }
  }
  std::uint64_t go() {
    GroupMove move;
    move.target = to;
    move.path.feed = 1000.0;
    return groups->move(0, move);
  }
  [[nodiscard]] Shares shares(std::size_t but) {
    double least = 1e9;
    double most = -1e9;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (i == but) continue;
      const double share = (demand(*this, i) - from[i]) / (to[i] - from[i]);
      least = std::min(least, share);
      most = std::max(most, share);
    }
    return {most - least, 0.5 * (most + least)};
  }

  std::vector<double> from;
  std::vector<double> to;
};

TEST(GroupDemand, AFaultOfOneOf32AxesStopsAllOthersOnThePath) {
  constexpr std::size_t kAxes = 32;
  constexpr std::size_t kFailing = 13;
  WideLine line(kAxes);
  const auto id = line.go();
  double worst = 0.0;
  for (int i = 0; i < 1200; ++i) {
    line.cycle();
    worst = std::max(worst, line.shares(kAxes).apart);
  }
  ASSERT_EQ(line.group_state(), GroupState::kMoving);
  EXPECT_GT(line.groups->group_report(0).speed, 50.0) << "they are under way";
  const double at_fault = line.shares(kAxes).mean;
  line.drives.drive(kFailing).raise(slaves::msd::Fault::kOvercurrent);
  for (int i = 0; i < 3000; ++i) {
    line.cycle();
    worst = std::max(worst, line.shares(kFailing).apart);
  }
  EXPECT_LT(worst, kOnPath / 4.0) << "ways are 4 rad and more";
  EXPECT_EQ(line.group_state(), GroupState::kErrorStop);
  EXPECT_EQ(line.groups->group_report(0).failed_axis, kFailing);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kAborted);
  const auto stopped = line.shares(kFailing).mean;
  EXPECT_GT(stopped, at_fault);
  EXPECT_LT(stopped, 0.98);
  line.cycles(100);
  EXPECT_EQ(line.shares(kFailing).mean, stopped) << "at rest";
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (i == kFailing) continue;
    EXPECT_EQ(line.state(i), PlcopenState::kStandstill) << i;
    line.judges[i].expect_obedience();
  }
}

TEST(GroupDemand, ManyAxesAreHeldOverriddenAndReversedOnTheirLine) {
  constexpr std::size_t kAxes = 12;
  std::mt19937_64 random(7);
  const auto any = [&random](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  WideLine line(kAxes);
  std::vector<ToldJudge> told(kAxes, ToldJudge(kMaxVelocity, kMaxAcceleration, kMaxJerk));
  double worst = 0.0;
  bool interrupted = false;
  auto id = line.go();
  for (int event = 0; event < 200; ++event) {
    const int cycles = any(1, 100);
    for (int i = 0; i < cycles; ++i) {
      line.cycle();
      worst = std::max(worst, line.shares(kAxes).apart);
      for (std::size_t axis = 0; axis < kAxes; ++axis) told[axis].look(line.setpoint(axis));
    }
    switch (any(0, 3)) {
      case 0:
        static_cast<void>(line.submit_to_group(interrupted ? GroupCommand::kContinue : GroupCommand::kInterrupt));
        interrupted = line.groups->group_report(0).interrupted;
        break;
      case 1:
        static_cast<void>(line.submit_to_group(any(0, 2) == 0 ? GroupCommand::kReverse : GroupCommand::kForward));
        break;
      default:
        static_cast<void>(line.submit_to_group(GroupCommand::kSetOverride, 0.1 * any(0, 20)));
    }
  }
  static_cast<void>(line.submit_to_group(GroupCommand::kContinue));
  static_cast<void>(line.submit_to_group(GroupCommand::kForward));
  static_cast<void>(line.submit_to_group(GroupCommand::kSetOverride, 1.0));
  line.cycles(8000);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
  EXPECT_LT(worst, kOnPath / 4.0);
  for (std::size_t i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(line.setpoint(i), line.to[i], 1e-9);
    told[i].expect_obedience();
  }
  line.expect_obedience();
  // Unsupported moves.
  const auto reason_of = [&line](const GroupMove& move) {
    const auto refused = line.groups->move(0, move);
    EXPECT_EQ(line.finish_of_group(refused).error, GroupError::kBadMove);
    return line.groups->refusal(refused);
  };
  GroupMove move;
  move.path.feed = 1.0;
  EXPECT_EQ(reason_of(move), "the target has 0 values for 12 axes");
  move.target = line.from;
  move.path.feed = 1e-6;
  EXPECT_EQ(reason_of(move), "with that feed it would take more than 100000 s");
  move.path.feed = 1.0;
  move.path.tolerance = 0.1;
  EXPECT_NE(reason_of(move), "");
  move.path.tolerance = 0.0;
  move.path.kind = PathMove::Kind::kSpline;
  EXPECT_EQ(reason_of(move), "a group of more than 8 axes moves along lines only");
}

// The inputs of an axis fail, because its slave has no power.
TEST(GroupDemand, ALostAxisStopsTheOthersOnThePath) {
  StandbyGroup line(3);
  const auto from = demands(line, 3);
  const GroupVector to{6.0, 9.0, 4.0};
  ASSERT_NE(line.groups->move(0, line_to(to, 60.0)), 0U);
  line.cycles(900);
  line.drives.line().set_power(2, false);
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    line.cycle();
    const auto at = demands(line, 2);
    worst = std::max(worst, from_line(at, {from[0], from[1]}, {to[0], to[1]}));
  }
  // The path waits for the axis until its loss is known, and the others return to the path one by one.
  EXPECT_LT(worst, 5e-4);
  EXPECT_EQ(line.group_state(), GroupState::kErrorStop);
  EXPECT_EQ(line.groups->group_report(0).failed_axis, 2U);
  EXPECT_EQ(line.groups->group_report(0).axis_error, AxisError::kLost);
  EXPECT_EQ(line.state(0), PlcopenState::kStandstill);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  line.judges[0].expect_obedience();
  line.judges[1].expect_obedience();
}

// Frames are lost and periods missed at any time. The drives continue at their present velocity, and the path waits: it
// is left by no more than their distance meanwhile, until they have returned with the remaining acceleration. Without
// gaps the error is kOnPath.
TEST(GroupDemand, LostFramesAndMissedPeriodsNeverMakeAxesLeap) {
  constexpr double kNear = 60.0 * 8 * 125e-6;  // the highest feed, rad/s, in the longest gap
  for (const unsigned seed : {99U, 102U, 104U, 105U}) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto any = [&random](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
    StandbyGroup line(PointsOfPath::kAxes);
    const auto moves = random_path(random, 40);
    PointsOfPath path(line.place(), moves);
    const auto first = line.groups->move_path(0, moves);
    ASSERT_NE(first, 0U);
    double worst = 0.0;
    const auto cycles = [&](int count) {
      for (int i = 0; i < count; ++i) {
        line.cycle();
        worst = std::max(worst, path.from_path(demands(line, PointsOfPath::kAxes)));
      }
    };
    const auto stall = [&](int periods) {
      line.stall(periods);
      worst =
          std::max(worst, path.from_path(demands(line, PointsOfPath::kAxes), static_cast<std::size_t>(periods) + 1));
    };
    int gaps = 0;
    while (!line.groups->report(first + moves.size() - 1).over()) {
      cycles(any(20, 200));
      ++gaps;
      if (any(0, 1) == 0) {
        stall(any(1, 6));
      } else {
        auto& way = any(0, 1) == 0 ? line.lose_out : line.lose_back;
        way = true;
        cycles(any(1, 6));
        way = false;
      }
    }
    EXPECT_EQ(line.group_phase(first + moves.size() - 1), RequestPhase::kDone);
    EXPECT_GT(gaps, 50);
    EXPECT_LT(worst, kNear);
    cycles(2000);
    EXPECT_LT(apart(demands(line, PointsOfPath::kAxes), path.end()), kOnPath);
    line.expect_obedience();
  }
}

// Time along the path is the time for which all its axes got their setpoints, as on the path of a line.
TEST(GroupDemand, APathWaitsForSetpointsThatAreLostAndPeriodsThatAreMissed) {
  constexpr double kFeed = 20.0;
  constexpr double kStep = kFeed * 125e-6;
  StandbyGroup line(2);
  ASSERT_NE(line.groups->move(0, line_to({20.0, 10.0}, kFeed)), 0U);
  line.cycles(1200);
  const auto steps_during = [&line](const std::function<void()>& disturb) {
    const double before = line.groups->group_report(0).length;
    line.cycles(50);
    disturb();
    line.cycles(50);
    return (line.groups->group_report(0).length - before) / kStep;
  };
  EXPECT_NEAR(steps_during([] {}), 100.0, 0.1);
  for (bool* const way : {&line.lose_out, &line.lose_back}) {
    const auto lose = [&] {
      *way = true;
      line.cycles(5);
      *way = false;
    };
    EXPECT_NEAR(steps_during(lose), 100.0, 0.1) << "in 105 cycles";
  }
  EXPECT_NEAR(steps_during([&line] { line.stall(5); }), 101.0, 0.1) << "in 101 cycles and 5 missed periods";
  line.expect_obedience();
}

TEST(GroupDemand, APathBridgesGapsAsLongAsTheLineAllows) {
  auto options = single_options();
  options.max_lost_cycles = 400;
  for (const int periods : {9, 64, 65, 80, 200}) {
    for (const int kind : {0, 1, 2}) {
      SCOPED_TRACE(testing::Message() << periods << " periods, kind " << kind);
      StandbyGroup line(2, {}, options);
      const auto id = line.groups->move(0, line_to({12.0, 6.0}, 30.0));
      line.cycles(800);
      if (kind == 0) {
        line.stall(periods);
      } else {
        auto& way = kind == 1 ? line.lose_out : line.lose_back;
        way = true;
        line.cycles(periods);
        way = false;
      }
      EXPECT_EQ(line.finish_of_group(id).phase, RequestPhase::kDone);
      line.cycles(400);
      EXPECT_LT(apart(line.place(), {12.0, 6.0}), kOnPath);
      line.expect_obedience();
    }
  }
}

}  // namespace
}  // namespace driveline::bus_test
