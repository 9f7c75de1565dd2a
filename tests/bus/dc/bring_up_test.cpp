// The real master synchronises the clocks of a line; compared with the true times.
#include "dc/bring_up.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "clock_line.hpp"
#include "drive_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::dc::ClockPlan;
using ecat_master::dc::DelayQuality;
using ecat_master::dc::FollowMode;
using ecat_master::dc::LineClocks;
using slaves::LineOptions;
using slaves::MasterPort;
using slaves::Wiring;

constexpr nanoseconds kCable{50};

LineOptions with_cable(nanoseconds cable) {
  LineOptions options;
  options.cable_delay = cable;
  return options;
}

/// Register 0x0928 of every clock after the reference contains the true delay, within one count of the clocks.
void expect_true_delays(ClockLine& line, const LineClocks& clocks) {
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!clocks.slaves[i].present) continue;
    const auto written = line.slave(i).esc().memory().get(wire::reg::kSystemTimeDelay);
    EXPECT_NEAR(static_cast<double>(static_cast<std::int32_t>(written)), line.true_delay(clocks.reference, i),
                static_cast<double>(line.spec(i).resolution.count()))
        << "slave " << i;
    EXPECT_EQ(clocks.slaves[i].quality, DelayQuality::kMeasured) << "slave " << i;
  }
}

LineClocks bring_up(ClockLine& line, const ClockPlan& plan) {
  auto clocks = line.bring_up(plan);
  if (!clocks) throw std::runtime_error(sentence(clocks));
  return *clocks;
}

void expect_delays_of(const Wiring& wiring, const LineOptions& options = {}) {
  ClockLine line(random_clocks(wiring.slave_count(), 100.0), wiring, options);
  line.open();
  expect_true_delays(line, bring_up(line, line.plan()));
}

TEST(ClockDelays, OfALineAreTrue) {
  for (const std::size_t count : {1U, 2U, 9U, 64U}) {
    for (const auto cable : {nanoseconds{5}, nanoseconds{537}}) {
      ClockLine line(random_clocks(count, 100.0), std::nullopt, with_cable(cable));
      line.open();
      expect_true_delays(line, bring_up(line, line.plan()));
    }
  }
}

TEST(ClockDelays, OfALineWhoseProcessingTakesLongerAreTrue) {
  LineOptions options = with_cable(kCable);
  options.delays = {nanoseconds{540}, nanoseconds{500}};
  ClockLine line(random_clocks(8, 100.0), std::nullopt, options);
  line.open();
  auto plan = line.plan();
  for (auto& slave : plan.slaves) slave.processing_extra_ns = 40.0;
  expect_true_delays(line, bring_up(line, plan));
}

TEST(ClockDelays, OfABranchedLineAreTrue) {
  // Branches at ports 3 and 1, one of them branching again, cables of all lengths.
  Wiring wiring(8);
  ASSERT_TRUE(wiring.connect_master(MasterPort::kPrimary, {0, 0}, nanoseconds{20}));
  ASSERT_TRUE(wiring.connect({0, 3}, {1, 0}, nanoseconds{500}));
  ASSERT_TRUE(wiring.connect({1, 1}, {2, 0}, nanoseconds{5}));
  ASSERT_TRUE(wiring.connect({0, 1}, {3, 0}, nanoseconds{73}));
  ASSERT_TRUE(wiring.connect({3, 3}, {4, 0}, nanoseconds{11}));
  ASSERT_TRUE(wiring.connect({3, 1}, {5, 0}, nanoseconds{250}));
  ASSERT_TRUE(wiring.connect({5, 1}, {6, 0}, nanoseconds{31}));
  ASSERT_TRUE(wiring.connect({0, 2}, {7, 0}, nanoseconds{99}));
  expect_delays_of(wiring);
}

TEST(ClockDelays, OfAStarAreTrue) {
  Wiring wiring(4);
  ASSERT_TRUE(wiring.connect_master(MasterPort::kPrimary, {0, 0}, nanoseconds{20}));
  for (const unsigned port : {1U, 2U, 3U}) {
    ASSERT_TRUE(wiring.connect({0, port}, {port, 0}, nanoseconds{100 * port}));
  }
  expect_delays_of(wiring);
}

