#include "driveline/slaves/mc7000/program_run.hpp"

#include <gmock/gmock.h>

#include <initializer_list>
#include <ostream>
#include <string>
#include <vector>

#include "driveline/slaves/mc7000/program_line.hpp"
#include "fake_sequence_drive.hpp"

namespace driveline::slaves::mc7000 {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kPeriod = 500us;
constexpr double kPeriodMs = 0.5;

class ProgramRuns : public testing::Test {
 protected:
  void start(const std::vector<std::string>& lines) {
    program = {};
    for (const auto& text : lines) {
      const auto line = parse_line(text);
      ASSERT_TRUE(line && std::holds_alternative<Record>(*line)) << text;
      program.put(std::get<Record>(*line));
    }
    run.start(program);
  }
  /// Steps until the program ends or fails, at most `most` times; returns how many.
  int steps(int most) {
    for (int i = 0; i < most; ++i) {
      state = run.step();
      if (state != RunState::kRunning) return i + 1;
      drive.advance(kPeriodMs);
    }
    return most;
  }

  test::FakeSequenceDrive drive;
  ProcessValues values;
  ProgramRun run{drive, values, kPeriod};
  Program program;
  RunState state = RunState::kRunning;
};

TEST_F(ProgramRuns, ExecutesRecordsWithoutWaitsInOneStep) {
  start({"N010 SET H12=-7", "N020 SET M13=1", "N030 JMP (M13=1) N050", "N040 SET H12=3", "N050 SET H14=9"});
  EXPECT_EQ(steps(5), 1);
  EXPECT_EQ(state, RunState::kEnded);
  EXPECT_EQ(values.variable(12), -7);
  EXPECT_EQ(values.flag(13), 1);
  EXPECT_EQ(values.variable(14), 9);
}

TEST_F(ProgramRuns, AnEmptyProgramEndsAtOnce) {
  start({});
  EXPECT_EQ(steps(5), 1);
  EXPECT_EQ(state, RunState::kEnded);
}

struct WaitCase {
  const char* text;
  int steps;
};
void PrintTo(const WaitCase& one, std::ostream* out) {
  *out << one.text;
}

class Waits : public ProgramRuns, public testing::WithParamInterface<WaitCase> {};

TEST_P(Waits, TakeTheirTime) {
  values.set_variable(20, 30);
  values.set_variable(21, -5);
  start({GetParam().text});
  EXPECT_EQ(steps(10000), GetParam().steps);
  EXPECT_EQ(state, RunState::kEnded);
}

// Steps of 0.5 ms, and the one in which the wait begins.
INSTANTIATE_TEST_SUITE_P(Times, Waits,
                         testing::Values(WaitCase{"N010 WAIT 0", 1}, WaitCase{"N010 WAIT 7", 15},
                                         WaitCase{"N010 WAIT 2000", 4001}, WaitCase{"N010 WAIT H20", 61},
                                         WaitCase{"N010 WAIT H21", 1}));

TEST_F(ProgramRuns, TwoWaitsInSuccessionTakeBothTimes) {
  start({"N010 WAIT 3", "N020 WAIT 5"});
  EXPECT_EQ(steps(100), 17);
}

struct ConditionCase {
  const char* condition;
  bool holds;
};
void PrintTo(const ConditionCase& one, std::ostream* out) {
  *out << one.condition;
}

class Conditions : public ProgramRuns, public testing::WithParamInterface<ConditionCase> {
 protected:
  void SetUp() override {
    values.set_flag(40, 1);
    values.set_flag(41, 0x80);
    drive.inputs = {{ConditionSource::kExtensionInput, 1, true}, {ConditionSource::kServoInput, 1, false}};
  }
};

TEST_P(Conditions, DecideOverWaitAndJump) {
  const std::string condition = GetParam().condition;
  start({"N010 WAIT (" + condition + ")"});
  steps(50);
  EXPECT_EQ(state, GetParam().holds ? RunState::kEnded : RunState::kRunning);
  start({"N010 JMP (" + condition + ") N030", "N020 SET H05=6", "N030 SET H06=7"});
  EXPECT_EQ(steps(50), 1);
  EXPECT_EQ(values.variable(5), GetParam().holds ? 0 : 6);
}

INSTANTIATE_TEST_SUITE_P(Sources, Conditions,
                         testing::Values(ConditionCase{"M40=1", true}, ConditionCase{"M40=0", false},
                                         ConditionCase{"M41=1", true}, ConditionCase{"M42=0", true},
                                         ConditionCase{"M42=1", false}, ConditionCase{"IE01=1", true},
                                         ConditionCase{"IE01=0", false}, ConditionCase{"IS01=0", true},
                                         ConditionCase{"IS01=1", false}));

TEST_F(ProgramRuns, MovesAndWaitsForTheTarget) {
  drive.is_referenced = true;
  values.set_variable(11, 2000);
  values.set_variable(10, 500);
  start({"N010 GO W A H11 H10", "N020 SET M99=1", "N030 GO W A-300 V1000"});
  EXPECT_EQ(steps(100), 65) << "20 ms and 11.5 ms, one step to see each target and one for the TxPDO";
  EXPECT_EQ(state, RunState::kEnded);
  EXPECT_THAT(drive.take(), ElementsAre("move 2000 500", "at 2000", "TxPDO2", "move -300 1000", "at -300"));
}

TEST_F(ProgramRuns, GoesOnBesideAMoveWithoutW) {
  drive.is_referenced = true;
  start({"N010 GO A 2000 V500", "N020 SET M98=1", "N030 WAIT 3"});
  steps(100);
  EXPECT_EQ(state, RunState::kEnded);
  EXPECT_THAT(drive.take(), ElementsAre("move 2000 500", "TxPDO1"));
}

TEST_F(ProgramRuns, SendsOneTxPdoPerStepEachTimeTheFlagIsSet) {
  start({"N010 SET M98=1", "N020 SET M98=1", "N030 SET M99=1", "N040 SET M99=0", "N050 SET M97=1"});
  EXPECT_EQ(run.step(), RunState::kRunning);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1"));
  EXPECT_EQ(run.step(), RunState::kRunning);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1"));
  EXPECT_EQ(run.step(), RunState::kRunning);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO2"));
  EXPECT_EQ(run.step(), RunState::kEnded);
  EXPECT_THAT(drive.take(), IsEmpty());
  EXPECT_EQ(values.flag(99), 0);
}

TEST_F(ProgramRuns, WithoutWaitsGoesOnInTheNextStepAfter1000Records) {
  std::vector<std::string> lines;
  for (int i = 0; i < 999; ++i) lines.push_back("N" + std::to_string(i) + " SET H" + std::to_string(i % 100) + "=8");
  lines.emplace_back("N999 JMP N3");
  start(lines);
  EXPECT_EQ(run.step(), RunState::kRunning);
  EXPECT_EQ(run.record(), 999);
  values.set_variable(2, 5);
  EXPECT_EQ(run.step(), RunState::kRunning);
  EXPECT_EQ(run.record(), 5) << "997 records from N3 to N999, and three more";
}

TEST_F(ProgramRuns, ARecordThatJumpsToItselfIsExecutedOncePerStep) {
  start({"N010 JMP (M90=0) N010", "N020 SET H05=6"});
  EXPECT_EQ(steps(50), 50);
  EXPECT_EQ(state, RunState::kRunning);
  EXPECT_EQ(run.record(), 10);
  values.set_flag(90, 1);
  EXPECT_EQ(steps(50), 1);
  EXPECT_EQ(values.variable(5), 6);
}

struct FailureCase {
  std::vector<std::string> lines;
  PosModLocation location;
  int record;
  bool referenced = true;
  PosModLocation refusal = PosModLocation::kNone;
};
void PrintTo(const FailureCase& one, std::ostream* out) {
  *out << one.lines.back();
}

class Failures : public ProgramRuns, public testing::WithParamInterface<FailureCase> {};

TEST_P(Failures, EndTheProgramWithTheirLocation) {
  drive.is_referenced = GetParam().referenced;
  drive.refusal = GetParam().refusal;
  start(GetParam().lines);
  steps(100);
  EXPECT_EQ(state, RunState::kFailed);
  EXPECT_EQ(run.fault(), GetParam().location) << text_of(run.fault());
  EXPECT_EQ(run.record(), GetParam().record);
}

INSTANTIATE_TEST_SUITE_P(
    Locations, Failures,
    testing::Values(FailureCase{{"N010 WAIT 3", "N020 GO W A5 V6"}, PosModLocation::kNoReference, 20, false},
                    FailureCase{{"N020 GO A5 V6"}, PosModLocation::kNoReference, 20, false},
                    FailureCase{{"N010 JMP N030", "N020 WAIT 3"}, PosModLocation::kNoRecord, 10},
                    FailureCase{{"N010 JMP (M05=0) N011"}, PosModLocation::kNoRecord, 10},
                    FailureCase{{"N010 WAIT (IE07=0)"}, PosModLocation::kNoHardware, 10},
                    FailureCase{{"N010 JMP (IS07=0) N010"}, PosModLocation::kNoHardware, 10},
                    FailureCase{{"N010 GO A2000 V6", "N020 GO A5 V6"}, PosModLocation::kMoving, 20},
                    FailureCase{{"N010 GO A2000 V6", "N020 GO W A5 V6"}, PosModLocation::kMoving, 20},
                    FailureCase{{"N010 GO A2000 V6", "N020 GO 0"}, PosModLocation::kMoving, 20},
                    FailureCase{{"N010 GO W A5 H30"}, PosModLocation::kNotReached, 10},
                    FailureCase{{"N005 SET H30=-4", "N010 GO W A5 H30"}, PosModLocation::kNotReached, 10},
                    FailureCase{{"N010 GO W A5 V6"}, PosModLocation::kTooFast, 10, true, PosModLocation::kTooFast},
                    FailureCase{
                        {"N010 GO A5 V6"}, PosModLocation::kOutsideRange, 10, true, PosModLocation::kOutsideRange}));

TEST_F(ProgramRuns, FailsWhenAMoveEndsBesideItsTarget) {
  drive.is_referenced = true;
  start({"N010 GO W A2000 V500"});
  steps(4);
  drive.state = {.moving = false, .in_position = false};
  steps(4);
  EXPECT_EQ(state, RunState::kFailed);
  EXPECT_EQ(run.fault(), PosModLocation::kNotReached);
}

TEST_F(ProgramRuns, RunsAgainAfterAFailure) {
  start({"N010 JMP N020"});
  steps(5);
  EXPECT_EQ(state, RunState::kFailed);
  start({"N010 WAIT 3"});
  EXPECT_EQ(steps(100), 7);
  EXPECT_EQ(state, RunState::kEnded);
  EXPECT_EQ(run.fault(), PosModLocation::kNone);
}

}  // namespace
}  // namespace driveline::slaves::mc7000
