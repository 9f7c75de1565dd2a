#include "text/run_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "driveline/runtime/event.hpp"
#include "text/can_report.hpp"
#include "text/eoe_view.hpp"
#include "text/histogram_json.hpp"
#include "text/image_view.hpp"
#include "text/input_values.hpp"
#include "text/machine_json.hpp"
#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

nlohmann::json three_percentiles(const rt::Histogram& histogram) {
  if (histogram.count() == 0) return {{"p50", nullptr}, {"p99", nullptr}, {"max", nullptr}};
  return {{"p50", histogram.percentile(0.5).count()},
          {"p99", histogram.percentile(0.99).count()},
          {"max", histogram.max().count()}};
}

/// Time between the arrival of the outputs and SYNC0, as measured by the drives.
std::string margins_to_text(const std::vector<runtime::ClockReport::Margin>& margins) {
  if (margins.empty()) return {};
  auto us = [](std::chrono::nanoseconds value) { return static_cast<double>(value.count()) / 1000.0; };
  std::string text = fmt::format("\n  {:<28}{:>12}{:>12}{:>24}\n", "outputs before SYNC0", "least us", "most us",
                                 "SYNC0 without outputs");
  for (const auto& [slave, report] : margins) {
    text += fmt::format("  {:<28}{:>12.1f}{:>12.1f}{:>24}\n", slave, us(report.shortest), us(report.longest),
                        report.missed);
  }
  return text;
}

/// Without clocks, or with the reference clock alone, there is no lock and no difference to report.
nlohmann::json clocks_to_json(const std::optional<runtime::ClockReport>& clocks) {
  nlohmann::json document = {{"locked", clocks && clocks->locked},
                             {"difference_ns", three_percentiles(clocks ? clocks->differences : rt::Histogram{})}};
  if (!clocks) return document;
  if (clocks->phase_errors.count() > 0) document["phase_error_ns"] = three_percentiles(clocks->phase_errors);
  for (const auto& [slave, report] : clocks->margins) {
    document["sync0_margin"].push_back({{"slave", slave},
                                        {"min_ns", report.shortest.count()},
                                        {"max_ns", report.longest.count()},
                                        {"missed", report.missed}});
  }
  return document;
}

std::string_view ring_state(port::RingStatus::State state) {
  using State = port::RingStatus::State;
  return state == State::kOpen ? "open" : state == State::kClosed ? "closed" : "unknown";
}

std::string ring_to_text(const runtime::RingReport& ring) {
  return fmt::format(
      "\n  ring: {}; {} answers combined from two halves, {} halves stayed single ({} waits without result)\n",
      ring_state(ring.status.state), ring.merged, ring.halves, ring.late_halves);
}

/// Events in operation, with their time. Files that could not be written afterwards are among the faults.
std::vector<std::string> events_of(const runtime::RunReport& report) {
  std::vector<std::string> sentences;
  for (const auto& event : report.events) {
    if (event.time) sentences.push_back(runtime::describe_with_time(event, report.increments));
  }
  return sentences;
}

/// Absences of the master that the motion bridged. Each was printed when it happened, so the text has their sum.
struct Absences {
  std::uint64_t count = 0;
  std::chrono::nanoseconds total{};
  std::chrono::nanoseconds longest{};

  /// Returns whether the event is one of them.
  bool add(const runtime::Event& event) {
    if (event.is_fault()) return false;
    if (const auto* away = event.as<runtime::events::MasterAway>()) {
      ++count;
      total += away->absence.duration;
      longest = std::max(longest, away->absence.duration);
      return true;
    }
    const auto* often = event.as<runtime::events::MasterAwayOften>();
    if (often == nullptr) return false;
    count += often->count;
    total += often->total;
    longest = std::max(longest, often->longest);
    return true;
  }
};

/// An event in lines of a terminal, further ones indented below the sentence.
std::string event_lines(const runtime::Event& event, bool increments) {
  const auto seconds = std::chrono::duration<double>(event.time.value_or(std::chrono::nanoseconds{0})).count();
  return wrapped(fmt::format("  {:.3f} s ", seconds), runtime::describe(event, increments)) + '\n';
}

std::string events_to_text(const runtime::RunReport& report) {
  std::string text;
  Absences absences;
  for (const auto& event : report.events) {
    if (event.time && !absences.add(event)) text += event_lines(event, report.increments);
  }
  if (absences.count == 0) return text;
  const auto ms = [](std::chrono::nanoseconds time) { return static_cast<double>(time.count()) / 1e6; };
  return fmt::format("  the master was away {} time{}, {:.1f} ms in all, {:.1f} ms at the longest\n", absences.count,
                     absences.count == 1 ? "" : "s", ms(absences.total), ms(absences.longest)) +
         text;
}

