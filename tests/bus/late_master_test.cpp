// Statistics and motion with a late master and lost frames.
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "drive_line.hpp"
#include "late_line.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::AbsenceEffect;
using motion::LatePolicy;
using motion::LossPolicy;
using motion::MasterAbsence;
using motion::MotionFailure;
using motion::MotionPhase;
using testing::HasSubstr;

TEST(LateMaster, CountsItsWholeAbsence) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  operation.run(milliseconds{2});
  operation.master().core()->count(false);
  operation.cycle();
  operation.master().core()->count(true);
  operation.run(milliseconds{2});
  EXPECT_EQ(operation.statistics().longest_absence, nanoseconds{0});
  const auto cycles = operation.statistics().cycles;
  operation.line_samples.clear();
  // The next cycle is due in a period, less the remainder of this one.
  const auto due = drives.clock.now() / kLatePeriod * kLatePeriod + kLatePeriod;
  const auto late = 6 * kLatePeriod + microseconds{20};
  drives.clock.advance(due + late - drives.clock.now());
  operation.cycle();
  const auto& statistics = operation.statistics();
  EXPECT_EQ(statistics.cycles, cycles + 1);
  EXPECT_EQ(statistics.missed_periods, 6U);
  EXPECT_EQ(statistics.wake_latency.max(), late);
  EXPECT_EQ(statistics.wake_latency.count(), statistics.cycles + statistics.missed_periods);
  EXPECT_EQ(statistics.longest_absence, late);
  EXPECT_EQ(statistics.longest_absence_at, due);
  ASSERT_EQ(operation.line_samples.size(), 1U);
  EXPECT_EQ(operation.line_samples[0].wake_latency_ns, late.count()) << "so it goes to DDS and the flight recorder";
}

/// As for a supervising thread that is faster than the cycle.
TEST(LateMaster, CountingThatIsRestartedBetweenTwoCyclesStartsAnew) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  operation.run(milliseconds{2});
  ASSERT_GT(operation.statistics().cycles, 16U);
  operation.master().core()->count(false);
  operation.master().core()->count(true);
  operation.cycle();
  EXPECT_EQ(operation.statistics().cycles, 1U);
  operation.master().core()->count(true);
  operation.cycle();
  EXPECT_EQ(operation.statistics().cycles, 2U) << "it was on already";
}

/// Ends the counting as soon as an absence is reported, before the late cycle is over, as a supervising thread may do.
class EndsCountingAtOnce final : public motion::CycleTask {
 public:
  void update(const motion::TaskCycle&) noexcept override {
    MasterAbsence absence;
    if (core != nullptr && core->take_absence(absence)) core->count(false);
  }
  ecat_master::CyclicCore* core = nullptr;
};

TEST(LateMaster, TheAbsenceThatEndsTheCountingIsCounted) {
  DriveLine drives(1);
  EndsCountingAtOnce task;
  RunOptions options;
  options.task = &task;
  IdleOperation operation(drives, options);
  operation.run(milliseconds{2});
  task.core = operation.master().core();
  drives.clock.advance(50 * kLatePeriod);
  operation.run(milliseconds{2});
  EXPECT_GE(operation.statistics().longest_absence, 49 * kLatePeriod);
  EXPECT_GE(operation.statistics().missed_periods, 49U);
}

TEST(LateMotion, IsWithinTheLimitsWhenNothingIsLate) {
  LateLine line;
  line.cycles(7000);
  line.expect_obedience();
  EXPECT_EQ(line.operation.motion().path_late(), nanoseconds{0});
  EXPECT_TRUE(line.absences().empty());
}

TEST(LateMotion, StaysLateByThePeriodsThatWereMissed) {
  LateLine line;
  line.cycles(400);
  line.stall(5);
  line.cycles(400);
  line.expect_obedience();
  EXPECT_EQ(line.operation.motion().phase(), MotionPhase::kFollowing);
  EXPECT_EQ(line.operation.motion().path_late(), 5 * kLatePeriod);
  const auto absences = line.absences();
  ASSERT_EQ(absences.size(), 1U);
  EXPECT_EQ(absences[0].duration, 5 * kLatePeriod);
  EXPECT_EQ(absences[0].path_late, 5 * kLatePeriod);
  EXPECT_EQ(absences[0].effect, AbsenceEffect::kBridged);
  EXPECT_EQ(motion::describe(absences[0], absences[0].since - milliseconds{850}, "8 cycles"),
            "the master was away for 0.6 ms at 0.850 s; the path is 0.6 ms late");
}

