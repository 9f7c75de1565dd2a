// Axes of a line that move together along paths, and what the drives demand meanwhile.
#include "driveline/ecat_master/group/axis_groups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "group_line.hpp"

namespace driveline::bus_test {
namespace {

constexpr double kExact = 1e-9;

double distance(const GroupVector& one, const GroupVector& other) {
  double sum = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) sum = std::hypot(sum, one[i] - other[i]);
  return sum;
}

/// From the straight line through two points.
double from_line(const GroupVector& at, const GroupVector& from, const GroupVector& to) {
  double along = 0.0;
  double length2 = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    along += (at[i] - from[i]) * (to[i] - from[i]);
    length2 += (to[i] - from[i]) * (to[i] - from[i]);
  }
  const double share = std::clamp(along / length2, 0.0, 1.0);
  GroupVector foot{};
  for (std::size_t i = 0; i < at.size(); ++i) foot[i] = from[i] + share * (to[i] - from[i]);
  return distance(at, foot);
}

TEST(AxisGroups, MoveAlongAStraightLineTogether) {
  GroupLine line(3);
  line.take_axes();
  EXPECT_EQ(line.state(1), PlcopenState::kSynchronizedMotion);
  const auto from = line.place();
  const GroupVector to{3.0, -2.0, 1.0};
  const auto id = line.groups->move(0, line_to(to));
  double worst = 0.0;
  bool active = false;
  for (int i = 0; i < 8000 && !line.groups->report(id).over(); ++i) {
    line.cycle();
    worst = std::max(worst, from_line(line.place(), from, to));
    active = active || line.group_phase(id) == RequestPhase::kActive;
  }
  EXPECT_TRUE(active);
  EXPECT_EQ(line.group_phase(id), RequestPhase::kDone);
  EXPECT_LT(worst, kExact);
  EXPECT_LT(distance(line.place(), to), kExact);
  EXPECT_EQ(line.group_state(), GroupState::kStandby);
  EXPECT_EQ(line.ask_group(GroupCommand::kDisable).phase, RequestPhase::kDone);
  EXPECT_EQ(line.group_state(), GroupState::kDisabled);
  line.cycles(10);
  EXPECT_EQ(line.state(1), PlcopenState::kStandstill);
  EXPECT_EQ(line.ask(move(0.5), 1).phase, RequestPhase::kDone);
  line.expect_obedience();
}

}  // namespace
}  // namespace driveline::bus_test
