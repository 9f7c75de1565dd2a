#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/bridge/dds_config.hpp"
#include "driveline/snapshot/snapshot.hpp"
#include "ros2.h"

namespace driveline::bridge {

/// The DDS topic of the ROS 2 topic `joint_states`.
inline constexpr const char* kJointStatesTopic = "rt/joint_states";
/// USER_DATA of a writer of this type (REP 2016); computed by scripts/ros2_type_hash.py.
inline constexpr const char* kJointStateTypeHash =
    "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;";

/// Converts nanoseconds since 1970-01-01 UTC to a ROS 2 time; rounds down, also for negative times.
[[nodiscard]] builtin_interfaces::msg::dds_::Time_ stamp_of(std::int64_t wall_time_ns);

/// Combines the samples of all axes in a cycle into a JointState of ROS 2, about a hundred times per second unless
/// configured otherwise.
class JointStates {
 public:
  explicit JointStates(const DdsConfig& config);

  /// Adds a sample. Returns the message if it is the last sample of a published cycle, valid until the next call;
  /// otherwise null. A cycle that lacks a sample is omitted.
  [[nodiscard]] sensor_msgs::msg::dds_::JointState_* add(const snapshot::AxisSample& sample);
  /// Sets the wall clock minus the master's clock, for the following samples.
  void set_wall_offset(std::int64_t offset_ns) noexcept { wall_offset_ns_ = offset_ns; }
  /// Every decimation()-th cycle is published.
  [[nodiscard]] std::uint64_t decimation() const noexcept { return decimation_; }

 private:
  std::uint64_t decimation_;
  std::int64_t wall_offset_ns_ = 0;
  std::uint64_t cycle_ = 0;
  std::size_t next_ = 0;  ///< next axis expected in the message
  sensor_msgs::msg::dds_::JointState_ message_;
};

}  // namespace driveline::bridge
