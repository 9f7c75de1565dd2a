#include "text/plots.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <stdlib.h>

#include <array>

#include "driveline/runtime/event.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using std::chrono::nanoseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

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
    motion::CycleStatistics statistics;
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
  /// Rows of the positions of x and y: target and actual. All other values are 0.
  void write_values(const std::vector<std::array<double, 4>>& rows) const {
    std::string text = "head\n";
    for (std::size_t i = 0; i < rows.size(); ++i) {
      text += fmt::format("{},{},{},0,{},{},0,0,0,0,0,0,0\n", i, rows[i][0], rows[i][1], rows[i][2], rows[i][3]);
    }
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
  motion::CycleStatistics statistics;
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
  const auto pictures = must(draw_plots(directory, axes()));
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
  EXPECT_THAT(script, HasSubstr("using 1:2 with lines lw 4 lc rgb '#9ecae1' notitle"));
  EXPECT_THAT(script, HasSubstr("using 1:3 with lines lc rgb '#08306b' notitle"));
  EXPECT_THAT(script, HasSubstr("using 1:10:11 with filledcurves"));
  EXPECT_THAT(script, HasSubstr("using 1:5 with lines lw 4 lc rgb '#9ecae1' notitle"));
  EXPECT_THAT(script, HasSubstr("using 1:12:13 with filledcurves"));
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
  EXPECT_THAT(script, HasSubstr("using 1:14 with lines lt 2 notitle"));
  EXPECT_THAT(script, HasSubstr("using 1:15 with lines lc rgb '#238b45' notitle, '' skip 1 using 1:6 with lines"));
  EXPECT_THAT(script, HasSubstr("title 'demand (6062h)'"));
  EXPECT_THAT(script, HasSubstr("title 'by the drive (60F4h)'"));
}

TEST_F(Plots, EachPanelHasANameOfItsOwnAndThePictureOneLegend) {
  leave_csv_files();
  auto named = axes();
  named[1].unit = "mm";
  ASSERT_TRUE(draw_plots(directory, named));
  const auto script = read(directory / "plots.gp");
  for (const auto* name : {"'x in rad'", "'x error in rad'", "'y in mm'", "'y error in mm'"}) {
    EXPECT_THAT(script, HasSubstr(fmt::format("set label 100 {} at graph 0,graph 1 left", name)));
  }
  EXPECT_EQ(script.find("title 'commanded'"), script.rfind("title 'commanded'"));
  EXPECT_THAT(script, Not(HasSubstr("set key outside"))) << "a legend beside each panel takes its width";
}

TEST_F(Plots, LabelsOfTicksAreShort) {
  leave_csv_files();
  write_values({{0.000'002, 0.000'002, 123.456, 123.456}, {0.000'004, 0.000'004, 123.456, 123.456}});
  ASSERT_TRUE(draw_plots(directory, axes()));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, HasSubstr("set label 100 'x in 1e-6 rad' at graph 0,graph 1 left offset 0,0.7\n"
                                "set yrange [1.92:4.08]\nset ytics 0.5\n"
                                "plot 'axes.csv' skip 1 using 1:($2*1e6) with lines"));
  EXPECT_THAT(script, HasSubstr("set yrange [123.389334:123.522666]\nset ytics 0.05\n"))
      << "y stands still: its ticks differ all the same";
}

TEST_F(Plots, IncrementsOnRequest) {
  leave_csv_files();
  auto named = axes();
  named[1].unit = "mm";
  named[1].increments_per_unit = 104.25;
  ASSERT_TRUE(draw_plots(directory, named));
  EXPECT_THAT(read(directory / "plots.gp"), Not(HasSubstr("increments")));
  const auto plain = read(directory / "following_error.png");
  ASSERT_EQ(failure_text(draw_plots(directory, named, true)), "");
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, HasSubstr("'y in mm; right: increments'"));
  // y from 3 to 4 mm with a margin of 0.04 mm on either side, in increments.
  EXPECT_THAT(script, HasSubstr("set yrange [2.96:4.04]\nset ytics 0.2\nset ytics nomirror\nset y2range [308.5"));
  EXPECT_THAT(script, HasSubstr("set y2tics 50 format '%.0f'\n"));
  EXPECT_THAT(read(directory / "following_error.png"), testing::AllOf(IsPng(), testing::Ne(plain)));
}

