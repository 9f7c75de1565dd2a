#include "driveline/ecat_master/diagnosis/diagnosis.hpp"

#include <gmock/gmock.h>

#include "drive_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineSupervisor;
using slaves::FaultKind;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Diagnosis : public testing::Test {
 protected:
  void start(std::size_t count) {
    drives = std::make_unique<DriveLine>(count);
    operation = std::make_unique<LineOperation>(*drives);
    ASSERT_EQ(sentence(operation->to_op()), "");
    supervisor = std::make_unique<LineSupervisor>(operation->master());
  }
  ecat_master::LineDiagnosis diagnosis() {
    auto found = ecat_master::diagnose(operation->master(), supervisor.get(), nullptr);
    EXPECT_EQ(sentence(found), "");
    return found.value_or(ecat_master::LineDiagnosis{});
  }
  std::vector<std::string> places() {
    std::vector<std::string> texts;
    for (const auto& place : diagnosis().places) texts.push_back(describe(place));
    return texts;
  }

  std::unique_ptr<DriveLine> drives;
  std::unique_ptr<LineOperation> operation;
  std::unique_ptr<LineSupervisor> supervisor;
};

TEST_F(Diagnosis, KnowsNothingWrongOfAHealthyLine) {
  start(4);
  operation->run(milliseconds{10});
  const auto found = diagnosis();
  EXPECT_THAT(found.places, IsEmpty());
  ASSERT_EQ(found.slaves.size(), 4U);
  for (const auto& slave : found.slaves) {
    EXPECT_TRUE(slave.answers);
    EXPECT_EQ(slave.al.status.state, wire::AlState::kOp);
  }
  EXPECT_TRUE(found.slaves[0].ports[1].status.communication);
  ASSERT_EQ(found.groups.size(), 1U);
  EXPECT_EQ(found.groups[0].working_counter, 12U);
  EXPECT_EQ(found.groups[0].expected_working_counter, 12U);
  EXPECT_EQ(found.groups[0].lost_frames, 0U);
  const auto text = to_text(found);
  EXPECT_THAT(text, HasSubstr("no problem is known\n"));
  EXPECT_THAT(text, HasSubstr("  3 (drive 3): OP\n"));
  EXPECT_THAT(text, HasSubstr("group 0: working counter 12 of 12"));
}

TEST_F(Diagnosis, NamesTheCableThatDamagesFrames) {
  start(4);
  ASSERT_TRUE(drives->line().inject({.kind = FaultKind::kDamage, .slave = 2, .port = 0, .count = 6}));
  operation->run(milliseconds{2});
  EXPECT_THAT(places(), ElementsAre("slave 2, port 0: 6 damaged frames received: the cable between slave 1 and slave "
                                    "2, or the sender at its other end"));
  EXPECT_EQ(diagnosis().groups[0].lost_frames, 6U);
  ASSERT_EQ(sentence(ecat_master::clear_error_counters(operation->master().bus())), "");
  EXPECT_THAT(places(), IsEmpty());
}

TEST_F(Diagnosis, NamesTheCableThatDamagesFramesOnTheirWayBack) {
  start(4);
  ASSERT_TRUE(drives->line().inject({.kind = FaultKind::kDamage, .slave = 0, .port = 1, .count = 3}));
  operation->run(milliseconds{2});
  EXPECT_THAT(places(), ElementsAre("slave 0, port 1: 3 damaged frames received: the cable between slave 1 and slave "
                                    "0, or the sender at its other end"));
}

TEST_F(Diagnosis, NamesTheCableFromTheMaster) {
  start(2);
  ASSERT_TRUE(drives->line().inject({.kind = FaultKind::kDamage, .slave = 0, .port = 0, .count = 2}));
  operation->run(milliseconds{2});
  EXPECT_THAT(places(),
              ElementsAre("slave 0, port 0: 2 damaged frames received: the cable between the master and slave "
                          "0, or the sender at its other end"));
}

TEST_F(Diagnosis, NamesTheBreakAndNotEverybodyBehindIt) {
  start(5);
  ASSERT_TRUE(drives->line().break_cable({1, 1}));
  operation->run(milliseconds{5});
  EXPECT_THAT(places(),
              testing::Contains(
                  "slave 1, port 1: no link: the cable between slave 2 and slave 1, or the supply at its other end"));
  for (const auto& place : places()) EXPECT_THAT(place, HasSubstr("slave 1, port 1"));
  const auto found = diagnosis();
  EXPECT_TRUE(found.slaves[1].answers);
  for (const std::size_t cut_off : {2U, 3U, 4U}) EXPECT_FALSE(found.slaves[cut_off].answers);
  EXPECT_THAT(to_text(found), HasSubstr("  4 (drive 4): does not answer\n"));
}

TEST_F(Diagnosis, CountsLinksThatWereLostOncePerCable) {
  start(3);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(drives->line().break_cable({0, 1}));
    operation->run(milliseconds{2});
    ASSERT_TRUE(drives->line().break_cable({0, 1}, false));
    operation->run(milliseconds{2});
  }
  EXPECT_THAT(places(),
              ElementsAre("slave 0, port 1: the link was lost 2 times: the cable between slave 1 and slave 0, "
                          "or the supply of one of them"));
}

TEST_F(Diagnosis, TellsWhatHappenedAndWhen) {
  start(2);
  drives->line().drop_frames(2);
  operation->run(milliseconds{1});
  drives->line().set_power(1, false);
  operation->run(milliseconds{1});
  supervisor->poll();
  const auto found = diagnosis();
  EXPECT_THAT(places(), testing::Contains(HasSubstr("slave 0, port 1: no link")));
  EXPECT_THAT(to_text(found), HasSubstr("s slave 1: no longer answers\n"));
  EXPECT_THAT(to_text(found), HasSubstr("s group 0: 1 frame(s) did not come back in their cycle\n"));
  EXPECT_THAT(to_text(found), HasSubstr("s group 0: working counter 3 of 6\n"));
  ASSERT_FALSE(found.events.empty());
  EXPECT_NEAR(static_cast<double>(found.events[0].time.count()), static_cast<double>(found.time.count()), 2e6);
}

}  // namespace
}  // namespace driveline::bus_test
