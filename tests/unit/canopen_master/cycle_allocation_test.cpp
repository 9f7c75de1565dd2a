// The cycle allocates and locks only in its constructor. A separate program, because the guard replaces malloc.
#include <gtest/gtest.h>

#include <array>

#include "driveline/canopen_master/can_cycle.hpp"
#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "support/must.hpp"

namespace driveline::canopen {
namespace {

using namespace std::chrono_literals;

/// Answers every SYNC of a line of eight nodes, now and then late, short, twice or not at all, and takes not every
/// frame.
class UnreliablePort final : public CanPort {
 public:
  explicit UnreliablePort(rt::Clock& clock) : clock_(clock) {}

  SendStatus send(const Frame& frame) noexcept override {
    ++sent_;
    if (frame.identifier.value == 0x080) next_ = 0;
    return sent_ % 41 == 0 ? SendStatus::kBusy : sent_ % 1009 == 0 ? SendStatus::kDown : SendStatus::kSent;
  }
  std::optional<ReceivedFrame> receive() noexcept override {
    constexpr std::uint32_t kFrames = 20;
    if (next_ >= kFrames || clock_.now() < 1s + 1ms) return std::nullopt;
    const auto number = next_++;
    ++received_;
    const std::array<std::byte, 8> data{std::byte{0x27}};
    // TPDO 1 and 2 of each node, a heartbeat, an EMCY, and frames of a second master.
    const std::uint32_t identifier = number < 8    ? 0x183 + number
                                     : number < 16 ? 0x283 + number - 8
                                     : number < 17 ? 0x703U
                                     : number < 18 ? 0x083U
                                     : number < 19 ? 0x080U
                                                   : 0x304U;
    const std::size_t length = received_ % 97 == 0 ? 2 : number < 8 ? 6 : 3;
    return ReceivedFrame{Frame::of(identifier, std::span(data).first(length)),
                         received_ % 89 == 0 ? clock_.now() - 5ms : clock_.now()};
  }
  bool wait_readable(std::chrono::nanoseconds /*deadline*/) noexcept override { return true; }
  PortStatistics statistics() const noexcept override { return {}; }

 private:
  rt::Clock& clock_;
  std::uint64_t sent_ = 0;
  std::uint64_t received_ = 0;
  std::uint32_t next_ = 0;
};

MasterPlan eight_nodes() {
  MasterPlan plan;
  plan.master_heartbeat = 20ms;
  for (std::uint8_t i = 0; i < 8; ++i) {
    auto& node = plan.nodes.emplace_back();
    node.id = static_cast<std::uint8_t>(3 + i);
    node.rpdos = {{.number = 1, .exchange = PdoExchange::kOnChange, .objects = {{0x6040, 0, 16}, {0x6060, 0, 8}}},
                  {.number = 2, .objects = {{0x60C1, 1, 32}}}};
    node.tpdos = {{.number = 1, .objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}},
                  {.number = 2, .exchange = PdoExchange::kOnChange, .objects = {{0x6061, 0, 8}, {0x603F, 0, 16}}}};
  }
  return plan;
}

TEST(CanCycleAllocation, None) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  rt::VirtualClock clock{1s};
  UnreliablePort port(clock);
  AcyclicChannel channel;
  rt::SpscRing<snapshot::LineSample> lines(64);
  rt::SpscRing<snapshot::AxisSample> axes(64);
  motion::FlightRecorder recorder(0, 64);
  motion::CycleTrace trace(64);
  motion::TaskSchedule tasks;
  CanCycle::Settings settings;
  settings.tasks = &tasks;
  settings.recorder = &recorder;
  settings.trace = &trace;
  settings.copies = {{0, 8, 16, 8}};
  const auto plan = eight_nodes();
  CanCycle cycle(port, clock, plan, *must(PdoImage::build(plan)), channel, nullptr, {&lines, &axes}, settings);
  AcyclicPort owner(channel, clock, plan.period);

  rt::RtGuard::enter();
  std::int64_t number = 0;
  for (int i = 0; i < 12'000; ++i) {
    cycle.set_operational(static_cast<std::size_t>(i % 8), i % 100 < 95);
    static_cast<void>(owner.send(Frame::of(0x603, std::array{std::byte{0x40}})));
    const std::int64_t missed = i % 500 == 0 ? 3 : 0;
    number += 1 + missed;
    clock.sleep_until(1s + number * 2ms);
    if (i % 3 != 0) cycle.prepare();
    cycle.cycle({number, 1s + number * 2ms, clock.now(), missed});
    cycle.count(i % 1000 != 0);
    while (owner.receive()) {
    }
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);

  EXPECT_EQ(cycle.cycles(), 12'000U - 1);
  EXPECT_GT(cycle.counters().syncs_unsent, 0U);
  EXPECT_GT(cycle.counters().foreign_frames, 0U);
  EXPECT_GT(cycle.counters().stale_frames, 0U);
  EXPECT_GT(cycle.node_report(0).wrong_length, 0U);
  EXPECT_GT(cycle.node_report(0).lost, 0U);
}

}  // namespace
}  // namespace driveline::canopen
