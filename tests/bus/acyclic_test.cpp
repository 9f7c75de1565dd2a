#include <gmock/gmock.h>

#include <functional>
#include <tuple>

#include "drive_line.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/wire/frame.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
namespace facts = ecat_master::facts;

TEST(SdoWhileCycling, AThousandTransfersDisturbNothing) {
  DriveLine drives(2);
  FollowingOperation operation(drives, RunOptions{.repeat = true});
  const auto missed = operation.statistics().missed_periods;
  for (std::uint32_t i = 0; i < 250; ++i) {
    for (std::size_t drive = 0; drive < 2; ++drive) {
      CoeClient coe(*operation.master().mailbox(drive));
      const std::uint32_t window = 1'000'000 + 2 * i + static_cast<std::uint32_t>(drive);
      ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, window)), "") << i;
      const auto read = coe.upload_as<std::uint32_t>(0x6065, 0);
      ASSERT_EQ(sentence(read), "") << i;
      ASSERT_EQ(*read, window);
    }
  }
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
  EXPECT_EQ(operation.statistics().stale_frames, 0U);
  EXPECT_EQ(operation.statistics().missed_periods, missed);
  EXPECT_EQ(operation.motion().failure().cause, motion::MotionFailure::Cause::kNone);
}

/// What the axes reported over the cycles of a motion, while `beside` ran between them.
std::vector<snapshot::AxisSample> samples_of_a_motion(const std::function<void(LineOperation&)>& beside) {
  DriveLine drives(2);
  FollowingOperation operation(drives, RunOptions{.repeat = true});
  operation.axis_samples.clear();
  const auto begin = operation.statistics().cycles;
  beside(operation);
  constexpr std::uint64_t kCycles = 48'000;  // more than the transfers take, along a path of 0.4 s that repeats
  EXPECT_LT(operation.statistics().cycles - begin, kCycles);
  while (operation.statistics().cycles - begin < kCycles) operation.cycle();
  return std::move(operation.axis_samples);
}

TEST(SdoWhileCycling, EveryParameterIsReadAndNoProcessDataChange) {
  std::size_t parameters = 0;
  const auto with_sdos = samples_of_a_motion([&](LineOperation& operation) {
    CoeClient coe(*operation.master().mailbox(1));
    for (const auto& row : slaves::msd::dictionary_table().rows()) {
      if ((row.access & slaves::access::kReadOperating) == 0) continue;
      ASSERT_EQ(sentence(coe.upload(row.index, row.subindex)), "") << std::hex << row.index << ':' << +row.subindex;
      parameters += row.index >= 0x2000 && row.index < 0x6000 ? 1 : 0;
      operation.cycle();  // takes the samples before their ring is full
    }
  });
  EXPECT_GT(parameters, 100U);
  const auto alone = samples_of_a_motion([](LineOperation&) {});
  ASSERT_EQ(with_sdos.size(), alone.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    const auto seen = [](const snapshot::AxisSample& sample) {
      return std::tuple(sample.cycle, sample.axis, sample.control_word, sample.status_word, sample.target_position,
                        sample.actual_position, sample.actual_velocity, sample.actual_torque,
                        sample.drive_following_error);
    };
    ASSERT_EQ(seen(with_sdos[i]), seen(alone[i])) << "sample " << i;
  }
  EXPECT_NE(alone.front().actual_position, alone.back().actual_position) << "the axes move";
}

/// Largest delay of the frames of the cycle while many registers were read, on a wire of limited speed.
struct Wire {
  nanoseconds alone{};
  nanoseconds busy{};
  std::uint64_t lost = 0;
};

