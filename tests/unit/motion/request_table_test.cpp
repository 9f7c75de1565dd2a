// Reports of requests when their numbers have gone round the table.
#include "driveline/motion/single_axis/request_table.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <random>
#include <thread>
#include <vector>

#include "group/group_request_table.hpp"

namespace driveline::motion {
namespace {

constexpr std::size_t kSlots = 16;

/// A table with few slots, and a report in a phase.
class ReportTableTest : public testing::Test {
 protected:
  static RequestReport in(RequestPhase phase) { return {phase, AxisError::kNone}; }
  RequestPhase phase(std::uint64_t id) const { return table.report(id).phase; }
  void add_and_end(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) table.set(table.add(), in(RequestPhase::kDone));
  }

  ReportTable<RequestReport, kSlots> table;
};

TEST_F(ReportTableTest, AnOldRequestThatGoesOnDoesNotOverwriteANewerOne) {
  const auto conveyor = table.add();
  for (std::size_t i = 0; i < 3 * kSlots; ++i) {
    const auto id = table.add();
    table.set(conveyor, in(RequestPhase::kReached));
    EXPECT_EQ(phase(id), RequestPhase::kWaiting) << "request " << id;
    table.set(id, in(RequestPhase::kDone));
  }
}

TEST_F(ReportTableTest, ARequestThatIsNotOverKeepsItsReportHoweverManyFollow) {
  const auto conveyor = table.add();
  table.set(conveyor, in(RequestPhase::kReached));
  add_and_end(10 * kSlots);
  EXPECT_EQ(phase(conveyor), RequestPhase::kReached);
  table.set(conveyor, in(RequestPhase::kAborted));
  EXPECT_EQ(phase(conveyor), RequestPhase::kAborted);
  add_and_end(kSlots);
  EXPECT_EQ(phase(conveyor), RequestPhase::kUnknown) << "its slot is free now";
}

TEST_F(ReportTableTest, ALateReportOfAForgottenRequestIsIgnored) {
  const auto first = table.add();
  table.set(first, in(RequestPhase::kDone));
  add_and_end(kSlots - 1);
  const auto next = table.add();
  ASSERT_EQ(next % kSlots, first % kSlots);
  table.set(first, in(RequestPhase::kAborted));
  EXPECT_EQ(phase(first), RequestPhase::kUnknown);
  EXPECT_EQ(phase(next), RequestPhase::kWaiting);
}

TEST_F(ReportTableTest, SeveralRequestsHaveConsecutiveNumbersBesideOneThatGoesOn) {
  add_and_end(kSlots / 2);
  const auto conveyor = table.add();
  for (int turn = 0; turn < 20; ++turn) {
    const auto first = table.add(kSlots / 2);
    for (std::size_t i = 0; i < kSlots / 2; ++i) {
      EXPECT_EQ(phase(first + i), RequestPhase::kWaiting);
      table.set(first + i, in(RequestPhase::kDone));
    }
    EXPECT_EQ(phase(conveyor), RequestPhase::kWaiting);
  }
}

TEST_F(ReportTableTest, WithoutAFreeSlotTheOldestReportsAreLost) {
  std::vector<std::uint64_t> ids;
  for (std::size_t i = 0; i < kSlots; ++i) ids.push_back(table.add());
  const auto next = table.add();
  EXPECT_NE(next, 0U);
  EXPECT_EQ(phase(next), RequestPhase::kWaiting);
  EXPECT_EQ(phase(ids.front()), RequestPhase::kUnknown);
  table.set(ids.front(), in(RequestPhase::kActive));
  EXPECT_EQ(phase(next), RequestPhase::kWaiting);
}

TEST_F(ReportTableTest, OnlyARequestThatHasNotBeenTakenCanBeWithdrawn) {
  const auto id = table.add();
  EXPECT_TRUE(table.set_if_waiting(id, in(RequestPhase::kAborted)));
  EXPECT_FALSE(table.set_if_waiting(id, in(RequestPhase::kError)));
  EXPECT_EQ(phase(id), RequestPhase::kAborted);
  EXPECT_FALSE(table.set_if_waiting(0, in(RequestPhase::kAborted)));
}

/// Whatever happens in which order: a request that is not over has the report that was stored last, and a request that
/// is over has it or is unknown.
template <typename Report>
void expect_right_reports(unsigned seed) {
  constexpr std::size_t kMostOpen = kSlots / 2;
  std::mt19937 random(seed);
  ReportTable<Report, kSlots> table;
  std::map<std::uint64_t, RequestPhase> model;
  std::vector<std::uint64_t> open;
  for (int step = 0; step < 20'000; ++step) {
    if (open.size() < kMostOpen && random() % 2 == 0) {
      open.push_back(table.add());
      ASSERT_TRUE(model.emplace(open.back(), RequestPhase::kWaiting).second) << "a number was given twice";
    } else if (!open.empty()) {
      const auto at = random() % open.size();
      constexpr std::array kPhases{RequestPhase::kActive, RequestPhase::kReached, RequestPhase::kDone,
                                   RequestPhase::kAborted, RequestPhase::kError};
      Report report{};
      report.phase = kPhases[random() % kPhases.size()];
      table.set(open[at], report);
      model[open[at]] = report.phase;
      if (report.over()) open.erase(open.begin() + static_cast<std::ptrdiff_t>(at));
    }
    if (step % 16 != 0) continue;
    for (const auto& [id, expected] : model) {
      const auto seen = table.report(id).phase;
      const bool right = seen == expected || (is_over(expected) && seen == RequestPhase::kUnknown);
      ASSERT_TRUE(right) << "request " << id << " in step " << step;
    }
    while (model.size() > 4 * kSlots && is_over(model.begin()->second)) model.erase(model.begin());
  }
}

TEST(ReportTables, AreRightInAnyOrderOfEvents) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    expect_right_reports<RequestReport>(seed);
    expect_right_reports<GroupRequestReport>(seed);
  }
}

