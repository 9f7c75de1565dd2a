// Every layout of the process image with single lost and late frames, recovery, the return to the path, mailboxes
// during process data exchange, and the flight recorder.
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/motion/cycle/flight_recorder.hpp"
#include "driveline/wire/fmmu.hpp"
#include "every_layout.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::LineSupervisor;
using motion::AxisPresence;
using motion::LossPolicy;
using motion::MotionFailure;
using motion::MotionPhase;
using wire::AlState;

/// Logical addresses that a frame carries, according to its datagrams.
struct LogicalRange {
  std::uint32_t first;
  std::uint32_t bytes;
  bool reads;
  bool writes;
  // NOLINTNEXTLINE(modernize-use-nullptr): what is found is the 0 that a comparison by <=> ends in
  auto operator<=>(const LogicalRange&) const = default;
};
using LogicalFrame = std::vector<LogicalRange>;

LogicalFrame logical_ranges(std::span<const std::byte> frame) {
  using wire::Command;
  LogicalFrame ranges;
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) break;
    const auto& header = datagram->header;
    if (!wire::is_logical(header.command)) continue;
    ranges.push_back(
        {header.address.raw, header.length, header.command != Command::kLwr, header.command != Command::kLrd});
  }
  return ranges;
}

/// Whether the FMMUs of a slave map process data in this frame, single status bytes not counted.
bool touches(slaves::Slave& slave, const LogicalFrame& frame) {
  for (unsigned n = 0; n < 8; ++n) {
    const auto registers = slave.esc().memory().at(wire::reg::kFmmu.at(n), wire::FmmuEntity::kSize);
    const auto fmmu = wire::FmmuEntity::decode(registers).value();
    if (!fmmu.active || fmmu.physical_start < wire::kProcessRamStart) continue;
    for (const auto& range : frame) {
      const bool overlaps =
          fmmu.logical_start < range.first + range.bytes && range.first < fmmu.logical_start + fmmu.length;
      const bool reads = range.reads && (fmmu.type & wire::FmmuEntity::kTypeRead) != 0;
      const bool writes = range.writes && (fmmu.type & wire::FmmuEntity::kTypeWrite) != 0;
      if (overlaps && (reads || writes)) return true;
    }
  }
  return false;
}

class EveryLayoutLoses : public LayoutTest {};

TEST_P(EveryLayoutLoses, ExactlyTheSlavesOfTheFrameThatIsLost) {
  constexpr std::size_t kMany = 80;
  DriveLine many(kMany);
  std::set<LogicalFrame> seen;
  LogicalFrame doomed;
  LossyPort port(many.line(), LossyPort::Direction::kBack, [&](std::uint64_t, std::span<const std::byte> frame) {
    const auto ranges = logical_ranges(frame);
    if (ranges.empty()) return false;
    seen.insert(ranges);
    if (ranges != doomed) return false;
    doomed.clear();
    return true;
  });
  auto run = options();
  run.period = microseconds{250};
  IdleOperation line(many, port, run);
  line.run(milliseconds{5});
  auto& core = *line.master().core();
  const auto frames = seen;
  ASSERT_GE(frames.size(), 2U);
  std::size_t of_two_frames = 0;
  for (const auto& frame : frames) {
    const auto lost = line.statistics().lost_frames;
    doomed = frame;
    while (!doomed.empty()) line.cycle();
    EXPECT_EQ(line.statistics().lost_frames, lost + 1);
    std::size_t hit = 0;
    for (std::size_t i = 0; i < kMany; ++i) {
      const bool touched = touches(many.slave(i), frame);
      hit += touched ? 1 : 0;
      EXPECT_EQ(core.slave_report(i).valid, !touched) << i;
      EXPECT_EQ(core.slave_report(i).stale_exchanges > 0, touched) << i;
    }
    EXPECT_GT(hit, 0U);
    EXPECT_LT(hit, kMany) << "it is one frame of several";
    of_two_frames += hit;
    line.run(milliseconds{1});
    for (std::size_t i = 0; i < kMany; ++i) EXPECT_TRUE(core.slave_report(i).valid) << i;
  }
  EXPECT_GE(of_two_frames, kMany) << "every slave was hit by one of the frames at least";
  EXPECT_EQ(line.statistics().wkc_errors, 0U) << "a frame that is lost is no wrong working counter";
}