Wire read_registers_on_a_wire(std::size_t acyclic_bytes) {
  slaves::LineOptions wire_options;
  wire_options.byte_time = nanoseconds{80};
  DriveLine drives(24, {}, wire_options);
  FollowingOperation operation(drives, RunOptions{.repeat = true, .acyclic_bytes = acyclic_bytes});
  auto& core = *operation.master().core();
  const auto count_anew = [&] {
    core.count(false);
    operation.master().pass(std::chrono::milliseconds{1});
    core.count(true);
  };
  Wire wire;
  count_anew();
  operation.master().pass(std::chrono::milliseconds{50});
  wire.alone = core.statistics().round_trip.max();
  count_anew();
  // Together much more than a frame: the pages of FMMUs and sync managers of all drives.
  std::vector<std::array<std::byte, 128>> pages(drives.size());
  std::vector<ecat_master::Request> requests;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const auto station = operation.master().slaves()[i].info.ref.station;
    requests.push_back({wire::Command::kFprd, wire::DatagramAddress::physical(station, 0x0600), pages[i]});
  }
  for (int i = 0; i < 20; ++i) EXPECT_EQ(sentence(operation.master().bus().exchange().exchange(requests)), "");
  wire.busy = core.statistics().round_trip.max();
  wire.lost = core.statistics().lost_frames;
  return wire;
}

TEST(AcyclicBudget, FramesOfTheCycleDoNotWaitForOthers) {
  const auto wire = read_registers_on_a_wire(0);
  EXPECT_EQ(wire.busy, wire.alone);
  EXPECT_EQ(wire.lost, 0U);
}

/// Shows the effect of the budget, and that the wire in the previous test has a limited speed.
TEST(AcyclicBudget, WithoutItTheyWait) {
  const auto wire = read_registers_on_a_wire(port::kMaxFrameBytes);
  EXPECT_TRUE(wire.busy > wire.alone || wire.lost > 0);
}

TEST(SdoWhileCycling, LongObjectsAndAborts) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  CoeClient coe(*operation.master().mailbox(0));
  const auto name = coe.upload(0x1008, 0);
  ASSERT_EQ(sentence(name), "");
  std::string text;
  for (const auto byte : *name) text += static_cast<char>(byte);
  EXPECT_EQ(text, "MSD Servo Drive");
  EXPECT_EQ(sentence(coe.upload(0x5FFF, 1)),
            "slave 0: object 5FFFh:01 aborted with 0x06020000 (object does not exist in the object dictionary)");
  EXPECT_EQ(sentence(coe.download_as<std::uint32_t>(0x1000, 0, 1)),
            "slave 0: object 1000h:00 aborted with 0x06010002 (object is read only)");
  EXPECT_EQ(sentence(coe.upload_as<std::uint16_t>(0x1000, 0)), "slave 0: object 1000h:00 has 4 bytes, 2 were expected");
}

class LossWhileCycling : public testing::TestWithParam<LossyPort::Direction> {};

TEST_P(LossWhileCycling, OneFrameInFiveOfAnyKind) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    DriveLine drives(1);
    bool armed = false;
    Chance chance(5, seed);
    LossyPort port(drives.line(), GetParam(), [&](auto, auto) { return armed && chance(); });
    IdleOperation operation(drives, port);
    CoeClient coe(*operation.master().mailbox(0));
    armed = true;
    for (std::uint32_t i = 0; i < 20; ++i) {
      ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 70'000 + i)), "") << seed << " " << i;
      const auto read = coe.upload_as<std::uint32_t>(0x6065, 0);
      ASSERT_EQ(sentence(read), "") << seed << " " << i;
      ASSERT_EQ(*read, 70'000 + i);
    }
    EXPECT_GT(port.lost(), 50U);
    EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, LossWhileCycling,
                         testing::Values(LossyPort::Direction::kOut, LossyPort::Direction::kBack),
                         [](const auto& test) { return test.param == LossyPort::Direction::kOut ? "Out" : "Back"; });

TEST(AcyclicWork, ThroughADeadLineEndsWithAnError) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  drives.line().drop_frames(1'000'000);
  CoeClient coe(*operation.master().mailbox(0));
  const auto read = coe.upload(0x6041, 0);
  ASSERT_FALSE(read);
  EXPECT_TRUE(read.error().is<facts::NoAnswer>());
  EXPECT_EQ(read.error().slave, 0);
}

