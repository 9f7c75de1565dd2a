// A feed between two processes: laps, writers that die, readers that start late, and invalid regions.
#include <gmock/gmock.h>

#include <array>
#include <atomic>
#include <cstring>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/rt/shared_region.hpp"
#include "driveline/snapshot/feed/feed_reader.hpp"
#include "driveline/snapshot/feed/feed_writer.hpp"
#include "support/must.hpp"

namespace driveline::snapshot {
namespace {

using testing::HasSubstr;

FeedDescription description_of(std::uint32_t axes) {
  FeedDescription description;
  description.line.set("press");
  description.axes = axes;
  description.domain = 17;
  description.decimation = 4;
  description.interfaces = 1;
  description.interface[0].set("127.0.0.1");
  description.period_ns = 125'000;
  for (std::uint32_t i = 0; i < axes; ++i) description.axis[i].name.set("axis" + std::to_string(i));
  return description;
}

FeedWriter feed_of(std::uint32_t axes, std::uint64_t cycles) {
  auto feed = FeedWriter::create(description_of(axes), cycles);
  if (!feed) throw std::runtime_error(rt::describe(feed.error()));
  return *std::move(feed);
}

FeedReader reader_of(const FeedWriter& feed, std::optional<std::uint64_t> from = std::nullopt) {
  auto reader = FeedReader::open(feed.description_descriptor(), feed.status_descriptor(), feed.cycles_descriptor(),
                                 feed.events_descriptor(), from);
  if (!reader) throw std::runtime_error(describe(reader.error()));
  return *std::move(reader);
}

/// All values of a cycle are derived from its number, so that a mixture of two records would show.
AxisSample axis_of(std::uint64_t cycle, std::uint16_t axis) {
  const auto base = static_cast<double>(cycle * 100 + axis);
  return {.cycle = cycle,
          .time_ns = static_cast<std::int64_t>(cycle) * 125'000,
          .axis = axis,
          .control_word = 0x000F,
          .status_word = 0x1637,
          .mode = -3,
          .state = AxisState::kOperationEnabled,
          .plcopen_state = SampledPlcopenState::kStopping,
          .homed = AxisHomed::kYes,
          .error_code = 0x8611,
          .digital_inputs = 0xFFFF'0000,
          .target_position = base + 0.1,
          .actual_position = base + 0.2,
          .target_velocity = base + 0.3,
          .actual_velocity = base + 0.4,
          .target_torque = base + 0.5,
          .actual_torque = base + 0.6,
          .following_error = base + 0.7,
          .drive_following_error = base + 0.8,
          .demand_position = base + 0.9,
          .demand_velocity = base + 0.91,
          .demand_torque = base + 0.92};
}

LineSample line_of(std::uint64_t cycle) {
  LineSample line;
  line.cycle = cycle;
  line.time_ns = static_cast<std::int64_t>(cycle) * 125'000;
  line.wake_latency_ns = 4000;
  line.cost_ns = -1;
  line.round_trip_ns = 15'000;
  line.dc_difference_ns = -42;
  line.missed_periods = 7;
  line.working_counter = 9;
  line.expected_working_counter = 12;
  line.frame_received = true;
  line.dc_locked = true;
  line.bus_load = 0.73F;
  line.bus_send_errors = 96;
  line.bus_receive_errors = 5;
  return line;
}

void push(FeedWriter& feed, std::uint64_t cycle) {
  std::vector<FeedAxisSample> axes;
  for (std::size_t i = 0; i < feed.axes(); ++i) {
    axes.push_back(to_feed(axis_of(cycle, static_cast<std::uint16_t>(i))));
  }
  feed.push(to_feed(line_of(cycle)), axes);
}

/// Expects that the cycle is complete.
void expect_cycle(const FeedReader& reader, std::uint64_t cycle) {
  ASSERT_NE(reader.line(), nullptr);
  EXPECT_EQ(reader.line()->cycle, cycle);
  ASSERT_EQ(reader.axes().size(), reader.description().axes);
  for (std::size_t i = 0; i < reader.axes().size(); ++i) {
    const auto sent = axis_of(cycle, static_cast<std::uint16_t>(i));
    const auto& got = reader.axes()[i];
    EXPECT_EQ(got.cycle, cycle);
    EXPECT_EQ(got.axis, i);
    EXPECT_EQ(got.target_position, sent.target_position);
    EXPECT_EQ(got.drive_following_error, sent.drive_following_error);
    EXPECT_EQ(got.demand_torque, sent.demand_torque);
    EXPECT_EQ(got.digital_inputs, 0xFFFF'0000);
  }
}

TEST(Feed, EveryValueOfACycleArrives) {
  auto feed = feed_of(2, 8);
  auto reader = reader_of(feed);
  EXPECT_FALSE(reader.take());
  push(feed, 41);
  ASSERT_TRUE(reader.take());
  const auto* line = reader.line();
  ASSERT_NE(line, nullptr);
  EXPECT_EQ(line->cycle, 41U);
  EXPECT_EQ(line->time_ns, 41 * 125'000);
  EXPECT_EQ(line->wake_latency_ns, 4000);
  EXPECT_EQ(line->cost_ns, -1);
  EXPECT_EQ(line->round_trip_ns, 15'000);
  EXPECT_EQ(line->dc_difference_ns, -42);
  EXPECT_EQ(line->missed_periods, 7U);
  EXPECT_EQ(line->working_counter, 9U);
  EXPECT_EQ(line->expected_working_counter, 12U);
  EXPECT_EQ(line->axes, 2U);
  EXPECT_TRUE(line->frame_received);
  EXPECT_TRUE(line->dc_locked);
  EXPECT_EQ(line->bus_load, 0.73F);
  EXPECT_EQ(line->bus_send_errors, 96);
  EXPECT_EQ(line->bus_receive_errors, 5);
  ASSERT_EQ(reader.axes().size(), 2U);
  const auto& got = reader.axes()[1];
  const auto sent = axis_of(41, 1);
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): it went as bytes, and is to arrive as them
  EXPECT_EQ(std::memcmp(&got, &sent, sizeof(AxisSample)), 0) << "the record of the cycle, to the bit";
  EXPECT_FALSE(reader.take());
}

TEST(Feed, DescribesItsLine) {
  const auto feed = feed_of(3, 8);
  const auto reader = reader_of(feed);
  const auto& line = reader.description();
  EXPECT_EQ(line.line.view(), "press");
  EXPECT_EQ(line.axes, 3U);
  EXPECT_EQ(line.axis[2].name.view(), "axis2");
  EXPECT_EQ(line.domain, 17U);
  EXPECT_EQ(line.decimation, 4U);
  EXPECT_EQ(line.interface[0].view(), "127.0.0.1");
}

TEST(Feed, ALapIsCountedAndTheRestIsWhole) {
  auto feed = feed_of(2, 8);
  auto reader = reader_of(feed);
  for (std::uint64_t cycle = 0; cycle < 20; ++cycle) push(feed, cycle);
  for (std::uint64_t cycle = 12; cycle < 20; ++cycle) {
    ASSERT_TRUE(reader.take());
    expect_cycle(reader, cycle);
  }
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.lost(), 12U);
  EXPECT_EQ(reader.next(), 20U);
}

TEST(Feed, ALaterReaderGoesOnWhereTheOneBeforeHasEnded) {
  auto feed = feed_of(1, 8);
  for (std::uint64_t cycle = 0; cycle < 5; ++cycle) push(feed, cycle);
  auto next = reader_of(feed, 3);
  ASSERT_TRUE(next.take());
  expect_cycle(next, 3);
  for (std::uint64_t cycle = 5; cycle < 12; ++cycle) push(feed, cycle);
  auto late = reader_of(feed, 1);
  ASSERT_TRUE(late.take());
  expect_cycle(late, 4);
  EXPECT_EQ(late.lost(), 3U);
  auto fresh = reader_of(feed);
  EXPECT_FALSE(fresh.take()) << "without a place it begins with what comes";
  auto beyond = reader_of(feed, 1'000'000);
  EXPECT_FALSE(beyond.take());
  push(feed, 12);
  ASSERT_TRUE(beyond.take()) << "a place that cannot be is now";
  expect_cycle(beyond, 12);
}

TEST(Feed, HalfACycleOfAKilledWriterIsNeverSeen) {
  auto region = must(rt::SharedRegion::create("driveline-test", feed_cycles_layout(1, 4)));
  rt::SharedBlockWriter writer{*region};
  rt::SharedBlockReader reader{*region};
  std::vector<std::uint64_t> record(reader.record_words());
  FeedLine line;
  for (std::uint64_t cycle = 0; cycle < 4; ++cycle) {
    line.cycle = cycle;
    writer.begin();
    writer.write(0, line);
    writer.commit();
  }
  // The fifth replaces the first, and is never completed.
  line.cycle = 99;
  writer.begin();
  writer.write(0, line);
  for (std::uint64_t cycle = 1; cycle < 4; ++cycle) {
    ASSERT_TRUE(reader.take(record));
    EXPECT_EQ(record[0], cycle);
  }
  EXPECT_FALSE(reader.take(record));
  EXPECT_EQ(reader.lost(), 1U);
}

TEST(Feed, PartsThatDoNotFitAreLeftOut) {
  auto region = must(rt::SharedRegion::create("driveline-test", rt::shared_blocks(1, 1, 16, 2)));
  rt::SharedBlockWriter writer{*region};
  rt::SharedBlockReader reader{*region};
  writer.begin();
  writer.write(0, std::uint64_t{1});
  writer.write(8, std::uint64_t{2});
  writer.write(16, std::uint64_t{3});
  writer.write(12, std::uint64_t{4});
  writer.write(~std::size_t{7}, std::uint64_t{5});
  writer.commit();
  writer.begin();
  writer.write(0, std::uint64_t{6});
  writer.write(8, std::uint64_t{7});
  writer.commit();
  std::array<std::uint64_t, 2> record{};
  ASSERT_TRUE(reader.take(record));
  EXPECT_THAT(record, testing::ElementsAre(1, 2));
  // The third replaces the first; after that comes the number of the second.
  writer.begin();
  writer.write(16, std::uint64_t{8});
  ASSERT_TRUE(reader.take(record));
  EXPECT_THAT(record, testing::ElementsAre(6, 7)) << "the record behind is not touched";
  EXPECT_FALSE(reader.take(std::span{record}.first(1)));
}

TEST(Feed, MoreSamplesThanAxesAreLeftOut) {
  auto feed = feed_of(1, 4);
  auto reader = reader_of(feed);
  feed.push(to_feed(line_of(0)), std::vector<FeedAxisSample>(3));
  ASSERT_TRUE(reader.take());
  EXPECT_EQ(reader.axes().size(), 1U);
}

TEST(Feed, ACycleWithoutItsLineHasItsAxes) {
  auto feed = feed_of(1, 4);
  auto reader = reader_of(feed);
  FeedLine lost;
  lost.cycle = 5;
  feed.push(lost, std::array{to_feed(axis_of(5, 0))});
  ASSERT_TRUE(reader.take());
  EXPECT_EQ(reader.line(), nullptr);
  ASSERT_EQ(reader.axes().size(), 1U);
  EXPECT_EQ(reader.axes()[0].cycle, 5U);
}

TEST(Feed, ItsStatusIsTheNewest) {
  auto feed = feed_of(1, 4);
  const auto reader = reader_of(feed);
  FeedStatus status;
  ASSERT_TRUE(reader.status(status)) << "there is one from the start";
  EXPECT_EQ(status.cycles, 0U);
  for (std::uint64_t cycles = 1; cycles < 10; ++cycles) {
    status.cycles = cycles;
    status.faults = 1;
    status.fault[0].set("axis z: cable");
    feed.set_status(status);
  }
  FeedStatus got;
  ASSERT_TRUE(reader.status(got));
  EXPECT_EQ(got.cycles, 9U);
  EXPECT_EQ(got.fault[0].view(), "axis z: cable");
}

TEST(Feed, ALateReaderHasTheLastEventsWithTheirNumbers) {
  auto feed = feed_of(1, 4);
  FeedEvent event;
  for (std::uint64_t i = 0; i < kFeedEvents + 3; ++i) {
    event.wall_time_ns = static_cast<std::int64_t>(i) * 1000;
    event.severity = i % 4;
    event.text.set("event " + std::to_string(i));
    feed.push_event(event);
  }
  auto reader = reader_of(feed);
  std::uint64_t number = 0;
  for (std::uint64_t i = 3; i < kFeedEvents + 3; ++i) {
    ASSERT_TRUE(reader.take_event(event, number));
    EXPECT_EQ(number, i);
    EXPECT_EQ(event.wall_time_ns, static_cast<std::int64_t>(i) * 1000);
    EXPECT_EQ(event.severity, i % 4);
    EXPECT_EQ(event.text.view(), "event " + std::to_string(i));
  }
  EXPECT_FALSE(reader.take_event(event, number));
}

TEST(Feed, NumbersThatCannotBeAreBroughtIntoTheirRanges) {
  auto feed = feed_of(1, 4);
  auto reader = reader_of(feed);
  FeedAxisSample sample = to_feed(axis_of(0, 0));
  sample.state = 0xEE;
  feed.push(to_feed(line_of(0)), std::array{sample});
  ASSERT_TRUE(reader.take());
  EXPECT_EQ(reader.axes()[0].state, AxisState::kUnavailable);
  FeedStatus status;
  status.faults = 0xFFFF;
  for (auto& fault : status.fault) fault.bytes.fill('x');  // without an end
  feed.set_status(status);
  ASSERT_TRUE(reader.status(status));
  EXPECT_EQ(status.faults, kMaxFeedFaults);
  EXPECT_EQ(status.fault[3].view().size(), 256U);
}

FeedWriter feed_of_slaves(std::uint32_t slaves) {
  auto description = description_of(1);
  description.slaves = slaves;
  auto feed = FeedWriter::create(description, 4);
  if (!feed) throw std::runtime_error(rt::describe(feed.error()));
  return *std::move(feed);
}

TEST(Feed, TheNewestConditionArrivesToTheBit) {
  auto feed = feed_of_slaves(2);
  auto reader = must(FeedConditionReader::open(feed.condition_descriptor(), 2, 1));
  FeedCondition got;
  EXPECT_FALSE(reader->take(got)) << "nothing is known yet";
  std::vector<FeedSlave> slaves(2);
  FeedConditionHead head;
  head.ring_slave = 1;
  head.silent_ports = 1;
  head.silent[0] = 7;
  for (std::uint16_t i = 0; i < 3; ++i) {
    slaves[1].name.set("y");
    slaves[1].alias = i;
    slaves[1].port[3].lost_links = 9;
    FeedOwner owner;
    owner.name.set("stream");
    feed.set_condition({head, slaves, {owner}});
  }
  ASSERT_TRUE(reader->take(got));
  EXPECT_EQ(got.head.slaves, 2U);
  EXPECT_EQ(got.head.ring_slave, 1);
  EXPECT_EQ(got.head.silent[0], 7U);
  ASSERT_EQ(got.slaves.size(), 2U);
  EXPECT_EQ(got.slaves[1].name.view(), "y");
  EXPECT_EQ(got.slaves[1].alias, 2U) << "the newest";
  EXPECT_EQ(got.slaves[1].port[3].lost_links, 9U);
  ASSERT_EQ(got.owners.size(), 1U);
  EXPECT_EQ(got.owners[0].name.view(), "stream");
  EXPECT_FALSE(reader->take(got)) << "nothing new";
  auto late = must(FeedConditionReader::open(feed.condition_descriptor(), 2, 1));
  EXPECT_TRUE(late->take(got)) << "who comes late has it, too";
}

TEST(Feed, AConditionHasNoMoreThanItsRoom) {
  auto feed = feed_of_slaves(2);
  feed.set_condition({{}, std::vector<FeedSlave>(5), std::vector<FeedOwner>(5)});
  auto region = must(rt::SharedRegion::create("driveline-test", feed_condition_layout(2, 1, 4)));
  rt::SharedBlockWriter liar{*region};
  FeedConditionHead head;
  head.slaves = 4'000'000'000;
  head.axes = 4'000'000'000;
  head.silent_ports = 4'000'000'000;
  liar.begin();
  liar.write(0, head);
  liar.commit();
  for (const int descriptor : {feed.condition_descriptor(), region->descriptor()}) {
    auto reader = must(FeedConditionReader::open(descriptor, 2, 1));
    FeedCondition got;
    ASSERT_TRUE(reader->take(got));
    EXPECT_EQ(got.slaves.size(), 2U);
    EXPECT_EQ(got.owners.size(), 1U);
    EXPECT_LE(got.head.silent_ports, kMaxFeedSilentPorts);
  }
  EXPECT_THAT(failure_text(FeedConditionReader::open(feed.condition_descriptor(), 3, 1)),
              HasSubstr("feed, condition: "));
}

TEST(Feed, AnIndexThatCannotBeCostsRecordsAndNeverTime) {
  auto region = must(rt::SharedRegion::create("driveline-test", feed_cycles_layout(1, 4)));
  rt::SharedBlockWriter writer{*region};
  rt::SharedBlockReader reader{*region};
  std::vector<std::uint64_t> record(reader.record_words());
  writer.begin();
  writer.commit();
  ASSERT_TRUE(reader.take(record));
  auto& head = region->words()[rt::shared_detail::kHeadWord];
  head = ~std::uint64_t{0} - 5;
  EXPECT_FALSE(reader.take(record)) << "no slot has these numbers";
  head = 0;
  EXPECT_FALSE(reader.take(record));
  EXPECT_EQ(reader.next(), 0U);
  head = 1;
  EXPECT_TRUE(reader.take(record)) << "and back in order";
}

TEST(Feed, RegionsThatAreNoFeedAreRefusedInASentence) {
  const auto feed = feed_of(1, 4);
  const auto open = [&feed](int description, int status, int cycles) {
    const auto reader = FeedReader::open(description, status, cycles, feed.events_descriptor());
    return reader ? std::string{} : describe(reader.error());
  };
  EXPECT_THAT(open(0, feed.status_descriptor(), feed.cycles_descriptor()), HasSubstr("feed, description: "));
  EXPECT_THAT(open(feed.description_descriptor(), -1, feed.cycles_descriptor()), HasSubstr("feed, status: "));
  EXPECT_THAT(open(feed.description_descriptor(), feed.status_descriptor(), feed.status_descriptor()),
              HasSubstr("feed, cycles: shared region: content"));
  const auto other = feed_of(2, 4);
  EXPECT_THAT(open(feed.description_descriptor(), feed.status_descriptor(), other.cycles_descriptor()),
              HasSubstr("bytes of a record"))
      << "of a line with another number of axes";
  auto silent = must(rt::SharedRegion::create("driveline-test", feed_description_layout(1)));
  EXPECT_THAT(open(silent->descriptor(), feed.status_descriptor(), feed.cycles_descriptor()),
              HasSubstr("there is none"));
}

TEST(Feed, ADescriptionThatCannotBeIsRefused) {
  for (auto* const spoil : std::initializer_list<void (*)(FeedDescription&)>{
           [](FeedDescription& d) { d.axes = kMaxFeedAxes + 1; }, [](FeedDescription& d) { d.interfaces = 17; },
           [](FeedDescription& d) { d.peers = kMaxFeedPeers + 1; },
           [](FeedDescription& d) { d.discovery_port = 65536; }, [](FeedDescription& d) { d.decimation = 0; }}) {
    auto description = description_of(1);
    spoil(description);
    auto region = must(rt::SharedRegion::create("driveline-test", feed_description_layout(1)));
    rt::SharedBroadcastWriter<FeedDescription>{*region}.push(description);
    const auto feed = feed_of(1, 4);
    const auto reader = FeedReader::open(region->descriptor(), feed.status_descriptor(), feed.cycles_descriptor(),
                                         feed.events_descriptor());
    ASSERT_FALSE(reader);
    EXPECT_THAT(describe(reader.error()), HasSubstr("too many axes"));
  }
}

TEST(Feed, IsReadWhileItIsWritten) {
  auto feed = feed_of(3, 16);
  auto reader = reader_of(feed);
  constexpr std::uint64_t kCycles = 20'000;
  std::atomic<bool> done{false};
  std::thread writer{[&] {
    for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle) {
      push(feed, cycle);
      if (cycle % 64 == 0) std::this_thread::yield();
    }
    done = true;
  }};
  std::uint64_t taken = 0;
  std::uint64_t last = 0;
  for (bool more = true; more;) {
    more = !done;
    while (reader.take()) {
      const auto cycle = reader.line()->cycle;
      EXPECT_TRUE(taken == 0 || cycle > last);
      expect_cycle(reader, cycle);
      last = cycle;
      ++taken;
    }
  }
  writer.join();
  EXPECT_EQ(taken + reader.lost(), kCycles);
  EXPECT_EQ(last, kCycles - 1);
}

TEST(Feed, AReaderCannotWriteIt) {
  const auto feed = feed_of(1, 4);
  EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, feed.cycles_descriptor(), 0), MAP_FAILED);
}

