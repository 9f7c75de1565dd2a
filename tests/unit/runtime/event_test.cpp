// Events of a line: their facts, and the sentences derived from them.
#include "driveline/runtime/event.hpp"

#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "driveline/runtime/record/run_report.hpp"

namespace driveline::runtime {
namespace {

using motion::MasterAbsence;
using std::chrono::milliseconds;
using Cause = motion::MotionFailure::Cause;

motion::AxisConfig slide(std::string_view unit) {
  motion::AxisConfig axis;
  axis.name = "z";
  axis.kind = trajectory::AxisKind::kLinear;
  axis.increments_per_unit = 2e5;
  axis.unit = trajectory::find_position_unit(unit);
  return axis;
}

events::AxesStopped stopped(const motion::AxisConfig& axis, Cause cause) {
  events::AxesStopped stopped;
  stopped.axis = events::event_axis(axis);
  stopped.failure.cause = cause;
  stopped.failure.status_word = 0x0218;
  stopped.failure.error_code = 0x8611;
  stopped.failure.position.from = 0.125;
  stopped.failure.position.moved = 0.0125;
  stopped.failure.position.allowed = 0.001;
  stopped.failure.position.within_s = 0.002;
  stopped.limit.cycles = 8;
  return stopped;
}

std::string sentence(EventFacts facts, bool increments = false) {
  return describe(Event{std::move(facts)}, increments);
}

TEST(Event, ALeapIsInTheUnitOfTheAxis) {
  EXPECT_EQ(sentence(stopped(slide("mm"), Cause::kPositionLeap)),
            "axis z: its actual position jumped by 12.5 mm within 2 ms, at most 1 mm are plausible: not "
            "plausible; all axes stopped within their limits");
  EXPECT_EQ(
      sentence(stopped(slide("mm"), Cause::kPositionUnsteady), true),
      "axis z: was not enabled, its actual position is not steady: it jumped by 12.5 mm (2500 increments) within 2 "
      "ms, at most 1 mm are plausible");
  EXPECT_EQ(
      sentence(stopped(slide("none"), Cause::kPositionUnsteady)),
      "axis z: was not enabled, its actual position is not steady: it jumped by 0.0125 m within 2 ms, at most 0.001 "
      "m are plausible");
}

TEST(Event, AFollowingErrorIsInTheUnitOfTheAxis) {
  auto facts = stopped(slide("mm"), Cause::kFollowingError);
  facts.failure.following_error = -0.0035;
  EXPECT_EQ(sentence(facts),
            "axis z: its following error was -3.5 mm, outside following_error_window for too long: axis "
            "blocked, overloaded, or commanded too fast; all axes stopped within their limits");
}

TEST(Event, AStandstillIsInTheUnitOfTheAxis) {
  EXPECT_EQ(
      sentence(stopped(slide("um"), Cause::kPositionFrozen)),
      "axis z: its actual position stayed at 125000 um for 2 ms while its setpoint moved by 12500 um: frozen, or the "
      "axis is blocked; all axes stopped within their limits");
}

TEST(Event, WhatTheMasterHasCausedSaysSo) {
  auto facts = stopped(slide("mm"), Cause::kAxisFault);
  EXPECT_THAT(sentence(facts), testing::EndsWith("status word 0x0218; all axes stopped"));
  facts.after = MasterAbsence{milliseconds{850}, milliseconds{54}};
  EXPECT_THAT(sentence(facts), testing::EndsWith("all axes stopped; the master had been away for 54.0 ms at 0.850 s"));
  ecat_master::LineEvent left;
  left.slave = 3;
  EXPECT_THAT(sentence(events::LineChanged{left, "z", facts.after}),
              testing::AllOf(testing::StartsWith("slave 3 (z): "), testing::EndsWith(" at 0.850 s")));
  EXPECT_EQ(sentence(stopped(slide("mm"), Cause::kMasterAway)),
            "the master was away for longer than the 8 cycles that [bus] max_lost_cycles allows; all axes stopped");
}

TEST(Event, WhatADriveBehindSoeSaysIsInWords) {
  ecat_master::SoeRecord record{
      .slave = 4, .drive = 1, .message = ecat_master::SoeNotification{{99}, wire::SoeCommandState::kFailed}};
  EXPECT_EQ(sentence(events::SoeMessage{record, "y"}),
            "slave 4 (y): drive 1: data state of S-0-0099 is 0x000F (failed)");
  record.message = wire::Emergency{0x8130, 0x10, {}};
  EXPECT_EQ(sentence(events::SoeMessage{record, "y"}),
            "slave 4 (y): drive 1: emergency 0x8130, error register 0x10, 00 00 00 00 00");
}

TEST(Event, IsAskedForItsKindAndFacts) {
  const Event event{events::SlaveNotBack{2, "z", std::chrono::seconds{60}}, Severity::kFailure, milliseconds{1250}};
  EXPECT_TRUE(event.is<events::SlaveNotBack>());
  EXPECT_FALSE(event.is<events::SlaveNotConnected>());
  ASSERT_NE(event.as<events::SlaveNotBack>(), nullptr);
  EXPECT_EQ(event.as<events::SlaveNotBack>()->slave, 2U);
  EXPECT_EQ(event.as<events::StateReached>(), nullptr);
  EXPECT_TRUE(event.is_fault());
  EXPECT_EQ(describe(event), "slave 2 (z): not back within 60 s");
  EXPECT_EQ(describe_with_time(event), "1.250 s slave 2 (z): not back within 60 s");
  EXPECT_FALSE(Event{event.facts}.is_fault()) << "a step, unless it is said to be more";
  EXPECT_EQ(describe_with_time(Event{event.facts}), describe(event)) << "there is no time before the operation";
}

TEST(Event, ProgressHasItsTime) {
  const Event event{events::Progress{motion::MotionPhase::kFollowing}, Severity::kProgress, milliseconds{12340}};
  EXPECT_EQ(describe(event), "  12.3 s  following the path");
  EXPECT_EQ(sentence(events::Progress{}), "   0.0 s  exchanging");
}

TEST(Event, ClocksAreNamedUnlessTheyAreTheFault) {
  const events::ClocksChanged facts{{.kind = ecat_master::dc::ClockEvent::Kind::kReferenceTaken, .slave = 1}};
  const auto fault = describe(Event{facts, Severity::kFault});
  EXPECT_EQ(describe(Event{facts, Severity::kNotice}), "clocks: " + fault);
}

TEST(Event, ALinkThatIsGoneIsTheReasonWhyNoFrameCameBack) {
  const auto sentence = [](events::CommunicationLost facts) {
    return describe(Event{std::move(facts), Severity::kFailure});
  };
  EXPECT_EQ(sentence({16, 0, {}}), "communication lost: no frame came back for 16 cycles");
  EXPECT_EQ(sentence({16, 0, "eth1: no link"}), "communication lost: no frame came back for 16 cycles; eth1: no link");
}

TEST(Event, ALinkThatIsGoneIsTheReasonWhyTheAxesOfAPathWereStopped) {
  auto facts = stopped(slide("mm"), Cause::kCommunication);
  EXPECT_EQ(sentence(facts), "communication lost: the axes exchange no valid process data; quick stop commanded");
  facts.link = "eth1: no link";
  EXPECT_EQ(sentence(facts),
            "communication lost: the axes exchange no valid process data; quick stop commanded; eth1: no link");
}

TEST(Event, TheFailureOfARunIsItsFirstAndFaultsThatDoNotEndItAreNone) {
  RunReport report;
  report.events.push_back({events::CommunicationLost{100, 0, {}}, Severity::kFault, milliseconds{100}});
  EXPECT_EQ(report.failure(), nullptr);
  report.events.push_back(
      {events::CommunicationNotBack{std::chrono::seconds{1}}, Severity::kFailure, milliseconds{1100}});
  const auto& added = report.note_failure(fail(ErrorKind::kMachine, "cannot be written", "out/run.pcapng").value());
  EXPECT_EQ(describe(added), "out/run.pcapng: cannot be written");
  ASSERT_NE(report.failure(), nullptr);
  EXPECT_EQ(describe(*report.failure()), "no frame came back within 1 s");
}

}  // namespace
}  // namespace driveline::runtime
