#include <gmock/gmock.h>

#include <bit>
#include <span>
#include <string>

#include "drive_line.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::Master;
using motion::MotionFailure;
using motion::MotionPhase;
using wire::AlState;
using Direction = LossyPort::Direction;

class LostFrames : public testing::TestWithParam<Direction> {};

/// From the first frame to SAFEOP and back to INIT, with an SDO transfer in between.
std::string whole_way(DriveLine& drives, port::Port& port) {
  LineOperation operation(drives, port);
  if (const auto done = operation.to_safe_op(); !done) return sentence(done);
  CoeClient coe(*operation.master().mailbox(0));
  const auto name = coe.upload(0x1008, 0);
  if (!name) return sentence(name);
  if (name->size() != 15) return "the device name has another size";
  if (const auto done = operation.master().shut_down(); !done) return sentence(done);
  return drives.all_in(AlState::kInit) ? "" : "not in INIT";
}

TEST_P(LostFrames, AnySingleOneOnTheWholeWayIsMadeUpFor) {
  std::uint64_t frames = 0;
  {
    DriveLine drives(1);
    LossyPort port(drives.line(), GetParam(), [](auto, auto) { return false; });
    ASSERT_EQ(whole_way(drives, port), "");
    frames = port.sent();
  }
  ASSERT_GT(frames, 150U);
  for (std::uint64_t lost = 0; lost < frames; ++lost) {
    DriveLine drives(1);
    LossyPort port(drives.line(), GetParam(), [lost](auto number, auto) { return number == lost; });
    ASSERT_EQ(whole_way(drives, port), "") << "frame " << lost << " of " << frames;
    ASSERT_EQ(port.lost(), 1U);
  }
}

TEST_P(LostFrames, ThreeInARowAnywhereAreMadeUpFor) {
  DriveLine once(1);
  LossyPort counting(once.line(), GetParam(), [](auto, auto) { return false; });
  ASSERT_EQ(whole_way(once, counting), "");
  for (std::uint64_t lost = 0; lost < counting.sent(); lost += 2) {
    DriveLine drives(1);
    LossyPort port(drives.line(), GetParam(),
                   [lost](auto number, auto) { return number >= lost && number < lost + 3; });
    ASSERT_EQ(whole_way(drives, port), "") << "frames from " << lost;
  }
}

TEST_P(LostFrames, OneInFourIsMadeUpForWithSeveralDrives) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    DriveLine drives(3);
    Chance chance(4, seed);
    // At most four attempts in a row are lost, because the master fails after five.
    unsigned in_a_row = 0;
    LossyPort port(drives.line(), GetParam(), [&](auto, auto) {
      const bool lost = in_a_row < 3 && chance();
      in_a_row = lost ? in_a_row + 1 : 0;
      return lost;
    });
    EXPECT_EQ(whole_way(drives, port), "") << "seed " << seed;
    EXPECT_GT(port.lost(), 60U);
  }
}