TEST(AcyclicWork, ReadsManyRegistersInAFewFrames) {
  DriveLine drives(8);
  IdleOperation operation(drives);
  const auto before = operation.master().core()->cycles();
  const auto reports = operation.master().al_status();
  ASSERT_EQ(sentence(reports), "");
  EXPECT_LE(operation.master().core()->cycles() - before, 3U) << "all eight travel in one frame";
  ASSERT_EQ(reports->size(), 8U);
  for (const auto& report : *reports) EXPECT_EQ(report.status.state, wire::AlState::kOp);
}

/// Number of reads of a register with a datagram of its own (the first of its frame or a later one).
std::size_t reads_of(std::span<const std::byte> frame, std::uint16_t address) {
  std::size_t count = 0;
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) break;
    if (datagram->header.command == wire::Command::kFprd && datagram->header.address.ado() == address) ++count;
  }
  return count;
}

TEST(MailboxStatus, ComesWithTheProcessDataAndCostsNoDatagram) {
  DriveLine drives(3);
  std::size_t polls = 0;
  std::size_t reads = 0;
  ChangingPort port(drives.line(),
                    [&](std::span<std::byte> frame) {
                      polls += reads_of(frame, 0x080D);
                      reads += reads_of(frame, 0x1200);
                    },
                    {});
  IdleOperation operation(drives, port);
  ASSERT_NE(operation.master().image().places()[1].mailbox_offset, ecat_master::ProcessDataPlace::kNone);
  polls = reads = 0;
  for (int i = 0; i < 50; ++i) {
    CoeClient coe(*operation.master().mailbox(1));
    ASSERT_EQ(sentence(coe.upload(0x1018, 1)), "") << i;
  }
  EXPECT_EQ(polls, 0U) << "the status is in the process data";
  EXPECT_EQ(reads, 50U) << "no read finds an empty mailbox";
  EXPECT_EQ(operation.master().mailboxes().statistics(1).repeated, 0U);
}

TEST(MailboxStatus, IsAskedForAgainWhenTheCycleEnds) {
  DriveLine drives(2);
  IdleOperation operation(drives);
  ASSERT_EQ(sentence(operation.master().shut_down()), "");
  ASSERT_EQ(sentence(operation.master().enter_pre_op()), "");
  EXPECT_EQ(sentence(CoeClient(*operation.master().mailbox(1)).upload(0x1018, 1)), "");
}

TEST(MailboxStatus, OfASlaveThatIsGoneIsNotTakenFromOldProcessData) {
  DriveLine drives(3);
  IdleOperation operation(drives);
  drives.line().set_power(2, false);
  operation.run(milliseconds{2});
  const auto begin = drives.clock.now();
  const auto read = CoeClient(*operation.master().mailbox(2)).upload(0x1018, 1);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().slave, 2);
  EXPECT_LT(drives.clock.now() - begin, milliseconds{100}) << "three unanswered polls, not the time limit of a mailbox";
}

TEST(Emergencies, ArriveWithTheFaultThatCausedThem) {
  DriveLine drives(2);
  FollowingOperation operation(drives);
  drives.drive(1).set_dc_link(false);
  operation.run(milliseconds{10});
  ASSERT_EQ(sentence(operation.master().mailbox(1)->poll()), "");
  const auto emergencies = operation.master().emergencies().take(1);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].message.error_code, 0x3220);
  EXPECT_EQ(emergencies[0].message.error_register, 0x05) << "generic and voltage";
  ASSERT_EQ(sentence(operation.master().mailbox(0)->poll()), "");
  EXPECT_TRUE(operation.master().emergencies().take(0).empty());
  // An emergency ahead of an SDO answer must not disturb the transfer.
  drives.drive(1).set_dc_link(true);
  operation.run(milliseconds{300});
  operation.motion().request_start();
  operation.run(milliseconds{20});
  CoeClient coe(*operation.master().mailbox(1));
  const auto vendor = coe.upload_as<std::uint32_t>(0x1018, 1);
  ASSERT_EQ(sentence(vendor), "");
  EXPECT_EQ(*vendor, 0x28U);
  EXPECT_EQ(operation.master().emergencies().take(1).size(), 1U) << "the acknowledgement";
}

}  // namespace
}  // namespace driveline::bus_test