TEST_P(EveryLayoutLoses, NothingToAFrameThatComesLate) {
  bool armed = false;
  // 2.4 cycles late, while a later frame is awaited.
  LatePort port(drives.line(), drives.clock, microseconds{300},
                [&](std::uint64_t number) { return armed && number % 7 == 0; });
  auto run = options();
  run.repeat = true;
  start(port, run);
  const auto stale = operation->statistics().stale_frames;
  operation->axis_samples.clear();
  operation->line_samples.clear();
  armed = true;
  operation->run(milliseconds{100});
  armed = false;
  operation->run(milliseconds{2});
  EXPECT_GE(port.delayed(), 100U);
  EXPECT_EQ(operation->statistics().late_frames, port.delayed());
  EXPECT_EQ(operation->statistics().lost_frames, port.delayed());
  EXPECT_EQ(operation->statistics().stale_frames - stale, port.delayed()) << "none was taken for another";
  EXPECT_EQ(operation->statistics().wkc_errors, 0U);
  // Stale inputs would throw the positions back by two cycles of motion (up to 2e-4 rad each).
  std::array<double, kDrives> last{};
  std::array<double, kDrives> step{};
  std::array<unsigned, kDrives> samples{};
  unsigned compared = 0;
  for (const auto& sample : operation->axis_samples) {
    const double moved = sample.actual_position - last[sample.axis];
    last[sample.axis] = sample.actual_position;
    if (samples[sample.axis]++ == 0 || moved == 0.0) continue;
    if (std::abs(step[sample.axis]) > 5e-5) {
      ++compared;
      EXPECT_GT(moved * step[sample.axis], 0.0) << sample.axis;
    }
    step[sample.axis] = moved;
  }
  EXPECT_GT(compared, 200U);
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
}

INSTANTIATE_TEST_SUITE_P(Layouts, EveryLayoutLoses, all_layouts(),
                         [](const auto& name) { return std::string(name.param.name); });

/// Counts the cycles in which the data of a slave were not valid.
struct Watch final : motion::CycleTask {
  void update(const motion::TaskCycle& now) noexcept override {
    const auto valid = now.valid;
    ++cycles;
    for (std::size_t i = 0; i < valid.size(); ++i) invalid[i] += valid[i] ? 0 : 1;
  }
  std::array<std::uint64_t, 16> invalid{};
  std::uint64_t cycles = 0;
};

class EveryLayoutRecovers : public LayoutTest {
 protected:
  void begin(LossPolicy policy) {
    auto run = options();
    run.repeat = true;
    run.on_loss = policy;
    run.task = &watch;
    run.acyclic_bytes = 200;
    start(drives.line(), run);
    LineSupervisor::Settings settings;
    settings.state_timeout = std::chrono::seconds{1};
    supervisor = std::make_unique<LineSupervisor>(operation->master(), nullptr, settings);
    operation->run(milliseconds{5});
    watch = {};
  }
  void live(nanoseconds duration) {
    const auto end = drives.clock.now() + duration;
    while (drives.clock.now() < end) {
      operation->run(milliseconds{4});
      supervisor->poll();
      operation->axis_samples.clear();
      operation->line_samples.clear();
    }
  }
  bool live_until(const std::function<bool()>& done) {
    const auto end = drives.clock.now() + std::chrono::seconds{8};
    while (!done() && drives.clock.now() < end) live(milliseconds{4});
    return done();
  }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor->history()) all += what_happened(event) + "\n";
    return all;
  }
  void expect_undisturbed(std::size_t reached) {
    EXPECT_GT(watch.cycles, 100U);
    for (std::size_t i = 0; i < reached; ++i) EXPECT_EQ(watch.invalid[i], 0U) << "cycles of slave " << i;
  }

  Watch watch;
  std::unique_ptr<LineSupervisor> supervisor;
};

