// Groups whose axes are the joints of a machine, and outputs at positions on their paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <future>
#include <limits>
#include <semaphore>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "driveline/trajectory/scara_kinematics.hpp"
#include "group_line.hpp"

namespace driveline::bus_test {
namespace {

using trajectory::ScaraKinematics;

constexpr double kOnPath = 2e-5;  ///< m: whole increments of the joints, 6e-6 rad, on arms of 0.55 m

/// Records the setpoints of the axes when an output changes.
class Noted final : public motion::PathOutputs {
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
  MachineLine(const trajectory::Kinematics& scara, Noted* outputs, double elbow)
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
  static AxisGroupSettings config(const trajectory::Kinematics& scara, Noted* outputs) {
    AxisGroupSettings made{"arm", {0, 1, 2, 3}};
    made.kinematics = &scara;
    made.tool.max_velocity = 3.0;
    made.outputs = outputs;
    return made;
  }
  const trajectory::Kinematics& scara_;
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
  EXPECT_EQ(line.finish_of_group(line.groups->move(0, line_to(to, 2.0))).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kAborted);
  EXPECT_LT(apart(line.tool(), to), kOnPath);
  line.expect_obedience();
}

/// A machine whose planning can be stopped in the middle.
class HeldUpScara final : public trajectory::Kinematics {
 public:
  explicit HeldUpScara(const ScaraKinematics& scara) : scara_(scara) {}
  [[nodiscard]] std::span<const trajectory::KinematicCoordinate> coordinates() const noexcept override {
    return scara_.coordinates();
  }
  [[nodiscard]] std::span<const trajectory::KinematicCoordinate> joints() const noexcept override {
    return scara_.joints();
  }
  [[nodiscard]] bool forward(const GroupVector& joints, GroupVector& tool) const noexcept override {
    return scara_.forward(joints, tool);
  }
  [[nodiscard]] trajectory::PoseFault inverse(const trajectory::PathGeometry& tool,
                                              trajectory::PathGeometry& joints) const noexcept override {
    if (std::this_thread::get_id() == held_up.load() && !reached.exchange(true)) {
      inside.release();
      go_on.acquire();
    }
    return scara_.inverse(tool, joints);
  }
  [[nodiscard]] std::string explain(const trajectory::PoseFault& fault) const override { return scara_.explain(fault); }

  std::atomic<std::thread::id> held_up{};  ///< the thread that is to be held up
  mutable std::atomic<bool> reached{false};
  mutable std::binary_semaphore inside{0};
  mutable std::binary_semaphore go_on{0};

 private:
  const ScaraKinematics& scara_;
};

/// A path may take long to plan. Neither the client that stops the group, nor the cycle, waits for it.
TEST(GroupMachine, AStopDoesNotWaitForThePlanningOfAPath) {
  const ScaraKinematics scara({.upper_arm = 0.3, .forearm = 0.25, .elbow_left = true});
  HeldUpScara machine(scara);
  MachineLine line(machine, nullptr, 1.2);
  const auto from = line.tool();
  const auto first = line.groups->move(0, line_to({from[0] + 0.1, from[1] - 0.3, from[2], from[3]}, 0.5));
  line.cycles(800);
  ASSERT_EQ(line.group_state(), GroupState::kMoving);
  auto next = line_to(from, 0.5);
  next.buffer = GroupBuffer::kBuffered;
  const auto second = line.groups->move(0, next);
  std::thread planner([&] {
    machine.held_up = std::this_thread::get_id();
    line.groups->plan();
  });
  machine.inside.acquire();
  auto stop = std::async(std::launch::async, [&line] {
    const auto room = line.groups->room(0);
    const auto id = line.submit_to_group(GroupCommand::kStop);
    return room < AxisGroups::kMaxMoves && line.groups->refusal(id).empty() ? id : 0;
  });
  // Where a lock is shared, the thread returns only after the planner.
  const bool returned = stop.wait_for(std::chrono::seconds{10}) == std::future_status::ready;
  EXPECT_TRUE(returned);
  if (returned) {
    line.SingleLine::cycles(1);
    EXPECT_EQ(line.group_state(), GroupState::kStopping);
  }
  machine.go_on.release();
  planner.join();
  EXPECT_EQ(line.finish_of_group(stop.get()).phase, RequestPhase::kDone);
  line.cycles(10);
  EXPECT_EQ(line.group_phase(first), RequestPhase::kAborted);
  EXPECT_EQ(line.group_phase(second), RequestPhase::kAborted);
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
