#include "driveline/canopen_master/bus_budget.hpp"

#include <gtest/gtest.h>

#include "cycle_rig.hpp"

namespace driveline::canopen {
namespace {

using cycle_test::axes_plan;
using std::chrono::milliseconds;

BusBudget budget_of(const MasterPlan& plan) {
  return bus_budget(plan, *must(PdoImage::build(plan)));
}

struct BudgetRow {
  unsigned axes;
  int sync_ms;
  std::uint32_t bit_rate;
  std::uint32_t bits;        ///< counted by hand: 47 + axes * (79 + 95)
  std::uint32_t worst_bits;  ///< 55 + axes * (95 + 115)
  bool fits;
  std::uint32_t acyclic_frames;
  const char* sentence;
};

class BusBudgetRows : public testing::TestWithParam<BudgetRow> {};

TEST_P(BusBudgetRows, SaysWhetherTheLineFits) {
  const auto& row = GetParam();
  auto plan = axes_plan(row.axes);
  plan.period = milliseconds{row.sync_ms};
  plan.bit_rate = row.bit_rate;
  const auto budget = budget_of(plan);
  EXPECT_EQ(budget.bits, row.bits);
  EXPECT_EQ(budget.worst_bits, row.worst_bits);
  EXPECT_EQ(budget.fits, row.fits);
  EXPECT_EQ(budget.acyclic_frames, row.acyclic_frames);
  EXPECT_EQ(describe(budget, "axes"), row.sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Lines, BusBudgetRows,
    testing::Values(
        BudgetRow{8, 2, 1'000'000, 1439, 1735, true, 1,
                  "8 axes load the bus to 72 %, at most 87 %, and leave room for 1 more frame in each period"},
        BudgetRow{3, 1, 1'000'000, 569, 685, true, 2,
                  "3 axes load the bus to 57 %, at most 69 %, and leave room for 2 more frames in each period"},
        BudgetRow{16, 4, 1'000'000, 2831, 3415, true, 4,
                  "16 axes load the bus to 71 %, at most 85 %, and leave room for 4 more frames in each period"},
        BudgetRow{8, 4, 500'000, 1439, 1735, true, 1,
                  "8 axes load the bus to 72 %, at most 87 %, and leave room for 1 more frame in each period"},
        BudgetRow{8, 1, 1'000'000, 1439, 1735, false, 0,
                  "8 axes need 1.74 ms of bus in the worst case, SYNC is 1 ms: take 2 ms, or 3 axes"},
        BudgetRow{4, 1, 1'000'000, 743, 895, false, 0,
                  "4 axes need 0.90 ms of bus in the worst case, SYNC is 1 ms: take 2 ms, or 3 axes"},
        BudgetRow{1, 1, 125'000, 221, 265, false, 0,
                  "1 axes need 2.12 ms of bus in the worst case, SYNC is 1 ms: take 4 ms"}));

TEST(BusBudgetTest, LoadsOfTheTable) {
  const auto budget = budget_of(axes_plan(8));
  EXPECT_NEAR(budget.load(), 0.7195, 1e-9);
  EXPECT_NEAR(budget.worst_load(), 0.8675, 1e-9);
  EXPECT_EQ(budget.needed, std::chrono::microseconds{1735});
  EXPECT_EQ(kLongestFrameBits, 135U);
}

// The 6 bytes of control word, mode and setpoint in one RPDO: 78 % and 95 % of the same period.
TEST(BusBudgetTest, AControlWordInEveryPeriodLeavesNoRoom) {
  auto plan = axes_plan(8);
  for (auto& node : plan.nodes) {
    node.rpdos.erase(node.rpdos.begin());
    node.rpdos[0].objects = {{0x6040, 0, 16}, {0x60C1, 1, 32}};
  }
  const auto budget = budget_of(plan);
  EXPECT_EQ(budget.worst_bits, 55U + 8U * (115 + 115));
  EXPECT_FALSE(budget.fits);
}

// 8 RPDOs of 3 bytes each 100 ms, a heartbeat of 1 byte of the master and of each node, and guarding of one.
TEST(BusBudgetTest, CountsWhatComesNowAndThen) {
  auto plan = axes_plan(8);
  plan.master_heartbeat = milliseconds{50};
  for (auto& node : plan.nodes) node.error_control.heartbeat = milliseconds{200};
  plan.nodes[2].error_control = {};
  plan.nodes[2].error_control.guard_time = milliseconds{25};
  const double per_second = 8 * 85 * 10 + 65 * 20 + 7 * 65 * 5 + (55 + 65) * 40;
  EXPECT_NEAR(budget_of(plan).other_load, per_second / 1e6, 1e-12);
}

TEST(BusBudgetTest, AnEmptyLineFits) {
  const auto budget = budget_of(axes_plan(0));
  EXPECT_TRUE(budget.fits);
  EXPECT_EQ(budget.nodes, 0U);
  EXPECT_EQ(budget.acyclic_frames, (2000U - 55U) / 135U);
}

}  // namespace
}  // namespace driveline::canopen