TEST_P(EveryLayoutRecovers, ADriveThatWasSwitchedOffAndTakesItsAxisBackOntoThePath) {
  constexpr std::size_t kLast = kDrives - 1;
  begin(LossPolicy::kContinue);
  drives.line().set_power(kLast, false);
  live(milliseconds{100});
  EXPECT_EQ(operation->motion().presence(kLast), AxisPresence::kMissing);
  EXPECT_EQ(told(), "slave 5: no longer answers\n");
  drives.line().set_power(kLast, true);
  ASSERT_TRUE(live_until([&] { return operation->motion().presence(kLast) == AxisPresence::kPresent; })) << told();
  live(milliseconds{50});
  EXPECT_EQ(told(), "slave 5: no longer answers\nslave 5: back in OP\n");
  EXPECT_TRUE(drives.all_in(AlState::kOp));
  expect_undisturbed(kLast);
  EXPECT_NEAR(operation->motion().setpoints()[kLast].position, drives.drive(kLast).position_rad(), 0.02);
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
}

TEST_P(EveryLayoutRecovers, WhatLiesBehindABrokenCable) {
  begin(LossPolicy::kHold);
  ASSERT_TRUE(drives.line().break_cable({2, 1}));
  live(milliseconds{300});
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kWaiting);
  ASSERT_TRUE(drives.line().break_cable({2, 1}, false));
  ASSERT_TRUE(live_until([&] { return operation->motion().phase() == MotionPhase::kFollowing; })) << told();
  EXPECT_TRUE(supervisor->all_operational());
  EXPECT_EQ(supervisor->recoveries(), 3U);
  expect_undisturbed(3);
}

TEST_P(EveryLayoutRecovers, ADriveThatFellToSafeOpAlone) {
  begin(LossPolicy::kContinue);
  const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
  const auto ref = operation->master().slaves()[2].info.ref;
  ASSERT_EQ(sentence(operation->master().bus().write(ref, wire::reg::kAlControl, value)), "");
  ASSERT_TRUE(live_until([&] { return supervisor->recoveries() == 1; })) << told();
  live(milliseconds{20});
  EXPECT_EQ(told(), "slave 2: left OP, is in SAFEOP, AL status code 0x0000 (no error)\nslave 2: back in OP\n");
  for (const std::size_t other : {0U, 1U, 3U, 4U, 5U}) EXPECT_EQ(watch.invalid[other], 0U) << other;
}

/// Its outputs stay locked until the supervisor acknowledges the error; the shorter working counter is no reason to
/// distrust the others.
TEST_P(EveryLayoutRecovers, ADriveThatFellToSafeOpByAnError) {
  begin(LossPolicy::kContinue);
  const auto value = wire::AlControl{AlState::kBootstrap, false, false}.raw();
  const auto ref = operation->master().slaves()[2].info.ref;
  ASSERT_EQ(sentence(operation->master().bus().write(ref, wire::reg::kAlControl, value)), "");
  ASSERT_TRUE(live_until([&] { return supervisor->recoveries() == 1; })) << told();
  live(milliseconds{20});
  EXPECT_EQ(told(),
            "slave 2: left OP, is in SAFEOP with an error, AL status code 0x0011 (invalid requested state change)\n"
            "slave 2: back in OP\n");
  for (const std::size_t other : {0U, 1U, 3U, 4U, 5U}) EXPECT_EQ(watch.invalid[other], 0U) << other;
}

INSTANTIATE_TEST_SUITE_P(Layouts, EveryLayoutRecovers, all_layouts(),
                         [](const auto& name) { return std::string(name.param.name); });

class EveryLayoutBeside : public LayoutTest {};

