#include "text/plots.hpp"

#include <gmock/gmock.h>
#include <stdlib.h>

#include "driveline/runtime/event.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using std::chrono::nanoseconds;
using testing::ElementsAre;

/// Sets an environment variable; the destructor restores it.
class ScopedEnvironment {
 public:
  ScopedEnvironment(std::string name, const std::string& value) : name_(std::move(name)) {
    if (const char* before = getenv(name_.c_str())) before_ = before;
    setenv(name_.c_str(), value.c_str(), 1);
  }
  ~ScopedEnvironment() { setenv(name_.c_str(), before_.c_str(), 1); }
  ScopedEnvironment(const ScopedEnvironment&) = delete;
  ScopedEnvironment& operator=(const ScopedEnvironment&) = delete;

 private:
  std::string name_;
  std::string before_;
};

class Plots : public test::TemporaryDirectory {
 protected:
  void leave_csv_files() const {
    ecat_master::CycleStatistics statistics;
    for (int i = 0; i < 1000; ++i) statistics.wake_latency.record(nanoseconds{50 + i});
    for (int i = 0; i < 1000; ++i) statistics.cost.record(nanoseconds{8000 + i});
    ASSERT_TRUE(write_jitter_csv(statistics, directory / "jitter.csv"));
    std::string text =
        "time[s],x_target[rad],x_actual[rad],x_following_error[rad],y_target[m],y_actual[m],"
        "y_following_error[m],x_torque[Nm],y_torque[N],x_following_error_min[rad],x_following_error_max[rad],"
        "y_following_error_min[m],y_following_error_max[m]\n";
    for (int i = 0; i < 100; ++i)
      text += std::to_string(i) +
              (i < 10 ? ",1,2,0.5,3,4,-0.5,0,0,nan,nan,nan,nan\n" : ",1,2,0.5,3,4,-0.5,0,0,0.4,0.6,-0.7,-0.1\n");
    write(directory / "axes.csv", text);
  }
  static std::vector<runtime::AxisRunReport> axes() {
    return {{"x", 0, 1.0, 1.0, "rad", 1000.0}, {"y", 1, 1.0, 1.0, "m", 1.0}};
  }
};

MATCHER(IsPng, "") {
  return arg.substr(0, 8) == "\x89PNG\r\n\x1a\n" && arg.size() > 2000;
}

TEST_F(Plots, JitterCsvHasBothHistogramsByBucket) {
  ecat_master::CycleStatistics statistics;
  statistics.wake_latency.record(nanoseconds{7});
  statistics.wake_latency.record(nanoseconds{7});
  statistics.cost.record(nanoseconds{7});
  statistics.cost.record(nanoseconds{100});
  ASSERT_TRUE(write_jitter_csv(statistics, directory / "jitter.csv"));
  EXPECT_EQ(read(directory / "jitter.csv"), "from[ns],to[ns],wake_latency,cycle_cost\n7,8,2,1\n100,101,0,1\n");
}

TEST_F(Plots, JitterCsvThatCannotBeWritten) {
  const auto file = directory / "none" / "jitter.csv";
  EXPECT_EQ(runtime::describe(write_jitter_csv({}, file).error()),
            file.string() + ": cannot be written: No such file or directory");
}

TEST_F(Plots, PicturesAreDrawn) {
  leave_csv_files();
  const auto pictures = draw_plots(directory, axes());
  ASSERT_TRUE(pictures) << pictures.error();
  EXPECT_EQ(pictures->pictures, (std::map<std::string, std::filesystem::path>{
                                    {"jitter_plot", directory / "jitter.png"},
                                    {"position_plot", directory / "positions.png"},
                                    {"following_error_plot", directory / "following_error.png"}}));
  for (const auto& [key, picture] : pictures->pictures) EXPECT_THAT(read(picture), IsPng()) << key;
  EXPECT_THAT(files(),
              ElementsAre("axes.csv", "following_error.png", "jitter.csv", "jitter.png", "plots.gp", "positions.png"));
}

