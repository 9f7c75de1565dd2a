#include "mcap_ros2.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace driveline::bridge::clients::mcap {
namespace {

/// Prefix of the DDS names of topics of ROS 2 (design.ros2.org, "Topic and Service name mapping to DDS").
constexpr std::string_view kRos2Prefix = "rt";

bool is_of_ros2(const Topic& topic) noexcept {
  return topic.name.starts_with(kRos2Prefix) && topic.name.substr(kRos2Prefix.size()).starts_with('/');
}

}  // namespace

std::string_view recorded_name(const Topic& topic) noexcept {
  return is_of_ros2(topic) ? topic.name.substr(kRos2Prefix.size()) : topic.name;
}

const Topic* find_recorded(std::string_view name) noexcept {
  const auto all = topics();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Topic& topic) { return recorded_name(topic) == name; });
  return found == all.end() ? find_topic(name) : &*found;
}

std::string offered_qos_profiles(const Topic& topic) {
  // The numbers are those of rmw/types.h. Discovery does not show the history of a writer, so it is unknown (3), as in
  // recordings of ROS 2 with Fast DDS. The times are infinite.
  constexpr int kReliable = 1;
  constexpr int kBestEffort = 2;
  constexpr int kTransientLocal = 1;
  constexpr int kVolatile = 2;
  constexpr std::string_view kInfinite = "\n    sec: 9223372036\n    nsec: 854775807\n";
  return fmt::format(
      "- history: 3\n  depth: 0\n  reliability: {}\n  durability: {}\n  deadline:{}  lifespan:{}  liveliness: 1\n"
      "  liveliness_lease_duration:{}  avoid_ros_namespace_conventions: {}",
      topic.reliable ? kReliable : kBestEffort, topic.kept ? kTransientLocal : kVolatile, kInfinite, kInfinite,
      kInfinite, !is_of_ros2(topic));
}

}  // namespace driveline::bridge::clients::mcap