/// Transfers with all drives at once: the mailbox status comes with the process data, so it is not polled, and only
/// full mailboxes are read.
TEST_P(EveryLayoutBeside, MailboxesOfAllSlavesAreServed) {
  std::size_t polls = 0;
  std::size_t reads = 0;
  ChangingPort port(drives.line(),
                    [&](std::span<std::byte> frame) {
                      auto cursor = wire::DatagramCursor::open(frame);
                      while (cursor && !cursor->done()) {
                        const auto datagram = cursor->next();
                        if (!datagram) return;
                        if (datagram->header.command != wire::Command::kFprd) continue;
                        // Status of sync manager 1, and the mailbox behind it.
                        polls += datagram->header.address.ado() == 0x080D ? 1 : 0;
                        reads += datagram->header.address.ado() == 0x1200 ? 1 : 0;
                      }
                    },
                    {});
  auto run = options();
  run.repeat = true;
  run.acyclic_bytes = 700;
  start(port, run);
  polls = 0;
  reads = 0;
  constexpr std::uint32_t kRounds = 10;
  for (std::uint32_t round = 0; round < kRounds; ++round) {
    std::vector<ecat_master::SdoFuture> downloads;
    for (std::uint16_t i = 0; i < kDrives; ++i) {
      CoeClient coe(operation->master().mailboxes(), i);
      downloads.push_back(
          coe.start_download({0x6065, 0, false}, bytes::to_le_bytes<std::uint32_t>(70'000 + round + i)));
    }
    for (auto& download : downloads) ASSERT_EQ(sentence(download.get()), "");
  }
  EXPECT_EQ(polls, 0U);
  EXPECT_EQ(reads, kRounds * kDrives) << "one mailbox for each answer";
  for (std::uint16_t i = 0; i < kDrives; ++i) {
    EXPECT_EQ(CoeClient(operation->master().mailboxes(), i).upload_as<std::uint32_t>(0x6065, 0).value_or(0),
              70'000 + kRounds - 1 + i);
  }
  EXPECT_EQ(operation->statistics().wkc_errors, 0U);
  EXPECT_EQ(operation->statistics().lost_frames, 0U);
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
}

TEST_P(EveryLayoutBeside, TheRecorderKeepsWhereTheDrivesWere) {
  motion::FlightRecorder recorder(kDrives);
  auto run = options();
  run.repeat = true;
  run.recorder = &recorder;
  start(drives.line(), run);
  operation->run(milliseconds{100});
  drives.drive(3).set_dc_link(false);
  operation->run(milliseconds{300});
  ASSERT_TRUE(recorder.frozen());
  std::ostringstream out;
  const std::vector<motion::FlightRecorder::AxisLabel> labels{{"a"}, {"b"}, {"c"}, {"d"}, {"e"}, {"f"}};
  recorder.write_csv(out, labels);
  std::istringstream in(out.str());
  std::string head;
  std::getline(in, head);
  std::map<std::string, std::size_t> column;
  std::istringstream cells(head);
  for (std::string name; std::getline(cells, name, ',');) column.emplace(name, column.size());
  ASSERT_TRUE(column.contains("d.status_word")) << head;
  bool fault = false;
  bool other_fault = false;
  std::size_t rows = 0;
  for (std::string line; std::getline(in, line); ++rows) {
    std::vector<std::string> row;
    std::istringstream values(line);
    for (std::string value; std::getline(values, value, ',');) row.push_back(value);
    for (const auto& [name, unit, scale] : labels) {
      // Fault: xxxx xxxx x0xx 1000b (CiA 402).
      const bool has = (std::stoul(row[column[name + ".status_word"]], nullptr, 0) & 0x4FU) == 0x08U;
      (name == "d" ? fault : other_fault) |= has;
    }
  }
  EXPECT_GT(rows, 256U);
  EXPECT_TRUE(fault) << "of the drive that had it";
  EXPECT_FALSE(other_fault) << "of no other";
}

INSTANTIATE_TEST_SUITE_P(Layouts, EveryLayoutBeside, all_layouts(),
                         [](const auto& name) { return std::string(name.param.name); });

}  // namespace
}  // namespace driveline::bus_test
