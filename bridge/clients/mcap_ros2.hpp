#pragma once

#include <string>
#include <string_view>

#include "schema.hpp"

/// What the profile `ros2` of MCAP (mcap.dev/spec/registry) and players of ROS 2 expect of a recording.
namespace driveline::bridge::clients::mcap {

inline constexpr std::string_view kRos2Profile = "ros2";

/// Name of the metadata record of a recording of ROS 2, and its only entry. Players that expect QoS policies as words
/// read them as numbers, as older players do, where this record has no other entry (ros2/rosbag2,
/// rosbag2_storage_mcap/src/mcap_storage.cpp: read_metadata()). Recordings of ROS 2 Humble are like this.
inline constexpr std::string_view kRos2Metadata = "rosbag2";
inline constexpr std::string_view kRos2DistroKey = "ROS_DISTRO";
inline constexpr std::string_view kRos2Distro = "humble";

/// Key of the metadata of a channel.
inline constexpr std::string_view kOfferedQosKey = "offered_qos_profiles";

/// Name of the topic in a recording: a topic of ROS 2 has the name that its nodes use, `/joint_states` for the DDS
/// topic `rt/joint_states`. All others have their DDS name.
[[nodiscard]] std::string_view recorded_name(const Topic& topic) noexcept;

/// Finds the topic that a recording calls `name`, also by its DDS name, which older recordings have; null if
/// there is none.
[[nodiscard]] const Topic* find_recorded(std::string_view name) noexcept;

/// The QoS with which the writers of a topic publish it, as YAML: one profile, with the policies as numbers.
[[nodiscard]] std::string offered_qos_profiles(const Topic& topic);

}  // namespace driveline::bridge::clients::mcap
