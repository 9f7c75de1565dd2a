#include "joint_states.hpp"

#include <algorithm>
#include <chrono>

namespace driveline::bridge {
namespace {

/// Usual period of joint states in ROS 2.
constexpr std::chrono::milliseconds kPeriod{10};
constexpr std::int64_t kSecond = 1'000'000'000;

}  // namespace

builtin_interfaces::msg::dds_::Time_ stamp_of(std::int64_t wall_time_ns) {
  const std::int64_t rest = (wall_time_ns % kSecond + kSecond) % kSecond;
  builtin_interfaces::msg::dds_::Time_ stamp;
  stamp.sec_(static_cast<std::int32_t>((wall_time_ns - rest) / kSecond));
  stamp.nanosec_(static_cast<std::uint32_t>(rest));
  return stamp;
}

JointStates::JointStates(const DdsConfig& config)
    : decimation_(config.joint_decimation > 0 ? config.joint_decimation
                  : config.cycle_period.count() > 0
                      ? static_cast<std::uint64_t>(std::max<std::int64_t>(kPeriod / config.cycle_period, 1))
                      : config.decimation) {
  for (const auto& axis : config.axes) message_.name_().push_back(axis.name);
  for (auto* values : {&message_.position_(), &message_.velocity_(), &message_.effort_()}) {
    values->resize(config.axes.size());
  }
}

sensor_msgs::msg::dds_::JointState_* JointStates::add(const snapshot::AxisSample& sample) {
  if (sample.cycle % decimation_ != 0) return nullptr;
  if (sample.axis == 0) {
    next_ = 0;
    cycle_ = sample.cycle;
  }
  if (sample.axis != next_ || sample.cycle != cycle_ || next_ >= message_.name_().size()) return nullptr;
  message_.position_()[next_] = sample.actual_position;
  message_.velocity_()[next_] = sample.actual_velocity;
  message_.effort_()[next_] = sample.actual_torque;
  if (++next_ < message_.name_().size()) return nullptr;
  message_.header_().stamp_(stamp_of(sample.time_ns + wall_offset_ns_));
  return &message_;
}

}  // namespace driveline::bridge