TEST(ClockDelays, OfASwappedSlaveAreTrue) {
  Wiring wiring(4);
  ASSERT_TRUE(wiring.connect_master(MasterPort::kPrimary, {0, 0}, nanoseconds{20}));
  ASSERT_TRUE(wiring.connect({0, 1}, {1, 1}, nanoseconds{60}));  // connected at its output
  ASSERT_TRUE(wiring.connect({1, 0}, {2, 0}, nanoseconds{110}));
  ASSERT_TRUE(wiring.connect({2, 1}, {3, 0}, nanoseconds{35}));
  expect_delays_of(wiring);
}

TEST(ClockDelays, BehindSlavesWithoutClockAreTrue) {
  auto specs = random_clocks(7, 100.0);
  for (const std::size_t i : {0U, 2U, 3U, 5U}) specs[i].clock = false;
  ClockLine line(specs, std::nullopt, with_cable(kCable));
  line.open();
  const auto clocks = bring_up(line, line.plan());
  EXPECT_EQ(clocks.reference, 1);
  expect_true_delays(line, clocks);
}

/// Frames leave a closed ring at its other end; for the measurement the ring is opened there, and closed again.
TEST(ClockDelays, OfARingAreTrueAndTheRingIsClosedAgain) {
  class RingPort final : public PassingPort {
   public:
    explicit RingPort(slaves::SimulatedLine& line) : PassingPort(line), far_(line.secondary()) {}
    [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
      auto frame = inner_.receive();
      return frame ? frame : far_.receive();
    }
    bool wait_readable(nanoseconds deadline) noexcept override {
      // In small steps, because the frame may leave at either end.
      for (auto step = start(); step < deadline; step += microseconds{1}) {
        if (far_.wait_readable(step) || inner_.wait_readable(step)) return true;
      }
      return false;
    }

   private:
    [[nodiscard]] nanoseconds start() const noexcept { return inner_.last_send_time(); }
    port::Port& far_;
  };
  ClockLine line(random_clocks(6, 100.0), Wiring::ring(6, kCable));
  RingPort ring(line.line());
  line.open(&ring);
  ASSERT_TRUE(line.master().topology().ring_end);
  const auto before = line.slave(5).esc().memory().get(wire::reg::kDlControl);
  const auto clocks = bring_up(line, line.plan());
  expect_true_delays(line, clocks);
  EXPECT_EQ(line.slave(5).esc().memory().get(wire::reg::kDlControl), before);
}

/// Local clocks that wrap around, or change their sign bit, between two ports of the same frame.
TEST(ClockDelays, DoNotMindWhereTheClocksAre) {
  for (const std::uint32_t edge : {0x8000'0000U, 0U}) {
    for (int step = -6; step <= 2; ++step) {
      auto specs = random_clocks(5, 20.0);
      // All latches of the bring-up happen within the next milliseconds; the clocks pass the edge there in steps.
      for (std::size_t i = 0; i < specs.size(); ++i) {
        specs[i].start = nanoseconds{(std::int64_t{7} << 32) + edge} + step * microseconds{300} +
                         static_cast<std::int64_t>(i) * nanoseconds{777};
      }
      ClockLine line(specs, std::nullopt, with_cable(kCable), nanoseconds{0});
      line.open();
      expect_true_delays(line, bring_up(line, line.plan()));
    }
  }
}

/// After bring-up the copies of the system time agree, and with the master's clock.
void expect_together(ClockLine& line, const LineClocks& clocks, nanoseconds window) {
  for (std::size_t i = clocks.reference; i < line.size(); ++i) {
    if (!clocks.slaves[i].present) continue;
    EXPECT_LE(std::chrono::abs(line.ahead(i, clocks.reference)), window) << "slave " << i;
  }
  const auto mapped = clocks.mapping.at(line.clock.now());
  const auto reference = line.system_time(clocks.reference);
  // The mapping includes the delay from the master to the reference.
  const auto off =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(reference) - static_cast<std::uint32_t>(mapped));
  EXPECT_LE(std::chrono::abs(nanoseconds{off}), microseconds{3});
}

TEST(ClockBringUp, AllClocksShowTheSameTime) {
  ClockLine line(random_clocks(16, 100.0), std::nullopt, with_cable(kCable));
  line.open();
  const auto clocks = bring_up(line, line.plan());
  expect_together(line, clocks, microseconds{1});
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(line.system_time(i) >> 32, clocks.mapping.at(line.clock.now()) >> 32) << "all 64 bits of slave " << i;
  }
}