std::vector<std::string> faults_of(const runtime::RunReport& report) {
  std::vector<std::string> sentences;
  for (const auto& event : report.events) {
    if (event.is_fault()) sentences.push_back(runtime::describe(event, report.increments));
  }
  return sentences;
}

/// Seconds in operation; null: the master was never away.
nlohmann::json absence_at(const runtime::RunReport& report) {
  if (report.statistics.longest_absence.count() == 0) return nullptr;
  return report.longest_absence_at_s;
}

std::string row(std::string_view name, const rt::Histogram& histogram) {
  auto us = [](std::chrono::nanoseconds value) { return static_cast<double>(value.count()) / 1000.0; };
  return fmt::format("  {:<22}{:>9.1f}{:>9.1f}{:>9.1f}{:>9.1f}\n", name, us(histogram.percentile(0.5)),
                     us(histogram.percentile(0.99)), us(histogram.percentile(0.999)), us(histogram.max()));
}

/// Following errors in the units of the axes, those reported by the drives and, if requested, increments.
std::string axes_to_text(const std::vector<runtime::AxisRunReport>& axes, bool increments) {
  constexpr std::string_view kTitle = "following error";
  // With the value of the drive, a row is as wide as a terminal: a longer name is cut.
  constexpr auto kWidestName = kTitle.size();
  auto text = fmt::format("\n  {}{:>6}{:>15}{:>14}\n", kTitle, "slave", "maximum", "RMS");
  for (const auto& axis : axes) {
    const auto shown = [&axis](double length) {
      return fmt::format("{:.4g} {}", length / axis.increments_per_unit, axis.unit);
    };
    text += fmt::format("  {:<{}}{:>6}{:>15}{:>14}", shortened(axis.name, kWidestName), kWidestName,
                        axis.slave ? fmt::format("{}", *axis.slave) : "-", shown(axis.following_error_max),
                        shown(axis.following_error_rms));
    if (increments)
      text += fmt::format("{:>14.1f} inc{:>14.2f} inc", axis.following_error_max, axis.following_error_rms);
    if (axis.by_drive) {
      text += fmt::format("  (60F4h: max {}{})", shown(axis.by_drive->maximum),
                          increments ? fmt::format(", {:.1f} inc", axis.by_drive->maximum) : std::string{});
    }
    text += "\n";
  }
  return text;
}

nlohmann::json telemetry_to_json(const std::optional<runtime::TelemetryReport>& telemetry) {
  const auto report = telemetry.value_or(runtime::TelemetryReport{});
  return {{"published", report.published}, {"dropped", report.dropped}, {"restarts", report.restarts}};
}

std::string telemetry_to_text(const std::optional<runtime::TelemetryReport>& telemetry) {
  if (!telemetry) return "\n  telemetry: off\n";
  auto text =
      fmt::format("\n  telemetry: {} axis samples published, {} dropped", telemetry->published, telemetry->dropped);
  if (telemetry->restarts > 0) text += fmt::format(", bridge restarted {} times", telemetry->restarts);
  return text + "\n";
}

nlohmann::json thread_to_json(const runtime::RunReport& report) {
  const auto& thread = report.thread;
  if (!thread) return nullptr;
  return {{"minor_faults", thread->minor_faults},
          {"major_faults", thread->major_faults},
          {"voluntary_switches", thread->voluntary_switches},
          {"involuntary_switches", thread->involuntary_switches},
          {"wake_ahead_ns", report.wake_ahead.count()}};
}

std::string thread_to_text(const rt::ThreadUsage& thread, std::chrono::nanoseconds wake_ahead) {
  return fmt::format(
      "\n  thread of the cycle: {} page faults ({} from disk), it woke {:.1f} us ahead\n"
      "    context switches   {} voluntary, {} involuntary\n",
      thread.minor_faults + thread.major_faults, thread.major_faults, static_cast<double>(wake_ahead.count()) / 1000.0,
      thread.voluntary_switches, thread.involuntary_switches);
}

nlohmann::json interfaces_to_json(const std::vector<runtime::InterfaceReport>& interfaces) {
  auto rows = nlohmann::json::array();
  for (const auto& interface : interfaces) {
    rows.push_back({{"name", interface.name}, {"port", interface.access_method}, {"steps_down", interface.steps_down}});
  }
  return rows;
}

std::string_view change_text(runtime::LeaseChange::Kind kind) {
  using Kind = runtime::LeaseChange::Kind;
  switch (kind) {
    case Kind::kTaken:
      return "taken";
    case Kind::kTakenOver:
      return "taken over";
    case Kind::kReleased:
      return "released";
    case Kind::kExpired:
      break;
  }
  return "expired";
}

