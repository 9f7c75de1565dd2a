// The content of a line's feed: cycles assembled from two rings, its description, its status.
#include <gmock/gmock.h>

#include <limits>

#include "driveline/snapshot/feed/feed_condition.hpp"
#include "telemetry/cycle_assembler.hpp"
#include "telemetry/line_feed.hpp"

namespace driveline::runtime {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// "3:xy" is cycle 3 with its line and axes 0 and 1; "3-" has no line.
class Assembled : public testing::Test {
 protected:
  void line(std::uint64_t cycle) {
    snapshot::LineSample sample;
    sample.cycle = cycle;
    assembler_.add(sample);
  }
  void axis(std::uint64_t cycle, std::uint16_t axis) {
    snapshot::AxisSample sample;
    sample.cycle = cycle;
    sample.axis = axis;
    assembler_.add(sample);
  }

  std::vector<std::string> records_;
  CycleAssembler assembler_{2, [this](const snapshot::FeedLine& line, std::span<const snapshot::FeedAxisSample> axes) {
                              auto text = std::to_string(line.cycle) + (line.present != 0 ? ":" : "-");
                              for (const auto& each : axes) text += each.axis == 0 ? "x" : "y";
                              records_.push_back(text);
                            }};
};

TEST_F(Assembled, ARecordIsACycle) {
  for (std::uint64_t cycle = 0; cycle < 3; ++cycle) line(cycle);
  for (std::uint64_t cycle = 0; cycle < 2; ++cycle) {
    axis(cycle, 0);
    axis(cycle, 1);
  }
  axis(2, 0);
  EXPECT_THAT(records_, ElementsAre("0:xy", "1:xy")) << "the third is not complete";
  axis(2, 1);
  EXPECT_THAT(records_, ElementsAre("0:xy", "1:xy", "2:xy"));
}

TEST_F(Assembled, ACycleThatLostASampleComesWithoutIt) {
  line(0);
  line(2);
  line(3);
  axis(0, 0);
  axis(1, 0);
  axis(1, 1);
  axis(3, 1);
  assembler_.finish();
  EXPECT_THAT(records_, ElementsAre("0:x", "1-xy", "2:", "3:y"));
}

TEST_F(Assembled, LinesWithoutAxesDoNotPileUp) {
  for (std::uint64_t cycle = 0; cycle < CycleAssembler::kMaxWaiting + 2; ++cycle) line(cycle);
  EXPECT_THAT(records_, ElementsAre("0:", "1:"));
}

TEST(CycleAssembler, ALineWithoutAxesIsHandedOnAtOnce) {
  int records = 0;
  CycleAssembler assembler(0, [&](const snapshot::FeedLine&, std::span<const snapshot::FeedAxisSample>) { ++records; });
  assembler.add(snapshot::LineSample{});
  EXPECT_EQ(records, 1);
}

LineConfig line_with_axes(std::size_t axes) {
  LineConfig config;
  config.name = "press";
  config.axes.resize(axes);
  for (std::size_t i = 0; i < axes; ++i) config.axes[i].name = "a" + std::to_string(i);
  return config;
}

TEST(LineFeed, DescribesTheLine) {
  auto config = line_with_axes(2);
  config.axes[1].kind = trajectory::AxisKind::kLinear;
  config.telemetry.domain = 9;
  config.telemetry.decimation = 3;
  config.telemetry.ros2 = true;
  config.telemetry.shared_memory = true;
  config.telemetry.interfaces = {"127.0.0.1", "192.168.1.10"};
  config.telemetry.partition = "hall2";
  config.telemetry.peers = {"192.168.1.11"};
  config.telemetry.discovery_server = DiscoveryServer{"192.168.1.12", 11811};
  config.telemetry.rates[2] = {TopicRate::Kind::kCycles, 5, {}};
  config.telemetry.rates[8] = {TopicRate::Kind::kPeriod, 1, std::chrono::seconds{2}};
  config.realtime.cpu = 1;
  const auto description = describe_for_feed(config);
  ASSERT_TRUE(description);
  EXPECT_EQ(description->line.view(), "press");
  EXPECT_EQ(description->axes, 2U);
  EXPECT_EQ(description->axis[1].name.view(), "a1");
  EXPECT_EQ(description->axis[0].linear, 0U);
  EXPECT_EQ(description->axis[1].linear, 1U);
  EXPECT_EQ(description->domain, 9U);
  EXPECT_EQ(description->decimation, 3U);
  EXPECT_EQ(description->ros2, 1U);
  EXPECT_EQ(description->shared_memory, 1U);
  EXPECT_EQ(description->partition.view(), "hall2");
  EXPECT_EQ(description->peers, 1U);
  EXPECT_EQ(description->peer[0].view(), "192.168.1.11");
  EXPECT_EQ(description->discovery_server.view(), "192.168.1.12");
  EXPECT_EQ(description->discovery_port, 11811U);
  EXPECT_EQ(description->rate[0].kind, snapshot::FeedRateKind::kDefault);
  EXPECT_EQ(description->rate[2].kind, snapshot::FeedRateKind::kCycles);
  EXPECT_EQ(description->rate[2].cycles, 5U);
  EXPECT_EQ(description->rate[8].period_ns, 2'000'000'000);
  EXPECT_EQ(description->interfaces, 2U);
  EXPECT_EQ(description->interface[1].view(), "192.168.1.10");
  EXPECT_EQ(description->realtime_cpu, 1);
  EXPECT_EQ(description->period_ns, 125'000);
  EXPECT_EQ(description->slaves, snapshot::kMaxFeedSlaves) << "a line without a description may be as long";
  config.slaves.resize(3);
  EXPECT_EQ(describe_for_feed(config)->slaves, 3U);
}

TEST(LineFeed, RefusesWhatHasNoRoom) {
  const auto refusal = [](const LineConfig& config) {
    const auto description = describe_for_feed(config);
    return description ? std::string{} : describe(description.error());
  };
  EXPECT_EQ(refusal(line_with_axes(snapshot::kMaxFeedAxes)), "");
  EXPECT_THAT(refusal(line_with_axes(snapshot::kMaxFeedAxes + 1)),
              HasSubstr("513 axes are too many, the limit is 512"));
  auto config = line_with_axes(1);
  config.telemetry.interfaces.assign(16, "127.0.0.1");
  EXPECT_EQ(refusal(config), "");
  config.telemetry.interfaces.assign(17, "127.0.0.1");
  EXPECT_THAT(refusal(config), HasSubstr("17 interfaces are too many, the limit is 16"));
  config.telemetry.peers.assign(17, "127.0.0.1");
  config.telemetry.interfaces.clear();
  EXPECT_THAT(refusal(config), HasSubstr("17 peers are too many, the limit is 16"));
  config.telemetry.peers.clear();
  config.telemetry.interfaces = {std::string(47, '1')};
  EXPECT_EQ(refusal(config), "");
  config.telemetry.interfaces = {std::string(48, '1')};
  EXPECT_THAT(refusal(config), HasSubstr("not an IPv4 address"));
}

TEST(LineFeed, HoldsAQuarterOfASecondAndNoMoreThan16Mib) {
  auto config = line_with_axes(8);
  EXPECT_EQ(feed_cycles(config), 2048U);
  config.period = std::chrono::milliseconds{1};
  EXPECT_EQ(feed_cycles(config), 256U);
  config.period = std::chrono::milliseconds{100};
  EXPECT_EQ(feed_cycles(config), 64U);
  config = line_with_axes(256);
  EXPECT_EQ(feed_cycles(config), 512U);
  EXPECT_LE(feed_cycles(config) * snapshot::feed_axis_offset(256), 16U << 20);
}

TEST(LineFeed, KeepsTheNewestFaultsOfAStatus) {
  snapshot::LineStatus status;
  status.state = snapshot::LineState::kSafeOp;
  status.cycles = 5;
  status.missed_periods = 6;
  status.wkc_errors = 7;
  status.lost_frames = 8;
  status.wake_latency = {std::chrono::nanoseconds{1}, std::chrono::nanoseconds{2}, std::chrono::nanoseconds{3}};
  status.cycle_cost = {std::chrono::nanoseconds{4}, std::chrono::nanoseconds{5}, std::chrono::nanoseconds{6}};
  status.statistics.number = 9;
  for (int i = 0; i < 20; ++i) status.faults.push_back("fault " + std::to_string(i));
  snapshot::FeedStatus record;
  record.published_before = 77;
  set_status(record, status);
  EXPECT_EQ(record.state, static_cast<std::uint8_t>(snapshot::LineState::kSafeOp));
  EXPECT_EQ(record.cycles, 5U);
  EXPECT_EQ(record.missed_periods, 6U);
  EXPECT_EQ(record.wkc_errors, 7U);
  EXPECT_EQ(record.lost_frames, 8U);
  EXPECT_THAT(record.wake_latency_ns, ElementsAre(1, 2, 3));
  EXPECT_THAT(record.cycle_cost_ns, ElementsAre(4, 5, 6));
  EXPECT_EQ(record.statistics.number, 9U);
  EXPECT_EQ(record.faults, 16U);
  EXPECT_EQ(record.fault[0].view(), "fault 4");
  EXPECT_EQ(record.fault[15].view(), "fault 19");
  EXPECT_EQ(record.published_before, 77U) << "that is not of the line";
}

}  // namespace
}  // namespace driveline::runtime
