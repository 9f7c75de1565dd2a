#include "driveline/slaves/mc7000/program_line.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <ostream>
#include <string>

namespace driveline::slaves::mc7000 {
namespace {

constexpr Operand variable(std::int32_t number) {
  return {.variable = true, .value = number};
}
constexpr Operand number(std::int32_t value) {
  return {.variable = false, .value = value};
}
constexpr Condition kFlag90Clear{.source = ConditionSource::kFlag, .number = 90, .state = false};

struct RecordCase {
  const char* text;
  Record record;
};
void PrintTo(const RecordCase& one, std::ostream* out) {
  *out << one.text;
}

class ProgramLineRecords : public testing::TestWithParam<RecordCase> {};

TEST_P(ProgramLineRecords, AreWhatTheirTextSays) {
  const auto line = parse_line(GetParam().text);
  ASSERT_TRUE(line) << text_of(line.error());
  const auto* record = std::get_if<Record>(&*line);
  ASSERT_NE(record, nullptr);
  EXPECT_TRUE(*record == GetParam().record);
}

INSTANTIATE_TEST_SUITE_P(
    Texts, ProgramLineRecords,
    testing::Values(
        RecordCase{"N010 SET H10=5000",
                   {.number = 10, .command = Command::kSetVariable, .field = 10, .value = number(5000)}},
        RecordCase{"N060 SET H01 = 2 ; comment",
                   {.number = 60, .command = Command::kSetVariable, .field = 1, .value = number(2)}},
        RecordCase{"N7 SET H99=-2147483648",
                   {.number = 7,
                    .command = Command::kSetVariable,
                    .field = 99,
                    .value = number(std::numeric_limits<std::int32_t>::min())}},
        RecordCase{"N070 SET M99 = 1", {.number = 70, .command = Command::kSetFlag, .field = 99, .value = number(1)}},
        RecordCase{"N100 GO 0;", {.number = 100, .command = Command::kReference}},
        RecordCase{"N120 GO W A H98 H10",
                   {.number = 120, .command = Command::kMoveAndWait, .value = variable(98), .speed = variable(10)}},
        RecordCase{"N050 GO W A100000 V1000",
                   {.number = 50, .command = Command::kMoveAndWait, .value = number(100000), .speed = number(1000)}},
        RecordCase{"  N999\tGO A -300 V2147483647",
                   {.number = 999, .command = Command::kMove, .value = number(-300), .speed = number(2147483647)}},
        RecordCase{"N045 WAIT 2000", {.number = 45, .command = Command::kWaitTime, .value = number(2000)}},
        RecordCase{"N130 WAIT H20\r\n", {.number = 130, .command = Command::kWaitTime, .value = variable(20)}},
        RecordCase{"N110 WAIT (IE01=1)",
                   {.number = 110,
                    .command = Command::kWaitCondition,
                    .condition = Condition{.source = ConditionSource::kExtensionInput, .number = 1, .state = true}}},
        RecordCase{"N111 WAIT ( IS02 = 0 )",
                   {.number = 111,
                    .command = Command::kWaitCondition,
                    .condition = Condition{.source = ConditionSource::kServoInput, .number = 2, .state = false}}},
        RecordCase{"N110 JMP (M90=0) N115",
                   {.number = 110, .command = Command::kJump, .condition = kFlag90Clear, .target = 115}},
        RecordCase{"N200 JMP N110", {.number = 200, .command = Command::kJump, .target = 110}}));

TEST(ProgramLine, ReadsDirectCommands) {
  const auto open = parse_line("%P42 (Commissioning)");
  ASSERT_TRUE(open && std::holds_alternative<OpenProgram>(*open));
  EXPECT_EQ(std::get<OpenProgram>(*open).number, 42);
  EXPECT_EQ(std::get<OpenProgram>(*open).name, "Commissioning");
  const auto nameless = parse_line("%P07");
  ASSERT_TRUE(nameless && std::holds_alternative<OpenProgram>(*nameless));
  EXPECT_EQ(std::get<OpenProgram>(*nameless).name, "");
  const auto deleted = parse_line("%CLP13");
  ASSERT_TRUE(deleted && std::holds_alternative<DeleteProgram>(*deleted));
  EXPECT_EQ(std::get<DeleteProgram>(*deleted).number, 13);
  const auto save = parse_line("%SAV");
  EXPECT_TRUE(save && std::holds_alternative<SavePrograms>(*save));
  const auto end = parse_line("END");
  EXPECT_TRUE(end && std::holds_alternative<EndProgram>(*end));
}

struct RefusedCase {
  std::string text;
  LineError error;
};
void PrintTo(const RefusedCase& one, std::ostream* out) {
  *out << one.text;
}

class ProgramLineRefusals : public testing::TestWithParam<RefusedCase> {};

TEST_P(ProgramLineRefusals, NameTheirReason) {
  const auto line = parse_line(GetParam().text);
  ASSERT_FALSE(line);
  EXPECT_EQ(text_of(line.error()), text_of(GetParam().error));
  EXPECT_FALSE(text_of(line.error()).empty());
}

INSTANTIATE_TEST_SUITE_P(Commands, ProgramLineRefusals,
                         testing::Values(RefusedCase{"N010 LET H10=5", LineError::kUnknownCommand},
                                         RefusedCase{"N010 GOW A5 V6", LineError::kUnknownCommand},
                                         RefusedCase{"N010 END", LineError::kUnknownCommand},
                                         RefusedCase{"SET H10=5", LineError::kUnknownCommand},
                                         RefusedCase{"%LOAD", LineError::kUnknownCommand},
                                         RefusedCase{"ENDE", LineError::kUnknownCommand}));

INSTANTIATE_TEST_SUITE_P(Ranges, ProgramLineRefusals,
                         testing::Values(RefusedCase{"N1000 GO 0", LineError::kOutOfRange},
                                         RefusedCase{"N010 JMP N1000", LineError::kOutOfRange},
                                         RefusedCase{"N010 JMP N99999999999", LineError::kOutOfRange},
                                         RefusedCase{"N010 SET H100=5", LineError::kOutOfRange},
                                         RefusedCase{"N010 SET M100=1", LineError::kOutOfRange},
                                         RefusedCase{"N010 SET M10=2", LineError::kOutOfRange},
                                         RefusedCase{"N010 SET H10=2147483648", LineError::kOutOfRange},
                                         RefusedCase{"N010 SET H10=-2147483649", LineError::kOutOfRange},
                                         RefusedCase{"N010 SET H10=99999999999999999999", LineError::kOutOfRange},
                                         RefusedCase{"N010 GO W A5 V0", LineError::kOutOfRange},
                                         RefusedCase{"N010 WAIT -5", LineError::kOutOfRange},
                                         RefusedCase{"N010 WAIT (M10=2)", LineError::kOutOfRange},
                                         RefusedCase{"N010 WAIT (IE100=1)", LineError::kOutOfRange},
                                         RefusedCase{"%P100", LineError::kOutOfRange},
                                         RefusedCase{"%CLP100", LineError::kOutOfRange}));

INSTANTIATE_TEST_SUITE_P(
    Forms, ProgramLineRefusals,
    testing::Values(RefusedCase{"", LineError::kSyntax}, RefusedCase{" ; comment", LineError::kSyntax},
                    RefusedCase{"N", LineError::kSyntax}, RefusedCase{"N010", LineError::kSyntax},
                    RefusedCase{"n010 GO 0", LineError::kSyntax}, RefusedCase{"N010 set H10=5", LineError::kSyntax},
                    RefusedCase{"N010 SET", LineError::kSyntax}, RefusedCase{"N010 SET H", LineError::kSyntax},
                    RefusedCase{"N010 SET H10", LineError::kSyntax}, RefusedCase{"N010 SET H10=", LineError::kSyntax},
                    RefusedCase{"N010 SET H10=H11", LineError::kSyntax},
                    RefusedCase{"N010 SET IE01=1", LineError::kSyntax},
                    RefusedCase{"N010 SET H10=5 6", LineError::kSyntax}, RefusedCase{"N010 GO", LineError::kSyntax},
                    RefusedCase{"N010 GO 05", LineError::kSyntax}, RefusedCase{"N010 GO_W_A5 V6", LineError::kSyntax},
                    RefusedCase{"N010 GO W", LineError::kSyntax}, RefusedCase{"N010 GO W A", LineError::kSyntax},
                    RefusedCase{"N010 GO W A5", LineError::kSyntax}, RefusedCase{"N010 GO W A5 6", LineError::kSyntax},
                    RefusedCase{"N010 GO W A- 5 V6", LineError::kSyntax}, RefusedCase{"N010 WAIT", LineError::kSyntax},
                    RefusedCase{"N010 WAIT (", LineError::kSyntax}, RefusedCase{"N010 WAIT (M90", LineError::kSyntax},
                    RefusedCase{"N010 WAIT (M90=1", LineError::kSyntax},
                    RefusedCase{"N010 WAIT (H90=1)", LineError::kSyntax}, RefusedCase{"N010 JMP", LineError::kSyntax},
                    RefusedCase{"N010 JMP (M90=1)", LineError::kSyntax}, RefusedCase{"N010 JMP 20", LineError::kSyntax},
                    RefusedCase{"%P00 (Commissioning", LineError::kSyntax}, RefusedCase{"%P", LineError::kSyntax},
                    RefusedCase{"%SAV 5", LineError::kSyntax}, RefusedCase{"END 5", LineError::kSyntax}));

TEST(ProgramLine, HasAtMost80CharactersBeforeItsComment) {
  const std::string longest = "N010 WAIT " + std::string(kMaxLineLength - 11, ' ') + "5";
  EXPECT_TRUE(parse_line(longest));
  EXPECT_TRUE(parse_line(longest + "; and a comment"));
  EXPECT_EQ(parse_line(longest + " ").error(), LineError::kSyntax);
}

TEST(ProgramLine, WithAnyOneCharacterCutOffItsEndIsReadOrRefusedButNeverAnotherCommand) {
  for (const std::string text : {"N050 GO W A100000 V1000", "N110 JMP (M90=0) N110", "N110 WAIT (IE01=1)"}) {
    const auto whole = std::get<Record>(*parse_line(text));
    for (std::size_t length = 0; length < text.size(); ++length) {
      const auto cut = parse_line(text.substr(0, length));
      if (!cut) continue;
      EXPECT_EQ(std::get<Record>(*cut).command, whole.command) << text.substr(0, length);
      EXPECT_EQ(std::get<Record>(*cut).number, whole.number);
    }
  }
}

}  // namespace
}  // namespace driveline::slaves::mc7000
