#include "driveline/slaves/mc7000/sequence_control.hpp"

#include <array>
#include <ostream>

#include "sequence_fixture.hpp"

namespace driveline::slaves::mc7000 {
namespace {

using test::kAutomatic;
using test::kManual;
using test::kStart;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint16_t kFeedBit = 1U << 6U;
constexpr std::uint16_t kJogPositive = 1U << 12U;
constexpr std::uint16_t kJogNegative = 1U << 13U;

class Sequence : public test::SequenceTest {};

TEST_F(Sequence, StartsAProgramByAnEdgeAfter10MillisecondsOfAutomatic) {
  download({"%P00", "N010 SET M98=1", "END"});
  run_ms(2, kManual);
  control.step(kAutomatic, true);
  EXPECT_EQ(control.state(), SequenceState::kReady);
  for (int i = 0; i < 19; ++i) control.step(kAutomatic, true);
  drive.take();
  control.step(kStart, true);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1")) << "20 periods of 0.5 ms after automatic";
}

TEST_F(Sequence, DoesNotStartAProgramTooEarlyOrByALevel) {
  download({"%P00", "N010 SET M98=1", "END"});
  run_ms(2, kManual);
  control.step(kAutomatic, true);
  for (int i = 0; i < 18; ++i) control.step(kAutomatic, true);
  drive.take();
  run_ms(30, kStart);
  EXPECT_THAT(drive.take(), IsEmpty());
  EXPECT_EQ(control.state(), SequenceState::kReady);
  control.step(kAutomatic, true);
  control.step(kStart, true);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1"));
}

TEST_F(Sequence, StartsTheSelectedProgramAndAgainAfterItsEnd) {
  download({"%P00", "N010 SET M98=1", "END", "%P42", "N010 SET M99=1", "END"});
  control.select(42);
  start_program();
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO2"));
  EXPECT_EQ(control.state(), SequenceState::kEnded);
  EXPECT_EQ(control.status_bits() & 0x4000U, 0x4000U);
  run_ms(1, kAutomatic);
  EXPECT_THAT(drive.take(), IsEmpty());
  run_ms(1, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO2"));
}

TEST_F(Sequence, ASecondStartDoesNotDisturbAProgramThatRuns) {
  download({"%P00", "N010 WAIT 20", "N020 SET M98=1", "END"});
  start_program();
  run_ms(9, kAutomatic);
  run_ms(9, kStart);
  EXPECT_THAT(drive.take(), IsEmpty());
  run_ms(3, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1"));
}

TEST_F(Sequence, ManualModeEndsTheProgramAndStopsTheAxis) {
  drive.is_referenced = true;
  download({"%P00", "N010 GO W A2000 V5", "END"});
  start_program();
  EXPECT_EQ(control.state(), SequenceState::kRunning);
  EXPECT_EQ(control.record(), 10);
  control.step(kManual, true);
  EXPECT_THAT(drive.take(), ElementsAre("move 2000 5", "stop"));
  EXPECT_EQ(control.state(), SequenceState::kManual);
  run_ms(4, kManual);
  EXPECT_THAT(drive.take(), IsEmpty());
}

struct StartCase {
  const char* name;
  std::uint16_t start;
  bool enabled;
  std::uint8_t program;
  PosModLocation location;
};
void PrintTo(const StartCase& one, std::ostream* out) {
  *out << one.name;
}

class RefusedStarts : public Sequence, public testing::WithParamInterface<StartCase> {};

TEST_P(RefusedStarts, AreErrorsUntilAcknowledged) {
  download({"%P05", "N010 SET M98=1", "END"});
  control.select(GetParam().program);
  run_ms(4, kManual);
  enabled = GetParam().enabled;
  run_ms(12, kAutomatic & GetParam().start);
  drive.take();
  run_ms(3, GetParam().start);
  EXPECT_EQ(control.state(), SequenceState::kFault);
  EXPECT_EQ(control.fault(), GetParam().location) << text_of(control.fault());
  EXPECT_THAT(drive.take(), ElementsAre("stop"));
  enabled = true;
  control.select(5);
  run_ms(3, kAutomatic);
  run_ms(3, kStart);
  EXPECT_EQ(control.state(), SequenceState::kFault) << "not acknowledged";
  control.acknowledge();
  EXPECT_EQ(control.fault(), PosModLocation::kNone);
  EXPECT_EQ(control.state(), SequenceState::kReady);
  run_ms(3, kAutomatic);
  run_ms(3, kStart);
  EXPECT_EQ(control.state(), SequenceState::kEnded);
}

INSTANTIATE_TEST_SUITE_P(Reasons, RefusedStarts,
                         testing::Values(StartCase{"no program", kStart, true, 6, PosModLocation::kNoProgram},
                                         StartCase{"no such number", kStart, true, 200, PosModLocation::kNoProgram},
                                         StartCase{"no feed", static_cast<std::uint16_t>(kStart & ~kFeedBit), true, 5,
                                                   PosModLocation::kNoFeed},
                                         StartCase{"not enabled", kStart, false, 5, PosModLocation::kNotEnabled}));

TEST_F(Sequence, LossOfTheEnableEndsTheProgram) {
  download({"%P00", "N010 WAIT 50", "END"});
  start_program();
  enabled = false;
  run_ms(1, kStart);
  EXPECT_EQ(control.fault(), PosModLocation::kNotEnabled);
  EXPECT_THAT(drive.take(), ElementsAre("stop"));
}

TEST_F(Sequence, AFailureOfTheMotionEndsTheProgramInAnyRecord) {
  drive.is_referenced = true;
  download({"%P00", "N010 GO A2000 V5", "N020 WAIT 500", "END"});
  start_program();
  drive.state = {.failure = PosModLocation::kPositiveLimitSwitch};
  run_ms(4, kStart);
  EXPECT_EQ(control.fault(), PosModLocation::kPositiveLimitSwitch);
  EXPECT_EQ(control.record(), 20);
  EXPECT_THAT(drive.take(), ElementsAre("move 2000 5", "stop"));
}

TEST_F(Sequence, AnErrorOfTheProgramStopsTheAxis) {
  drive.is_referenced = true;
  download({"%P00", "N010 GO A2000 V5", "N020 JMP N030", "END"});
  start_program();
  EXPECT_EQ(control.fault(), PosModLocation::kNoRecord);
  EXPECT_THAT(drive.take(), ElementsAre("move 2000 5", "stop"));
}

TEST_F(Sequence, HoldsTheFeedWithBit6AndLetsTheProgramWait) {
  drive.is_referenced = true;
  download({"%P00", "N010 GO W A60 V50", "N020 SET M98=1", "END"});
  start_program();
  EXPECT_THAT(drive.take(), ElementsAre("move 60 50"));
  run_ms(40, kStart & ~kFeedBit);
  EXPECT_THAT(drive.take(), ElementsAre("hold"));
  run_ms(20, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("feed", "at 60", "TxPDO1"));
}

struct JogCase {
  const char* name;
  std::uint16_t word;
  bool enabled;
  std::vector<std::string> orders;
};
void PrintTo(const JogCase& one, std::ostream* out) {
  *out << one.name;
}

class Jogs : public Sequence, public testing::WithParamInterface<JogCase> {};

TEST_P(Jogs, MoveInManualModeOnly) {
  run_ms(4, kManual);
  run_ms(12, GetParam().word & 0x08FFU);
  drive.take();
  enabled = GetParam().enabled;
  run_ms(5, GetParam().word);
  run_ms(5, GetParam().word & 0x08FFU);
  EXPECT_EQ(drive.take(), GetParam().orders);
}

INSTANTIATE_TEST_SUITE_P(Bits, Jogs,
                         testing::Values(JogCase{"positive", kManual | kJogPositive, true, {"jog 1", "jog 0"}},
                                         JogCase{"negative", kManual | kJogNegative, true, {"jog -1", "jog 0"}},
                                         JogCase{"both", kManual | kJogPositive | kJogNegative, true, {}},
                                         JogCase{"automatic", kAutomatic | kJogPositive, true, {}},
                                         JogCase{"not enabled", kManual | kJogPositive, false, {}}));

TEST_F(Sequence, AutomaticEndsAJog) {
  run_ms(4, kManual | kJogNegative);
  drive.take();
  run_ms(4, kAutomatic | kJogNegative);
  EXPECT_THAT(drive.take(), ElementsAre("jog 0"));
}

TEST_F(Sequence, Bits14And15AreTheOutputsInEveryMode) {
  control.step(kManual, true);
  EXPECT_THAT(drive.take(), ElementsAre("feed", "OS00=0", "OS01=0"));
  run_ms(3, kManual | 0x4000U);
  EXPECT_THAT(drive.take(), ElementsAre("OS00=1"));
  run_ms(3, kAutomatic | 0x8000U);
  EXPECT_THAT(drive.take(), ElementsAre("OS00=0", "OS01=1"));
}

TEST_F(Sequence, TakesLinesInManualModeOnlyAndDropsACutDownload) {
  download({"%P00", "N010 SET M98=1"});
  run_ms(12, kAutomatic);
  for (const auto line : {"N020 WAIT 3", "END", "%SAV", "%CLP00"}) {
    const auto taken = control.command(line);
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error(), LineError::kNotManual);
  }
  run_ms(1, kStart);
  EXPECT_EQ(control.fault(), PosModLocation::kNoProgram);
  run_ms(1, kManual);
  EXPECT_EQ(control.command("END").error(), LineError::kNoOpenProgram);
  download({"%P00", "N010 SET M98=1", "END"});
  control.acknowledge();
  start_program();
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1"));
}

TEST_F(Sequence, SavesDuringItsSteps) {
  download({"%P03 (kept)", "END", "%SAV"});
  run_ms(99, kManual);
  EXPECT_TRUE(control.programs().saving());
  run_ms(1, kManual);
  EXPECT_FALSE(control.programs().saving());
  download({"%P04 (lost)", "END"});
  control.values().set_variable(5, 6);
  control.restart();
  EXPECT_EQ(control.programs().name(3), "kept");
  EXPECT_EQ(control.programs().program(4), nullptr);
  EXPECT_EQ(control.values().variable(5), 0);
}

TEST_F(Sequence, StatusBits12And13AreThoseOfTheAxis) {
  EXPECT_EQ(control.status_bits(), 0x0000);
  drive.state.in_position = true;
  EXPECT_EQ(control.status_bits(), 0x1000);
  drive.is_referenced = true;
  EXPECT_EQ(control.status_bits(), 0x3000);
}

TEST_F(Sequence, AnRxPdo21BeyondTheLastFieldIsAnError) {
  std::array<std::byte, ProcessValues::kRxPdo21Size> pdo{};
  pdo[0] = std::byte{0xF0};
  pdo[1] = std::byte{0x64};
  control.receive_rx_pdo21(pdo);
  EXPECT_EQ(control.state(), SequenceState::kFault);
  EXPECT_EQ(control.fault(), PosModLocation::kIndexOverflow);
}

}  // namespace
}  // namespace driveline::slaves::mc7000
