// Pitch error and backlash: conversion in both directions, without a step, and refusals.
#include "driveline/trajectory/position_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "support/must.hpp"

namespace driveline::trajectory {
namespace {

CorrectionTable wave(bool both = true, double begin = -0.2, double end = 1.0, double step = 0.02) {
  CorrectionTable table;
  table.file = "t.csv";
  table.kind = AxisKind::kLinear;
  const auto points = static_cast<int>(std::lround((end - begin) / step));
  for (int i = 0; i <= points; ++i) {
    const double position = begin + i * step;
    const double forward = 1e-4 * std::sin(9.0 * position) + 2e-5 * position;
    table.points.push_back({position, forward, both ? forward + 3e-5 * std::cos(5.0 * position) : forward, 0});
  }
  return table;
}

PositionCorrection made(const std::optional<CorrectionTable>& table, double backlash) {
  return PositionCorrection::make(table, backlash).value();
}

TEST(PositionCorrection, ThereAndBackIsTheSamePlace) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.4, 1.2);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (const auto& correction : {made(wave(), 4e-5), made(wave(false), 0.0), made(std::nullopt, 4e-5)}) {
    for (int i = 0; i < 2000; ++i) {
      const double axis = place(random);
      const double forward = i % 3 == 0 ? 1.0 : i % 3 == 1 ? 0.0 : share(random);
      EXPECT_NEAR(correction.axis(correction.drive(axis, forward).position, forward), axis, 1e-15);
    }
  }
}

TEST(PositionCorrection, PassesThePointsOfTheTable) {
  const auto table = wave();
  const auto correction = made(table, 4e-5);
  for (const auto& point : table.points) {
    EXPECT_NEAR(correction.drive(point.position, 1.0).position, point.position + point.forward, 1e-15);
    EXPECT_NEAR(correction.drive(point.position, 0.0).position, point.position + point.backward - 4e-5, 1e-15);
    EXPECT_NEAR(correction.gap(point.position), 4e-5 + point.forward - point.backward, 1e-15);
  }
  // Beyond its ends the nearest point counts.
  EXPECT_NEAR(correction.drive(5.0, 1.0).position, 5.0 + table.points.back().forward, 1e-15);
  EXPECT_NEAR(correction.drive(-5.0, 1.0).position, -5.0 + table.points.front().forward, 1e-15);
}

TEST(PositionCorrection, VelocityAndAccelerationOfTheDriveHaveNoStep) {
  const auto correction = made(wave(), 4e-5);
  constexpr double kStep = 1e-5;
  for (const double forward : {0.0, 0.3, 1.0}) {
    auto before = correction.drive(-0.19, forward);
    for (double axis = -0.19 + kStep; axis < 0.98; axis += kStep) {
      const auto now = correction.drive(axis, forward);
      ASSERT_NEAR((now.position - before.position) / kStep, 0.5 * (now.slope + before.slope), 1e-7);
      ASSERT_NEAR((now.slope - before.slope) / kStep, 0.5 * (now.curvature + before.curvature), 1e-5);
      // The curvature is about 1e-2; a step of it would be a share of that.
      ASSERT_LT(std::abs(now.curvature - before.curvature), 20.0 * kStep);
      before = now;
    }
  }
}

TEST(PositionCorrection, ItsBoundsHoldAndAreReached) {
  const auto correction = made(wave(), 4e-5);
  const auto& bounds = correction.bounds();
  double slope = 0.0;
  double curvature = 0.0;
  double gap = 0.0;
  double gap_slope = 0.0;
  for (double axis = -0.3; axis < 1.1; axis += 1e-5) {
    for (const double forward : {0.0, 1.0}) {
      slope = std::max(slope, std::abs(correction.drive(axis, forward).slope - 1.0));
      curvature = std::max(curvature, std::abs(correction.drive(axis, forward).curvature));
    }
    gap = std::max(gap, std::abs(correction.gap(axis)));
    gap_slope = std::max(gap_slope, std::abs(correction.gap(axis + 1e-6) - correction.gap(axis)) / 1e-6);
  }
  EXPECT_LE(slope, bounds.slope);
  EXPECT_GT(slope, 0.999 * bounds.slope);
  EXPECT_LE(curvature, bounds.curvature);
  EXPECT_GT(curvature, 0.99 * bounds.curvature);
  EXPECT_LE(gap, bounds.gap);
  EXPECT_LE(gap_slope, bounds.gap_slope);
}