TEST_F(Plots, AnAxisThatDoesNotMoveHasTicksOfAnIncrement) {
  leave_csv_files();
  write_values({{0.5, 0.5, 0.5, 0.5}});
  auto coarse = axes();
  coarse[0].increments_per_unit = 5.0;
  ASSERT_TRUE(draw_plots(directory, coarse, true));
  EXPECT_THAT(read(directory / "plots.gp"), HasSubstr("set yrange [0.284:0.716]\nset ytics 0.1\n"))
      << "an increment of 0.2 rad to either side";
}

TEST_F(Plots, JitterHasEqualLogarithmicBarsTheDeadlineAndMissedPeriodsAtTheirDelay) {
  leave_csv_files();
  using namespace std::chrono_literals;
  ASSERT_TRUE(draw_plots(directory, {}, false, {.period = 125us, .wake = {550ns, 1040ns, 20us, 3ms}}));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script,
              HasSubstr("bar(ns) = (floor(10*(log10((ns > 1 ? ns : 1)/1000.0) - origin)) + 0.5) / 10 + origin"));
  EXPECT_THAT(script, HasSubstr("deadline = 125000\norigin = log10(deadline / 1000.0)\n"))
      << "a bar begins at the deadline, so that none has both kinds";
  EXPECT_THAT(script, HasSubstr("set arrow 9 from 2.0969,graph 0 to 2.0969,graph 1 nohead lw 2 lc 'red'"));
  EXPECT_THAT(script, HasSubstr("'p99 1.04 us' at 0.0170"));
  EXPECT_THAT(script, HasSubstr("'max 3000.00 us' at 3.4771,graph 0.75 front boxed right"))
      << "left of its line: it is the end";
  EXPECT_THAT(script, HasSubstr("set xrange [-2.2:3.6771]"));
  EXPECT_THAT(script, HasSubstr("using (-2):($1<25 ? $3 : 0) smooth frequency"));
  EXPECT_THAT(script, HasSubstr("using (bar($1)):($1>=deadline ? $3 : 0) smooth frequency with boxes lc rgb 'red'"));
  EXPECT_THAT(read(directory / "jitter.png"), IsPng());
}

TEST_F(Plots, EventsHaveNumbersAndTheirSentencesStandBelow) {
  leave_csv_files();
  const std::vector<PlotMark> marks{{20.0, false, "axis y: unavailable"},
                                    {12.5, true, "periods missed"},
                                    {21.5, false, "axis y: available again"},
                                    {60.0, false, "it's over"}};
  ASSERT_TRUE(draw_plots(directory, axes(), false, {.marks = marks}));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, HasSubstr("set multiplot layout 2,2 title 'commanded and actual position"));
  EXPECT_THAT(script,
              HasSubstr("set arrow 1 from 12.500000,graph 0 to 12.500000,graph 1 nohead dt 2 lc rgb '#dd181f'"));
  EXPECT_THAT(script, HasSubstr("set label 1 '1-2' at 20.750000,graph 0.9")) << "of 99 s: their labels would overlap";
  EXPECT_THAT(script, HasSubstr("set label 2 '3' at 60.000000,graph 0.9"));
  EXPECT_THAT(script, HasSubstr("set label 1 '1  20.000 s  axis y: unavailable' at screen 0.02"));
  EXPECT_THAT(script, HasSubstr("set label 3 '3  60.000 s  it''s over' at screen 0.02"));
  EXPECT_THAT(script, HasSubstr("title 'events, listed below'"));
  EXPECT_THAT(script, HasSubstr("set autoscale xfix")) << "the time ends with the data";
  EXPECT_THAT(read(directory / "positions.png"), IsPng());
}

