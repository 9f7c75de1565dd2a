#include "config/gantry_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "driveline/motion/axis/axis_compensation.hpp"

namespace driveline::runtime {
namespace {

/// Default and highest share of the limits of the axes that squaring the follower uses.
constexpr double kSquareShare = 0.02;
constexpr double kMaxSquare = 0.5;
constexpr double kFarthestOffset = 1e6;  // rad or m
constexpr double kLeastOfPair = 1e-9;    // in the unit of the leader

std::size_t read_axis_of_pair(TomlReader& reader, std::string_view key, const LineConfig& config) {
  const auto name = reader.text(key);
  const auto& axes = config.axes;
  const auto found = std::find_if(axes.begin(), axes.end(), [&](const auto& axis) { return axis.name == name; });
  if (found == axes.end()) reader.fail(key, fmt::format("there is no [[axis]] named \"{}\"", name));
  const auto number = static_cast<std::size_t>(found - axes.begin());
  for (const auto& other : config.gantries) {
    if (other.leader == number || other.follower == number)
      reader.fail(key, fmt::format("\"{}\" is already in a [[gantry]] above", name));
  }
  if (found->compensation && found->compensation->when_homed) {
    reader.fail(key, fmt::format("\"{}\" is compensated only after homing, which a gantry does not do: compensate = "
                                 "\"always\" is expected",
                                 name));
  }
  return number;
}

/// Checks that both axes can move as a pair.
void check_pair(const TomlReader& reader, const LineConfig& config, const motion::GantrySettings& gantry) {
  const auto& leader = config.axes[gantry.leader];
  const auto& follower = config.axes[gantry.follower];
  if (gantry.leader == gantry.follower)
    reader.fail("follower", fmt::format("is \"{}\", the same as the leader: a gantry needs two axes", follower.name));
  if (leader.kind != follower.kind)
    reader.fail("follower", fmt::format("\"{}\" is {}, but the leader \"{}\" is not", follower.name,
                                        follower.linear() ? "linear" : "rotary", leader.name));
  if (leader.mode != follower.mode) {
    reader.fail("follower", fmt::format("\"{}\" is in mode \"{}\", but the leader \"{}\" in \"{}\"", follower.name,
                                        to_text(follower.mode), leader.name, to_text(leader.mode)));
  }
  if (leader.modulo || follower.modulo)
    reader.fail("leader", "a gantry has end positions: its axes must not have a modulo");
  if (follower.software_limits) {
    reader.fail("follower", fmt::format("\"{}\" has min_position and max_position: those of the leader are expected "
                                        "alone",
                                        follower.name));
  }
  const auto streamed = [&](std::size_t axis) {
    return config.stream && std::count(config.stream->axes.begin(), config.stream->axes.end(), axis) > 0;
  };
  if (streamed(gantry.follower)) {
    reader.fail("follower",
                fmt::format("\"{}\" is one of the axes of [stream]: only the leader is expected there", follower.name));
  }
  for (const auto& group : config.axis_groups) {
    if (std::count(group.axes.begin(), group.axes.end(), gantry.follower) > 0) {
      reader.fail("follower", fmt::format("\"{}\" is in the [[axis_group]] \"{}\": only the leader is expected there",
                                          follower.name, group.name));
    }
  }
}

/// Gives both axes limits with which they stop alike, with a reserve for squaring the follower.
void share_limits(LineConfig& config, const motion::GantrySettings& gantry) {
  auto& leader = config.axes[gantry.leader];
  auto& follower = config.axes[gantry.follower];
  auto both = leader.limits;
  both.max_velocity = std::min(both.max_velocity, follower.limits.max_velocity);
  both.max_acceleration = std::min(both.max_acceleration, follower.limits.max_acceleration);
  follower.limits = both;
  leader.limits = {both.max_velocity - gantry.square_velocity, both.max_acceleration};
  if (leader.max_jerk && follower.max_jerk) leader.max_jerk = std::min(*leader.max_jerk, *follower.max_jerk);
  if (!leader.max_jerk) leader.max_jerk = follower.max_jerk;
  follower.max_jerk = leader.max_jerk;
}

}  // namespace

void read_gantry(TomlReader reader, LineConfig& config) {
  motion::GantrySettings gantry;
  if (config.path) reader.fail("", "needs axes that wait for requests: remove [path], which moves all axes");
  gantry.leader = read_axis_of_pair(reader, "leader", config);
  gantry.follower = read_axis_of_pair(reader, "follower", config);
  check_pair(reader, config, gantry);
  const auto& leader = config.axes[gantry.leader];
  const auto& follower = config.axes[gantry.follower];
  const auto& unit = motion::position_unit(leader);
  const auto in_unit = [&](std::string_view key, double fallback, double lowest, double highest) {
    return unit.to_si(reader.number_or(key, unit.from_si(fallback), lowest, unit.from_si(highest)));
  };
  gantry.offset = in_unit("offset", 0.0, unit.from_si(-kFarthestOffset), kFarthestOffset);
  gantry.skew_limit = unit.to_si(reader.number("skew_limit", kLeastOfPair, unit.from_si(kFarthestOffset)));
  gantry.skew_warning = in_unit("skew_warning", 0.5 * gantry.skew_limit, 0.0, gantry.skew_limit);
  const double velocity = std::min(leader.limits.max_velocity, follower.limits.max_velocity);
  const double acceleration = std::min(leader.limits.max_acceleration, follower.limits.max_acceleration);
  gantry.square_velocity = in_unit("square_velocity", kSquareShare * velocity, kLeastOfPair, kMaxSquare * velocity);
  gantry.square_acceleration =
      in_unit("square_acceleration", kSquareShare * acceleration, kLeastOfPair, kMaxSquare * acceleration);
  gantry.when_homed = reader.choice_or("reference", 0, {"drives", "homing"}) == 1;
  gantry.square_when_enabled = reader.choice_or("out_of_skew", 0, {"refuse", "square"}) == 1;
  reader.finish();
  share_limits(config, gantry);
  config.gantries.push_back(gantry);
}

}  // namespace driveline::runtime
