// What the judgement of a period must not overlook on a line on which nothing has happened for a while.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "cycle_rig.hpp"

namespace driveline::canopen {
namespace {

using cycle_test::CycleRig;
using ::testing::ElementsAre;
using namespace std::chrono_literals;

struct EventRow {
  const char* what;
  std::function<void(CycleRig&)> before;  ///< the SYNC of the period
  std::string answer;                     ///< the answer of axis 3; empty: it does not answer
  bool valid;                             ///< axis 3 in the period
  bool other_valid;                       ///< axis 4
  std::uint64_t lost, unsent;             ///< counters of axis 3
  bool operational, heard;                ///< axis 3
  std::uint32_t bad_cycles;
};

class CanCycleEvents : public testing::TestWithParam<EventRow> {};

// A line on which nothing has happened for some periods, then the period of the row, then quiet ones again.
TEST_P(CanCycleEvents, AreFoundOnAQuietLine) {
  const auto& row = GetParam();
  CycleRig rig;
  const auto quiet = [&] {
    for (int i = 0; i < 3; ++i) {
      static_cast<void>(rig.step());
      rig.both_answer();
    }
  };
  quiet();
  row.before(rig);
  static_cast<void>(rig.step());
  ASSERT_THAT(rig.motion.valid, ElementsAre(true, true));
  rig.port.refusals.clear();
  if (!row.answer.empty()) rig.comes(300us, row.answer);
  rig.comes(420us, "184#270000020000");
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(row.valid, row.other_valid));
  const auto report = rig.cycle.node_report(0);
  EXPECT_EQ(report.valid, row.valid);
  EXPECT_EQ(report.lost, row.lost);
  EXPECT_EQ(report.unsent, row.unsent);
  EXPECT_EQ(report.operational, row.operational);
  EXPECT_EQ(report.heard, row.heard);
  EXPECT_EQ(report.stale_cycles, row.valid ? 0U : 1U);
  EXPECT_EQ(rig.cycle.bad_cycles(), row.bad_cycles);
  rig.both_answer();
  quiet();
  const bool out_of_use = !row.operational;
  EXPECT_THAT(rig.motion.valid, ElementsAre(!out_of_use, true));
  EXPECT_EQ(rig.cycle.node_report(0).lost, row.lost);
  EXPECT_EQ(rig.cycle.node_report(0).stale_cycles, out_of_use ? 4U : 0U);
  EXPECT_EQ(rig.cycle.bad_cycles(), 0U);
}

const std::string kAnswer = "183#270000010000";

INSTANTIATE_TEST_SUITE_P(
    Events, CanCycleEvents,
    testing::Values(EventRow{"None", [](CycleRig&) {}, kAnswer, true, true, 0, 0, true, false, 0},
                    EventRow{"AnAnswerIsMissing", [](CycleRig&) {}, "", false, true, 1, 0, true, false, 1},
                    EventRow{"AnAnswerIsTooShort", [](CycleRig&) {}, "183#2700", false, true, 1, 0, true, false, 1},
                    EventRow{"SyncIsNotSent",
                             [](CycleRig& rig) {
                               rig.port.refusals = {{0x080, SendStatus::kBusy}};
                             },
                             kAnswer, false, false, 0, 0, true, false, 1},
                    EventRow{"ASetpointIsNotSent",
                             [](CycleRig& rig) {
                               rig.port.refusals = {{0x303, SendStatus::kBusy}};
                             },
                             kAnswer, false, true, 0, 1, true, false, 1},
                    EventRow{"ANodeGoesOutOfUse", [](CycleRig& rig) { rig.cycle.set_operational(0, false); }, kAnswer,
                             false, true, 0, 0, false, false, 0},
                    EventRow{"TheLastOfItsPdosComes", [](CycleRig& rig) { rig.comes(1ms, "283#070130"); }, kAnswer,
                             true, true, 0, 0, true, true, 0}),
    [](const auto& row) { return row.param.what; });

}  // namespace
}  // namespace driveline::canopen