TEST_F(Plots, LongListsOfEventsAndLongSentencesAreCut) {
  leave_csv_files();
  std::vector<PlotMark> marks;
  for (int i = 0; i < 40; ++i) marks.push_back({2.0 * i, false, std::string(196, '-') + "µ and more"});
  ASSERT_EQ(failure_text(draw_plots(directory, axes(), false, {.marks = marks})), "");
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, HasSubstr("'24  46.000 s  " + std::string(196, '-') + "µ...' at screen"))
      << "a character of two bytes is not cut in half";
  EXPECT_THAT(script, HasSubstr("'and 16 more events'"));
  EXPECT_THAT(script, Not(HasSubstr("'25  ")));
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
  EXPECT_TRUE(facts.marks[0].missed);
  EXPECT_EQ(facts.marks[0].time_s, 1.25);
  EXPECT_FALSE(facts.marks[1].missed);
  EXPECT_EQ(facts.marks[1].text, describe(report.events[3]));
  EXPECT_TRUE(facts.marks[2].missed);
  EXPECT_EQ(facts.marks[2].time_s, 1.5);
}

TEST_F(Plots, ALongRunHasTheMarksOfItsLastMinutes) {
  leave_csv_files();
  runtime::RunReport report;
  constexpr int kEvents = 75;
  for (int i = 0; i < kEvents; ++i) {
    report.events.push_back(
        {runtime::events::CommunicationLost{}, runtime::Severity::kFault, std::chrono::seconds{100 + i}});
  }
  const auto facts = plot_facts(report);
  ASSERT_EQ(facts.marks.size(), 60U);
  EXPECT_EQ(facts.marks.front().time_s, 115.0);
  EXPECT_EQ(facts.marks.back().time_s, 174.0);

  // The first row of the recording is at 0 s.
  const std::vector<PlotMark> marks{
      {-3.5, false, "before the recording"}, {-2.5, true, "away"}, {0.0, false, "first"}, {99.5, false, "after"}};
  ASSERT_TRUE(draw_plots(directory, axes(), false, {.marks = marks}));
  const auto script = read(directory / "plots.gp");
  EXPECT_THAT(script, HasSubstr("'1  0.000 s  first'"));
  EXPECT_THAT(script, HasSubstr("'2  99.500 s  after'")) << "the event that ended the run";
  EXPECT_THAT(script, Not(HasSubstr("before the recording")));
  EXPECT_THAT(script, Not(HasSubstr("periods missed")));
}

TEST_F(Plots, OneAxisHasTheWholePicture) {
  leave_csv_files();
  ASSERT_TRUE(draw_plots(directory, axes()));
  EXPECT_THAT(read(directory / "plots.gp"), HasSubstr("set multiplot layout 1,2 title"));
  ASSERT_TRUE(draw_plots(directory, {axes().front()}));
  EXPECT_THAT(read(directory / "plots.gp"), HasSubstr("set multiplot layout 1,1 title"));
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
  EXPECT_THAT(script, HasSubstr("notitle, '' skip 1 using 1:14 with lines lt 2 notitle\n"));
  EXPECT_EQ(script.find("lt 2 notitle"), script.rfind("lt 2 notitle")) << "x reports none";
}

TEST_F(Plots, WithoutAxesOnlyTheJitterIsDrawn) {
  leave_csv_files();
  const auto pictures = must(draw_plots(directory, {}));
  EXPECT_EQ(pictures->pictures.size(), 1U);
  EXPECT_THAT(read(pictures->pictures.at("jitter_plot")), IsPng());
}

TEST_F(Plots, NamesAreTextsAndNoCommands) {
  leave_csv_files();
  const auto proof = directory / "proof";
  auto named = axes();
  named[0].name = "x'\nsystem \"touch " + proof.string() + "\" #";
  named[1].name = "y`touch " + proof.string() + "`";
  ASSERT_EQ(failure_text(draw_plots(directory, named)), "");
  EXPECT_FALSE(std::filesystem::exists(proof));
  EXPECT_THAT(read(directory / "plots.gp"), HasSubstr("set label 100 'x'' system "));
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
  const auto drawing = must(draw_plots(directory, axes()));
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
  const auto drawing = must(draw_plots(directory / "none", axes()));
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