TEST_P(LostFrames, ALossThatNeverLetsTheMailboxThroughEndsInATimeout) {
  // Every third frame: initially out of phase with the retries, then in step with the repetition of a mailbox reply.
  for (std::uint64_t phase = 0; phase < 3; ++phase) {
    DriveLine drives(3);
    LossyPort port(drives.line(), GetParam(), [phase](auto number, auto) { return number % 3 == phase; });
    EXPECT_THAT(whole_way(drives, port), testing::AnyOf("", testing::HasSubstr("no mailbox reply for object")));
    EXPECT_LT(drives.clock.now(), std::chrono::seconds{20});
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, LostFrames, testing::Values(Direction::kOut, Direction::kBack),
                         [](const auto& test) { return test.param == Direction::kOut ? "Out" : "Back"; });

TEST(LostFramesOfTheLine, DroppedByTheLineItself) {
  DriveLine drives(2);
  LineOperation operation(drives);
  drives.line().drop_frames(3);
  ASSERT_EQ(sentence(operation.master().scan()), "");
  drives.line().drop_frames(3);
  ASSERT_EQ(sentence(operation.master().configure(operation.plans())), "");
  drives.line().drop_frames(3);
  CoeClient coe(*operation.master().mailbox(1));
  EXPECT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
}

TEST(LostFramesOfTheLine, TooManyAreAnErrorThatSaysHowOften) {
  DriveLine drives(2);
  Master master(drives.line(), drives.clock);
  drives.line().drop_frames(5);
  EXPECT_EQ(sentence(master.scan()), "the line: no answer to a frame after 5 tries");
}

/// The n-th read of the drive's outgoing mailbox (0x1200) loses its answer if bit n is set.
struct MailboxReplyLoss {
  unsigned pattern;
  unsigned reads = 0;
  bool operator()(std::span<const std::byte> frame) {
    const auto datagram = first_datagram(frame);
    if (datagram.command != wire::Command::kFprd || datagram.ado != 0x1200) return false;
    return (pattern >> reads++ & 1U) != 0;
  }
};

class LostMailboxReply : public testing::TestWithParam<unsigned> {};

TEST_P(LostMailboxReply, IsRepeatedByTheDrive) {
  DriveLine drives(1);
  bool armed = false;
  MailboxReplyLoss loss{GetParam()};
  LossyPort port(drives.line(), Direction::kBack, [&](auto, auto frame) { return armed && loss(frame); });
  PreOpMaster master(port, drives.clock);
  CoeClient coe(*master.mailbox(0));
  armed = true;
  const auto begin = drives.clock.now();
  const auto vendor = coe.upload_as<std::uint32_t>(0x1018, 1);
  ASSERT_EQ(sentence(vendor), "");
  EXPECT_EQ(*vendor, 0x28U);
  EXPECT_EQ(port.lost(), static_cast<unsigned>(std::popcount(GetParam())));
  EXPECT_LT(drives.clock.now() - begin, milliseconds{500}) << "well before the mailbox time-out";
  // Request and repetition are distinguished: the next transfer gets its own answer.
  const auto product = coe.upload_as<std::uint32_t>(0x1018, 2);
  ASSERT_EQ(sentence(product), "");
  EXPECT_EQ(*product, slaves::msd::kProductCode);
}

// A single loss, then also losses of the mailbox's repetition. The frame itself is not repeated, but the message is
// requested again.
INSTANTIATE_TEST_SUITE_P(Patterns, LostMailboxReply, testing::Values(0b1U, 0b11U, 0b111U, 0b1111U, 0b11111U));

TEST(LostMailboxRequestAcknowledge, DoesNotWriteTwice) {
  DriveLine drives(1);
  bool armed = false;
  unsigned seen = 0;
  LossyPort port(drives.line(), Direction::kBack, [&](auto, auto frame) {
    const auto datagram = first_datagram(frame);
    return armed && datagram.command == wire::Command::kFpwr && datagram.ado == 0x1000 && seen++ < 2;
  });
  PreOpMaster master(port, drives.clock);
  CoeClient coe(*master.mailbox(0));
  armed = true;
  ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 12345)), "");
  EXPECT_EQ(port.lost(), 2U);
  const auto window = coe.upload_as<std::uint32_t>(0x6065, 0);
  ASSERT_EQ(sentence(window), "") << "a second answer to the download must not stand in the way";
  EXPECT_EQ(*window, 12345U);
}

TEST(LostCyclicFrames, CostTheirCycleAndNothingElse) {
  DriveLine drives(2);
  bool armed = false;
  LossyPort port(drives.line(), Direction::kBack, [&](auto number, auto) { return armed && number % 10 == 3; });
  FollowingOperation operation(drives, port);
  armed = true;
  operation.run(milliseconds{100});
  EXPECT_EQ(operation.motion().phase(), MotionPhase::kFollowing);
  EXPECT_GE(port.lost(), 79U);
  EXPECT_EQ(operation.statistics().lost_frames, port.lost());
  EXPECT_EQ(operation.statistics().late_frames, 0U);
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().missed_periods, 0U) << "the grid stands";
  EXPECT_TRUE(drives.all_in(AlState::kOp));
}