TEST(FeedReturn, TellsAndRemembers) {
  auto region = must(rt::SharedRegion::create("driveline-test", feed_return_layout(1)));
  auto first = must(FeedReturnWriter::open(region->descriptor()));
  first->tell({.beats = 1, .next = 2, .published = 3, .lost = 4, .refused = 5});
  const auto second = must(FeedReturnWriter::open(region->descriptor()));
  const auto told = second->last_record();
  EXPECT_EQ(told.next, 2U);
  EXPECT_EQ(told.refused, 5U);
}

TEST(Feed, AReaderThatWaitsIsWoken) {
  using std::chrono::hours;
  auto feed = feed_of(1, 64);
  auto reader = reader_of(feed);
  std::atomic<bool> woken{false};
  std::thread waiting([&] {
    while (!reader.take()) reader.wait(hours{1});
    woken = true;
  });
  // However late the thread is, it sees the cycle, or is woken for it.
  feed.push({}, {});
  while (!woken) {
    feed.wake();
    std::this_thread::yield();
  }
  waiting.join();
  feed.push({}, {});
  reader.wait(hours{1});  // returns at once, because there is one to take
  EXPECT_TRUE(reader.take());
  const auto began = std::chrono::steady_clock::now();
  reader.wait(std::chrono::milliseconds{1});
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds{1}) << "there is none";
}

}  // namespace
}  // namespace driveline::snapshot
