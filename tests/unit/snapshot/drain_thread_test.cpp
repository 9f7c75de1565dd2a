#include "driveline/snapshot/drain_thread.hpp"

#include <gmock/gmock.h>
#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <future>
#include <vector>

#include "support/must.hpp"

namespace driveline::snapshot {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

AxisSample axis_sample(std::uint64_t cycle, std::uint16_t axis) {
  AxisSample sample;
  sample.cycle = cycle;
  sample.axis = axis;
  return sample;
}

LineSample line_sample(std::uint64_t cycle) {
  LineSample sample;
  sample.cycle = cycle;
  return sample;
}

/// Stores all samples. Read it only after the thread has stopped.
class Recorder : public SampleConsumer {
 public:
  void lines(std::span<const LineSample> samples) override {
    lines_seen.insert(lines_seen.end(), samples.begin(), samples.end());
  }
  void axes(std::span<const AxisSample> samples) override {
    axes_seen.insert(axes_seen.end(), samples.begin(), samples.end());
  }
  void pass_done(const DrainCounters& counters) override {
    last = counters;
    ++passes;
  }
  void finish(const DrainCounters& counters) override {
    last = counters;
    ++finishes;
    pthread_getschedparam(pthread_self(), &policy, &priority);
  }

  std::vector<LineSample> lines_seen;
  std::vector<AxisSample> axes_seen;
  DrainCounters last;
  std::atomic<int> passes{0};
  int finishes = 0;
  int policy = -1;
  sched_param priority{.sched_priority = -1};
};

/// Blocks in its first batch of axis samples until it is released.
class Blocker : public SampleConsumer {
 public:
  void lines(std::span<const LineSample> /*samples*/) override {}
  void axes(std::span<const AxisSample> samples) override {
    if (!blocked_once_) {
      blocked_once_ = true;
      taken_when_blocked.set_value(samples.size());
      release.get_future().wait();
    }
  }

  std::promise<std::size_t> taken_when_blocked;
  std::promise<void> release;

 private:
  bool blocked_once_ = false;
};

struct Rings {
  explicit Rings(std::size_t capacity) : lines(capacity), axes(capacity) {}
  rt::SpscRing<LineSample> lines;
  rt::SpscRing<AxisSample> axes;
};

TEST(DrainThread, HandsEverySampleToEveryConsumerInOrder) {
  Rings rings{1U << 14};
  Recorder first;
  Recorder second;
  DrainThread drain{rings.lines, rings.axes, {&first, &second}};
  ASSERT_TRUE(drain.start());
  constexpr std::uint64_t kCycles = 8000;  // more than one pass takes
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
    ASSERT_TRUE(rings.lines.try_push(line_sample(cycle)));
    ASSERT_TRUE(rings.axes.try_push(axis_sample(cycle, 0)));
    ASSERT_TRUE(rings.axes.try_push(axis_sample(cycle, 1)));
  }
  drain.stop();
  for (const Recorder* recorder : {&first, &second}) {
    ASSERT_EQ(recorder->lines_seen.size(), kCycles);
    ASSERT_EQ(recorder->axes_seen.size(), 2 * kCycles);
    for (std::size_t i = 0; i < kCycles; ++i) {
      EXPECT_EQ(recorder->lines_seen[i].cycle, i);
      EXPECT_EQ(recorder->axes_seen[2 * i].cycle, i);
      EXPECT_EQ(recorder->axes_seen[2 * i + 1].axis, 1);
    }
    EXPECT_EQ(recorder->finishes, 1);
    EXPECT_EQ(recorder->last.lines, kCycles);
    EXPECT_EQ(recorder->last.axes, 2 * kCycles);
    EXPECT_EQ(recorder->last.axes_dropped, 0U);
  }
}