TEST(LateMotion, StaysLateByTheFramesThatWereLost) {
  for (const bool out : {true, false}) {
    LateLine line;
    line.cycles(400);
    line.lose(3, out);
    line.cycles(400);
    line.expect_obedience();
    EXPECT_EQ(line.operation.motion().path_late(), 3 * kLatePeriod);
    EXPECT_TRUE(line.absences().empty());
  }
}

/// The drives have received setpoints although the master lost the answer: its next setpoints must continue from those.
TEST(LateMotion, SetpointsBehindALostAnswerAreWithinTheLimits) {
  LateLine line;
  auto& samples = line.operation.axis_samples;
  const double most = LineOperation::axis(0, {}).limits.max_acceleration * 125e-6 * 125e-6;
  for (int place = 0; place < 60; ++place) {
    line.cycles(200 + place);
    samples.clear();
    line.cycles(3);
    line.lose(1 + place % 3, false);
    line.cycles(3);
    for (std::size_t i = 2; i < samples.size(); ++i) {
      const double bend =
          samples[i].target_position - 2.0 * samples[i - 1].target_position + samples[i - 2].target_position;
      EXPECT_LE(std::abs(bend), 1.001 * most) << "place " << place << " sample " << i;
    }
  }
}

/// Stalls of every length that is bridged, at and between the instants of the grid, with frames lost on the way out or
/// back.
TEST(LateMotion, DemandOfTheDriveObeysTheLimitsWhateverIsLate) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    LateLine line(LateLine::fast_path(), 2);
    std::mt19937 random(seed);
    const auto pick = [&random](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
    for (int event = 0; event < 60; ++event) {
      line.cycles(pick(1, 200));
      switch (pick(0, 3)) {
        case 0:
          line.stall(pick(1, 7));
          break;
        case 1:
          line.stall(pick(0, 6), nanoseconds{pick(1, 109'000)});
          break;
        case 2:
          line.lose(pick(1, 7), true);
          break;
        default:
          line.lose(pick(1, 7), false);
          break;
      }
      ASSERT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone) << "event " << event;
    }
    line.cycles(500);
    line.expect_obedience();
    EXPECT_GT(line.operation.motion().path_late(), 60 * kLatePeriod);
  }
}

/// One thread may submit both within a cycle, or two threads one each.
TEST(LateMotion, AStopIsObeyedThoughAStartFollowsInTheSameCycle) {
  LateLine line;
  auto& motion = line.operation.motion();
  line.cycles(400);
  motion.request_stop();
  motion.request_start();
  line.cycle();
  EXPECT_EQ(motion.phase(), MotionPhase::kStopping);
  for (int i = 0; i < 4000 && motion.phase() != MotionPhase::kDisabling; ++i) line.cycle();
  line.expect_obedience();  // without power, the demand of the drives is their actual position
  for (int i = 0; i < 4000 && motion.phase() != MotionPhase::kIdle; ++i) line.cycle();
  ASSERT_EQ(motion.phase(), MotionPhase::kIdle) << "a moving line is not started";
  motion.request_stop();
  motion.request_start();
  line.cycle();
  EXPECT_EQ(motion.phase(), MotionPhase::kEnabling) << "nothing was to be stopped";
  motion.request_start();
  motion.request_stop();
  line.cycle();
  EXPECT_EQ(motion.phase(), MotionPhase::kIdle) << "the last request is the stop, and no axis has power yet";
}

TEST(LateMotion, StopsWithinTheLimitsAfterAGapOnTheWay) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    LateLine line;
    line.cycles(200 + 37 * static_cast<int>(seed));
    line.operation.motion().request_stop();
    line.cycles(static_cast<int>(seed) % 4);
    seed % 2 == 0 ? line.stall(6) : line.lose(5, seed % 3 == 0);
    for (int i = 0; i < 4000 && line.operation.motion().phase() != MotionPhase::kDisabling; ++i) line.cycle();
    EXPECT_EQ(line.operation.motion().phase(), MotionPhase::kDisabling);
    line.expect_obedience();
    EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone);
  }
}

