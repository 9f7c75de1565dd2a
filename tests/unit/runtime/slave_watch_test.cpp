// Reports about the slaves and the cycle.
#include <gmock/gmock.h>

#include "record/cycle_tally.hpp"
#include "telemetry/slave_watch.hpp"

namespace driveline::runtime {
namespace {

using snapshot::FeedSlave;
using snapshot::LineSample;

constexpr std::chrono::nanoseconds kCycle = std::chrono::microseconds{500};

LineSample cycle_of(std::uint64_t number) {
  LineSample sample;
  sample.cycle = number;
  sample.time_ns = 7'000'000'000 + static_cast<std::int64_t>(number) * kCycle.count();
  sample.wake_latency_ns = number % 2 == 0 ? 2000 : 5000;
  sample.cost_ns = 30'000;
  sample.round_trip_ns = 20'000;
  sample.dc_difference_ns = number % 2 == 0 ? -40 : 10;
  sample.dc_locked = true;
  sample.working_counter = 9;
  sample.expected_working_counter = 9;
  sample.frame_received = true;
  return sample;
}

TEST(CycleStatistics, ComeOnceInASecondOfTheLineAndSinceItsStart) {
  StatisticsClock clock(kCycle);
  std::vector<snapshot::CycleStatisticsSample> made;
  for (std::uint64_t number = 0; number < 4500; ++number) {
    auto sample = cycle_of(number);
    if (number == 2100) sample.working_counter = 6;
    if (number == 2200) sample.frame_received = false;
    if (clock.add(sample)) made.push_back(clock.statistics());
  }
  ASSERT_EQ(made.size(), 2U);
  EXPECT_EQ(made[0].number, 1U);
  EXPECT_EQ(made[0].cycle, 1999U);
  EXPECT_EQ(made[0].time_ns, cycle_of(1999).time_ns);
  EXPECT_EQ(made[0].last.cycles, 2000U);
  EXPECT_EQ(made[0].last.duration_ns, 1'000'000'000);
  EXPECT_EQ(made[1].number, 2U);
  EXPECT_EQ(made[1].dc_difference_ns, 10);
  EXPECT_EQ(made[1].dc_locked, 1U);
  EXPECT_EQ(made[1].last.cycles, 2000U);
  EXPECT_EQ(made[1].last.wkc_errors, 1U);
  EXPECT_EQ(made[1].last.lost_frames, 1U);
  EXPECT_EQ(made[1].total.cycles, 4000U);
  EXPECT_EQ(made[1].total.duration_ns, 2'000'000'000);
  EXPECT_EQ(made[1].total.wkc_errors, 1U);
  EXPECT_EQ(made[1].last.wake_latency.max_ns, 5000);
  EXPECT_NEAR(static_cast<double>(made[1].last.wake_latency.p50_ns), 2000, 20);
  EXPECT_EQ(made[1].last.jitter.max_ns, 3000) << "from one cycle to the next";
  EXPECT_EQ(made[1].last.cost.count, 2000U);
  EXPECT_EQ(made[1].last.round_trip.count, 1999U) << "a lost frame has none";
  EXPECT_EQ(made[1].last.dc_difference.max_ns, 40) << "without sign";
  ASSERT_TRUE(clock.close()) << "what is left at the end";
  EXPECT_EQ(clock.statistics().last.cycles, 500U);
  EXPECT_EQ(clock.statistics().total.cycles, 4500U);
  EXPECT_FALSE(clock.close());
}

TEST(CycleStatistics, AnAbsenceIsWholeInThem) {
  StatisticsClock clock(kCycle);
  static_cast<void>(clock.add(cycle_of(0)));
  auto late = cycle_of(101);
  late.missed_periods = 100;
  late.wake_latency_ns = 100 * kCycle.count() + 3000;
  static_cast<void>(clock.add(late));
  ASSERT_TRUE(clock.close());
  const auto& last = clock.statistics().last;
  EXPECT_EQ(last.cycles, 2U);
  EXPECT_EQ(last.missed_periods, 100U);
  EXPECT_EQ(last.duration_ns, 102 * kCycle.count());
  EXPECT_EQ(last.wake_latency.count, 102U) << "every instant that was missed";
  EXPECT_EQ(last.wake_latency.max_ns, late.wake_latency_ns);
  EXPECT_EQ(last.jitter.count, 1U);
}

ecat_master::SlaveDiagnosis damaged_slave() {
  ecat_master::SlaveDiagnosis found;
  found.answers = true;
  found.al.status.state = wire::AlState::kSafeOp;
  found.al.status.error = true;
  found.al.code = static_cast<wire::AlStatusCode>(0x001B);
  found.ports[1] = {{true, false, true}, 1, 2, 3, 4};
  found.ports[2] = {{true, true, false}, 0, 0, 0, 0};
  found.processing_unit_errors = 5;
  found.pdi_errors = 6;
  return found;
}

TEST(SlaveWatch, TellsEveryRegister) {
  FeedSlave record;
  set_registers(record, damaged_slave(), 99);
  EXPECT_EQ(record.answers, 1U);
  EXPECT_EQ(record.read_at_ns, 99);
  EXPECT_EQ(record.al_state, 4U);
  EXPECT_EQ(record.al_error, 1U);
  EXPECT_EQ(record.al_status_code, 0x001BU);
  EXPECT_THAT(std::string(record.al_text.view()), testing::HasSubstr("watchdog"));
  EXPECT_EQ(record.port[1].link, 1U);
  EXPECT_EQ(record.port[1].open, 1U);
  EXPECT_EQ(record.port[1].invalid_frames, 1U);
  EXPECT_EQ(record.port[1].receive_errors, 2U);
  EXPECT_EQ(record.port[1].forwarded, 3U);
  EXPECT_EQ(record.port[1].lost_links, 4U);
  EXPECT_EQ(record.port[2].link, 1U);
  EXPECT_EQ(record.port[2].open, 0U) << "nobody answers there";
  EXPECT_EQ(record.processing_unit_errors, 5U);
  EXPECT_EQ(record.pdi_errors, 6U);
}

TEST(SlaveWatch, ASilentSlaveKeepsWhatWasKnownOfIt) {
  FeedSlave record;
  set_registers(record, damaged_slave(), 99);
  set_registers(record, {}, 100);
  EXPECT_EQ(record.answers, 0U);
  EXPECT_EQ(record.read_at_ns, 99) << "nothing was read now";
  EXPECT_EQ(record.al_state, 4U);
  EXPECT_EQ(record.port[1].lost_links, 4U);
}

TEST(SlaveWatch, TellsTheWiring) {
  ecat_master::Topology topology;
  topology.slaves.resize(3);
  topology.slaves[1].parent = ecat_master::PortRef{0, 1};
  topology.slaves[1].depth = 1;
  topology.slaves[2].parent = ecat_master::PortRef{0, 3};
  topology.slaves[2].entry_port = 1;
  topology.slaves[2].depth = 1;
  topology.ring_end = ecat_master::PortRef{2, 0};
  topology.silent_ports.assign(20, ecat_master::PortRef{1, 2});
  FeedSlave record;
  set_place(record, topology, 0);
  EXPECT_EQ(record.parent, snapshot::kFeedParentMaster);
  set_place(record, topology, 2);
  EXPECT_EQ(record.parent, 0);
  EXPECT_EQ(record.parent_port, 3U);
  EXPECT_EQ(record.entry_port, 1U);
  EXPECT_EQ(record.depth, 1);
  set_place(record, topology, 3);
  EXPECT_EQ(record.parent, snapshot::kFeedParentUnknown);
  const auto head = wiring_of(topology);
  EXPECT_EQ(head.ring_slave, 2);
  EXPECT_EQ(head.silent_ports, snapshot::kMaxFeedSilentPorts);
  EXPECT_EQ(head.silent[0], 1U * 4 + 2);
  EXPECT_EQ(wiring_of({}).ring_slave, snapshot::kFeedParentUnknown);
}

}  // namespace
}  // namespace driveline::runtime
