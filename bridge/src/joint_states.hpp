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
/// What a writer of this type tells in its USER_DATA (REP 2016); scripts/ros2_type_hash.py computes it.
inline constexpr const char* kJointStateTypeHash =
    "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;";

/// A time of ROS 2, of nanoseconds since 1970-01-01 UTC; rounded down, also before.
[[nodiscard]] builtin_interfaces::msg::dds_::Time_ stamp_of(std::int64_t wall_time_ns);

/// Puts the samples of all axes in one cycle together to a JointState of ROS 2, about a hundred times in a second
/// unless it is configured otherwise.
class JointStates {
 public:
  explicit JointStates(const DdsConfig& config);

  /// Adds a sample. Returns the message when it is the last one of a cycle that is published, valid until the next
  /// call; null: it is not. A cycle that lacks a sample is left out.
  [[nodiscard]] sensor_msgs::msg::dds_::JointState_* add(const snapshot::AxisSample& sample);
  /// By the clock of the machine, minus the master's clock; for the samples that follow.
  void set_wall_offset(std::int64_t offset_ns) noexcept { wall_offset_ns_ = offset_ns; }
  /// Every n-th cycle is published.
  [[nodiscard]] std::uint64_t decimation() const noexcept { return decimation_; }

 private:
  std::uint64_t decimation_;
  std::int64_t wall_offset_ns_ = 0;
  std::uint64_t cycle_ = 0;
  std::size_t next_ = 0;  ///< axis that is missing next in the message
  sensor_msgs::msg::dds_::JointState_ message_;
};

}  // namespace driveline::bridge
