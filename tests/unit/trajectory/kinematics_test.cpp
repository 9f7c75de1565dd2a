#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>

#include "driveline/trajectory/cartesian_kinematics.hpp"
#include "driveline/trajectory/delta_kinematics.hpp"
#include "driveline/trajectory/kinematic_kinds.hpp"
#include "driveline/trajectory/machine.hpp"
#include "driveline/trajectory/scara_kinematics.hpp"
#include "move_oracle.hpp"

namespace driveline::trajectory {
namespace {

using Kind = PoseFault::Kind;

/// A machine, and a box that its tool can reach completely.
struct Machine {
  std::string name;
  std::unique_ptr<Kinematics> kinematics;
  GroupVector low;
  GroupVector high;
};

std::vector<Machine> machines() {
  std::vector<Machine> all;
  all.push_back({"cartesian", std::make_unique<CartesianKinematics>(), {-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}});
  for (const bool left : {false, true}) {
    all.push_back({left ? "scara, left" : "scara",
                   std::make_unique<ScaraKinematics>(ScaraKinematics::Shape{0.35, 0.25, left}),
                   {0.2, -0.3, -0.2, -3.0},
                   {0.45, 0.3, 0.0, 3.0}});
  }
  all.push_back({"delta",
                 std::make_unique<RotaryDeltaKinematics>(RotaryDeltaKinematics::Shape{0.2, 0.045, 0.25, 0.6}),
                 {-0.15, -0.15, -0.65},
                 {0.15, 0.15, -0.45}});
  all.push_back({"linear delta",
                 std::make_unique<LinearDeltaKinematics>(LinearDeltaKinematics::Shape{0.25, 0.04, 0.5}),
                 {-0.1, -0.1, 0.0},
                 {0.1, 0.1, 0.3}});
  return all;
}

GroupVector random_place(test::Random& random, const Machine& machine) {
  GroupVector place{};
  for (std::size_t i = 0; i < machine.kinematics->coordinates().size(); ++i) {
    place[i] = random.real(machine.low[i], machine.high[i]);
  }
  return place;
}

PathGeometry joints_at(const Machine& machine, const PathPiece& piece, double length) {
  PathGeometry joints;
  EXPECT_EQ(machine.kinematics->inverse(piece.at(length), joints).kind, Kind::kNone) << machine.name;
  return joints;
}

TEST(Kinematics, ForwardUndoesInverseEverywhere) {
  test::Random random;
  for (const auto& machine : machines()) {
    for (int round = 0; round < 2000; ++round) {
      DRIVELINE_TRACE_SEED(random, round);
      PathGeometry tool;
      tool.position = random_place(random, machine);
      PathGeometry joints;
      ASSERT_EQ(machine.kinematics->inverse(tool, joints).kind, Kind::kNone) << machine.name;
      GroupVector back{};
      ASSERT_TRUE(machine.kinematics->forward(joints.position, back));
      ASSERT_LT(test::distance(back, tool.position), 1e-12) << machine.name;
    }
  }
}

TEST(Kinematics, DerivativesAreThoseOfThePlacesOfTheJoints) {
  test::Random random;
  for (const auto& machine : machines()) {
    for (int round = 0; round < 300; ++round) {
      DRIVELINE_TRACE_SEED(random, round);
      // A helix: all derivatives of the tool are non-zero.
      CircularArc arc;
      arc.center = random_place(random, machine);
      arc.to_start[0] = 0.03;
      arc.across[1] = 0.03;
      arc.rise[2] = 0.02;
      arc.angle_rad = 2.0;
      const auto piece = PathPiece::arc(arc);
      const double s = random.real(0.01, 0.05);
      const double h = 1e-3;
      const auto before = joints_at(machine, piece, s - h);
      const auto there = joints_at(machine, piece, s);
      const auto behind = joints_at(machine, piece, s + h);
      for (std::size_t i = 0; i < machine.kinematics->joints().size(); ++i) {
        const auto difference = [&](const GroupVector PathGeometry::*of) {
          return ((behind.*of)[i] - (before.*of)[i]) / (2.0 * h);
        };
        // Central differences are off by h^2 / 6 times the third derivative of what is differentiated.
        ASSERT_NEAR(difference(&PathGeometry::position), there.first[i], 2e-3 + 1e-3 * std::abs(there.first[i]));
        ASSERT_NEAR(difference(&PathGeometry::first), there.second[i], 0.5 + 1e-2 * std::abs(there.second[i]));
        ASSERT_NEAR(difference(&PathGeometry::second), there.third[i], 40.0 + 2e-2 * std::abs(there.third[i]));
      }
    }
  }
}

TEST(Kinematics, AScaraIsWhereItsAnglesSay) {
  const ScaraKinematics scara({0.3, 0.2, true});
  PathGeometry tool;
  tool.position = {0.3, 0.2, -0.1, 0.5};  // the forearm square to the upper arm, which is along x
  PathGeometry joints;
  ASSERT_EQ(scara.inverse(tool, joints).kind, Kind::kNone);
  EXPECT_NEAR(joints.position[0], 0.0, 1e-15);
  EXPECT_NEAR(joints.position[1], std::numbers::pi / 2.0, 1e-15);
  EXPECT_EQ(joints.position[2], -0.1);
  EXPECT_NEAR(joints.position[3], 0.5 - std::numbers::pi / 2.0, 1e-15);
}

TEST(Kinematics, ADeltaInTheMiddleHasEqualJointsAndItsRodsAreAsLongAsTheyAre) {
  const RotaryDeltaKinematics delta({0.2, 0.05, 0.25, 0.6});
  PathGeometry tool;
  tool.position = {0.0, 0.0, -0.6};
  PathGeometry joints;
  ASSERT_EQ(delta.inverse(tool, joints).kind, Kind::kNone);
  EXPECT_NEAR(joints.position[0], joints.position[1], 1e-14);
  EXPECT_NEAR(joints.position[0], joints.position[2], 1e-14);
  const double angle = joints.position[0];
  EXPECT_NEAR(std::hypot(0.15 + 0.25 * std::cos(angle), 0.6 - 0.25 * std::sin(angle)), 0.6, 1e-14);
  EXPECT_LT(std::abs(angle), std::numbers::pi / 2.0);  // knees outside
}

TEST(Kinematics, PlacesOutOfReachAndSingularOnesAreToldApart) {
  const ScaraKinematics scara({0.3, 0.2, true});
  const auto kind_at = [](const Kinematics& machine, const GroupVector& place) {
    PathGeometry tool;
    tool.position = place;
    PathGeometry joints;
    return machine.inverse(tool, joints);
  };
  EXPECT_EQ(kind_at(scara, {0.51}).kind, Kind::kUnreachable);
  EXPECT_EQ(kind_at(scara, {0.09}).kind, Kind::kUnreachable);
  EXPECT_EQ(kind_at(scara, {0.49999}).kind, Kind::kSingular);
  EXPECT_EQ(kind_at(scara, {0.10001}).kind, Kind::kSingular);
  EXPECT_EQ(kind_at(scara, {0.4}).kind, Kind::kNone);
  EXPECT_EQ(scara.explain(kind_at(scara, {0.51})), "the arms reach from 0.1 m to 0.5 m");
  EXPECT_EQ(scara.explain(kind_at(scara, {0.49999})), "the arms would be stretched or folded there");

  const RotaryDeltaKinematics delta({0.2, 0.05, 0.25, 0.6});
  EXPECT_EQ(kind_at(delta, {0.0, 0.0, -0.9}).kind, Kind::kUnreachable);
  EXPECT_EQ(kind_at(delta, {0.9, 0.0, -0.5}).kind, Kind::kUnreachable);
  EXPECT_EQ(delta.explain(kind_at(delta, {0.9, 0.0, -0.5})), "chain 1 is too short or too long for it");
  // Straight down the arm and its rods are in line just above this.
  const double lowest = -std::sqrt(0.85 * 0.85 - 0.15 * 0.15);
  EXPECT_EQ(kind_at(delta, {0.0, 0.0, lowest + 1e-5}).kind, Kind::kSingular);
  EXPECT_EQ(delta.explain(kind_at(delta, {0.0, 0.0, lowest + 1e-5})), "arm and rods of chain 1 would be in line there");
  // Level with its knees the platform is not constrained, and above them the solution would be inverted.
  const LinearDeltaKinematics linear({0.25, 0.04, 0.5});
  EXPECT_EQ(kind_at(linear, {0.0, 0.0, 0.3}).kind, Kind::kNone);
  const LinearDeltaKinematics flat({0.25, 0.04, 0.21001});
  EXPECT_EQ(kind_at(flat, {0.0, 0.0, 0.3}).kind, Kind::kSingular);
  const RotaryDeltaKinematics narrow({0.2, 0.2, 0.001, 0.6});
  EXPECT_EQ(narrow.explain(kind_at(narrow, {0.0, 0.0, -0.6})),
            "the rods would be in one plane there and could not hold the platform");
}

TEST(Kinematics, LengthsThatAreNoneAreRefused) {
  EXPECT_THROW(ScaraKinematics({0.0, 0.2, false}), std::invalid_argument);
  EXPECT_THROW(ScaraKinematics({0.3, std::nan(""), false}), std::invalid_argument);
  EXPECT_THROW(RotaryDeltaKinematics({0.2, 0.05, 0.25, -0.6}), std::invalid_argument);
  EXPECT_THROW(LinearDeltaKinematics({0.0, 0.05, 0.6}), std::invalid_argument);
}

TEST(KinematicKinds, AreMadeByTheirNames) {
  const auto refusal = [](std::string_view kind, std::vector<KinematicParameter> parameters) {
    const auto made = make_kinematics(kind, parameters);
    return made ? "" : made.error().reason;
  };
  EXPECT_EQ(refusal("cartesian", {}), "");
  EXPECT_EQ(refusal("scara", {{"upper_arm", 0.3}, {"forearm", 0.2}, {"elbow_left", 1.0}}), "");
  EXPECT_EQ(refusal("delta", {{"base_radius", 0.2}, {"platform_radius", 0.05}, {"upper_arm", 0.25}, {"rod", 0.6}}), "");
  EXPECT_EQ(refusal("linear_delta", {{"column_radius", 0.2}, {"platform_radius", 0.05}, {"rod", 0.6}}), "");
  EXPECT_EQ(refusal("hexapod", {}),
            "there is no machine of kind 'hexapod'; there are cartesian, scara, delta and linear_delta");
  EXPECT_EQ(refusal("scara", {{"upper_arm", 0.3}}), "a machine of kind scara needs forearm");
  EXPECT_EQ(refusal("scara", {{"upper_arm", 0.3}, {"forearm", 0.0}}), "forearm is 0 m; it must be above 0");
  EXPECT_EQ(refusal("scara", {{"upper_arm", 0.3}, {"upper_arm", 0.3}}), "there are two values of upper_arm");
  EXPECT_EQ(refusal("scara", {{"rod", 0.3}}), "a machine of kind scara has no 'rod'");
}

TEST(Machine, HasTheUnitsOfItsFileAndKnowsAnotherOne) {
  const auto arm =
      trajectory::Machine::make("scara", "mm", {{"upper_arm", 350.0}, {"forearm", 250.0}, {"elbow_left", 1.0, true}});
  ASSERT_TRUE(arm) << arm.error().reason;
  const auto* const degree = find_position_unit("deg");
  const auto* const metre = find_position_unit("m");
  const std::vector<NamedAxis> axes{{"a", degree}, {"b", degree}, {"lift", metre}, {"c", degree}, {"track", metre}};
  EXPECT_EQ(arm->fault_of(axes), "");
  const auto coordinates = arm->coordinates(axes);
  ASSERT_EQ(coordinates.size(), 5U);
  EXPECT_EQ(coordinates[0].name, "x");
  EXPECT_EQ(coordinates[0].unit->name, "mm");
  EXPECT_EQ(coordinates[3].name, "c");
  EXPECT_EQ(coordinates[3].unit, degree);
  EXPECT_EQ(coordinates[4].name, "track");
  EXPECT_EQ(coordinates[4].unit, metre);
  GroupVector tool{};
  ASSERT_TRUE(arm->kinematics().forward({}, tool));
  EXPECT_DOUBLE_EQ(tool[0], 0.6);
  const std::vector<NamedAxis> wrong{{"a", degree}, {"b", metre}, {"lift", metre}, {"c", degree}};
  EXPECT_EQ(arm->fault_of(wrong), "axis b is a turning joint of the machine; its unit must be one of angles");
  EXPECT_EQ(arm->fault_of(std::span(wrong).first(3)), "the machine has 4 joints, the group 3 axes");

  const auto difference = [&](std::string_view kind, std::vector<MachineValue> values) {
    const auto other = trajectory::Machine::make(kind, "m", std::move(values));
    return other ? arm->difference_to(*other) : other.error().reason;
  };
  EXPECT_EQ(difference("scara", {{"forearm", 0.25}, {"elbow_left", 1.0, true}, {"upper_arm", 0.35}}), "");
  EXPECT_EQ(difference("scara", {{"forearm", 0.25}, {"upper_arm", 0.35}}), "elbow_left is false, not true");
  EXPECT_EQ(difference("scara", {{"forearm", 0.3}, {"upper_arm", 0.35}}), "forearm is 300 mm, not 250 mm");
  EXPECT_EQ(difference("cartesian", {}), "its kind is cartesian, not scara");
  EXPECT_EQ(difference("scara", {{"elbow_left", 1.0}}), "elbow_left must be true or false");
  EXPECT_EQ(difference("scara", {{"forearm", 1.0, true}}), "forearm must be a number");
  EXPECT_EQ(difference("scaar", {{"elbow_left", 1.0}}),
            "there is no machine of kind 'scaar'; there are cartesian, scara, delta and linear_delta");
  EXPECT_EQ(trajectory::Machine::make("cartesian", "deg", {}).error().key, "unit");
}

}  // namespace
}  // namespace driveline::trajectory