nlohmann::json groups_to_json(const std::vector<runtime::AxisGroupRunReport>& groups) {
  auto rows = nlohmann::json::array();
  for (const auto& group : groups) {
    nlohmann::json row = {{"name", group.name}, {"axes", group.axes}, {"state", group.state}, {"owner", group.owner}};
    if (group.machine) {
      row["kinematics"] = cli::to_json(*group.machine);
      row["coordinates"] = cli::to_json(group.coordinates, group.place);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string groups_to_text(const std::vector<runtime::AxisGroupRunReport>& groups) {
  std::string text = groups.empty() ? "" : "\n";
  for (const auto& group : groups) {
    std::string place;
    for (std::size_t i = 0; group.machine && i < group.place.size(); ++i) {
      const auto& coordinate = group.coordinates[i];
      place += fmt::format("{}{} {:.6g} {}", i == 0 ? " at " : ", ", coordinate.name,
                           coordinate.unit.from_si(group.place[i]), coordinate.unit.name);
    }
    text += fmt::format("  group {} ({}{}): {}{}\n", group.name, group.machine ? group.machine->kind() + ": " : "",
                        fmt::join(group.axes, ", "), group.state.empty() ? "not commanded" : group.state, place);
  }
  return text;
}

nlohmann::json authority_to_json(const std::vector<runtime::AuthorityRecord>& records) {
  auto rows = nlohmann::json::array();
  for (const auto& record : records) {
    rows.push_back({{"time_s", record.time_s},
                    {"axis", record.axis},
                    {"change", std::string(change_text(record.change.kind))},
                    {"owner", record.change.owner},
                    {"before", record.change.before}});
  }
  return rows;
}

nlohmann::json axes_to_json(const std::vector<runtime::AxisRunReport>& axes) {
  auto rows = nlohmann::json::array();
  for (const auto& axis : axes) {
    rows.push_back({{"name", axis.name},
                    {"slave", axis.slave ? nlohmann::json(*axis.slave) : nlohmann::json()},
                    {"owner", axis.owner},
                    {"following_error_max", axis.following_error_max},
                    {"following_error_rms", axis.following_error_rms},
                    {"path_error_max", axis.path_error.maximum},
                    {"path_error_rms", axis.path_error.rms},
                    {"unit", "increments"},
                    {"position_unit", axis.unit},
                    {"increments_per_position_unit", axis.increments_per_unit},
                    {"unavailable_cycles", axis.unavailable_cycles}});
    if (!axis.by_drive) continue;
    rows.back()["drive_following_error_max"] = axis.by_drive->maximum;
    rows.back()["drive_following_error_rms"] = axis.by_drive->rms;
  }
  return rows;
}

/// Adds what only some lines have.
void add_parts(nlohmann::json& document, const runtime::RunReport& report) {
  if (!report.interfaces.empty()) document["interfaces"] = interfaces_to_json(report.interfaces);
  if (!report.axis_groups.empty()) document["axis_groups"] = groups_to_json(report.axis_groups);
  if (report.ring) {
    document["ring"] = {{"state", ring_state(report.ring->status.state)},
                        {"merged", report.ring->merged},
                        {"halves", report.ring->halves},
                        {"late_halves", report.ring->late_halves}};
  }
  if (report.can) document["can"] = can_to_json(report);
  if (report.process_data) document["process_data"] = cli::to_json(*report.process_data);
  if (report.eoe) document["eoe"] = cli::to_json(*report.eoe);
  if (!report.gateway_clients.empty()) document["gateway"] = cli::to_json(report.gateway_clients);
  if (report.events_left_out > 0) document["events_left_out"] = report.events_left_out;
  if (!report.authority.empty()) document["authority"] = authority_to_json(report.authority);
  if (!report.inputs.empty()) document["inputs"] = cli::to_json(report.inputs);
}

std::string counters_to_text(const runtime::RunReport& report) {
  const auto& statistics = report.statistics;
  std::string text =
      fmt::format("  cycles {:>18}\n  missed periods {:>10}\n  {} {:>{}}\n  lost frames {:>13}", statistics.cycles,
                  statistics.missed_periods, report.can ? "lost answers" : "WKC errors", statistics.wkc_errors,
                  report.can ? 12 : 14, statistics.lost_frames);
  // Frames that arrived after their deadline were not lost on the wire.
  if (statistics.late_frames > 0) text += fmt::format(" ({} of them came late)", statistics.late_frames);
  text += "\n";
  if (statistics.flooded_cycles > 0)
    text += fmt::format("  flooded cycles {:>10}   (too many frames of other senders)\n", statistics.flooded_cycles);
  if (const auto longest = statistics.longest_absence; longest.count() > 0) {
    text += fmt::format("  longest absence {:>9.1f} ms, at {:.3f} s\n", static_cast<double>(longest.count()) / 1e6,
                        report.longest_absence_at_s);
  }
  if (report.path_late.count() > 0) {
    text += fmt::format("  path late {:>15.1f} ms\n", static_cast<double>(report.path_late.count()) / 1e6);
  }
  return text;
}

std::string times_to_text(const runtime::RunReport& report) {
  const auto& statistics = report.statistics;
  auto text = fmt::format("  {:<22}{:>9}{:>9}{:>9}{:>9}\n", "time in us", "p50", "p99", "p99.9", "max");
  text += row("wake-up latency", statistics.wake_latency) + row("cycle cost", statistics.cost) +
          row(report.round_trip_modelled ? "round trip (modelled)" : "round trip", statistics.round_trip);
  if (report.thread) text += thread_to_text(*report.thread, report.wake_ahead);
  if (!report.clocks) return text;
  const auto& differences = report.clocks->differences;
  text += fmt::format("\n  clocks: {}; slaves off the reference clock by p50 {} ns, p99 {} ns, max {} ns\n",
                      report.clocks->locked ? "locked" : "NOT LOCKED", differences.percentile(0.5).count(),
                      differences.percentile(0.99).count(), differences.max().count());
  return text + margins_to_text(report.clocks->margins);
}

std::string endpoints_to_text(const runtime::RunReport& report) {
  auto text = telemetry_to_text(report.telemetry);
  if (report.eoe) text += fmt::format("\n  EoE\n{}\n", to_text(*report.eoe));
  if (report.gateway_clients.empty()) return text;
  return text + fmt::format("\n  mailbox gateway\n{}\n", to_text(report.gateway_clients));
}

}  // namespace

nlohmann::json to_json(const runtime::RunReport& report) {
  const auto& statistics = report.statistics;
  nlohmann::json files = nlohmann::json::object();
  for (const auto& [key, path] : report.files) files[key] = path.string();
  nlohmann::json document = {{"state", report.state},
                             {"axes_count", report.axes.size()},
                             {"cycle_ns", report.period.count()},
                             {"duration_s", report.duration_s},
                             {"cycles", statistics.cycles},
                             {"missed_periods", statistics.missed_periods},
                             {"wkc_errors", statistics.wkc_errors},
                             {"lost_frames", statistics.lost_frames},
                             {"late_frames", statistics.late_frames},
                             {"flooded_cycles", statistics.flooded_cycles},
                             {"longest_absence_ns", statistics.longest_absence.count()},
                             {"longest_absence_at_s", absence_at(report)},
                             {"path_late_ns", report.path_late.count()},
                             {"wake_latency_ns", percentiles_json(statistics.wake_latency)},
                             {"cycle_cost_ns", percentiles_json(statistics.cost)},
                             {"round_trip_ns", percentiles_json(statistics.round_trip)},
                             {"round_trip_modelled", report.round_trip_modelled},
                             {"realtime_thread", thread_to_json(report)},
                             {"dc", clocks_to_json(report.clocks)},
                             {"axes", axes_to_json(report.axes)},
                             {"telemetry", telemetry_to_json(report.telemetry)},
                             {"faults", faults_of(report)},
                             {"events", events_of(report)},
                             {"recoveries", report.recoveries},
                             {"files", std::move(files)}};
  add_parts(document, report);
  return document;
}

std::string to_text(const runtime::RunReport& report) {
  std::string text = fmt::format("\n{}: {} axes, cycle {} us, {:.3f} s in operation, line state {}\n\n", report.line,
                                 report.axes.size(), static_cast<double>(report.period.count()) / 1000.0,
                                 report.duration_s, report.state);
  text += counters_to_text(report) + '\n' + times_to_text(report);
  for (const auto& interface : report.interfaces) {
    text += fmt::format("\n  interface {}: {}\n", interface.name, interface.access_method);
  }
  if (report.ring) text += ring_to_text(*report.ring);
  text += can_to_text(report);
  if (report.process_data) text += fmt::format("\n{}", to_text(*report.process_data));
  if (!report.inputs.empty()) text += fmt::format("\n  inputs at the end\n{}", to_text(report.inputs));
  if (!report.axes.empty()) {
    text += axes_to_text(report.axes, report.increments);
  }
  text += groups_to_text(report.axis_groups);
  text += endpoints_to_text(report);
  text += events_to_text(report);
  if (report.events_left_out > 0)
    text +=
        fmt::format("  {} more events between the first and the last ones are not stored\n", report.events_left_out);
  for (const auto& fault : faults_of(report)) text += wrapped("  fault: ", fault) + '\n';
  for (const auto& [key, path] : report.files) text += fmt::format("  {:<22}{}\n", key, path.string());
  return text;
}

}  // namespace driveline::cli