/// One thread ends requests while another one makes them: no report is lost.
TEST_F(ReportTableTest, TwoThreadsLoseNoReport) {
  constexpr std::uint64_t kRequests = 20'000;
  std::atomic<std::uint64_t> made{0};
  std::atomic<std::uint64_t> ended{0};
  std::thread cycle([this, &made, &ended] {
    const auto conveyor = table.add();
    for (std::uint64_t last = 0;;) {
      table.set(conveyor, in(RequestPhase::kReached));
      const auto now = made.load(std::memory_order_acquire);
      if (now == last) {
        std::this_thread::yield();
        continue;
      }
      table.set(now >> 1U, in(RequestPhase::kDone));
      last = now;
      ended.store(now, std::memory_order_release);
      if ((now & 1U) != 0) break;
    }
    EXPECT_EQ(phase(conveyor), RequestPhase::kReached);
  });
  std::uint64_t lost = 0;
  for (std::uint64_t i = 1; i <= kRequests; ++i) {
    const auto id = table.add();
    const auto word = id << 1U | static_cast<std::uint64_t>(i == kRequests);
    made.store(word, std::memory_order_release);
    while (ended.load(std::memory_order_acquire) != word) std::this_thread::yield();
    if (phase(id) != RequestPhase::kDone) ++lost;
  }
  cycle.join();
  EXPECT_EQ(lost, 0U);
}

TEST(ReportCode, HoldsEveryValueOfAReport) {
  const RequestReport single{RequestPhase::kError, AxisError::kSkew};
  EXPECT_EQ(ReportCode<RequestReport>::decode(ReportCode<RequestReport>::encode(single)).error, AxisError::kSkew);
  const GroupRequestReport group{RequestPhase::kAborted, GroupError::kResetFailed, 255};
  const auto back = ReportCode<GroupRequestReport>::decode(ReportCode<GroupRequestReport>::encode(group));
  EXPECT_EQ(back.phase, RequestPhase::kAborted);
  EXPECT_EQ(back.error, GroupError::kResetFailed);
  EXPECT_EQ(back.axis, 255U);
}

}  // namespace
}  // namespace driveline::motion