TEST(DrainThread, BlockedConsumerCostsCountedSamplesAndNeverTheProducer) {
  constexpr std::size_t kCapacity = 64;
  constexpr std::uint64_t kPushes = 10'000;
  Rings rings{kCapacity};
  Blocker blocker;
  Recorder recorder;
  DrainThread drain{rings.lines, rings.axes, {&blocker, &recorder}};
  ASSERT_TRUE(drain.start());
  ASSERT_TRUE(rings.axes.try_push(axis_sample(0, 0)));
  ASSERT_EQ(blocker.taken_when_blocked.get_future().get(), 1U);

  // While the reader is blocked, every push returns: the first ones are stored, the others dropped.
  std::uint64_t accepted = 0;
  for (std::uint64_t cycle = 1; cycle <= kPushes; ++cycle) {
    accepted += rings.axes.try_push(axis_sample(cycle, 0)) ? 1U : 0U;
  }
  EXPECT_EQ(accepted, kCapacity);
  EXPECT_EQ(drain.counters().axes_dropped, kPushes - kCapacity);

  blocker.release.set_value();
  drain.stop();
  EXPECT_EQ(recorder.axes_seen.size(), 1 + kCapacity);
  EXPECT_EQ(recorder.axes_seen.back().cycle, kCapacity) << "the oldest samples are the ones that are kept";
  EXPECT_EQ(recorder.last.axes, 1 + kCapacity);
  EXPECT_EQ(recorder.last.axes_dropped, kPushes - kCapacity);
}

/// Puts back the samples that it takes: a ring that never becomes empty.
class Refiller : public SampleConsumer {
 public:
  explicit Refiller(rt::SpscRing<LineSample>& ring) : ring_(ring) {}
  void lines(std::span<const LineSample> samples) override {
    for (const LineSample& sample : samples) {
      ring_.try_push(sample);
    }
  }
  void axes(std::span<const AxisSample> /*samples*/) override {}

 private:
  rt::SpscRing<LineSample>& ring_;
};

TEST(DrainThread, StopEndsAlthoughTheRingNeverGetsEmpty) {
  Rings rings{1024};
  for (std::uint64_t cycle = 0; cycle < 1024; ++cycle) {
    ASSERT_TRUE(rings.lines.try_push(line_sample(cycle)));
  }
  Refiller refiller{rings.lines};
  Recorder recorder;
  DrainThread drain{rings.lines, rings.axes, {&refiller, &recorder}, {.period = 1ms, .stop_limit = 10ms}};
  ASSERT_TRUE(drain.start());
  drain.stop();  // a hang is found by the time limit of the test
  EXPECT_EQ(recorder.finishes, 1);
  EXPECT_EQ(rings.lines.size(), 1024U) << "what is left stays in the ring";
}

TEST(DrainThread, PassesGoOnWhileNothingArrives) {
  Rings rings{16};
  Recorder recorder;
  DrainThread drain{rings.lines, rings.axes, {&recorder}, {.period = 100us, .stop_limit = 1s}};
  ASSERT_TRUE(drain.start());
  while (recorder.passes < 5) {  // a hang is found by the time limit of the test
    std::this_thread::sleep_for(1ms);
  }
  drain.stop();
  EXPECT_TRUE(recorder.axes_seen.empty());
}

TEST(DrainThread, StopDoesNotWaitForTheEndOfThePause) {
  Rings rings{16};
  Recorder recorder;
  DrainThread drain{rings.lines, rings.axes, {&recorder}, {.period = 24h, .stop_limit = 1s}};
  ASSERT_TRUE(drain.start());
  ASSERT_TRUE(rings.axes.try_push(axis_sample(7, 0)));
  drain.stop();  // a hang is found by the time limit of the test
  ASSERT_EQ(recorder.axes_seen.size(), 1U);
}

TEST(DrainThread, StartsOnceAndStopsAsOftenAsAsked) {
  Rings rings{16};
  Recorder recorder;
  DrainThread drain{rings.lines, rings.axes, {&recorder}};
  drain.stop();
  ASSERT_TRUE(drain.start());
  EXPECT_THAT(failure_text(drain.start()), HasSubstr("already started"));
  drain.stop();
  drain.stop();
  EXPECT_FALSE(drain.start());
  EXPECT_EQ(recorder.finishes, 1);
}

TEST(DrainThread, DoesNotInheritTheRealTimePolicyOfItsCreator) {
  Rings rings{16};
  Recorder recorder;
  DrainThread drain{rings.lines, rings.axes, {&recorder}};
  const sched_param fifo{.sched_priority = 1};
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo) != 0) {
    GTEST_SKIP() << "no permission for SCHED_FIFO";
  }
  const auto started = drain.start();
  const sched_param normal{};
  ASSERT_EQ(pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal), 0);
  ASSERT_TRUE(started);
  drain.stop();
  EXPECT_EQ(recorder.policy, SCHED_OTHER);
  EXPECT_EQ(recorder.priority.sched_priority, 0);
}

}  // namespace
}  // namespace driveline::snapshot
