// Joint states as ROS 2 serialises them.
#include "joint_states.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "cdr.hpp"
#include "ros2PubSubTypes.h"

namespace driveline::bridge {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::Cdr;

snapshot::AxisSample joint(std::uint64_t cycle, std::uint16_t axis) {
  snapshot::AxisSample sample;
  sample.cycle = cycle;
  sample.time_ns = 1'500'000'000;
  sample.axis = axis;
  sample.actual_position = 1.0 + axis;
  sample.actual_velocity = -2.0;
  sample.actual_torque = 0.5;
  return sample;
}

DdsConfig two_joints(std::chrono::nanoseconds period = 1ms) {
  DdsConfig config;
  config.axes = {{.name = "x"}, {.name = "slide"}};
  config.cycle_period = period;
  return config;
}

TEST(JointStates, HaveTheBytesOfTheMessageDefinition) {
  JointStates states(two_joints());
  states.set_wall_offset(1'700'000'000'000'000'000);
  EXPECT_EQ(states.add(joint(10, 0)), nullptr);
  auto* message = states.add(joint(10, 1));
  ASSERT_NE(message, nullptr);

  sensor_msgs::msg::dds_::JointState_PubSubType type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(
      static_cast<std::uint32_t>(type.getSerializedSizeProvider(message)()));
  ASSERT_TRUE(type.serialize(message, &payload));

  Cdr expected;
  expected.number(1'700'000'001, 4);  // header.stamp.sec
  expected.number(500'000'000, 4);    // header.stamp.nanosec
  expected.text("");                  // header.frame_id
  expected.number(2, 4);              // name
  expected.text("x");
  expected.text("slide");
  for (const auto& [first, second] : {std::pair{1.0, 2.0}, std::pair{-2.0, -2.0}, std::pair{0.5, 0.5}}) {
    expected.number(2, 4);  // position, velocity, effort
    expected.real(first);
    expected.real(second);
  }
  EXPECT_EQ(Bytes(payload.data, payload.data + payload.length), expected.message());
  EXPECT_STREQ(type.getName(), "sensor_msgs::msg::dds_::JointState_");
}

TEST(JointStates, ComeAHundredTimesInASecond) {
  EXPECT_EQ(JointStates(two_joints(125us)).decimation(), 80U);
  EXPECT_EQ(JointStates(two_joints(1ms)).decimation(), 10U);
  EXPECT_EQ(JointStates(two_joints(50ms)).decimation(), 1U);
  JointStates states(two_joints());
  int messages = 0;
  for (std::uint64_t cycle = 0; cycle < 100; ++cycle) {
    for (std::uint16_t axis = 0; axis < 2; ++axis) messages += states.add(joint(cycle, axis)) != nullptr ? 1 : 0;
  }
  EXPECT_EQ(messages, 10);
}

TEST(JointStates, ACycleThatLacksAnAxisIsLeftOut) {
  JointStates states(two_joints());
  EXPECT_EQ(states.add(joint(0, 1)), nullptr);
  EXPECT_EQ(states.add(joint(10, 0)), nullptr);
  EXPECT_EQ(states.add(joint(20, 1)), nullptr) << "of another cycle";
  EXPECT_EQ(states.add(joint(30, 2)), nullptr) << "of an axis that is not there";
  EXPECT_EQ(states.add(joint(40, 0)), nullptr);
  EXPECT_NE(states.add(joint(40, 1)), nullptr);
}

}  // namespace
}  // namespace driveline::bridge
