#include "axis_batcher.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

namespace driveline::bridge {
namespace {

using namespace std::chrono_literals;
using snapshot::AxisSample;

DdsConfig batch_config(std::size_t axes, std::chrono::nanoseconds period) {
  DdsConfig config;
  config.axes.resize(axes);
  config.cycle_period = period;
  return config;
}

AxisSample batched_sample(std::uint64_t cycle, std::uint16_t axis) {
  AxisSample sample;
  sample.cycle = cycle;
  sample.time_ns = static_cast<std::int64_t>(cycle) * 125'000;
  sample.axis = axis;
  sample.control_word = 0x000F;
  sample.status_word = 0x1637;
  sample.mode = -3;
  sample.state = snapshot::AxisState::kOperationEnabled;
  sample.target_position = static_cast<double>(cycle) + 0.1 * axis;
  sample.following_error = -1.5;
  return sample;
}

TEST(AxisBatcher, ABatchHasAsManyCyclesAsItsPeriodAndItsRoomHold) {
  EXPECT_EQ(AxisBatcher(batch_config(8, 125us)).cycles(), 8U);
  EXPECT_EQ(AxisBatcher(batch_config(8, 500us)).cycles(), 2U);
  EXPECT_EQ(AxisBatcher(batch_config(8, 2ms)).cycles(), 1U);
  EXPECT_EQ(AxisBatcher(batch_config(8, 0ns)).cycles(), 1U) << "not known";
  EXPECT_EQ(AxisBatcher(batch_config(100, 125us)).cycles(), 5U);
  EXPECT_EQ(AxisBatcher(batch_config(512, 125us)).cycles(), 1U);
  EXPECT_EQ(AxisBatcher(batch_config(1, 1us)).cycles(), 64U);
}

TEST(AxisBatcher, ABatchOfEveryThirdCycleEndsWithItsPeriodAllTheSame) {
  auto config = batch_config(1, 250us);
  config.batch_rate.cycles = 3;
  AxisBatcher batcher(config);
  std::vector<std::vector<std::uint64_t>> batches;
  for (std::uint64_t cycle = 0; cycle < 12; ++cycle) {
    if (const auto* batch = batcher.add(batched_sample(cycle, 0))) {
      EXPECT_EQ(cycle % 4, 3U) << "as soon as its period is over";
      auto& cycles = batches.emplace_back();
      for (const auto& time : batch->cycles()) cycles.push_back(time.cycle());
    }
  }
  EXPECT_THAT(batches,
              testing::ElementsAre(testing::ElementsAre(0U, 3U), testing::ElementsAre(6U), testing::ElementsAre(9U)));
}

TEST(SampleFilter, OnChangeTakesWhatDiffersAndOneInASecond) {
  SampleFilter filter({.cycles = 1, .on_change = true}, 2);
  auto sample = batched_sample(8, 0);
  sample.demand_torque = std::nan("");
  EXPECT_TRUE(filter.takes(sample)) << "the first";
  auto next = sample;
  next.cycle = 9;
  next.time_ns += 999'999'999;
  EXPECT_FALSE(filter.takes(next)) << "cycle and time are no change";
  EXPECT_TRUE(filter.takes(batched_sample(9, 1))) << "of another axis";
  next.time_ns += 1;
  EXPECT_TRUE(filter.takes(next)) << "a second later";
  next.status_word ^= 1;
  EXPECT_TRUE(filter.takes(next));
  EXPECT_FALSE(filter.takes(next));
  EXPECT_TRUE(filter.takes(batched_sample(10, 7))) << "of an axis that nobody knows: refused elsewhere";
}

TEST(AxisBatcher, ABatchIsWholeCyclesOfAllAxes) {
  AxisBatcher batcher(batch_config(2, 250us));
  batcher.set_wall_offset(1'000'000);
  telemetry::AxisBatch* batch = nullptr;
  for (std::uint64_t cycle = 4; cycle < 8; ++cycle) {
    for (std::uint16_t axis = 0; axis < 2; ++axis) {
      EXPECT_EQ(batch, nullptr);
      batch = batcher.add(batched_sample(cycle, axis));
    }
  }
  ASSERT_NE(batch, nullptr) << "with the last sample, not with the first of the next batch";
  EXPECT_EQ(batch->number(), 0U);
  EXPECT_EQ(batch->axes(), 2U);
  EXPECT_EQ(batch->cycle_period_ns(), 250'000);
  ASSERT_EQ(batch->cycles().size(), 4U);
  EXPECT_EQ(batch->cycles()[3].cycle(), 7U);
  EXPECT_EQ(batch->cycles()[3].time_ns(), 7 * 125'000);
  EXPECT_EQ(batch->cycles()[3].wall_time_ns(), 7 * 125'000 + 1'000'000);
  ASSERT_EQ(batch->samples().size(), 8U);
  const auto& values = batch->samples()[5];
  EXPECT_EQ(values.cycle_index(), 2U);
  EXPECT_EQ(values.axis(), 1U);
  EXPECT_EQ(values.control_word(), 0x000F);
  EXPECT_EQ(values.status_word(), 0x1637);
  EXPECT_EQ(values.mode(), -3);
  EXPECT_EQ(values.state(), telemetry::AXIS_OPERATION_ENABLED);
  EXPECT_EQ(values.target_position(), 6.1);
  EXPECT_EQ(values.following_error(), -1.5);
  EXPECT_TRUE(std::isnan(values.drive_following_error()));
}

TEST(AxisBatcher, ALostSampleEndsNoBatchTooLate) {
  AxisBatcher batcher(batch_config(2, 500us));
  EXPECT_EQ(batcher.add(batched_sample(0, 0)), nullptr);
  EXPECT_EQ(batcher.add(batched_sample(1, 0)), nullptr);
  auto* batch = batcher.add(batched_sample(2, 0));
  ASSERT_NE(batch, nullptr) << "the last sample of cycle 1 never came";
  EXPECT_EQ(batch->samples().size(), 2U);
  EXPECT_EQ(batch->cycles().size(), 2U);
  batch = batcher.flush();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->number(), 1U);
  EXPECT_EQ(batch->cycles().front().cycle(), 2U);
  EXPECT_EQ(batcher.flush(), nullptr);
}

TEST(AxisBatcher, MoreSamplesThanABatchHoldsAreLeftOut) {
  AxisBatcher batcher(batch_config(512, 1ms));
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(batcher.add(batched_sample(0, 0)), nullptr);
  EXPECT_EQ(batcher.flush()->samples().size(), 512U);
}

}  // namespace
}  // namespace driveline::bridge
