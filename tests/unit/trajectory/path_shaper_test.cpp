#include "driveline/trajectory/path_shaper.hpp"

#include <gtest/gtest.h>

#include "driveline/trajectory/interpolator.hpp"
#include "move_oracle.hpp"

namespace driveline::trajectory {
namespace {

using test::arc_by;
using test::distance;
using test::line_to;
using test::MovePlan;

constexpr double kAnyFeed = 1.0;

std::vector<ShapedPiece> shape(std::size_t axes, const MovePlan& plan) {
  PathShaper shaper(axes, plan.start);
  std::vector<ShapedPiece> out;
  for (const auto& move : plan.moves) {
    const auto added = shaper.add(move, out);
    if (!added) throw std::runtime_error(added.error().reason);
  }
  shaper.finish(out);
  return out;
}

std::string refusal(std::size_t axes, const MovePlan& plan) {
  PathShaper shaper(axes, plan.start);
  std::vector<ShapedPiece> out;
  for (const auto& move : plan.moves) {
    if (const auto added = shaper.add(move, out); !added) return added.error().reason;
  }
  return "";
}

double length_of(const GroupVector& v) {
  return distance(v, {});
}

/// Position, direction and curvature are continuous, unless the axes stop.
void expect_smooth(const std::vector<ShapedPiece>& pieces) {
  for (std::size_t k = 1; k < pieces.size(); ++k) {
    const auto before = pieces[k - 1].piece.at(pieces[k - 1].piece.length());
    const auto behind = pieces[k].piece.at(0.0);
    ASSERT_LT(distance(before.position, behind.position), 1e-9) << "piece " << k;
    if (pieces[k - 1].stops) continue;
    ASSERT_LT(distance(before.first, behind.first), 1e-8) << "piece " << k;
    ASSERT_LT(distance(before.second, behind.second), 1e-6 * (1.0 + length_of(before.second))) << "piece " << k;
  }
}

double largest_distance(const std::vector<ShapedPiece>& pieces, const MovePlan& plan, std::size_t samples) {
  double worst = 0.0;
  for (const auto& piece : pieces) {
    for (std::size_t k = 0; k <= samples; ++k) {
      const auto place = piece.piece.at(piece.piece.length() * static_cast<double>(k) / static_cast<double>(samples));
      double nearest = 1e9;
      for (std::size_t m = 0; m < plan.moves.size(); ++m) {
        nearest = std::min(nearest, test::distance_from_move(place.position, plan, m));
      }
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

TEST(PathShaper, RoundsACornerByExactlyTheTolerance) {
  const MovePlan plan{{}, {line_to({0.1, 0.0}, kAnyFeed, 1e-3), line_to({0.1, 0.1}, kAnyFeed, 0.0)}};
  const auto pieces = shape(2, plan);
  expect_smooth(pieces);
  EXPECT_NEAR(largest_distance(pieces, plan, 400), 1e-3 / std::sqrt(2.0), 1e-8);  // from the nearest leg
  double from_corner = 1.0;
  for (const auto& piece : pieces) {
    for (int k = 0; k <= 400; ++k) {
      from_corner =
          std::min(from_corner, distance(piece.piece.at(piece.piece.length() * k / 400.0).position, {0.1, 0.0}));
    }
  }
  EXPECT_NEAR(from_corner, 1e-3, 1e-7);
}

TEST(PathShaper, LeavesHalfOfAShortLineToEachCorner) {
  const MovePlan plan{
      {}, {line_to({1.0, 0.0}, kAnyFeed, 1.0), line_to({1.0, 0.1}, kAnyFeed, 1.0), line_to({0.0, 0.1}, kAnyFeed, 1.0)}};
  const auto pieces = shape(2, plan);
  expect_smooth(pieces);
  EXPECT_LT(largest_distance(pieces, plan, 100), 0.375 * 0.05);
  EXPECT_DOUBLE_EQ(pieces.back().piece.at(pieces.back().piece.length()).position[0], 0.0);
}

TEST(PathShaper, StopsInACornerWithoutTolerance) {
  const MovePlan plan{{}, {line_to({0.1}, kAnyFeed, 0.0), line_to({0.1, 0.1}, kAnyFeed, 0.0)}};
  const auto pieces = shape(2, plan);
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_TRUE(pieces[0].stops);
  EXPECT_TRUE(pieces[1].stops);
}

TEST(PathShaper, GoesOnThroughAJointThatIsNoCorner) {
  const MovePlan plan{{}, {line_to({0.1}, kAnyFeed, 0.0), line_to({0.3}, kAnyFeed, 0.0)}};
  const auto pieces = shape(1, plan);
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_FALSE(pieces[0].stops);
}

TEST(PathShaper, RandomPathsAreSmoothAndWithinTheirTolerance) {
  test::Random random;
  for (int round = 0; round < 300; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const std::size_t axes = random.index(1, kMaxGroupAxes);
    const auto plan = test::random_moves(random, axes, 8, 0.2);
    if (const auto refused = refusal(axes, plan); !refused.empty()) {
      ASSERT_TRUE(refused.find("reverses") != std::string::npos) << refused;
      continue;
    }
    const auto pieces = shape(axes, plan);
    expect_smooth(pieces);
    double tolerance = 0.0;
    for (const auto& move : plan.moves) tolerance = std::max(tolerance, move.tolerance);
    ASSERT_LE(largest_distance(pieces, plan, 20), tolerance + 1e-9);
    ASSERT_LT(distance(pieces.back().piece.at(pieces.back().piece.length()).position, plan.moves.back().target), 1e-9);
  }
}

TEST(PathShaper, LengthIsTheParameterAndDerivativesAreRight) {
  test::Random random;
  for (int round = 0; round < 100; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    const auto plan = test::random_moves(random, 3, 6, 0.2);
    if (!refusal(3, plan).empty()) continue;
    for (const auto& shaped : shape(3, plan)) {
      const auto& piece = shaped.piece;
      const auto bounds = piece.bounds(0.0, std::min(piece.length(), 0.4 * 0.04));
      for (int k = 1; k < 40; ++k) {
        const double step = piece.length() * 1e-4;
        const double s = piece.length() * k / 40.0;
        const auto low = piece.at(s - step);
        const auto here = piece.at(s);
        const auto high = piece.at(s + step);
        ASSERT_NEAR(length_of(here.first), 1.0, PathPiece::kLengthError);
        for (std::size_t i = 0; i < 3; ++i) {
          const double scale = 1e-3 * (1.0 + length_of(here.third));
          ASSERT_NEAR((high.position[i] - low.position[i]) / (2.0 * step), here.first[i], 1e-4);
          ASSERT_NEAR((high.first[i] - low.first[i]) / (2.0 * step), here.second[i], scale * piece.length() + 1e-6);
          ASSERT_NEAR((high.second[i] - low.second[i]) / (2.0 * step), here.third[i], 10.0 * scale);
          if (s > 0.4 * 0.04) continue;
          ASSERT_LE(std::abs(here.first[i]), bounds.first[i] + 1e-12);
          ASSERT_LE(std::abs(here.second[i]), bounds.second[i] * (1.0 + 1e-9) + 1e-12);
          ASSERT_LE(std::abs(here.third[i]), bounds.third[i] * (1.0 + 1e-9) + 1e-9);
        }
      }
    }
  }
}

TEST(PathShaper, BoundsOfFlatCornersAreReachedAndNotExceededOnAnyPartOfThem) {
  test::Random random;
  for (int round = 0; round < 100; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    MovePlan plan{{}, {line_to({0.1, 0.2, -0.1}, kAnyFeed, 1e-5)}};
    plan.moves.push_back(line_to({0.2, 0.4 + random.real(1e-4, 2e-3), -0.2}, kAnyFeed, 0.0));
    const auto pieces = shape(3, plan);
    ASSERT_EQ(pieces.size(), 3U);
    const auto& corner = pieces[1].piece;
    ASSERT_TRUE(corner.is_flat() && !corner.is_line());
    const double begin = random.real(0.0, 0.9) * corner.length();
    const double end = random.real(begin, corner.length());
    const auto bounds = corner.bounds(begin, end);
    PathBounds seen;
    constexpr int kPlaces = 1000;
    for (int k = 0; k <= kPlaces; ++k) {
      const auto there = corner.at(begin + (end - begin) * k / kPlaces);
      for (std::size_t i = 0; i < 3; ++i) {
        seen.first[i] = std::max(seen.first[i], std::abs(there.first[i]));
        seen.second[i] = std::max(seen.second[i], std::abs(there.second[i]));
        seen.third[i] = std::max(seen.third[i], std::abs(there.third[i]));
      }
    }
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(bounds.first[i], seen.first[i], 1e-9);
      EXPECT_NEAR(bounds.second[i], seen.second[i], 1e-5 * seen.second[i] + 1e-12);
      EXPECT_NEAR(bounds.third[i], seen.third[i], 1e-5 * seen.third[i] + 1e-12);
    }
  }
}

TEST(PathShaper, AnArcAroundACentreKeepsItsRadius) {
  MovePlan plan{{0.2, 0.1, 0.5}, {arc_by({0.2, 0.1, 0.5}, 0.1, 0.1, -4.0, kAnyFeed, 0.0)}};
  plan.moves[0].target[2] = 0.9;  // a helix
  const auto pieces = shape(3, plan);
  ASSERT_EQ(pieces.size(), 1U);
  const auto& piece = pieces[0].piece;
  EXPECT_NEAR(piece.length(), std::hypot(0.4, 0.4), 1e-12);
  for (int k = 0; k <= 10; ++k) {
    const auto place = piece.at(piece.length() * k / 10.0).position;
    EXPECT_NEAR(std::hypot(place[0] - 0.1, place[1] - 0.1), 0.1, 1e-12);
    EXPECT_NEAR(place[2], 0.5 + 0.04 * k, 1e-12);
  }
  EXPECT_LT(distance(piece.at(piece.length()).position, plan.moves[0].target), 1e-12);
}

TEST(PathShaper, AnArcThatEndsWhereItBeginsIsAWholeCircle) {
  MovePlan plan{{0.2}, {arc_by({0.2}, 0.1, 0.0, 1.0, kAnyFeed, 0.0)}};
  plan.moves[0].target = plan.start;
  EXPECT_NEAR(shape(2, plan)[0].piece.length(), 0.2 * std::numbers::pi, 1e-12);
}

TEST(PathShaper, AnArcPassesThroughItsPointOnTheWay) {
  test::Random random;
  for (int round = 0; round < 200; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    MovePlan plan;
    PathMove move = line_to({}, kAnyFeed, 0.0);
    move.kind = PathMove::Kind::kArcVia;
    for (std::size_t i = 0; i < 3; ++i) {
      plan.start[i] = random.real(-1.0, 1.0);
      move.via[i] = random.real(-1.0, 1.0);
      move.target[i] = random.real(-1.0, 1.0);
    }
    plan.moves = {move};
    const auto pieces = shape(3, plan);
    const auto& piece = pieces.at(0).piece;
    double nearest = 10.0;
    for (int k = 0; k <= 4000; ++k) {
      nearest = std::min(nearest, distance(piece.at(piece.length() * k / 4000.0).position, move.via));
    }
    ASSERT_LT(nearest, piece.length() / 4000.0);
    ASSERT_LT(distance(piece.at(0.0).position, plan.start), 1e-9);
    ASSERT_LT(distance(piece.at(piece.length()).position, move.target), 1e-9 * (1.0 + piece.length()));
  }
}

// The interpolator of time paths has a natural spline of its own: with the chords as time it is the same curve.
TEST(PathShaper, ASplineIsTheNaturalOneThroughItsPoints) {
  test::Random random;
  std::vector<double> chords{0.0};
  std::vector<std::vector<double>> rows{{0.0, 0.0}};
  PathMove move = line_to({}, kAnyFeed, 0.0);
  move.kind = PathMove::Kind::kSpline;
  for (std::size_t k = 1; k < 9; ++k) {
    rows.push_back({rows.back()[0] + random.real(0.05, 0.1), random.real(-0.1, 0.1)});
    move.points.push_back({rows.back()[0], rows.back()[1]});
    chords.push_back(chords.back() + std::hypot(rows[k][0] - rows[k - 1][0], rows[k][1] - rows[k - 1][1]));
  }
  auto reference = Interpolator::natural_spline(test::make_path(chords, rows));
  const auto pieces = shape(2, {{}, {move}});
  expect_smooth(pieces);
  std::vector<GroupVector> curve;
  for (int k = 0; k <= 20000; ++k) {
    const auto there = test::evaluate_all(reference, chords.back() * k / 20000.0);
    curve.push_back({there[0].position, there[1].position});
  }
  for (const auto& piece : pieces) {
    for (int k = 0; k <= 8; ++k) {
      const auto place = piece.piece.at(piece.piece.length() * k / 8.0).position;
      double nearest = 1.0;
      for (std::size_t m = 1; m < curve.size(); ++m) {
        nearest = std::min(nearest, test::distance_from_line(place, curve[m - 1], curve[m]));
      }
      ASSERT_LT(nearest, 1e-8);
    }
  }
}

TEST(PathShaper, AMoveWithoutLengthIsLeftOut) {
  const MovePlan plan{{},
                      {line_to({0.1}, kAnyFeed, 0.0), line_to({0.1}, kAnyFeed, 0.0), line_to({0.2}, kAnyFeed, 0.0)}};
  EXPECT_EQ(shape(1, plan).size(), 2U);
}

TEST(PathShaperBadInput, IsRefusedWithASentence) {
  const double nan = std::nan("");
  const auto reason = [](const PathMove& move, double first_tolerance = 1e-3) {
    return refusal(2, {{}, {line_to({1.0}, kAnyFeed, first_tolerance), move}});
  };
  EXPECT_EQ(
      reason(line_to({0.0}, kAnyFeed, 0.0)),
      "the path reverses where the move starts, and such a corner cannot be rounded; a tolerance of 0 stops there");
  EXPECT_EQ(reason(line_to({nan}, kAnyFeed, 0.0)), "the target of axis 1 is nan; positions lie within +-1e6 m or rad");
  EXPECT_EQ(reason(line_to({2.0, 0.0, 1.0}, kAnyFeed, 0.0)), "the target has a value for axis 3 of 2");
  EXPECT_EQ(reason(line_to({2.0}, 0.0, 0.0)), "the feed is 0; it must be above 0");
  EXPECT_EQ(reason(line_to({2.0}, nan, 0.0)), "the feed is nan; it must be above 0");
  EXPECT_EQ(reason(line_to({2.0}, kAnyFeed, -1.0)), "the tolerance is -1; it must be 0 or more, and finite");
  EXPECT_EQ(reason(line_to({2.0}, kAnyFeed, nan)), "the tolerance is nan; it must be 0 or more, and finite");
  EXPECT_EQ(reason(arc_by({1.0}, 1.0, 0.0005, 1.0, kAnyFeed, 1e-3)),
            "the radius of the arc, 0.0005 m, is below the tolerance of 0.001 m");
  auto open = arc_by({1.0}, 1.0, 0.5, 1.0, kAnyFeed, 0.0);
  open.target[1] += 0.01;
  EXPECT_EQ(reason(open).substr(0, 22), "the arc does not close");
  EXPECT_EQ(reason(arc_by({1.0}, 1.0, 0.0, 1.0, kAnyFeed, 0.0)), "the arc starts at its own centre");
  auto one_axis = arc_by({1.0}, 1.0, 0.5, 1.0, kAnyFeed, 0.0);
  one_axis.second_axis = 0;
  EXPECT_EQ(reason(one_axis), "an arc around a centre needs two different axes of the group");
  auto straight = line_to({2.0}, kAnyFeed, 0.0);
  straight.kind = PathMove::Kind::kArcVia;
  straight.via = {1.5};
  EXPECT_EQ(reason(straight), "the three points of the arc are on a straight line, or two of them are the same");
  auto empty = line_to({2.0}, kAnyFeed, 0.0);
  empty.kind = PathMove::Kind::kSpline;
  EXPECT_EQ(reason(empty), "a spline needs at least one point");
  EXPECT_EQ(reason(line_to({1.0, 1e-8}, kAnyFeed, 0.0)),
            "the corner before it cannot be rounded: the moves are too short for a blend");
}

TEST(PathShaperBadInput, LeavesThePathAsItWas) {
  PathShaper shaper(2, {});
  std::vector<ShapedPiece> out;
  ASSERT_TRUE(shaper.add(line_to({1.0}, kAnyFeed, 1e-3), out));
  ASSERT_FALSE(shaper.add(line_to({0.0}, kAnyFeed, 1e-3), out));
  ASSERT_TRUE(shaper.add(line_to({1.0, 1.0}, kAnyFeed, 0.0), out));
  shaper.finish(out);
  expect_smooth(out);
  EXPECT_LT(distance(out.back().piece.at(out.back().piece.length()).position, {1.0, 1.0}), 1e-12);
}

TEST(PathShaperBadInput, AGroupHasOneToEightAxes) {
  EXPECT_THROW(PathShaper(0, {}), std::invalid_argument);
  EXPECT_THROW(PathShaper(9, {}), std::invalid_argument);
  EXPECT_THROW(PathShaper(1, {0.0, 1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::trajectory
