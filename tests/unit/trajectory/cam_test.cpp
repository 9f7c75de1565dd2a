#include "driveline/trajectory/cam.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr CamMethod kMethods[] = {CamMethod::kLinear, CamMethod::kCubic, CamMethod::kQuintic, CamMethod::kSpline};
constexpr CamKind kKinds[] = {CamKind::kOneShot, CamKind::kPeriodic, CamKind::kAdvancing};

/// Points of a function of the master, one more than `steps`, unevenly over a turn.
template <typename Function>
CamTable sampled(int steps, Function function) {
  CamTable table;
  for (int i = 0; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    const double master = kTurn * (part + 0.05 * std::sin(kTurn * part) / kTurn);
    CamPoint point;
    point.master = i == steps ? kTurn : master;
    point.slave = function(i == steps ? 0.0 : master);
    table.points.push_back(point);
  }
  return table;
}

CamTable sine(int steps) {
  return sampled(steps, [](double master) { return std::sin(master); });
}

CamTable random_table(test::Random& random, CamKind kind) {
  CamTable table;
  double master = random.real(-10.0, 10.0);
  const auto count = random.index(3, 12);
  for (std::size_t i = 0; i < count; ++i, master += random.magnitude(0.05, 2.0))
    table.points.push_back({master, random.real(-5.0, 5.0), 0.0, 0.0, 0});
  if (kind == CamKind::kPeriodic) table.points.back().slave = table.points.front().slave;
  return table;
}

double worst_error_of_sine(int steps, CamMethod method) {
  const auto cam = Cam::make(sine(steps), method, CamKind::kPeriodic).value();
  double worst = 0.0;
  for (double master = 0.0; master < kTurn; master += 0.001)
    worst = std::max(worst, std::abs(cam.evaluate(master).position - std::sin(master)));
  return worst;
}

TEST(Cam, PassesThroughItsPointsByEveryMethodAndKind) {
  test::Random random;
  for (int round = 0; round < 300; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    for (const auto kind : kKinds) {
      const auto table = random_table(random, kind);
      for (const auto method : kMethods) {
        const auto cam = Cam::make(table, method, kind).value();
        for (const auto& point : table.points) {
          if (kind != CamKind::kOneShot && &point == &table.points.back()) continue;
          ASSERT_NEAR(cam.evaluate(point.master).position, point.slave, 1e-12) << to_text(method) << to_text(kind);
        }
      }
    }
  }
}

// Differences over a small step, at the points and across the end, must agree with slope and curvature.
TEST(Cam, DerivativesAreThoseOfItsPositionAndContinueAcrossTheEnd) {
  test::Random random;
  for (int round = 0; round < 200; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    for (const auto kind : {CamKind::kPeriodic, CamKind::kAdvancing}) {
      const auto table = random_table(random, kind);
      const double length = table.points.back().master - table.points.front().master;
      for (const auto method : {CamMethod::kCubic, CamMethod::kQuintic, CamMethod::kSpline}) {
        const auto cam = Cam::make(table, method, kind).value();
        double sharpest = 1.0;
        for (const auto& point : table.points)
          sharpest = std::max(sharpest, std::abs(cam.evaluate(point.master).curvature));
        for (const auto& point : table.points) {
          constexpr double kNear = 1e-8;
          const auto before = cam.evaluate(point.master + length - kNear);
          const auto behind = cam.evaluate(point.master + length + kNear);
          const double size = 1.0 + std::abs(before.slope) + std::abs(behind.slope);
          ASSERT_NEAR((behind.position - before.position) / (2.0 * kNear), behind.slope, 1e-6 * (size + sharpest));
          ASSERT_NEAR(before.slope, behind.slope, 4.0 * kNear * sharpest);
          const bool smooth = method != CamMethod::kCubic;
          ASSERT_NEAR(before.curvature, smooth ? behind.curvature : before.curvature, 1e-4 * sharpest);
        }
      }
    }
  }
}

