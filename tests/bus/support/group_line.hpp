#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "driveline/motion/group/axis_groups.hpp"
#include "single_line.hpp"

namespace driveline::bus_test {

using motion::AxisGroups;
using motion::AxisGroupSettings;
using motion::GroupBuffer;
using motion::GroupCommand;
using motion::GroupError;
using motion::GroupMove;
using motion::GroupReport;
using motion::GroupRequestReport;
using motion::GroupState;
using trajectory::GroupVector;
using trajectory::PathMove;

inline std::vector<std::size_t> first_axes(std::size_t count) {
  std::vector<std::size_t> axes(count);
  std::iota(axes.begin(), axes.end(), std::size_t{0});
  return axes;
}

inline GroupMove line_to(const GroupVector& target, double feed = 20.0) {
  GroupMove made;
  made.path.target = target;
  made.path.feed = feed;
  return made;
}

/// Distance between two positions.
inline double apart(const GroupVector& one, const GroupVector& other) {
  double sum = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) sum = std::hypot(sum, one[i] - other[i]);
  return sum;
}

/// Distance from the straight line between two positions.
inline double from_line(const GroupVector& at, const GroupVector& from, const GroupVector& to) {
  double along = 0.0;
  double length2 = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    along += (at[i] - from[i]) * (to[i] - from[i]);
    length2 += (to[i] - from[i]) * (to[i] - from[i]);
  }
  const double share = length2 > 0.0 ? std::clamp(along / length2, 0.0, 1.0) : 0.0;
  GroupVector foot{};
  for (std::size_t i = 0; i < at.size(); ++i) foot[i] = from[i] + share * (to[i] - from[i]);
  return apart(at, foot);
}

/// A line of axes in operation; the first ones form a group, which is planned in every cycle.
class GroupLine : public SingleLine {
 public:
  explicit GroupLine(std::size_t axes, std::vector<AxisGroupSettings> configs = {},
                     const RunOptions& options = single_options())
      : SingleLine(axes, options) {
    if (configs.empty()) configs.push_back({"plotter", first_axes(axes)});
    groups = std::make_unique<AxisGroups>(this->axes(), std::move(configs), kSinglePeriod);
    std::vector<std::uint64_t> enabled;
    for (std::size_t i = 0; i < axes; ++i) enabled.push_back(submit(power(true), i));
    for (const auto id : enabled) EXPECT_EQ(SingleLine::finish(id).phase, RequestPhase::kDone);
    SingleLine::cycles(10);
  }

  void cycle() {
    groups->plan();
    SingleLine::cycle();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  std::uint64_t submit_to_group(GroupCommand command, double value = 0.0, std::size_t group = 0) {
    return groups->submit(group, {command, value});
  }
  GroupRequestReport finish_of_group(std::uint64_t id, int at_most = 16000) {
    for (int i = 0; i < at_most && !groups->report(id).over(); ++i) cycle();
    return groups->report(id);
  }
  GroupRequestReport ask_group(GroupCommand command, double value = 0.0, std::size_t group = 0) {
    return finish_of_group(submit_to_group(command, value, group));
  }
  /// Runs cycles until the request is over, or `at_most` cycles (one second).
  RequestReport finish(std::uint64_t id, int at_most = 8000) {
    for (int i = 0; i < at_most && !axes().report(id).over(); ++i) cycle();
    return axes().report(id);
  }
  RequestReport ask(const AxisRequest& asked, std::size_t axis = 0) { return finish(submit(asked, axis)); }
  void take_axes(std::size_t group = 0) {
    ASSERT_EQ(ask_group(GroupCommand::kEnable, 0.0, group).phase, RequestPhase::kDone);
    ASSERT_EQ(group_state(group), GroupState::kStandby);
  }
  [[nodiscard]] GroupState group_state(std::size_t group = 0) const { return groups->group_report(group).state; }
  [[nodiscard]] RequestPhase group_phase(std::uint64_t id) const { return groups->report(id).phase; }
  /// The setpoints of the axes.
  [[nodiscard]] GroupVector place() {
    GroupVector at{};
    for (std::size_t i = 0; i < std::min(trajectory::kMaxGroupAxes, judges.size()); ++i) at[i] = setpoint(i);
    return at;
  }

  std::unique_ptr<AxisGroups> groups;
};

/// A line whose group is in standby.
struct StandbyGroup : GroupLine {
  using GroupLine::GroupLine;
  bool standby = (take_axes(), true);
};

}  // namespace driveline::bus_test