TEST_F(Plots, ScriptThatIsLeftDrawsTheRightColumns) {
  leave_csv_files();
  ASSERT_TRUE(draw_plots(directory, axes()));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, testing::HasSubstr("using 1:2 with lines lw 4 lc rgb '#9ecae1' title 'commanded'"));
  EXPECT_THAT(script, testing::HasSubstr("using 1:3 with lines lc rgb '#08306b' title 'actual'"));
  EXPECT_THAT(script, testing::HasSubstr("using 1:10:11 with filledcurves"));
  EXPECT_THAT(script, testing::HasSubstr("using 1:5 with lines lw 4 lc rgb '#9ecae1' title 'commanded'"));
  EXPECT_THAT(script, testing::HasSubstr("using 1:12:13 with filledcurves"));
}

TEST_F(Plots, DemandsOfDrivesThatReportThemAreDrawn) {
  leave_csv_files();
  auto some = axes();
  some[0].by_drive = runtime::AxisRunReport::Reported{};
  some[1].demand_recorded = true;
  // Add two columns after the existing ones.
  auto text = read(directory / "axes.csv");
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 5)) text.insert(at, ",0,1");
  write(directory / "axes.csv", text);
  ASSERT_TRUE(draw_plots(directory, some));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, testing::HasSubstr("using 1:14 with lines lt 2 title 'by the drive (60F4h)'"));
  EXPECT_THAT(script,
              testing::HasSubstr("using 1:15 with lines lc rgb '#238b45' title 'demand (6062h)', '' skip 1 using "
                                 "1:6 with lines"));
}

TEST_F(Plots, AxesNameTheirUnitsAndIncrementsOnRequest) {
  leave_csv_files();
  auto named = axes();
  named[1].unit = "mm";
  named[1].increments_per_unit = 104.25;
  ASSERT_TRUE(draw_plots(directory, named));
  auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, testing::HasSubstr("set ylabel 'x in rad'\n"));
  EXPECT_THAT(script, testing::HasSubstr("set ylabel 'y in mm'\n"));
  EXPECT_THAT(script, testing::Not(testing::HasSubstr("increments")));
  const auto plain = read(directory / "following_error.png");
  const auto drawn = draw_plots(directory, named, true);
  ASSERT_TRUE(drawn) << drawn.error();
  script = read(directory / "plots.gp");
  EXPECT_THAT(script, testing::HasSubstr("set y2label 'increments'\n"));
  EXPECT_THAT(script, testing::HasSubstr("using 1:(($2)*1000) axes x1y2 with lines lt nodraw"));
  EXPECT_THAT(script, testing::HasSubstr("using 1:(($12)*104.25) axes x1y2 with lines lt nodraw"));
  EXPECT_THAT(read(directory / "following_error.png"), testing::AllOf(IsPng(), testing::Ne(plain)));
}

TEST_F(Plots, JitterHasEqualLogarithmicBarsTheDeadlineAndWhatWasMissed) {
  leave_csv_files();
  using namespace std::chrono_literals;
  ASSERT_TRUE(draw_plots(directory, {}, false, {.period = 125us, .wake = {550ns, 1040ns, 20us, 3ms}}));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, testing::HasSubstr("bar(from, to) = (floor(10*log10((from + to) / 2000.0)) + 0.5) / 10"));
  EXPECT_THAT(script, testing::HasSubstr("deadline = 125000\n"));
  EXPECT_THAT(script, testing::HasSubstr("set arrow 9 from 2.0969,graph 0 to 2.0969,graph 1 nohead lw 2 lc 'red'"));
  EXPECT_THAT(script, testing::HasSubstr("'p99 1.04 us' at 0.0170"));
  EXPECT_THAT(script, testing::Not(testing::HasSubstr("'max 3000.00 us'"))) << "beyond the deadline, where the bar is";
  EXPECT_THAT(script, testing::HasSubstr("using (-2.0):($1<25 ? $3 : 0) smooth frequency"));
  EXPECT_THAT(script,
              testing::HasSubstr("using (2.3969):($1>=deadline ? $3 : 0) smooth frequency with boxes lc rgb 'red'"));
  EXPECT_THAT(read(directory / "jitter.png"), IsPng());
}

