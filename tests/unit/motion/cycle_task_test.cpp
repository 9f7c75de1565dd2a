// The cycles in which tasks run, and their input.
#include "driveline/motion/cycle/cycle_task.hpp"

#include <gmock/gmock.h>

#include <stdexcept>
#include <vector>

namespace driveline::motion {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;
using testing::ElementsAre;
using Order = TaskTiming::Order;

constexpr nanoseconds kPeriod = microseconds{125};

/// Records its calls.
struct Diary final : CycleTask {
  void update(const TaskCycle& now) noexcept override {
    cycles.push_back(now.cycle);
    missed.push_back(now.missed);
    elapsed_us.push_back(std::chrono::duration_cast<microseconds>(now.elapsed).count());
    if (clock != nullptr) clock->advance(takes);
    if (common != nullptr) common->push_back(name);
  }
  char name = 'a';
  std::vector<std::int64_t> cycles;
  std::vector<std::int64_t> missed;
  std::vector<std::int64_t> elapsed_us;
  rt::VirtualClock* clock = nullptr;
  nanoseconds takes{0};
  std::vector<char>* common = nullptr;
};

class TaskScheduleTest : public testing::Test {
 protected:
  /// Cycle `number` of the grid, after `missed` that were skipped.
  void cycle(std::int64_t number, std::int64_t missed = 0) {
    schedule.begin({number, number * kPeriod, number * kPeriod, missed});
    TaskCycle now;
    now.cycle = number;
    schedule.run(Order::kBeforeMotion, now, kPeriod, clock);
    if (motion != nullptr) motion->push_back('-');
    schedule.run(Order::kAfterMotion, now, kPeriod, clock);
  }

  rt::VirtualClock clock;
  TaskSchedule schedule;
  std::vector<char>* motion = nullptr;
};

TEST_F(TaskScheduleTest, DividerAndPhaseSayInWhichCycles) {
  Diary every;
  Diary fourth;
  Diary shifted;
  schedule.add(every, {});
  schedule.add(fourth, {4, 0});
  schedule.add(shifted, {4, 3});
  for (int i = 0; i < 10; ++i) cycle(i);
  EXPECT_THAT(every.cycles, ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(fourth.cycles, ElementsAre(0, 4, 8));
  EXPECT_THAT(fourth.elapsed_us, ElementsAre(0, 500, 500));
  EXPECT_THAT(shifted.cycles, ElementsAre(3, 7));
}

TEST_F(TaskScheduleTest, TheLinesLateStartIsNoMissedCall) {
  Diary fourth;
  schedule.add(fourth, {4, 0});
  cycle(5);
  cycle(6);
  cycle(8);
  EXPECT_THAT(fourth.cycles, ElementsAre(5, 8)) << "the turn of cycle 4 is made up for at the first chance";
}

TEST_F(TaskScheduleTest, ATaskWhoseCycleWasSkippedRunsInTheNextOneAndIsToldOfIt) {
  Diary every;
  Diary fourth;
  schedule.add(every, {});
  schedule.add(fourth, {4, 0});
  for (const int i : {0, 1, 2, 3}) cycle(i);
  cycle(6, 2);
  for (const int i : {7, 8}) cycle(i);
  cycle(20, 11);
  EXPECT_THAT(every.missed, ElementsAre(0, 0, 0, 0, 2, 0, 0, 11));
  EXPECT_THAT(every.elapsed_us, ElementsAre(0, 125, 125, 125, 375, 125, 125, 1500));
  EXPECT_THAT(fourth.cycles, ElementsAre(0, 6, 8, 20)) << "late once, then on its own cycles again, and never twice";
  EXPECT_THAT(fourth.missed, ElementsAre(0, 2, 0, 11));
  EXPECT_THAT(fourth.elapsed_us, ElementsAre(0, 750, 250, 1500));
}

TEST_F(TaskScheduleTest, PeriodsThatWereMissedBetweenTwoTurnsAreToldAtTheNextOne) {
  Diary fourth;
  schedule.add(fourth, {4, 0});
  cycle(0);
  cycle(2, 1);
  cycle(3);
  cycle(4);
  cycle(8);
  EXPECT_THAT(fourth.cycles, ElementsAre(0, 4, 8));
  EXPECT_THAT(fourth.missed, ElementsAre(0, 1, 0));
}

TEST_F(TaskScheduleTest, TheOrderIsBeforeTheMotionThenBehindItAndThatOfTheCalls) {
  std::vector<char> order;
  motion = &order;
  Diary a, b, c, d;
  a.name = 'a', b.name = 'b', c.name = 'c', d.name = 'd';
  for (auto* task : {&a, &b, &c, &d}) task->common = &order;
  schedule.add(a, {1, 0, Order::kAfterMotion});
  schedule.add(b, {});
  schedule.add(c, {1, 0, Order::kAfterMotion});
  schedule.add(d, {});
  cycle(0);
  EXPECT_THAT(order, ElementsAre('b', 'd', '-', 'a', 'c'));
}

TEST_F(TaskScheduleTest, EachTaskHasACostOfItsOwn) {
  Diary quick;
  Diary slow;
  quick.clock = slow.clock = &clock;
  quick.takes = nanoseconds{400};
  slow.takes = microseconds{7};
  schedule.add(quick, {});
  schedule.add(slow, {2, 0});
  for (int i = 0; i < 6; ++i) cycle(i);
  EXPECT_EQ(schedule.figures(0).calls, 6U);
  EXPECT_EQ(schedule.figures(0).cost.count(), 6U);
  EXPECT_EQ(schedule.figures(0).cost.max(), nanoseconds{400});
  EXPECT_EQ(schedule.figures(1).calls, 3U);
  EXPECT_EQ(schedule.figures(1).cost.max(), microseconds{7});
}

TEST_F(TaskScheduleTest, TimingThatCannotBeIsRefused) {
  Diary task;
  EXPECT_THROW(schedule.add(task, {0, 0}), std::invalid_argument);
  EXPECT_THROW(schedule.add(task, {4, 4}), std::invalid_argument);
  EXPECT_EQ(schedule.size(), 0U);
}

}  // namespace
}  // namespace driveline::motion