// Twice as many points: the error falls with the order of the method.
TEST(Cam, ConvergesWithTheOrderOfItsMethod) {
  const double orders[] = {2.0, 3.0, 3.0, 4.0};
  for (std::size_t i = 0; i < std::size(kMethods); ++i) {
    const double coarse = worst_error_of_sine(32, kMethods[i]);
    const double fine = worst_error_of_sine(64, kMethods[i]);
    EXPECT_GT(std::log2(coarse / fine), orders[i] - 0.3) << to_text(kMethods[i]);
    EXPECT_LT(fine, 2e-3) << to_text(kMethods[i]);
  }
}

TEST(Cam, GivenDerivativesAreReproduced) {
  CamTable table{"", nullptr, nullptr, true, true, {}};
  // s = x^5 on -1 to 1, whose derivatives at both ends are the same or opposite.
  for (const double x : {-1.0, 0.5, 1.0})
    table.points.push_back({x, std::pow(x, 5), 5.0 * std::pow(x, 4), 20.0 * std::pow(x, 3), 0});
  table.points.back().curvature = table.points.front().curvature;
  const auto cam = Cam::make(table, CamMethod::kQuintic, CamKind::kAdvancing).value();
  for (double x = -1.0; x < 0.5; x += 0.01) {
    const auto value = cam.evaluate(x);
    ASSERT_NEAR(value.position, std::pow(x, 5), 1e-13);
    ASSERT_NEAR(value.slope, 5.0 * std::pow(x, 4), 1e-12);
    ASSERT_NEAR(value.curvature, 20.0 * std::pow(x, 3), 1e-11);
  }
}

TEST(Cam, RepeatsAndAdvancesByWholeLifts) {
  CamTable table;
  table.points = {{1.0, 10.0, 0.0, 0.0, 0}, {2.0, 11.0, 0.0, 0.0, 0}, {5.0, 13.0, 0.0, 0.0, 0}};
  const auto feed = Cam::make(table, CamMethod::kSpline, CamKind::kAdvancing).value();
  EXPECT_EQ(feed.lift(), 3.0);
  for (const double master : {1.0, 1.5, 2.0, 4.75}) {
    const double once = feed.evaluate(master).position;
    EXPECT_NEAR(feed.evaluate(master + 4.0 * 1e6).position, once + 3e6, 1e-6);
    EXPECT_NEAR(feed.evaluate(master - 4.0 * 1e6).position, once - 3e6, 1e-6);
  }
  table.points.back().slave = 10.0;
  const auto closed = Cam::make(table, CamMethod::kSpline, CamKind::kPeriodic).value();
  EXPECT_NEAR(closed.evaluate(1.5 - 40.0).position, closed.evaluate(1.5).position, 1e-12);
}

TEST(Cam, AOneShotRestsOutsideOfItsPoints) {
  CamTable table;
  table.points = {{1.0, 10.0, 0.0, 0.0, 0}, {2.0, 11.0, 0.0, 0.0, 0}, {5.0, 13.0, 0.0, 0.0, 0}};
  for (const auto method : {CamMethod::kCubic, CamMethod::kQuintic, CamMethod::kSpline}) {
    const auto cam = Cam::make(table, method, CamKind::kOneShot).value();
    for (const double master : {-1e9, 0.999, 5.0, 7.0, 1e9}) {
      const auto value = cam.evaluate(master);
      EXPECT_EQ(value.position, master < 1.0 ? 10.0 : 13.0);
      EXPECT_EQ(value.slope, 0.0);
      EXPECT_EQ(value.curvature, 0.0);
    }
    EXPECT_NEAR(cam.evaluate(1.0).slope, 0.0, 1e-12);
    EXPECT_NEAR(cam.evaluate(5.0 - 1e-9).slope, 0.0, 1e-7);
  }
  EXPECT_NEAR(Cam::make(table, CamMethod::kQuintic, CamKind::kOneShot)->evaluate(5.0 - 1e-9).curvature, 0.0, 1e-7);
}

TEST(Cam, TakesAnyNumberForTheMaster) {
  for (const auto kind : kKinds) {
    const auto cam = Cam::make(sine(8), CamMethod::kSpline, kind).value();
    for (const double master :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300, -1e300, 1e9})
      EXPECT_LT(std::abs(cam.evaluate(master).position), 1e301) << master;
  }
}

}  // namespace
}  // namespace driveline::trajectory