TEST(LateFrames, AreCountedAndNeverTakenForNewOnes) {
  DriveLine drives(1);
  bool armed = false;
  // 2.4 cycles late, while a later frame is awaited.
  LatePort port(drives.line(), drives.clock, microseconds{300},
                [&](std::uint64_t number) { return armed && number % 7 == 0; });
  FollowingOperation operation(drives, port);
  operation.run(milliseconds{60});
  operation.axis_samples.clear();
  operation.line_samples.clear();
  armed = true;
  operation.run(milliseconds{100});  // on the rising part of the path
  armed = false;
  operation.run(milliseconds{2});
  EXPECT_GE(port.delayed(), 110U);
  EXPECT_EQ(operation.statistics().lost_frames, port.delayed());
  EXPECT_EQ(operation.statistics().late_frames, port.delayed()) << "told from those that never come";
  EXPECT_EQ(operation.statistics().stale_frames, port.delayed());
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  ASSERT_EQ(operation.axis_samples.size(), operation.line_samples.size());
  for (std::size_t i = 1; i < operation.axis_samples.size(); ++i) {
    const double before = operation.axis_samples[i - 1].actual_position;
    const double now = operation.axis_samples[i].actual_position;
    if (operation.line_samples[i].frame_received) {
      EXPECT_GT(now, before) << "an old position came back, cycle " << i;
    } else {
      EXPECT_EQ(now, before) << "cycle " << i;
    }
  }
}

TEST(LateFrames, OfAcyclicWorkAreNotTakenForTheAnswerToTheRepetition) {
  DriveLine drives(2);
  Chance chance(4, 3);
  // Later than the time-out of 2 ms: each such frame is repeated, and its answer arrives while others are awaited.
  LatePort port(drives.line(), drives.clock, microseconds{2300}, [&](std::uint64_t) { return chance(); });
  EXPECT_EQ(whole_way(drives, port), "");
  EXPECT_GT(port.delayed(), 50U);
}

/// Whether the frame carries process data.
bool carries_process_data(std::span<const std::byte> frame) {
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) return false;
    if (wire::is_logical(datagram->header.command)) return true;
  }
  return false;
}

class LostExchanges : public testing::TestWithParam<std::uint32_t> {
 protected:
  [[nodiscard]] RunOptions options() const {
    RunOptions options;
    options.layout.groups = {{GetParam(), 0, 0}};
    return options;
  }
  /// Loses this number of exchanges and runs on for 10 ms.
  void lose(LineOperation& operation, int exchanges) {
    left = exchanges;
    operation.run(static_cast<int>(GetParam()) * exchanges * microseconds{125} + milliseconds{10});
    EXPECT_EQ(left, 0);
  }

  int left = 0;
  DriveLine drives{1};
  LossyPort port{drives.line(), Direction::kOut,
                 [this](auto, auto frame) { return left > 0 && carries_process_data(frame) && left-- > 0; }};
};

TEST_P(LostExchanges, AreBridgedUpToTheLimitWhateverTheCyclesBetweenThem) {
  FollowingOperation operation(drives, port, options());
  operation.run(milliseconds{50});
  for (const int exchanges : {1, 7}) {
    lose(operation, exchanges);
    EXPECT_EQ(operation.motion().phase(), MotionPhase::kFollowing) << exchanges;
    EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kNone) << exchanges;
  }
}

TEST_P(LostExchanges, BeyondTheLimitStopTheAxes) {
  FollowingOperation operation(drives, port, options());
  operation.run(milliseconds{50});
  lose(operation, 8);
  EXPECT_NE(operation.motion().phase(), MotionPhase::kFollowing);
  EXPECT_EQ(operation.motion().failure().cause, MotionFailure::Cause::kCommunication);
}

TEST_P(LostExchanges, AreCountedForASingleAxisAsWell) {
  auto single = options();
  single.single_axes = true;
  IdleOperation operation(drives, port, single);
  auto& axes = operation.single_axes();
  motion::AxisRequest request;
  request.command = motion::AxisCommand::kPower;
  request.on = true;
  static_cast<void>(axes.submit(0, request));
  operation.run(std::chrono::seconds{1});
  ASSERT_EQ(axes.axis_report(0).state, motion::PlcopenState::kStandstill);
  for (const int exchanges : {1, 7}) {
    lose(operation, exchanges);
    EXPECT_EQ(axes.axis_report(0).error, motion::AxisError::kNone) << exchanges;
  }
  lose(operation, 8);
  EXPECT_EQ(axes.axis_report(0).error, motion::AxisError::kLost);
}

INSTANTIATE_TEST_SUITE_P(Dividers, LostExchanges, testing::Values(1U, 2U, 8U, 16U),
                         [](const auto& row) { return "Divider" + std::to_string(row.param); });

}  // namespace
}  // namespace driveline::bus_test
