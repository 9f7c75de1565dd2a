// Diagnostics as ROS 2 serialises them, and their content for a line.
#include "diagnostics.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "cdr.hpp"
#include "ros2PubSubTypes.h"

namespace driveline::bridge {
namespace {

using snapshot::AxisState;
using test::Bytes;
using test::Cdr;
using testing::ElementsAre;

DdsConfig diagnosed(std::size_t axes) {
  DdsConfig config;
  config.line_name = "press";
  for (std::size_t i = 0; i < axes; ++i) config.axes.push_back({.name = "a" + std::to_string(i)});
  return config;
}

snapshot::FeedSlave diagnosed_slave(std::uint8_t al_state) {
  snapshot::FeedSlave slave;
  slave.name.set("x");
  slave.device.set("drive");
  slave.serial_number = 7;
  slave.alias = 3;
  slave.al_state = al_state;
  slave.answers = 1;
  return slave;
}

TEST(Diagnostics, HaveTheBytesOfTheMessageDefinition) {
  Diagnostics diagnostics(diagnosed(1));
  snapshot::FeedCondition condition;
  condition.slaves = {diagnosed_slave(8)};
  condition.owners.resize(1);
  condition.owners[0].name.set("stream");
  diagnostics.set(condition);
  snapshot::AxisSample sample;
  sample.state = AxisState::kOperationEnabled;
  sample.plcopen_state = snapshot::SampledPlcopenState::kStandstill;
  sample.mode = 8;
  sample.error_code = 9;
  diagnostics.add(sample);
  snapshot::LineStatus line;
  line.state = snapshot::LineState::kOp;
  line.cycles = 1;
  line.missed_periods = 2;
  line.wkc_errors = 3;
  line.lost_frames = 4;
  line.wake_latency.p99 = std::chrono::nanoseconds{5};
  line.cycle_cost.p99 = std::chrono::nanoseconds{6};
  auto* message = diagnostics.message(line, 1'700'000'001'500'000'000);

  diagnostic_msgs::msg::dds_::DiagnosticArray_PubSubType type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(
      static_cast<std::uint32_t>(type.getSerializedSizeProvider(message)()));
  ASSERT_TRUE(type.serialize(message, &payload));

  Cdr expected;
  expected.number(1'700'000'001, 4);  // header.stamp.sec
  expected.number(500'000'000, 4);    // header.stamp.nanosec
  expected.text("");                  // header.frame_id
  expected.number(3, 4);              // status
  const auto status = [&expected](const std::vector<std::string>& texts) {
    expected.number(0, 1);                                                          // level, OK
    for (int i = 0; i < 3; ++i) expected.text(texts[static_cast<std::size_t>(i)]);  // name, message, hardware_id
    expected.number((texts.size() - 3) / 2, 4);                                     // values
    for (std::size_t i = 3; i < texts.size(); ++i) expected.text(texts[i]);
  };
  status({"driveline press: line", "OP", "press", "state", "OP", "cycles", "1", "missed_periods", "2", "wkc_errors",
          "3", "lost_frames", "4", "wake_latency_p99_ns", "5", "cycle_cost_p99_ns", "6"});
  status({"driveline press: slave 0 x", "OP", "drive 7", "state", "OP", "al_status_code", "0", "errors", "0", "alias",
          "3"});
  status({"driveline press: axis a0", "Standstill, operation enabled", "a0", "state", "operation enabled",
          "plcopen_state", "Standstill", "mode", "8", "error_code", "9", "owner", "stream"});
  EXPECT_EQ(Bytes(payload.data, payload.data + payload.length), expected.message());
  EXPECT_STREQ(type.getName(), "diagnostic_msgs::msg::dds_::DiagnosticArray_");
}

/// Level and message of each status.
std::vector<std::string> said(diagnostic_msgs::msg::dds_::DiagnosticArray_* message) {
  std::vector<std::string> all;
  for (const auto& status : message->status_()) {
    all.push_back(std::to_string(status.level_()) + " " + status.message_());
  }
  return all;
}

TEST(Diagnostics, TellWhatIsWrong) {
  Diagnostics diagnostics(diagnosed(3));
  snapshot::FeedCondition condition;
  condition.slaves.assign(6, diagnosed_slave(8));
  condition.slaves[1].answers = 0;
  condition.slaves[2].answers = 0;
  condition.slaves[2].hot_connect = 1;
  condition.slaves[3].al_state = 4;
  condition.slaves[3].al_error = 1;
  condition.slaves[3].al_text.set("sync manager watchdog");
  condition.slaves[4].al_state = 2;
  condition.slaves[5].port[2].lost_links = 1;
  diagnostics.set(condition);
  snapshot::AxisSample sample;
  sample.state = AxisState::kFault;
  diagnostics.add(sample);
  sample.axis = 1;
  sample.state = AxisState::kSwitchedOn;
  sample.plcopen_state = snapshot::SampledPlcopenState::kErrorStop;
  diagnostics.add(sample);
  sample.axis = 3;  // there is no such axis
  diagnostics.add(sample);
  snapshot::LineStatus line;
  EXPECT_THAT(said(diagnostics.message(line, 0)),
              ElementsAre("2 down", "0 OP", "2 does not answer", "1 is not connected",
                          "2 SAFEOP with an error: sync manager watchdog", "1 PREOP", "1 has counted errors", "2 fault",
                          "2 ErrorStop, switched on", "3 unavailable"));
  line.state = snapshot::LineState::kOp;
  line.faults = {"first", "axis a0: fault"};
  EXPECT_EQ(said(diagnostics.message(line, 0)).front(), "1 OP; axis a0: fault");
}

}  // namespace
}  // namespace driveline::bridge
