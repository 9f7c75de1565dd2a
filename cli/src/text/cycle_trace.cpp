#include "text/cycle_trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "driveline/rt/switch_log.hpp"
#include "driveline/runtime/files/output_file.hpp"

namespace driveline::cli {
namespace {

using motion::CyclePhase;
using motion::TracedCycle;
using nlohmann::json;
using std::chrono::nanoseconds;

constexpr int kProcess = 1;
constexpr int kCycleTrack = 1;
constexpr int kLatencyTrack = 2;
constexpr int kProcessorTrack = 3;

/// Microseconds, the unit of the format. Readers truncate to nanoseconds instead of rounding: without the correction a
/// phase would begin before the end of the previous one and be dropped.
double in_us(nanoseconds time) {
  constexpr double kNsPerUs = 1000.0;
  const double us = static_cast<double>(time.count()) / kNsPerUs;
  const bool cut_off = static_cast<std::int64_t>(us * kNsPerUs) < time.count();
  return cut_off ? std::nextafter(us, std::numeric_limits<double>::infinity()) : us;
}

json name_event(std::string_view what, int track, const std::string& name) {
  return {{"ph", "M"}, {"pid", kProcess}, {"tid", track}, {"name", what}, {"args", {{"name", name}}}};
}

/// Writes one event after another, so that the trace is never in memory a second time.
class EventWriter {
 public:
  EventWriter(std::ostream& out, nanoseconds origin) : out_(out), origin_(origin) {}

  void write(const json& event) {
    out_ << (first_ ? "\n" : ",\n") << event.dump();
    first_ = false;
  }
  /// Writes a time span on a track. `arguments`: null for none.
  void stretch(int track, std::string_view name, nanoseconds begin, nanoseconds end, const json& arguments = nullptr) {
    json event = {{"ph", "X"},
                  {"pid", kProcess},
                  {"tid", track},
                  {"name", name},
                  {"ts", in_us(begin - origin_)},
                  {"dur", in_us(end - begin)}};
    if (!arguments.is_null()) event["args"] = arguments;
    write(event);
  }

 private:
  std::ostream& out_;
  nanoseconds origin_;
  bool first_ = true;
};

void write_cycle(EventWriter& to, const TracedCycle& cycle) {
  const auto& stamps = cycle.stamps;
  json facts = {{"cycle", stamps.cycle},
                {"missed_periods", stamps.missed},
                {"wake_latency_ns", (stamps.wake - stamps.due).count()},
                {"cycle_cost_ns", stamps.cost().count()}};
  if (cycle.rank > 0) facts["worst"] = cycle.rank;
  if (stamps.wake > stamps.due) to.stretch(kLatencyTrack, "wake-up latency", stamps.due, stamps.wake);
  to.stretch(kCycleTrack, cycle.rank > 0 ? fmt::format("cycle, worst {}", cycle.rank) : "cycle", stamps.wake,
             stamps.end.back(), facts);
  auto begin = stamps.wake;
  for (std::size_t i = 0; i < motion::kCyclePhases; ++i) {
    to.stretch(kCycleTrack, name_of(static_cast<CyclePhase>(i)), begin, stamps.end[i]);
    begin = stamps.end[i];
  }
}

std::string label_of(std::int32_t thread) {
  auto name = rt::thread_name(thread);
  if (thread == 0) return name;
  return fmt::format("{} ({})", name.empty() ? "ended" : name, thread);
}

/// Writes which threads ran on the processor from the instant at which the cycle was due until its end.
void write_switches(EventWriter& to, const TracedCycle& cycle) {
  const auto& switches = cycle.switches;
  for (std::size_t i = 0; i < switches.size(); ++i) {
    const auto begin = std::max(switches[i].time, cycle.stamps.due);
    const auto end = i + 1 < switches.size() ? std::max(switches[i + 1].time, begin) : cycle.stamps.end.back();
    if (end > begin) to.stretch(kProcessorTrack, label_of(switches[i].thread), begin, end);
  }
}

}  // namespace

void write_trace_events(std::ostream& out, const runtime::RunReport& report) {
  const auto& cycles = report.trace;
  const auto ranked = std::count_if(cycles.begin(), cycles.end(), [](const auto& cycle) { return cycle.rank > 0; });
  json about = {{"line", report.line},
                {"cycle_ns", report.period.count()},
                {"cycles", cycles.size()},
                {"worst_cycles", ranked},
                {"cycles_of_the_run", report.statistics.cycles}};
  const auto& unknown = report.trace_without_switches;
  if (!unknown.empty()) about["processor"] = unknown;
  out << R"({"displayTimeUnit":"ns","otherData":)" << about.dump() << R"(,"traceEvents":[)";
  EventWriter to(out, cycles.empty() ? nanoseconds{0} : cycles.front().stamps.due);
  to.write(name_event("process_name", kCycleTrack, report.line));
  to.write(name_event("thread_name", kCycleTrack, "cycle"));
  to.write(name_event("thread_name", kLatencyTrack, "wake-up latency"));
  if (unknown.empty()) to.write(name_event("thread_name", kProcessorTrack, "processor, at the worst cycles"));
  for (const auto& cycle : cycles) {
    write_cycle(to, cycle);
    write_switches(to, cycle);
  }
  out << "\n]}\n";
}

runtime::Result<void> write_trace_file(const runtime::RunReport& report, const std::filesystem::path& file) {
  runtime::OutputFile output(file);
  write_trace_events(output.stream(), report);
  return output.complete();
}

}  // namespace driveline::cli