TEST(PositionCorrection, ThatOfAnEndlessAxisGoesOnBehindItsModulo) {
  CorrectionTable table;
  for (int i = 0; i <= 36; ++i) table.points.push_back({0.1 * i, 0.0, 0.0, 0});
  for (auto& point : table.points) {
    point.forward = 1e-3 * std::sin(point.position * 2.0 * 3.141592653589793 / 3.6);
    point.backward = point.forward;
  }
  table.points.back().forward = table.points.back().backward = table.points.front().forward;
  const auto correction = must(PositionCorrection::make(table, 0.0, 3.6));
  for (double axis = 0.0; axis < 3.6; axis += 0.01) {
    for (const double turns : {-2.0, 1.0, 5.0}) {
      EXPECT_NEAR(correction->drive(axis + turns * 3.6, 1.0).position - turns * 3.6,
                  correction->drive(axis, 1.0).position, 1e-12);
    }
  }
  EXPECT_EQ(PositionCorrection::make(table, 0.0, 4.0).error().message(),
            "the table goes from 0 rad to 3.6 rad; that of an endless axis goes from 0 to its modulo, 4 rad");
}

TEST(PositionCorrectionBadInput, HasOneSentenceWithItsPlace) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "c.csv:1: the file has no header row such as position[mm],correction[um]"},
      {"position[mm]\n",
       "c.csv:1: the header has 1 columns; it must be such as position[mm],correction[um], optionally followed by "
       "backward[um]"},
      {"position[mm];correction[um]\n",
       "c.csv:1: the separator is a comma, and numbers have a decimal point: position[mm],correction[um]"},
      {"place[mm],correction[um]\n",
       "c.csv:1:1: column 'place[mm]' must be position with its unit, such as in position[mm],correction[um]"},
      {"position[mm],correction\n",
       "c.csv:1:14: column 'correction' must be correction with its unit, such as in position[mm],correction[um]"},
      {"position[mm],correction[inch]\n", "c.csv:1:14: unknown unit 'inch'; expected rad, deg, rev, m, mm or um"},
      {"position[mm],correction[deg]\n", "c.csv:1:14: the unit deg does not fit positions in mm"},
      {"position[mm],correction[um]\n0,0\n1,x\n", "c.csv:3:3: 'x' is not a number"},
      {"position[mm],correction[um]\n0,0\n1,nan\n", "c.csv:3:3: 'nan' is not a finite number"},
      {"position[mm],correction[um]\n0,0,0\n",
       "c.csv:2: expected 2 fields as in the header, found 3; the separator is a comma, and numbers have a decimal "
       "point"},
      {"position[mm],correction[um]\n0,0\n", "c.csv: there are 1 points, at least 2 are expected"},
      {"position[mm],correction[um]\n0,0\n5,1\n5,2\n", "c.csv:4: the position 5 mm follows 5 mm: positions must rise"},
      {"position[mm],correction[um]\n0,0\n10,0\n11,100\n12,0\n",
       "c.csv:3: the correction has a slope of 0.153846 at 10 mm, at most 0.05 is expected: no screw has such an "
       "error"},
  };
  for (const auto& [text, sentence] : cases) {
    const auto table = parse_correction_csv(text, "c.csv");
    if (!table) {
      EXPECT_EQ(table.error().message(), sentence);
      continue;
    }
    const auto correction = PositionCorrection::make(*table, 0.0);
    EXPECT_EQ(correction ? "" : correction.error().message(), sentence);
  }
  EXPECT_EQ(load_correction_table("/nowhere/c.csv").error().message(),
            "/nowhere/c.csv: cannot be read: No such file or directory");
}

TEST(PositionCorrection, IsReadWithBothDirections) {
  const auto table =
      must(parse_correction_csv("# laser\nposition[mm], correction[um], backward[um]\n0,1,2\n10,-3,4\n", "c.csv"));
  ASSERT_EQ(table->points.size(), 2U);
  EXPECT_EQ(table->kind, AxisKind::kLinear);
  EXPECT_DOUBLE_EQ(table->points[1].position, 0.01);
  EXPECT_DOUBLE_EQ(table->points[1].forward, -3e-6);
  EXPECT_DOUBLE_EQ(table->points[1].backward, 4e-6);
  EXPECT_EQ(table->points[1].line, 4U);
}

}  // namespace
}  // namespace driveline::trajectory
