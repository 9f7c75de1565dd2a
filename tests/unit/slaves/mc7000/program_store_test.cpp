#include "driveline/slaves/mc7000/program_store.hpp"

#include <gmock/gmock.h>

#include <initializer_list>

namespace driveline::slaves::mc7000 {
namespace {

using namespace std::chrono_literals;

void download(ProgramStore& store, std::initializer_list<std::string_view> lines) {
  for (const auto line : lines) {
    const auto taken = store.execute(line);
    ASSERT_TRUE(taken) << line << ": " << text_of(taken.error());
  }
}

void expect_refused(ProgramStore& store, std::string_view line, LineError error) {
  const auto taken = store.execute(line);
  ASSERT_FALSE(taken) << line;
  EXPECT_EQ(text_of(taken.error()), text_of(error));
}

TEST(ProgramStore, HasAProgramFromItsEndOn) {
  ProgramStore store;
  download(store, {"%P03 (Wood)", "N010 GO 0", "N020 WAIT 7"});
  EXPECT_EQ(store.program(3), nullptr);
  EXPECT_TRUE(store.downloading());
  download(store, {"END"});
  EXPECT_FALSE(store.downloading());
  ASSERT_NE(store.program(3), nullptr);
  EXPECT_EQ(store.program(3)->records().size(), 2U);
  EXPECT_EQ(store.name(3), "Wood");
  EXPECT_EQ(store.program(2), nullptr);
  EXPECT_EQ(store.program(200), nullptr);
  EXPECT_EQ(store.name(200), "");
}

TEST(ProgramStore, KeepsRecordsInTheOrderOfTheirNumbersAndTheLastOfANumber) {
  ProgramStore store;
  download(store, {"%P00", "N200 WAIT 3", "N010 WAIT 4", "N100 WAIT 5", "N010 WAIT 6", "END"});
  const auto records = store.program(0)->records();
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records[0].number, 10);
  EXPECT_EQ(records[0].value.value, 6);
  EXPECT_EQ(records[1].number, 100);
  EXPECT_EQ(records[2].number, 200);
  EXPECT_EQ(store.program(0)->find(100), 1U);
  EXPECT_EQ(store.program(0)->find(110), std::nullopt);
  EXPECT_EQ(store.program(0)->find(201), std::nullopt);
}

TEST(ProgramStore, OverwritesAProgramOnlyAfterItWasDeleted) {
  ProgramStore store;
  download(store, {"%P05 (old)", "N010 WAIT 3", "END"});
  expect_refused(store, "%P05 (new)", LineError::kProgramExists);
  EXPECT_EQ(store.name(5), "old");
  download(store, {"%CLP05"});
  EXPECT_EQ(store.program(5), nullptr);
  expect_refused(store, "%CLP05", LineError::kProgramMissing);
  download(store, {"%P05 (new)", "END"});
  EXPECT_EQ(store.name(5), "new");
}

TEST(ProgramStore, RefusesWhatDoesNotFitTheStateOfTheDownload) {
  ProgramStore store;
  expect_refused(store, "N010 GO 0", LineError::kNoOpenProgram);
  expect_refused(store, "END", LineError::kNoOpenProgram);
  download(store, {"%P08", "END", "%P09", "N010 WAIT 3"});
  expect_refused(store, "%SAV", LineError::kOpenProgram);
  expect_refused(store, "%CLP08", LineError::kOpenProgram);
  EXPECT_NE(store.program(8), nullptr);
}

TEST(ProgramStore, GoesOnAfterARefusedLine) {
  ProgramStore store;
  download(store, {"%P09", "N010 WAIT 3"});
  expect_refused(store, "N020 FLY 5", LineError::kUnknownCommand);
  download(store, {"N020 WAIT 4", "END"});
  EXPECT_EQ(store.program(9)->records().size(), 2U);
}

TEST(ProgramStore, DropsADownloadThatWasCut) {
  ProgramStore store;
  download(store, {"%P09", "N010 WAIT 3"});
  store.drop_download();
  expect_refused(store, "END", LineError::kNoOpenProgram);
  EXPECT_EQ(store.program(9), nullptr);
  download(store, {"%P09", "N010 WAIT 3", "%P11", "N500 WAIT 4", "END"});
  EXPECT_EQ(store.program(9), nullptr);
  ASSERT_EQ(store.program(11)->records().size(), 1U);
  EXPECT_EQ(store.program(11)->records()[0].number, 500);
}

TEST(ProgramStore, SavesIn100MillisecondsAndIsBusyMeanwhile) {
  ProgramStore store;
  download(store, {"%P02 (kept)", "N010 WAIT 3", "END", "%SAV"});
  EXPECT_TRUE(store.saving());
  store.advance(60ms);
  expect_refused(store, "%CLP02", LineError::kSaving);
  store.advance(39ms);
  EXPECT_TRUE(store.saving());
  store.advance(1ms);
  EXPECT_FALSE(store.saving());
  download(store, {"%P04 (lost)", "END", "%CLP02"});
  store.restart();
  EXPECT_EQ(store.name(2), "kept");
  EXPECT_EQ(store.program(4), nullptr);
}

TEST(ProgramStore, HasSavedNothingWhenTheSupplyFailsMeanwhile) {
  ProgramStore store;
  download(store, {"%P02", "END", "%SAV"});
  store.advance(99ms);
  store.restart();
  EXPECT_FALSE(store.saving());
  EXPECT_EQ(store.program(2), nullptr);
  download(store, {"%P02", "N010 WAIT 3"});
  store.restart();
  EXPECT_FALSE(store.downloading());
}

TEST(Program, NamesTheFirstJumpWithoutTarget) {
  ProgramStore store;
  download(store, {"%P00", "N010 JMP N030", "N020 JMP (M05=1) N040", "N030 JMP N050", "END"});
  EXPECT_EQ(store.program(0)->first_lost_jump(), 20);
  download(store, {"%P06", "N010 JMP N030", "N030 JMP N010", "END"});
  EXPECT_EQ(store.program(6)->first_lost_jump(), std::nullopt);
}

}  // namespace
}  // namespace driveline::slaves::mc7000