TEST_F(Plots, PositionsHaveTheFollowingErrorBelowAndWhatHappenedAcross) {
  leave_csv_files();
  ASSERT_TRUE(
      draw_plots(directory, axes(), false, {.marks = {{12.5, true, "periods missed"}, {20.0, false, "fault"}}}));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, testing::HasSubstr("set multiplot layout 2,2 title 'commanded and actual position"));
  EXPECT_THAT(script, testing::HasSubstr(
                          "set arrow 1 from 12.500000,graph 0 to 12.500000,graph 1 nohead dt 2 lc rgb '#dd181f'"));
  EXPECT_THAT(script, testing::HasSubstr("set label 2 'fault' at 20.000000"));
  EXPECT_THAT(script, testing::HasSubstr("set autoscale xfix")) << "the time ends with the data";
  EXPECT_THAT(script, testing::HasSubstr("set key outside right"));
  EXPECT_THAT(read(directory / "positions.png"), IsPng());
}

TEST_F(Plots, MarksAreWhatHappenedInOperation) {
  runtime::RunReport report;
  report.period = std::chrono::microseconds{250};
  report.statistics.missed_periods = 3;
  report.longest_absence_at_s = 1.5;
  report.statistics.wake_latency.record(nanoseconds{100});
  report.events.push_back({runtime::events::MasterAway{}, runtime::Severity::kNotice, std::chrono::milliseconds{1250}});
  report.events.push_back({runtime::events::RecordingShortened{}, runtime::Severity::kFault, std::nullopt});
  report.events.push_back({runtime::events::Progress{}, runtime::Severity::kProgress, std::chrono::seconds{2}});
  report.events.push_back({runtime::events::CommunicationLost{}, runtime::Severity::kFault, std::chrono::seconds{3}});
  const auto facts = plot_facts(report);
  EXPECT_EQ(facts.period, std::chrono::microseconds{250});
  EXPECT_EQ(facts.wake[3], nanoseconds{100});
  ASSERT_EQ(facts.marks.size(), 3U);
  EXPECT_EQ(facts.marks[0].time_s, 1.5);
  EXPECT_TRUE(facts.marks[1].missed);
  EXPECT_EQ(facts.marks[1].time_s, 1.25);
  EXPECT_FALSE(facts.marks[2].missed);
  EXPECT_EQ(facts.marks[2].text, "fault");
}

TEST_F(Plots, OneAxisHasTheWholePicture) {
  leave_csv_files();
  ASSERT_TRUE(draw_plots(directory, axes()));
  EXPECT_THAT(read(directory / "plots.gp"), testing::HasSubstr("set multiplot layout 1,2 title"));
  ASSERT_TRUE(draw_plots(directory, {axes().front()}));
  EXPECT_THAT(read(directory / "plots.gp"), testing::HasSubstr("set multiplot layout 1,1 title"));
}

TEST_F(Plots, WhatADriveReportsIsDrawnBesideOurs) {
  std::string text = "time[s],x_t,x_a,x_e,y_t,y_a,y_e,x_torque,y_torque,x_min,x_max,y_min,y_max,y_drive\n";
  for (int i = 0; i < 100; ++i) text += std::to_string(i) + ",1,2,0.5,3,4,-0.5,0,0,-1,1,-1,1,0.1\n";
  leave_csv_files();
  write(directory / "axes.csv", text);
  auto both = axes();
  both[1].by_drive = {1.0, 1.0};
  ASSERT_TRUE(draw_plots(directory, both));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script,
              testing::HasSubstr("notitle, '' skip 1 using 1:14 with lines lt 2 title 'by the drive (60F4h)'\n"));
  EXPECT_EQ(script.find("60F4h"), script.rfind("60F4h")) << "x reports none";
}

TEST_F(Plots, WithoutAxesOnlyTheJitterIsDrawn) {
  leave_csv_files();
  const auto pictures = draw_plots(directory, {});
  ASSERT_TRUE(pictures) << pictures.error();
  EXPECT_EQ(pictures->pictures.size(), 1U);
  EXPECT_THAT(read(pictures->pictures.at("jitter_plot")), IsPng());
}

