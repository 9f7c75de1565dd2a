#include "text/run_report.hpp"
#include "driveline/runtime/event.hpp"

#include <gmock/gmock.h>
#include <memory>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace driveline::cli {
namespace {

using nlohmann::json;
using std::chrono::nanoseconds;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

runtime::RunReport report_of_a_run() {
  runtime::RunReport report;
  report.line = "press";
  report.state = "OP";
  report.axes = {{"x", 0, 120.0, 30.5, "rad", 1000.0}, {"z", 3, 8.0, 2.0, "mm", 1e3, 17}};
  report.axes[1].path_error = {90.5, 60.0};
  report.axes[0].owner = "path";
  report.period = std::chrono::microseconds{125};
  report.duration_s = 5.0;
  auto& statistics = report.statistics;
  statistics.cycles = 39'990;
  statistics.missed_periods = 10;
  statistics.wkc_errors = 3;
  statistics.lost_frames = 4;
  statistics.late_frames = 3;
  statistics.flooded_cycles = 6;
  statistics.longest_absence = nanoseconds{1'375'000};
  report.longest_absence_at_s = 0.85;
  report.path_late = std::chrono::milliseconds{2};
  // Below 128 ns the histogram is exact.
  for (int i = 1; i <= 100; ++i) statistics.wake_latency.record(nanoseconds{i});
  statistics.cost.record(nanoseconds{8000});
  statistics.round_trip.record(nanoseconds{60});
  ecat_master::LineEvent back;
  back.kind = ecat_master::LineEvent::Kind::kRecovered;
  back.slave = 3;
  report.events.push_back(
      {runtime::events::LineChanged{back, "z"}, runtime::Severity::kNotice, std::chrono::milliseconds{1250}});
  report.note_failure(
      runtime::fail(runtime::ErrorKind::kMachine, "cannot be written: No space left on device", "out/axes.csv")
          .value());
  report.recoveries = 1;
  report.telemetry = runtime::TelemetryReport{.published = 80'000, .dropped = 5, .restarts = 2};
  report.files = {{"axes_csv", "out/axes.csv"}};
  return report;
}

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

TEST(RunReport, JsonHasTheKeysOfTheContractAndNoOthers) {
  const auto document = to_json(report_of_a_run());
  EXPECT_THAT(keys(document),
              UnorderedElementsAre("state", "axes_count", "cycle_ns", "duration_s", "cycles", "missed_periods",
                                   "wkc_errors", "lost_frames", "wake_latency_ns", "cycle_cost_ns", "round_trip_ns",
                                   "dc", "axes", "telemetry", "faults", "files",
                                   // Added since:
                                   "events", "recoveries", "late_frames", "round_trip_modelled", "longest_absence_ns",
                                   "longest_absence_at_s", "path_late_ns", "realtime_thread", "flooded_cycles"));
  for (const auto* times : {"wake_latency_ns", "cycle_cost_ns", "round_trip_ns"}) {
    EXPECT_THAT(keys(document[times]), UnorderedElementsAre("p50", "p99", "p999", "max"));
  }
  EXPECT_THAT(keys(document["axes"][0]), UnorderedElementsAre("name", "slave", "following_error_max",
                                                              "following_error_rms", "unit", "unavailable_cycles",
                                                              // Added since:
                                                              "position_unit", "increments_per_position_unit",
                                                              "path_error_max", "path_error_rms", "owner"));
}

/// They were printed when they happened; a busy machine makes many.
TEST(RunReport, TextHasTheSumOfTheAbsencesOfTheMasterAndJsonEach) {
  auto report = report_of_a_run();
  const auto add = [&](auto facts, runtime::Severity severity) {
    report.events.push_back({std::move(facts), severity, std::chrono::milliseconds{2500}});
  };
  runtime::events::MasterAway away;
  away.absence.since = std::chrono::milliseconds{2000};
  away.absence.duration = std::chrono::microseconds{8100};
  add(away, runtime::Severity::kNotice);
  away.absence.duration = std::chrono::microseconds{1900};
  add(away, runtime::Severity::kNotice);
  add(runtime::events::MasterAwayOften{5, std::chrono::milliseconds{7}, std::chrono::milliseconds{2}},
      runtime::Severity::kNotice);
  const auto text = to_text(report);
  EXPECT_THAT(text, HasSubstr("  the master was away 7 times, 17.0 ms in all, 8.1 ms at the longest\n"));
  EXPECT_THAT(text, Not(HasSubstr("was away for")));
  EXPECT_THAT(to_json(report)["events"].dump(), HasSubstr("the master was away for 8.1 ms at 2.000 s"));
  away.absence.duration = std::chrono::milliseconds{54};
  away.absence.effect = motion::AbsenceEffect::kStopped;
  add(away, runtime::Severity::kFault);
  EXPECT_THAT(to_text(report), HasSubstr("2.500 s the master was away for 54.0 ms")) << "a fault is listed";
}

TEST(RunReport, NoLineOfTheTextIsWiderThanATerminal) {
  auto report = report_of_a_run();
  report.process_data.emplace();
  report.process_data->layout = "overlapped";
  report.process_data->wire.period = std::chrono::microseconds{125};
  auto& group = report.process_data->groups.emplace_back();
  group.name = "line";
  group.datagrams = 1;
  group.exchanges = 1'234'567;
  report.thread.emplace();
  report.axes[0].name = "the leader of the gantry";
  report.axes[0].by_drive = runtime::AxisRunReport::Reported{};
  report.axes[0].by_drive->maximum = 1.342;
  const ecat_master::StartupNote refused{
      1, ecat_master::notes::WriteRefused{{0x1C32, 2}, wire::SdoAbort::kValueRange, 1'000'000, 125'000}};
  for (const auto severity : {runtime::Severity::kNotice, runtime::Severity::kFault})
    report.events.push_back({runtime::events::StartupNoted{refused}, severity, std::chrono::milliseconds{12'500}});
  std::istringstream lines(to_text(report));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST(RunReport, JsonHasTheFigures) {
  EXPECT_EQ(to_json(report_of_a_run()), json::parse(R"({
    "state": "OP", "axes_count": 2, "cycle_ns": 125000, "duration_s": 5.0,
    "cycles": 39990, "missed_periods": 10, "wkc_errors": 3, "lost_frames": 4,
    "late_frames": 3, "flooded_cycles": 6, "longest_absence_ns": 1375000, "longest_absence_at_s": 0.85, "path_late_ns": 2000000,
    "wake_latency_ns": {"p50": 50, "p99": 99, "p999": 100, "max": 100},
    "cycle_cost_ns": {"p50": 8000, "p99": 8000, "p999": 8000, "max": 8000},
    "round_trip_ns": {"p50": 60, "p99": 60, "p999": 60, "max": 60}, "round_trip_modelled": false, "realtime_thread": null,
    "dc": {"locked": false, "difference_ns": {"p50": null, "p99": null, "max": null}},
    "axes": [
      {"name": "x", "slave": 0, "owner": "path", "following_error_max": 120.0, "following_error_rms": 30.5,
       "path_error_max": 0.0, "path_error_rms": 0.0, "unit": "increments",
       "position_unit": "rad", "increments_per_position_unit": 1000.0,
       "unavailable_cycles": 0},
      {"name": "z", "slave": 3, "owner": "", "following_error_max": 8.0, "following_error_rms": 2.0,
       "path_error_max": 90.5, "path_error_rms": 60.0, "unit": "increments",
       "position_unit": "mm", "increments_per_position_unit": 1000.0,
       "unavailable_cycles": 17}],
    "telemetry": {"published": 80000, "dropped": 5, "restarts": 2},
    "faults": ["out/axes.csv: cannot be written: No space left on device"], "events": ["1.250 s slave 3 (z): back in OP"], "recoveries": 1,
    "files": {"axes_csv": "out/axes.csv"}
  })"));
}

TEST(RunReport, WhatTheDriveReportsOfItsFollowingErrorStandsBesideOurs) {
  auto report = report_of_a_run();
  report.axes[0].by_drive = {12.5, 3.5};
  const auto document = to_json(report);
  EXPECT_EQ(document["axes"][0]["drive_following_error_max"], 12.5);
  EXPECT_EQ(document["axes"][0]["drive_following_error_rms"], 3.5);
  EXPECT_FALSE(document["axes"][1].contains("drive_following_error_max")) << "60F4h is not mapped";
  EXPECT_THAT(to_text(report), HasSubstr("0.12 rad    0.0305 rad  (60F4h: max 0.0125 rad)\n"));
  EXPECT_THAT(to_text(report), HasSubstr("0.008 mm      0.002 mm\n"));
  report.increments = true;
  EXPECT_THAT(to_text(report), HasSubstr("120.0 inc         30.50 inc  (60F4h: max 0.0125 rad, 12.5 inc)\n"));
}

TEST(RunReport, JsonTellsWhoHasCommandedTheAxes) {
  auto report = report_of_a_run();
  using Kind = runtime::LeaseChange::Kind;
  report.authority = {{0.5, "x", {0, Kind::kTaken, "script", ""}}, {1.5, "x", {0, Kind::kTakenOver, "hand", "script"}}};
  const auto rows = to_json(report).at("authority");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].dump(), R"({"axis":"x","before":"","change":"taken","owner":"script","time_s":0.5})");
  EXPECT_EQ(rows[1].at("change"), "taken over");
  EXPECT_EQ(rows[1].at("before"), "script");
}

TEST(RunReport, TellsOfEventsThatWereNotKept) {
  runtime::RunReport report;
  EXPECT_FALSE(to_json(report).contains("events_left_out"));
  EXPECT_THAT(to_text(report), Not(HasSubstr("not kept")));
  report.events_left_out = 17;
  EXPECT_EQ(to_json(report).at("events_left_out"), 17);
  EXPECT_THAT(to_text(report), HasSubstr("  17 more events between the first and the last ones are not stored\n"));
}

TEST(RunReport, JsonOfNothingIsComplete) {
  const auto document = to_json(runtime::RunReport{});
  EXPECT_EQ(document["axes"], json::array());
  EXPECT_EQ(document["faults"], json::array());
  EXPECT_EQ(document["files"], json::object());
  EXPECT_EQ(document["wake_latency_ns"]["p999"], 0);
  EXPECT_EQ(document["longest_absence_at_s"], nullptr);
  EXPECT_THAT(to_text(runtime::RunReport{}), Not(HasSubstr("longest absence")));
}

TEST(RunReport, TextHasTheFigures) {
  const auto text = to_text(report_of_a_run());
  EXPECT_THAT(text, HasSubstr("press: 2 axes, cycle 125 us, 5.000 s in operation, line state OP\n"));
  EXPECT_THAT(text, HasSubstr("  cycles              39990\n"));
  EXPECT_THAT(text, HasSubstr("  missed periods         10\n"));
  EXPECT_THAT(text, HasSubstr("  WKC errors              3\n"));
  EXPECT_THAT(text, HasSubstr("  lost frames             4 (3 of them came late)\n"));
  EXPECT_THAT(text, HasSubstr("  flooded cycles          6   (too many frames of other senders)\n"));
  EXPECT_THAT(text, HasSubstr("  longest absence       1.4 ms, at 0.850 s\n"));
  EXPECT_THAT(text, HasSubstr("  path late             2.0 ms\n"));
  EXPECT_THAT(text, HasSubstr("  wake-up latency             0.1      0.1      0.1      0.1\n"));
  EXPECT_THAT(text, HasSubstr("  cycle cost                  8.0      8.0      8.0      8.0\n"));
  EXPECT_THAT(text, HasSubstr("  following error slave        maximum           RMS\n"
                              "  x                   0       0.12 rad    0.0305 rad\n"
                              "  z                   3       0.008 mm      0.002 mm\n"));
  EXPECT_THAT(text, HasSubstr("telemetry: 80000 axis samples published, 5 dropped, bridge restarted 2 times\n"));
  EXPECT_THAT(text, HasSubstr("  fault: out/axes.csv: cannot be written: No space left on device\n"));
  EXPECT_THAT(text, HasSubstr("out/axes.csv\n"));
}

TEST(RunReport, IncrementsStandBesideUnitsOnRequest) {
  auto report = report_of_a_run();
  EXPECT_THAT(to_text(report), Not(HasSubstr(" inc")));
  report.increments = true;
  EXPECT_THAT(to_text(report), HasSubstr("  x                   0       0.12 rad    0.0305 rad         120.0 inc"
                                         "         30.50 inc\n"));
}

TEST(RunReport, RingTellsHalvesThatWereLateFromTheOthers) {
  auto report = report_of_a_run();
  report.ring = {{port::RingStatus::State::kClosed}, 900, 5, 3};
  EXPECT_EQ(to_json(report)["ring"],
            json::parse(R"({"state": "closed", "merged": 900, "halves": 5, "late_halves": 3})"));
  EXPECT_THAT(
      to_text(report),
      HasSubstr(
          "  ring: closed; 900 answers combined from two halves, 5 halves stayed single (3 waits without result)\n"));
}

TEST(RunReport, TellsWhatItsInterfacesWereOpenedWithAndWhyWithNothingFaster) {
  auto report = report_of_a_run();
  EXPECT_FALSE(to_json(report).contains("interfaces"));
  report.interfaces = {{"eth1", "AF_XDP, native, copied", {"No zero copy."}}};
  EXPECT_EQ(to_json(report)["interfaces"],
            json::parse(R"([{"name": "eth1", "port": "AF_XDP, native, copied", "steps_down": ["No zero copy."]}])"));
  EXPECT_THAT(to_text(report), HasSubstr("  interface eth1: AF_XDP, native, copied\n"));
}

TEST(RunReport, TheRoundTripOfAModelIsNoMeasurement) {
  auto report = report_of_a_run();
  EXPECT_THAT(to_text(report), HasSubstr("  round trip                  0.1"));
  report.round_trip_modelled = true;
  EXPECT_THAT(to_text(report), HasSubstr("  round trip (modelled)       0.1"));
  EXPECT_EQ(to_json(report)["round_trip_modelled"], true);
}

TEST(RunReport, TellsWhatTheKernelHasCountedOfTheThreadOfTheCycle) {
  auto report = report_of_a_run();
  EXPECT_THAT(to_text(report), Not(HasSubstr("thread of the cycle"))) << "it had none of its own";
  report.thread = rt::ThreadUsage{12, 1, 40'010, 31};
  report.wake_ahead = nanoseconds{14'230};
  EXPECT_EQ(to_json(report)["realtime_thread"], json::parse(R"({"minor_faults": 12, "major_faults": 1,
    "voluntary_switches": 40010, "involuntary_switches": 31, "wake_ahead_ns": 14230})"));
  EXPECT_THAT(to_text(report), HasSubstr("thread of the cycle: 13 page faults (1 from disk), it woke 14.2 us ahead\n"
                                         "    context switches   40010 voluntary, 31 involuntary\n"));
}

TEST(RunReport, TextSaysWhenTelemetryWasOff) {
  auto report = report_of_a_run();
  report.telemetry.reset();
  EXPECT_THAT(to_text(report), HasSubstr("telemetry: off\n"));
  EXPECT_THAT(to_text(report), Not(HasSubstr("published")));
}

TEST(RunReport, LineWithoutAxesShowsItsInputs) {
  auto report = report_of_a_run();
  EXPECT_THAT(to_text(report), Not(HasSubstr("inputs at the end")));
  report.inputs = {{"slave0.Statusword", 0x6041, 0, 16, 0x0250}, {"slave1.Blob", 0x7000, 1, 128, std::nullopt}};
  EXPECT_THAT(to_text(report), HasSubstr("  inputs at the end\n"
                                         "  slave0.Statusword  6041h:00   16 bit  0x0250 592\n"
                                         "  slave1.Blob        7000h:01  128 bit\n"));
  const auto rows = to_json(report)["inputs"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0],
            (json{{"name", "slave0.Statusword"}, {"index", 0x6041}, {"subindex", 0}, {"bits", 16}, {"value", 0x250}}));
  EXPECT_TRUE(rows[1]["value"].is_null());
}

TEST(RunReport, ClocksAreInTheDocument) {
  runtime::RunReport report;
  report.clocks.emplace();
  report.clocks->locked = true;
  EXPECT_EQ(to_json(report)["dc"].dump(), R"({"difference_ns":{"max":null,"p50":null,"p99":null},"locked":true})")
      << "the reference clock alone";
  for (int i = 1; i <= 100; ++i) report.clocks->differences.record(nanoseconds{i});
  EXPECT_EQ(to_json(report)["dc"].dump(), R"({"difference_ns":{"max":100,"p50":50,"p99":99},"locked":true})");
  EXPECT_NE(to_text(report).find("clocks: locked; slaves off the reference clock by p50 50 ns"), std::string::npos);
}

TEST(ClockReport, TellsPhaseAndMarginsWhereThereAreSome) {
  runtime::RunReport report;
  auto clocks = std::make_unique<runtime::ClockReport>();  // on the stack the compiler warns of what it inlines
  clocks->phase_errors.record(nanoseconds{7});
  clocks->margins.push_back({"x", {nanoseconds{58'500}, nanoseconds{60'000}, 3}});
  report.clocks = std::move(*clocks);
  const auto document = to_json(report)["dc"];
  EXPECT_EQ(document["phase_error_ns"].dump(), R"({"max":7,"p50":7,"p99":7})");
  EXPECT_EQ(document["sync0_margin"].dump(), R"([{"max_ns":60000,"min_ns":58500,"missed":3,"slave":"x"}])");
  const auto text = to_text(report);
  EXPECT_NE(text.find("outputs before SYNC0"), std::string::npos);
  EXPECT_NE(text.find("58.5        60.0"), std::string::npos);
}

}  // namespace
}  // namespace driveline::cli