TEST(LateMotion, CatchesUpWithinTheLimitsWhereThatIsThePolicy) {
  auto options = LateLine::fast_path();
  options.late = LatePolicy::kCatchUp;
  LateLine line(options);
  line.cycles(400);
  for (int i = 0; i < 3; ++i) {
    line.stall(7);
    line.cycles(40);
  }
  EXPECT_GT(line.operation.motion().path_late(), 2 * 7 * kLatePeriod);
  line.cycles(4000);
  EXPECT_LT(line.operation.motion().path_late(), kLatePeriod);
  line.expect_obedience();
}

/// The machine is stopped between sending and the slaves' processing: the axis continues meanwhile, and then stops on
/// its own.
TEST(LateMotion, AnExchangeThatIsHeldUpIsAnAbsenceAndNoLeapOfTheAxis) {
  LateLine line;
  line.cycles(400);
  const double before = line.operation.motion().axes()[0].inputs().position;
  line.hold_up = 40 * kLatePeriod;
  line.cycle();
  EXPECT_GT(std::abs(line.operation.motion().axes()[0].inputs().position - before), 0.1);
  EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone);
  line.cycle();
  EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kMasterAway);
}

/// Lines of busy machines allow gaps after whose first periods the drives have slowed down.
TEST(LateMotion, BridgesGapsAsLongAsTheLineAllows) {
  auto options = LateLine::fast_path();
  options.max_lost_cycles = 400;
  for (const int periods : {9, 64, 65, 80, 200}) {
    for (const int kind : {0, 1, 2}) {
      SCOPED_TRACE(testing::Message() << periods << " periods, kind " << kind);
      LateLine line(options, 2);
      line.cycles(400);
      const auto before = line.operation.motion().path_late();
      kind == 0 ? line.stall(periods) : line.lose(periods, kind == 1);
      EXPECT_GE(line.operation.motion().path_late() - before, periods * kLatePeriod);
      line.cycles(4000);
      EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone);
      line.expect_obedience();
    }
  }
}

TEST(LateMotion, IsStoppedByTheDrivesAfterTooLongAnAbsence) {
  LateLine line;
  line.cycles(400);
  line.stall(400);
  EXPECT_EQ(line.operation.motion().phase(), MotionPhase::kQuickStop);
  EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kMasterAway);
  const auto absences = line.absences();
  ASSERT_EQ(absences.size(), 1U);
  EXPECT_EQ(absences[0].effect, AbsenceEffect::kStopped);
  EXPECT_THAT(motion::describe(absences[0], absences[0].since, "8 cycles"),
              HasSubstr(" at 0.000 s, longer than 8 cycles: all axes"));
  line.cycles(2000);
  line.expect_obedience();
  EXPECT_EQ(line.operation.motion().phase(), MotionPhase::kIdle);
}

TEST(LateMotion, GoesOnAfterTooLongAnAbsenceWhereAxesMayBeMissing) {
  auto options = LateLine::fast_path();
  options.on_loss = LossPolicy::kHold;
  LateLine line(options);
  line.cycles(400);
  line.stall(300);
  EXPECT_EQ(line.operation.motion().failure().cause, MotionFailure::Cause::kNone);
  EXPECT_EQ(line.operation.motion().phase(), MotionPhase::kWaiting);
  bool follows = false;
  for (int i = 0; i < 16000 && !follows; ++i) {
    line.cycle();
    follows = line.operation.motion().phase() == MotionPhase::kFollowing;
  }
  EXPECT_TRUE(follows);
  line.expect_obedience();
}

}  // namespace
}  // namespace driveline::bus_test