TEST_F(Plots, NamesAreTextsAndNoCommands) {
  leave_csv_files();
  const auto proof = directory / "proof";
  auto named = axes();
  named[0].name = "x'\nsystem \"touch " + proof.string() + "\" #";
  named[1].name = "y`touch " + proof.string() + "`";
  const auto pictures = draw_plots(directory, named);
  ASSERT_TRUE(pictures) << pictures.error();
  EXPECT_FALSE(std::filesystem::exists(proof));
  EXPECT_THAT(read(directory / "plots.gp"), testing::HasSubstr("set ylabel 'x'' system "));
  write(directory / "clocks.csv", "time[s],x,y\n0,1,2\n1,2,3\n");
  const auto clocks = draw_clocks(directory, {named[0].name, named[1].name});
  EXPECT_TRUE(clocks) << clocks.error();
  EXPECT_FALSE(std::filesystem::exists(proof));
}

TEST_F(Plots, WarningsOfGnuplotAreNotTheUsers) {
  leave_csv_files();
  write(directory / "gnuplot", "#!/bin/sh\necho 'warning: empty y range' >&2\necho more\n");
  std::filesystem::permissions(directory / "gnuplot", std::filesystem::perms::owner_all);
  const ScopedEnvironment path("PATH", directory.string());
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const auto pictures = draw_plots(directory, axes());
  EXPECT_EQ(testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout(), "");
  EXPECT_TRUE(pictures);
}

TEST_F(Plots, APictureThatIsCutOffIsToldAndNotLeft) {
  leave_csv_files();
  // A program that reports success although the disk is full.
  write(directory / "gnuplot",
        "#!/bin/sh\nprintf 'many colours IEND\\256\\102\\140\\202' > jitter.png\nprintf half > positions.png\n");
  std::filesystem::permissions(directory / "gnuplot", std::filesystem::perms::owner_all);
  const ScopedEnvironment path("PATH", directory.string());
  const auto drawing = draw_plots(directory, axes());
  ASSERT_TRUE(drawing) << drawing.error();
  EXPECT_EQ(drawing->pictures,
            (std::map<std::string, std::filesystem::path>{{"jitter_plot", directory / "jitter.png"}}));
  ASSERT_TRUE(drawing->problem);
  EXPECT_THAT(
      runtime::describe(*drawing->problem),
      testing::EndsWith(
          ".png: could not be written completely: the disk is full, or the file size limit is reached (ulimit -f)"));
  EXPECT_FALSE(std::filesystem::exists(directory / "positions.png"));
}

TEST_F(Plots, AScriptThatCannotBeWrittenIsAProblem) {
  const auto drawing = draw_plots(directory / "none", axes());
  ASSERT_TRUE(drawing) << drawing.error();
  EXPECT_TRUE(drawing->pictures.empty());
  ASSERT_TRUE(drawing->problem);
  EXPECT_EQ(runtime::describe(*drawing->problem),
            (directory / "none" / "plots.gp").string() + ": cannot be written: No such file or directory");
}

TEST_F(Plots, FailingGnuplotIsQuoted) {
  leave_csv_files();
  write(directory / "gnuplot",
        "#!/bin/sh\necho 'warning: that' >&2\necho 'line 3: no such function' >&2\necho '   ^'\nexit 1\n");
  std::filesystem::permissions(directory / "gnuplot", std::filesystem::perms::owner_all);
  const ScopedEnvironment path("PATH", directory.string());
  EXPECT_EQ(draw_plots(directory, axes()).error(),
            "no plots: gnuplot failed on " + (directory / "plots.gp").string() + ": line 3: no such function");
}

TEST_F(Plots, MissingGnuplotIsASentenceWithTheRemedy) {
  leave_csv_files();
  const ScopedEnvironment path("PATH", directory.string());
  EXPECT_EQ(draw_plots(directory, axes()).error(), "no plots: gnuplot is not installed (Debian package gnuplot-nox)");
}

TEST_F(Plots, FailingGnuplotIsASentenceWithTheScript) {
  leave_csv_files();
  write(directory / "gnuplot", "#!/bin/sh\nexit 3\n");
  std::filesystem::permissions(directory / "gnuplot", std::filesystem::perms::owner_all);
  const ScopedEnvironment path("PATH", directory.string());
  EXPECT_EQ(draw_plots(directory, axes()).error(), "no plots: gnuplot failed on " + (directory / "plots.gp").string());
}

}  // namespace
}  // namespace driveline::cli
