// The example programs of the MC7000 manual, with the control words that it prints.

#include <array>
#include <initializer_list>

#include "sequence_fixture.hpp"

namespace driveline::slaves::mc7000 {
namespace {

using test::kManual;
using test::kShutDown;
using test::kStart;
using testing::ElementsAre;
using testing::IsEmpty;

class ManualExamples : public test::SequenceTest {
 protected:
  /// Reference run, with its 30 ms.
  void reference() {
    start_program();
    run_ms(32, kStart);
    EXPECT_THAT(drive.take(), ElementsAre("reference", "at 7"));
  }
  void receive(std::initializer_list<int> bytes) {
    std::array<std::byte, ProcessValues::kRxPdo21Size> pdo{};
    std::size_t i = 0;
    for (const int value : bytes) pdo.at(i++) = static_cast<std::byte>(value);
    control.receive_rx_pdo21(pdo);
  }
};

// Lines 924-943. 655360 is sent with the byte order of 100 (line 941); the manual misprints it in lines 939 and 940.
TEST_F(ManualExamples, FlagM90MovesBetweenH98And0) {
  download({"%P00", "N010 SET H10=5000;", "N020 SET H98=655360;", "N030 SET H12=0;", "N040 SET H20=100;", "N100 GO 0;",
            "N110 JMP (M90=0) N110;", "N120 GO W A H98 H10;", "N130 WAIT H20;", "N140 JMP (M90=1) N140;",
            "N150 GO W A H12 H10;", "N160 WAIT H20;", "N160 WAIT H20;", "N200 JMP N110;", "END"});
  reference();
  receive({0xFF, 0x62, 0x00, 0x00, 0x0A, 0x00, 0x5A, 0x00});
  run_ms(50, kStart);
  EXPECT_THAT(drive.take(), IsEmpty()) << "waits for the flag";
  receive({0xFF, 0x62, 0x00, 0x00, 0x0A, 0x00, 0x5A, 0x01});
  run_ms(2000, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 655360 5000", "at 655360")) << "and waits until the flag is clear";
  receive({0xFF, 0x62, 0x64, 0x00, 0x00, 0x00, 0x5A, 0x00});
  run_ms(2000, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 0 5000", "at 0"));
  receive({0xFF, 0x62, 0x64, 0x00, 0x00, 0x00, 0x5A, 0x01});
  run_ms(2000, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 100 5000", "at 100"));
  run_ms(2, kManual);
  EXPECT_THAT(drive.take(), ElementsAre("stop"));
  enabled = false;
  run_ms(2, kShutDown);
  EXPECT_EQ(control.state(), SequenceState::kManual);
  EXPECT_EQ(control.fault(), PosModLocation::kNone);
}

// A record number that is there twice is one record: 10 ms to the target and one waiting time of 100 ms.
TEST_F(ManualExamples, RecordN160WaitsOnce) {
  download({"%P00", "N150 GO W A2000 V1000", "N160 WAIT 100", "N160 WAIT 100", "N170 SET M98=1", "END"});
  drive.is_referenced = true;
  start_program();
  run_ms(105, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 2000 1000", "at 2000"));
  run_ms(10, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("TxPDO1"));
}

// Lines 1299-1307. Of records N010 to N040 the text has only the comments; they are ours, as the rest suggests.
TEST_F(ManualExamples, ThreePositionsAndTxPdo2AfterEach) {
  download({"%P00", "N010 GO 0", "N020 GO W A0 V1000", "N030 SET H01 = 1", "N040 SET M99 = 1", "N045 WAIT 2000",
            "N050 GO W A100000 V1000", "N060 SET H01 = 2", "N070 SET M99 = 1", "N080 GO W A200000 V1000",
            "N090 SET H01 = 3", "N100 SET M99 = 1", "N110 WAIT 2000", "N120 JMP N020", "END"});
  start_program();
  run_ms(32, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("reference", "at 7", "move 0 1000", "at 0", "TxPDO2"));
  EXPECT_EQ(control.values().variable(1), 1);
  run_ms(1960, kStart);
  EXPECT_THAT(drive.take(), IsEmpty()) << "waits for 2 s";
  run_ms(560, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 100000 1000", "at 100000", "TxPDO2", "move 200000 1000"));
  EXPECT_EQ(control.values().variable(1), 2);
  run_ms(500, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("at 200000", "TxPDO2"));
  EXPECT_EQ(control.values().variable(1), 3);
  run_ms(1940, kStart);
  EXPECT_THAT(drive.take(), IsEmpty()) << "waits for 2 s";
  run_ms(1100, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 0 1000", "at 0", "TxPDO2")) << "begins again at record N020";
  EXPECT_EQ(control.values().variable(1), 1);
}

// Lines 1610-1618: 15 strings.
TEST_F(ManualExamples, InputIE01MovesBetweenH11And0) {
  const std::vector<std::string_view> lines = {"%P00 (Commissioning)",
                                               "N010 SET H10=5000",
                                               "N020 SET H11=655360",
                                               "N030 SET H12=0",
                                               "N040 SET H20=100",
                                               "N100 GO 0",
                                               "N110 WAIT (IE01=1)",
                                               "N120 GO W A H11 H10",
                                               "N130 WAIT H20",
                                               "N140 WAIT (IE01=0)",
                                               "N150 GO W A H12 H10",
                                               "N160 WAIT H20",
                                               "N200 JMP N110",
                                               "END",
                                               "%SAV"};
  ASSERT_EQ(lines.size(), 15U);
  download(lines);
  run_ms(100, kManual);
  control.restart();
  EXPECT_EQ(control.programs().name(0), "Commissioning");
  drive.inputs = {{ConditionSource::kExtensionInput, 1, false}};
  reference();
  run_ms(300, kStart);
  EXPECT_THAT(drive.take(), IsEmpty());
  drive.inputs[0].on = true;
  run_ms(2000, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 655360 5000", "at 655360"));
  drive.inputs[0].on = false;
  run_ms(2000, kStart);
  EXPECT_THAT(drive.take(), ElementsAre("move 0 5000", "at 0"));
}

}  // namespace
}  // namespace driveline::slaves::mc7000