TEST(ClockBringUp, ALineOf32BitClocksIsNoDifferent) {
  auto specs = random_clocks(8, 100.0);
  for (auto& spec : specs) {
    spec.wide = false;
    spec.start = nanoseconds{spec.start.count() & 0xFFFF'FFFF};
  }
  // The system time passes 2^32 ns during the bring-up.
  ClockLine line(specs, std::nullopt, with_cable(kCable), nanoseconds{0xFFFF'FFFF} - milliseconds{50});
  line.open();
  const auto clocks = bring_up(line, line.plan());
  expect_true_delays(line, clocks);
  expect_together(line, clocks, microseconds{1});
  for (std::size_t i = 0; i < line.size(); ++i) {
    EXPECT_EQ(line.slave(i).esc().memory().get(wire::reg::kStartTimeCyclic), clocks.start & 0xFFFF'FFFFU) << i;
  }
}

TEST(ClockBringUp, SpeedOfTheReferenceClockIsKnown) {
  auto specs = random_clocks(3, 100.0);
  specs[0].ppm = -77.0;
  ClockLine line(specs);
  line.open();
  EXPECT_NEAR(bring_up(line, line.plan()).mapping.ppm, -77.0, 0.5);
}

TEST(ClockBringUp, BusShiftBringsTheReferenceToTheMastersClock) {
  auto specs = random_clocks(4, 100.0);
  specs[0].ppm = 60.0;
  ClockLine line(specs, std::nullopt, with_cable(kCable));
  line.open();
  auto plan = line.plan();
  plan.mode = FollowMode::kReferenceFollows;
  plan.epoch = seconds{1'000'000};
  const auto clocks = bring_up(line, plan);
  EXPECT_EQ(clocks.mapping.ppm, 0.0);
  expect_together(line, clocks, microseconds{1});
}

/// A frame of each kind that the bring-up sends is lost, on either way.
TEST(ClockBringUp, OneLostFrameChangesNothing) {
  std::uint64_t frames = 0;
  {
    ClockLine line(random_clocks(3, 50.0), std::nullopt, with_cable(kCable));
    LossyPort counting(line.line(), LossyPort::Direction::kOut, [](auto, auto) { return false; });
    line.open(&counting);
    const auto before = counting.sent();
    static_cast<void>(bring_up(line, line.plan()));
    frames = counting.sent() - before;
  }
  for (const auto way : {LossyPort::Direction::kOut, LossyPort::Direction::kBack}) {
    for (std::uint64_t lost = 0; lost < frames; lost += lost < 40 ? 1 : 37) {
      ClockLine line(random_clocks(3, 50.0), std::nullopt, with_cable(kCable));
      std::optional<std::uint64_t> first;
      bool armed = false;
      LossyPort lossy(line.line(), way, [&](std::uint64_t number, auto) {
        if (armed && !first) first = number;
        return armed && number == *first + lost;
      });
      line.open(&lossy);
      armed = true;
      const auto clocks = bring_up(line, line.plan());
      ASSERT_EQ(lossy.lost(), 1U) << lost;
      expect_true_delays(line, clocks);
      expect_together(line, clocks, microseconds{1});
      EXPECT_NEAR(clocks.mapping.ppm, line.spec(0).ppm, 1.0) << lost;
      if (HasFailure()) FAIL() << "frame " << lost << " of " << frames;
    }
  }
}

TEST(ClockBringUp, AFrameThatIsLostForGoodDuringCompensationIsOneSampleLess) {
  ClockLine line(random_clocks(3, 50.0), std::nullopt, with_cable(kCable));
  int drift_frames = 0;
  LossyPort lossy(line.line(), LossyPort::Direction::kBack, [&](auto, std::span<const std::byte> frame) {
    if (first_datagram(frame).command != wire::Command::kFrmw) return false;
    ++drift_frames;
    return drift_frames > 100 && drift_frames <= 105;  // the frame and all its repetitions
  });
  line.open(&lossy);
  const auto clocks = bring_up(line, line.plan());
  EXPECT_EQ(clocks.drift_frames_lost, 1U);
  EXPECT_NEAR(clocks.mapping.ppm, line.spec(0).ppm, 1.0);
  expect_together(line, clocks, microseconds{1});
}

TEST(ClockBringUp, ALineThatFallsSilentIsReported) {
  ClockLine line(random_clocks(3, 50.0), std::nullopt, with_cable(kCable));
  LossyPort lossy(line.line(), LossyPort::Direction::kBack, [](auto, std::span<const std::byte> frame) {
    return first_datagram(frame).command == wire::Command::kFrmw;
  });
  line.open(&lossy);
  EXPECT_EQ(sentence(line.bring_up(line.plan())), "the line: no answer to a frame after 5 tries");
}

TEST(ClockBringUp, ASlaveThatHasNotTakenItsActivationIsNamed) {
  ClockLine line(random_clocks(3, 50.0), std::nullopt, with_cable(kCable));
  // The byte is lost on its way out, so the returned write differs from the sent one, too.
  ChangingPort changing(line.line(),
                        [&](std::span<std::byte> frame) {
                          auto cursor = wire::MutableDatagramCursor::open(frame);
                          while (cursor && !cursor->done()) {
                            const auto datagram = cursor->next();
                            if (!datagram) return;
                            const auto& header = datagram->header;
                            const bool to_it = !line.refs().empty() && header.address.adp() == line.refs()[1].station;
                            if (header.command == wire::Command::kFpwr && header.address.ado() == 0x0981 && to_it)
                              frame[datagram->place.data()] = std::byte{0};
                          }
                        },
                        {});
  line.open(&changing);
  const auto done = line.bring_up(line.plan());
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().slave, 1);
  const auto& facts = std::get<ecat_master::facts::SyncRegister>(done.error().facts);
  EXPECT_EQ(facts.address, 0x0981);
  EXPECT_EQ(facts.written, 3U);
  EXPECT_EQ(facts.read, 0U);
}

TEST(ClockBringUp, SignalsStartTogetherInTheFuture) {
  ClockLine line(random_clocks(5, 100.0), std::nullopt, with_cable(kCable));
  line.open();
  auto plan = line.plan(microseconds{250});
  plan.slaves[1].signals.sync0_shift = microseconds{20};
  plan.slaves[2].signals.sync0_shift = microseconds{-30};
  plan.slaves[3].signals = {0x0700, microseconds{125}, {}, microseconds{250}, microseconds{10}};
  plan.slaves[4].signals = {};
  const auto clocks = bring_up(line, plan);
  const auto now = line.system_time(0);
  auto reg = [&](std::size_t i, const auto& r) { return line.slave(i).esc().memory().get(r); };
  EXPECT_GT(clocks.start, now);
  EXPECT_LT(clocks.start, now + 200'000'000);
  EXPECT_EQ(clocks.start % 250'000, 0U);
  EXPECT_EQ(reg(0, wire::reg::kStartTimeCyclic), clocks.start);
  EXPECT_EQ(reg(1, wire::reg::kStartTimeCyclic), clocks.start + 20'000);
  EXPECT_EQ(reg(2, wire::reg::kStartTimeCyclic), clocks.start - 30'000);
  EXPECT_EQ(reg(3, wire::reg::kStartTimeCyclic), clocks.start);
  EXPECT_EQ(reg(0, wire::reg::kSync0CycleTime), 250'000U);
  EXPECT_EQ(reg(3, wire::reg::kSync0CycleTime), 125'000U);
  EXPECT_EQ(reg(3, wire::reg::kSync1CycleTime), 135'000U);
  for (const std::size_t i : {0U, 1U, 2U}) EXPECT_EQ(reg(i, wire::reg::kDcActivation), 0x03) << i;
  EXPECT_EQ(reg(3, wire::reg::kDcActivation), 0x07);
  EXPECT_EQ(reg(4, wire::reg::kDcActivation), 0x00);
}

/// Writing takes longer than the first lead: the start time is moved, and no slave starts in the past.
TEST(ClockBringUp, AStartTimeThatHasPassedIsChosenAnew) {
  ClockLine line(random_clocks(4, 20.0), std::nullopt, with_cable(kCable));
  int activations = 0;
  class SlowPort final : public PassingPort {
   public:
    SlowPort(port::Port& inner, rt::VirtualClock& clock, int& activations, nanoseconds delay)
        : PassingPort(inner), clock_(clock), activations_(activations), delay_(delay) {}
    [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
      const auto first = first_datagram(frame);
      if (first.ado == wire::reg::kDcActivation.address && first.command == wire::Command::kFpwr) {
        ++activations_;
        clock_.advance(delay_);
      }
      return inner_.send(frame);
    }

   private:
    rt::VirtualClock& clock_;
    int& activations_;
    nanoseconds delay_;
  };
  SlowPort slow(line.line(), line.clock, activations, milliseconds{300});
  line.open(&slow);
  const auto clocks = bring_up(line, line.plan());
  EXPECT_EQ(activations, 3) << "100 ms and 200 ms are not enough, 400 ms are";
  EXPECT_GT(clocks.start, line.system_time(0));

  ClockLine hopeless(random_clocks(4, 20.0), std::nullopt, with_cable(kCable));
  SlowPort slower(hopeless.line(), hopeless.clock, activations, seconds{2});
  hopeless.open(&slower);
  EXPECT_EQ(sentence(hopeless.bring_up(hopeless.plan())),
            "the start time of SYNC0 had passed before it was written to all slaves, 1600000 us were not enough");
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(hopeless.slave(i).esc().memory().get(wire::reg::kDcActivation), 0) << "left off at slave " << i;
  }
}

TEST(ClockBringUp, TheReferenceClockIsChosen) {
  auto specs = random_clocks(5, 100.0);
  specs[0].clock = false;
  ClockLine line(specs, std::nullopt, with_cable(kCable));
  line.open();
  EXPECT_EQ(bring_up(line, line.plan()).reference, 1);

  auto later = line.plan();
  later.slaves[1].signals = {};
  EXPECT_EQ(bring_up(line, later).reference, 2) << "the first slave that is to be synchronised";
  later.may_join = true;
  EXPECT_EQ(bring_up(line, later).reference, 1) << "slaves that join before slave 2 could not follow it";
  for (auto& slave : later.slaves) slave.signals = {};
  later.may_join = false;
  EXPECT_EQ(bring_up(line, later).reference, 1) << "no slave needs the time";

  auto plan = line.plan();
  plan.reference = 2;
  plan.slaves[1].signals = {};  // has a clock, but does not need the time
  const auto clocks = bring_up(line, plan);
  EXPECT_EQ(clocks.reference, 2);
  EXPECT_FALSE(clocks.slaves[1].follows);
  EXPECT_TRUE(clocks.slaves[3].follows);
  expect_together(line, clocks, microseconds{1});
}

TEST(ClockBringUp, BadPlansAreRefusedInOneSentence) {
  auto specs = random_clocks(4, 100.0);
  specs[0].clock = false;
  ClockLine line(specs);
  line.open();
  const auto good = line.plan();

  auto plan = good;
  plan.slaves[0].signals = plan.slaves[1].signals;
  EXPECT_EQ(sentence(line.bring_up(plan)), "slave 0: has no distributed clock, but SYNC signals are planned for it");
  plan = good;
  plan.reference = 0;
  EXPECT_EQ(sentence(line.bring_up(plan)), "slave 0: is chosen as reference clock but has no distributed clock");
  plan.reference = 17;
  EXPECT_EQ(sentence(line.bring_up(plan)), "slave 17: is chosen as reference clock but has no distributed clock");
  plan.reference = 3;
  EXPECT_EQ(sentence(line.bring_up(plan)),
            "slave 1: frames reach it before the reference clock, slave 3, so it cannot follow that clock");
  plan = good;
  plan.slaves[2].signals.sync0_cycle = microseconds{100};
  plan.slaves[2].base = microseconds{125};
  EXPECT_EQ(sentence(line.bring_up(plan)), "slave 2: the SYNC0 cycle of 100000 ns is not a multiple of 125000 ns");
  plan = good;
  plan.frame_lead = microseconds{126};
  EXPECT_EQ(sentence(line.bring_up(plan)), "frames cannot be 126000 ns ahead of SYNC0 in a cycle of 125000 ns");
  ASSERT_TRUE(ecat_master::change_state(line.master().bus(), line.refs(), wire::AlState::kInit, seconds{1}));
  EXPECT_EQ(sentence(line.bring_up(good)), "slave 1: SYNC signals are set up in PREOP, it is in INIT");
}

TEST(ClockBringUp, ALineWithoutClocksIsRefused) {
  auto specs = random_clocks(2, 0.0);
  for (auto& spec : specs) spec.clock = false;
  ClockLine line(specs);
  line.open();
  EXPECT_EQ(sentence(line.bring_up(line.plan())),
            "no slave of the line has a distributed clock, but synchronisation to one is requested");
}

TEST(ClockBringUp, MayBeRepeated) {
  ClockLine line(random_clocks(4, 100.0), std::nullopt, with_cable(kCable));
  line.open();
  static_cast<void>(bring_up(line, line.plan()));
  const auto clocks = bring_up(line, line.plan());
  expect_true_delays(line, clocks);
  expect_together(line, clocks, microseconds{1});
}

}  // namespace
}  // namespace driveline::bus_test
