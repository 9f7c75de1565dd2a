#include "record/recorder.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using snapshot::AxisSample;
using snapshot::AxisState;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<motion::AxisConfig> two_axes() {
  std::vector<motion::AxisConfig> axes(2);
  axes[0].name = "x";
  axes[1].name = "z";
  axes[1].kind = trajectory::AxisKind::kLinear;
  return axes;
}

AxisSample sample(std::uint64_t cycle, std::uint16_t axis, double error = 0.0,
                  AxisState state = AxisState::kOperationEnabled) {
  AxisSample made;
  made.cycle = cycle;
  made.time_ns = 5'000'000'000 + static_cast<std::int64_t>(cycle) * 125'000;
  made.axis = axis;
  made.state = state;
  made.target_position = static_cast<double>(cycle);
  made.actual_position = static_cast<double>(cycle) - error;
  made.following_error = error;
  made.actual_torque = 0.1 * static_cast<double>(cycle);
  return made;
}

class RecorderTest : public test::TemporaryDirectory {
 protected:
  std::filesystem::path csv() const { return directory / "axes.csv"; }
  void feed(Recorder& recorder, const std::vector<AxisSample>& samples) { recorder.axes(samples); }
};

TEST_F(RecorderTest, FollowingErrorIsMaximumAndRmsOfEveryCycleInOperation) {
  Recorder recorder(two_axes(), std::nullopt, 8);
  feed(recorder, {sample(1, 0, 3.0), sample(1, 1, 0.0), sample(2, 0, -4.0), sample(2, 1, 0.5)});
  // An axis without power does not follow anything.
  feed(recorder, {sample(3, 0, 1000.0, AxisState::kSwitchedOn), sample(3, 1, 1000.0, AxisState::kFault)});
  recorder.finish({});
  ASSERT_EQ(recorder.following_errors().size(), 2U);
  EXPECT_DOUBLE_EQ(recorder.following_errors()[0].maximum, 4.0);
  EXPECT_DOUBLE_EQ(recorder.following_errors()[0].rms(), std::sqrt((9.0 + 16.0) / 2));
  EXPECT_DOUBLE_EQ(recorder.following_errors()[1].maximum, 0.5);
  EXPECT_DOUBLE_EQ(recorder.following_errors()[1].rms(), std::sqrt(0.25 / 2));
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(RecorderTest, ColumnsAreInTheUnitsOfTheAxesAndIncrementsBehindThemOnRequest) {
  auto axes = two_axes();
  axes[0].unit = trajectory::find_position_unit("rev");
  axes[1].unit = trajectory::find_position_unit("mm");
  axes[1].increments_per_unit = 2e6;
  for (const bool increments : {false, true}) {
    Recorder recorder(axes, csv(), 1, increments);
    auto x = sample(2, 0, 0.25);
    auto z = sample(2, 1, -0.5);
    x.drive_following_error = std::numeric_limits<double>::quiet_NaN();
    z.drive_following_error = 0.001;
    feed(recorder, {x, z});
    recorder.finish({});
    const std::string head =
        "time[s],x_target[rev],x_actual[rev],x_following_error[rev],z_target[mm],z_actual[mm],z_following_error[mm],"
        "x_torque[Nm],z_torque[N],x_following_error_min[rev],x_following_error_max[rev],z_following_error_min[mm],"
        "z_following_error_max[mm],z_drive_following_error[mm]";
    const std::string row =
        "0.000000,0.3183099,0.2785212,0.03979,2000,2500,-500,0.2,0.2,0.03978874,0.03978874,-500,-500,1";
    const std::string more_head =
        ",x_target[increments],x_actual[increments],x_following_error[increments],z_target[increments],"
        "z_actual[increments],z_following_error[increments]";
    const std::string more_row = ",333772,292051,41721.5,4000000,5000000,-1000000.0";
    EXPECT_EQ(read(csv()), increments ? head + more_head + "\n" + row + more_row + "\n" : head + "\n" + row + "\n");
  }
}

TEST_F(RecorderTest, NothingRecordedIsNoError) {
  Recorder recorder(two_axes(), std::nullopt, 1);
  recorder.finish({});
  EXPECT_EQ(recorder.following_errors()[0].rms(), 0.0);
}

TEST_F(RecorderTest, SampleOfAnUnknownAxisIsIgnored) {
  Recorder recorder(two_axes(), csv(), 1);
  feed(recorder, {sample(0, 2), sample(0, 65535)});
  EXPECT_EQ(recorder.rows(), 0U);
}

TEST_F(RecorderTest, CsvHasOneRowPerRecordedCycleAndUnitsInTheHeader) {
  Recorder recorder(two_axes(), csv(), 2);
  for (std::uint64_t cycle = 3; cycle < 8; ++cycle) feed(recorder, {sample(cycle, 0, 0.25), sample(cycle, 1)});
  recorder.finish({});
  EXPECT_EQ(read(csv()),
            "time[s],x_target[rad],x_actual[rad],x_following_error[rad],"
            "z_target[m],z_actual[m],z_following_error[m],x_torque[Nm],z_torque[N],"
            "x_following_error_min[rad],x_following_error_max[rad],z_following_error_min[m],z_following_error_max[m]\n"
            "0.000000,4,3.75,0.25,4,4,0,0.4,0.4,0.25,0.25,0,0\n"
            "0.000250,6,5.75,0.25,6,6,0,0.6,0.6,0.25,0.25,0,0\n"
            "0.000375,7,6.75,0.25,7,7,0,0.7,0.7,0.25,0.25,0,0\n")
      << "the last one stands for the cycles behind it";
  EXPECT_EQ(recorder.rows(), 3U);
  EXPECT_FALSE(recorder.problem());
}

TEST_F(RecorderTest, NoPeakIsLostBetweenTheRows) {
  Recorder recorder(two_axes(), csv(), 8);
  const std::map<std::uint64_t, double> peaks{{3, 2.0}, {7, -3.0}, {8, 0.5}, {9, 7.0}, {13, -8069.0}, {18, 1.5}};
  for (std::uint64_t cycle = 1; cycle < 20; ++cycle) {
    const double error = peaks.count(cycle) != 0 ? peaks.at(cycle) : 0.125;
    // An axis without power does not follow anything; samples of cycle 16 get lost, and with them its row.
    const auto state = cycle < 17 ? AxisState::kOperationEnabled : AxisState::kSwitchedOn;
    if (cycle != 16) feed(recorder, {sample(cycle, 0, error)});
    feed(recorder, {sample(cycle, 1, error, state)});
  }
  recorder.finish({});
  const auto text = read(csv());
  EXPECT_THAT(text, testing::HasSubstr("\n0.000000,8,7.5,0.5,8,7.5,0.5,0.8,0.8,-3,2,-3,2\n"));
  EXPECT_THAT(text, testing::HasSubstr("\n0.001375,19,18.875,0.125,19,18.875,0.125,1.9,1.9,-8069,7,-8069,7\n"));
  EXPECT_EQ(recorder.rows(), 2U);
  EXPECT_EQ(recorder.following_errors()[1].maximum, 8069.0) << "what the summary says the file has";
}

TEST_F(RecorderTest, RowsOfAxesWithoutPowerHaveNoExtremes) {
  Recorder recorder(two_axes(), csv(), 1);
  feed(recorder, {sample(1, 0, 5.0, AxisState::kSwitchedOn), sample(1, 1, 0.5)});
  recorder.finish({});
  EXPECT_THAT(read(csv()), testing::HasSubstr(",nan,nan,0.5,0.5\n"));
}

TEST_F(RecorderTest, FollowingErrorsOfTheDrivesThatReportThemStandBeside) {
  Recorder recorder(two_axes(), csv(), 1);
  for (std::uint64_t cycle = 0; cycle < 2; ++cycle) {
    auto z = sample(cycle, 1, 0.5);
    z.drive_following_error = 0.25 + static_cast<double>(cycle);
    feed(recorder, {sample(cycle, 0, 2.0), z});
  }
  recorder.finish({});
  EXPECT_EQ(read(csv()),
            "time[s],x_target[rad],x_actual[rad],x_following_error[rad],"
            "z_target[m],z_actual[m],z_following_error[m],x_torque[Nm],z_torque[N],"
            "x_following_error_min[rad],x_following_error_max[rad],z_following_error_min[m],z_following_error_max[m],"
            "z_drive_following_error[m]\n"
            "0.000000,0,-2,2,0,-0.5,0.5,0,0,2,2,0.5,0.5,0.25\n"
            "0.000125,1,-1,2,1,0.5,0.5,0.1,0.1,2,2,0.5,0.5,1.25\n");
  EXPECT_EQ(recorder.following_errors()[0].drive.samples, 0U);
  EXPECT_EQ(recorder.following_errors()[1].drive.maximum, 1.25);
  EXPECT_EQ(recorder.following_errors()[1].maximum, 0.5);
}

TEST_F(RecorderTest, DemandsOfTheDrivesThatReportThemStandBehind) {
  Recorder recorder(two_axes(), csv(), 1, true, true);
  for (std::uint64_t cycle = 0; cycle < 3; ++cycle) {
    auto z = sample(cycle, 1, 0.5);
    if (cycle < 2) z.demand_position = 0.75 + static_cast<double>(cycle);
    feed(recorder, {sample(cycle, 0, 2.0), z});
  }
  recorder.finish({});
  const auto text = read(csv());
  EXPECT_THAT(text,
              testing::HasSubstr("z_following_error_max[m],z_demand[m],x_commanded[rad],z_commanded[m],x_target"));
  EXPECT_THAT(text, testing::HasSubstr(",0.5,0.5,0.75,0,0,"));
  EXPECT_THAT(text, testing::HasSubstr(",0.5,0.5,1.75,1,1,"));
  EXPECT_THAT(text, testing::HasSubstr(",0.5,0.5,nan,2,2,")) << "as many columns in every row";
  EXPECT_FALSE(recorder.following_errors()[0].demand);
  EXPECT_TRUE(recorder.following_errors()[1].demand);
}

TEST_F(RecorderTest, PathErrorIsThatOfThePathAtThisInstant) {
  for (const bool compensated : {false, true}) {
    Recorder recorder(two_axes(), csv(), 1, false, compensated);
    auto x = sample(3, 0, 0.5);
    x.target_position = 9.0;
    x.actual_position = 7.0;
    feed(recorder, {x, sample(3, 1)});
    recorder.finish({});
    // The setpoint 9 is that of this instant; or it leads, and the path is at the setpoint being followed, 7.5.
    EXPECT_EQ(recorder.following_errors()[0].path.maximum, compensated ? 0.5 : 2.0);
    EXPECT_EQ(recorder.following_errors()[0].maximum, 0.5);
    const auto text = read(csv());
    EXPECT_EQ(text.find(",x_commanded[rad],z_commanded[m]\n") != std::string::npos, compensated);
    EXPECT_EQ(text.find(",7.5,") != std::string::npos, compensated);
  }
}

TEST_F(RecorderTest, FileGetsItsNameWhenItIsComplete) {
  Recorder recorder(two_axes(), csv(), 1);
  feed(recorder, {sample(0, 0), sample(0, 1)});
  EXPECT_THAT(files(), ElementsAre("axes.csv.partial"));
  recorder.finish({});
  EXPECT_THAT(files(), ElementsAre("axes.csv"));
}

TEST_F(RecorderTest, DroppedSamplesCostTheirRowAndNoOther) {
  Recorder recorder(two_axes(), csv(), 1);
  feed(recorder, {sample(1, 0), sample(1, 1)});
  feed(recorder, {sample(2, 0)});                // its second sample was dropped
  feed(recorder, {sample(3, 1)});                // its first
  feed(recorder, {sample(5, 1), sample(6, 0)});  // a whole cycle and two halves
  feed(recorder, {sample(7, 1)});                // must not complete cycle 6
  feed(recorder, {sample(8, 0), sample(8, 1)});
  recorder.finish({});
  EXPECT_EQ(recorder.rows(), 2U);
  EXPECT_FALSE(recorder.begins_at_s());
  const auto text = read(csv());
  EXPECT_THAT(text,
              testing::HasSubstr("\n0.000000,1,1,0,1,1,0,0.1,0.1,0,0,0,0\n0.000875,8,8,0,8,8,0,0.8,0.8,0,0,0,0\n"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

TEST_F(RecorderTest, TheFileHasTheEndOfALongRunAndTheFiguresAllOfIt) {
  constexpr std::uint64_t kPart = Recorder::kMaxRows / LastRows::kParts;
  constexpr std::uint64_t kCycles = Recorder::kMaxRows + kPart + 7;
  Recorder recorder(two_axes(), csv(), 1);
  for (std::uint64_t cycle = 0; cycle < kCycles; ++cycle)
    feed(recorder, {sample(cycle, 0, cycle == 3 ? 2.0 : 0.0), sample(cycle, 1)});
  recorder.finish({});
  EXPECT_FALSE(recorder.problem());
  constexpr std::uint64_t kFirst = 2 * kPart;
  EXPECT_EQ(recorder.rows(), kCycles - kFirst);
  EXPECT_NEAR(recorder.begins_at_s().value(), static_cast<double>(kFirst) * 125e-6, 1e-9);
  const auto text = read(csv());
  EXPECT_EQ(static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n')), kCycles - kFirst + 1);
  EXPECT_THAT(text, testing::StartsWith("time[s],"));
  const auto first = text.find('\n') + 1;
  EXPECT_EQ(text.substr(first, 15), "7.500000,60000,") << "time since the start of the recording";
  EXPECT_THAT(text.substr(text.rfind('\n', text.size() - 2)), testing::StartsWith("\n18.750750,150006,"));
  EXPECT_EQ(recorder.following_errors()[0].maximum, 2.0);
  EXPECT_THAT(files(), ElementsAre("axes.csv"));
}

TEST_F(RecorderTest, AFullRecordingIsComplete) {
  Recorder recorder(two_axes(), csv(), 1);
  for (std::uint64_t cycle = 0; cycle < Recorder::kMaxRows; ++cycle)
    feed(recorder, {sample(cycle, 0), sample(cycle, 1)});
  recorder.finish({});
  EXPECT_EQ(recorder.rows(), Recorder::kMaxRows);
  EXPECT_FALSE(recorder.begins_at_s());
}

TEST_F(RecorderTest, WithoutRowsThereIsNoFileAndAnOlderOneStays) {
  write(csv(), "older");
  {
    Recorder recorder(two_axes(), csv(), 1);
    recorder.finish({});
    EXPECT_FALSE(recorder.problem());
  }
  EXPECT_THAT(files(), ElementsAre("axes.csv"));
  EXPECT_EQ(read(csv()), "older");
}

TEST_F(RecorderTest, DiscardedOneLeavesNothing) {
  Recorder recorder(two_axes(), csv(), 1);
  feed(recorder, {sample(0, 0), sample(0, 1)});
  recorder.discard();
  recorder.finish({});
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(RecorderTest, UnfinishedOneLeavesNothing) {
  {
    Recorder recorder(two_axes(), csv(), 1);
    feed(recorder, {sample(0, 0), sample(0, 1)});
  }
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(RecorderTest, FolderThatCannotBeWrittenIsTold) {
  const auto file = directory / "none" / "axes.csv";
  Recorder recorder(two_axes(), file, 1);
  ASSERT_TRUE(recorder.problem());
  EXPECT_EQ(describe(*recorder.problem()), file.string() + ": cannot be written: No such file or directory");
  feed(recorder, {sample(0, 0, 1.0), sample(0, 1)});
  recorder.finish({});
  EXPECT_EQ(recorder.following_errors()[0].maximum, 1.0) << "the figures do not need the file";
}

TEST_F(RecorderTest, NameThatIsTakenByAFolderIsToldAndNoPartialFileStays) {
  std::filesystem::create_directory(csv());
  Recorder recorder(two_axes(), csv(), 1);
  feed(recorder, {sample(0, 0), sample(0, 1)});
  recorder.finish({});
  ASSERT_TRUE(recorder.problem());
  EXPECT_EQ(describe(*recorder.problem()), csv().string() + ": cannot be written: Is a directory");
  EXPECT_THAT(files(), ElementsAre("axes.csv"));
}

}  // namespace
}  // namespace driveline::runtime
