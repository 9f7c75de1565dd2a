// Setpoints that lead a path by the dead times of the axes.
#include "driveline/motion/path/path_leads.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "driveline/motion/path/path_source.hpp"
#include "driveline/trajectory/path.hpp"

namespace driveline::motion {
namespace {

using testing::ElementsAre;
using trajectory::AxisSetpoint;

TEST(PathLeads, TheAxisWithTheLongestDeadTimeIsToldFirst) {
  const PathLeads leads(std::array{1.5, 3.0, 0.0, 3.0});
  EXPECT_EQ(leads.longest(), 3.0);
  EXPECT_THAT(std::vector(leads.delays().begin(), leads.delays().end()), ElementsAre(0.0, 1.5, 3.0));
  EXPECT_EQ(leads.delay_of(0), 1U);
  EXPECT_EQ(leads.delay_of(1), 0U);
  EXPECT_EQ(leads.delay_of(2), 2U);
  EXPECT_EQ(leads.delay_of(3), 0U);
}

TEST(PathLeads, MomentsComeBackLater) {
  PathLeads leads(std::array{2.5});
  leads.rewind();
  for (int cycle = 1; cycle <= 4; ++cycle) leads.push({10.0 * cycle, 1.0, 0.1 * cycle});
  EXPECT_EQ(leads.at(0.0).path_s, 40.0);
  EXPECT_EQ(leads.at(1.0).path_s, 30.0);
  EXPECT_DOUBLE_EQ(leads.at(2.5).path_s, 15.0);
  EXPECT_DOUBLE_EQ(leads.at(2.5).slope, 0.15);
  leads.rewind();
  leads.push({10.0, 1.0, 0.0});
  EXPECT_DOUBLE_EQ(leads.at(0.5).path_s, 5.0);
  EXPECT_DOUBLE_EQ(leads.at(0.5).rate, 0.5) << "before the beginning the path stands";
  EXPECT_EQ(leads.at(2.5).path_s, 0.0);
}

constexpr double kPeriod = 1e-3;
constexpr std::array<trajectory::AxisLimits, 2> kLimits{{{50.0, 1000.0}, {50.0, 1000.0}}};

/// Two axes with the same motion, starting at 1 rad, at most 20 rad/s.
trajectory::Interpolator path() {
  trajectory::PathBuilder builder;
  for (const auto* name : {"x", "y"}) {
    if (!builder.add_axis({name, trajectory::AxisKind::kRotary})) throw std::runtime_error("axis");
  }
  for (int point = 0; point <= 100; ++point) {
    const double position = 2.0 - std::cos(0.0314159265358979 * point);
    if (!builder.add_point(point * 1e-3, std::array{position, position})) throw std::runtime_error("point");
  }
  auto built = builder.build();
  if (!built) throw std::runtime_error("path");
  return trajectory::Interpolator::clamped_spline(*built);
}

/// The setpoints of a source from its start to its end, a row per cycle.
std::vector<std::array<AxisSetpoint, 2>> all_of(PathSource& source) {
  std::array<AxisSetpoint, 2> setpoints{};
  source.rewind(setpoints);
  source.begin(true);
  std::vector rows{setpoints};
  for (int cycle = 1; cycle < 1000; ++cycle) {
    const bool goes_on = source.next({cycle * kPeriod, {}}, setpoints);
    rows.push_back(setpoints);
    if (!goes_on) break;
  }
  return rows;
}

TEST(DeadTime, EachAxisIsWhereThePathIsAfterItsOwnDeadTime) {
  constexpr std::array kDeadTimes{5.0, 2.0};
  PathSource ahead(path(), kLimits, LatePolicy::kStay, kDeadTimes);
  const auto rows = all_of(ahead);
  auto plain = path();
  std::array<AxisSetpoint, 2> now{};
  for (std::size_t cycle = 5; cycle < rows.size(); ++cycle) {
    // The path starts when the first axis can be on it.
    plain.evaluate(static_cast<double>(cycle) * kPeriod - 5.0 * kPeriod, now);
    ASSERT_NEAR(rows[cycle - 5][0].position, now[0].position, 1e-12) << cycle;
    ASSERT_NEAR(rows[cycle - 2][1].position, now[1].position, 1e-12) << cycle;
    ASSERT_NEAR(rows[cycle - 2][1].velocity, now[1].velocity, 1e-9) << cycle;
  }
}

TEST(DeadTime, NothingLeapsAtTheBeginningAndTheEndIsHeld) {
  PathSource ahead(path(), kLimits, LatePolicy::kStay, std::array{5.5, 2.25});
  const auto rows = all_of(ahead);
  EXPECT_EQ(rows.size(), 1U + 100U + 6U) << "until the last axis has arrived";
  for (std::size_t cycle = 1; cycle < rows.size(); ++cycle) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double step = rows[cycle][axis].position - rows[cycle - 1][axis].position;
      ASSERT_LT(std::abs(step), 35.0 * kPeriod) << cycle;
      ASSERT_NEAR(step, rows[cycle][axis].velocity * kPeriod, 0.6e-3) << cycle;
    }
  }
  EXPECT_DOUBLE_EQ(rows.front()[1].position, 1.0);
  EXPECT_DOUBLE_EQ(rows.back()[0].position, 3.0);
  EXPECT_EQ(rows.back()[0].velocity, 0.0);
}

TEST(DeadTime, APathThatBeginsAgainBeginsAtRest) {
  PathSource ahead(path(), kLimits, LatePolicy::kStay, std::array{5.0, 0.0});
  static_cast<void>(all_of(ahead));
  const auto again = all_of(ahead);
  EXPECT_EQ(again[1][1].position, 1.0) << "not where it was at the end";
  EXPECT_EQ(again[1][1].velocity, 0.0);
}

TEST(DeadTime, AxesWithTheSameOneMoveAsTheyDoWithoutCompensation) {
  PathSource plain(path(), kLimits, LatePolicy::kStay);
  PathSource ahead(path(), kLimits, LatePolicy::kStay, std::array{3.0, 3.0});
  const auto without = all_of(plain);
  const auto with = all_of(ahead);
  ASSERT_EQ(with.size(), without.size() + 3);
  for (std::size_t cycle = 0; cycle < without.size(); ++cycle) {
    ASSERT_EQ(with[cycle][0].position, without[cycle][0].position);
    ASSERT_EQ(with[cycle][1].velocity, without[cycle][1].velocity);
  }
}

TEST(DeadTime, AxesThatWaitDoSoAtTheSamePlace) {
  PathSource ahead(path(), kLimits, LatePolicy::kStay, std::array{6.0, 0.0});
  std::array<AxisSetpoint, 2> setpoints{};
  ahead.rewind(setpoints);
  ahead.begin(true);
  auto before = setpoints;
  for (int cycle = 1; cycle < 400; ++cycle) {
    if (cycle == 40) ahead.run(false);
    static_cast<void>(ahead.next({cycle * kPeriod, {}}, setpoints));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double change = setpoints[axis].velocity - before[axis].velocity;
      // The path's own acceleration plus the quarter of the limit that is reserved for braking.
      ASSERT_LE(std::abs(change), 1250.0 * kPeriod) << "cycle " << cycle;
    }
    before = setpoints;
  }
  EXPECT_EQ(setpoints[0].velocity, 0.0);
  EXPECT_DOUBLE_EQ(setpoints[0].position, setpoints[1].position);
}

}  // namespace
}  // namespace driveline::motion
