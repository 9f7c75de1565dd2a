// Groups whose axes are the joints of a machine, and outputs at positions on their paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/trajectory/scara_kinematics.hpp"
#include "group_line.hpp"

namespace driveline::bus_test {
namespace {

using trajectory::ScaraKinematics;

constexpr double kOnPath = 2e-5;  ///< m: whole increments of the joints, 6e-6 rad, on arms of 0.55 m

/// Records the setpoints of the axes when an output changes.
class Noted final : public ecat_master::PathOutputs {
 public:
  void change(const trajectory::PathOutput& output) noexcept override {
    last = output;
    ++changes;
  }
  trajectory::PathOutput last{};
  int changes = 0;
};

/// Four axes that are the joints of a SCARA robot with its elbow to the left.
class MachineLine : public GroupLine {
 public:
  MachineLine(const ScaraKinematics& scara, Noted* outputs, double elbow)
      : GroupLine(4, {config(scara, outputs)}), scara_(scara) {
    for (const auto& [axis, target] : {std::pair{0, 0.3}, std::pair{1, elbow}, std::pair{2, 0.0}, std::pair{3, 0.0}})
      EXPECT_EQ(ask(move(target), static_cast<std::size_t>(axis)).phase, RequestPhase::kDone);
    cycles(50);
    take_axes();
  }
  /// Position of the tool from the demands of the drives.
  [[nodiscard]] GroupVector tool() {
    GroupVector joints{};
    for (std::size_t i = 0; i < 4; ++i)
      joints[i] = drives.drive(i).dictionary().get(slaves::msd::kValue.position_demand) / kDemandIncrements;
    GroupVector made{};
    EXPECT_TRUE(scara_.forward(joints, made));
    return made;
  }

 private:
  static AxisGroupSettings config(const ScaraKinematics& scara, Noted* outputs) {
    AxisGroupSettings made{"arm", {0, 1, 2, 3}};
    made.kinematics = &scara;
    made.tool.max_velocity = 3.0;
    made.outputs = outputs;
    return made;
  }
  const ScaraKinematics& scara_;
};

TEST(GroupMachine, ThePathIsThatOfTheToolAndTheLimitsAreThoseOfTheJoints) {
  const ScaraKinematics scara({.upper_arm = 0.3, .forearm = 0.25, .elbow_left = true});
  Noted outputs;
  MachineLine line(scara, &outputs, 1.2);
  const auto from = line.tool();
  const GroupVector to{from[0] + 0.1, from[1] - 0.3, 0.05, from[3]};
  auto move = line_to(to, 2.0);
  move.path.outputs = {{{7, 1.0}, 0.1}};
  move.path.dwell_s = 0.05;
  auto id = line.groups->move(0, move);
  double worst = 0.0;
  double changed_at = 0.0;
  while (!line.groups->report(id).over()) {
    line.cycle();
    worst = std::max(worst, from_line(line.tool(), from, to));
    if (outputs.changes == 1 && changed_at == 0.0) changed_at = line.groups->group_report(0).length;
  }
  EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
  EXPECT_LT(worst, kOnPath);
  EXPECT_LT(apart(line.tool(), to), kOnPath);
  EXPECT_EQ(outputs.changes, 1);
  EXPECT_EQ(outputs.last.output, 7U);
  // The output changes in the cycle in which the axes pass the position, commanded a cycle later: 0.25 mm at 2 m/s.
  EXPECT_NEAR(changed_at, 0.1, 6e-4);
  // A new path starts where the tool is after the previous one was left.
  id = line.groups->move(0, line_to(from, 2.0));
  line.cycles(1000);
  const auto aborting = line.groups->move(0, line_to(to, 2.0));
  EXPECT_EQ(line.finish_of_group(aborting).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kAborted);
  EXPECT_LT(apart(line.tool(), to), kOnPath);
  line.expect_obedience();
}

TEST(GroupMachine, WhatTheMachineCannotDoIsRefusedWithASentence) {
  const ScaraKinematics scara({.upper_arm = 0.3, .forearm = 0.25, .elbow_left = true});
  const auto reason_of = [](MachineLine& line, const GroupMove& move) {
    const auto id = line.groups->move(0, move);
    EXPECT_EQ(line.finish_of_group(id).error, GroupError::kBadMove);
    return line.groups->refusal(id);
  };
  MachineLine line(scara, nullptr, 1.2);
  const auto from = line.tool();
  EXPECT_NE(reason_of(line, line_to({0.7, 0.0, 0.0, from[3]}, 1.0)), "") << "out of reach";
  auto lit = line_to({from[0] - 0.05, from[1], 0.0, from[3]}, 1.0);
  lit.path.outputs = {{{1, 1.0}, 0.01}};
  EXPECT_EQ(reason_of(line, lit), "the move changes outputs, but the group has none");
  lit.path.outputs.clear();
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, lit)).phase, RequestPhase::kDone);
  line.expect_obedience();
  MachineLine other(scara, nullptr, -1.2);
  EXPECT_EQ(reason_of(other, lit), "joint 1 is at a position that does not match the machine with its tool there");
  EXPECT_EQ(other.group_state(), GroupState::kStandby);
}

TEST(GroupMachine, AMachineWithoutAVelocityOfItsToolOrWithTooManyAxesIsNone) {
  const ScaraKinematics scara({.upper_arm = 0.3, .forearm = 0.25, .elbow_left = true});
  SingleLine line(9);
  const auto refusal_of = [&](const std::vector<std::size_t>& axes, double velocity) -> std::string {
    AxisGroupSettings config{"arm", axes};
    config.kinematics = &scara;
    config.tool.max_velocity = velocity;
    try {
      const AxisGroups groups(line.axes(), {config}, kSinglePeriod);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal_of({0, 1, 2, 3}, std::numeric_limits<double>::infinity()),
            "group 'arm': a machine with kinematics needs a velocity limit of its tool");
  EXPECT_EQ(refusal_of({0, 1}, 1.0), "group 'arm': the machine has 4 joints, the group 2 axes");
  EXPECT_EQ(refusal_of(first_axes(9), 1.0), "group 'arm': kinematics and outputs are for groups of up to 8 axes");
}

}  // namespace
}  // namespace driveline::bus_test
