#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <deque>
#include <map>
#include <optional>

#include "client.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "subscription.hpp"
#include "text.hpp"

namespace driveline::bridge::clients {
namespace {

constexpr double kPeriodSeconds = 0.5;
// for a single page: longest wait for axes and events after the line was found
constexpr double kRestPatienceSeconds = 2;
constexpr std::size_t kEvents = 8;
constexpr std::chrono::seconds kSilence{2};  // the status is published ten times per second

/// A stored sample.
struct Kept {
  std::vector<std::uint8_t> bytes;
  Value value;  ///< its strings point into `bytes`
};

std::string mode_name(std::int64_t mode) {
  static const std::map<std::int64_t, std::string_view> kNames{{1, "PP"}, {3, "PV"},  {4, "PT"},  {6, "HM"},
                                                               {7, "IP"}, {8, "CSP"}, {9, "CSV"}, {10, "CST"}};
  const auto found = kNames.find(mode);
  return found == kNames.end() ? fmt::format("{}", mode) : std::string(found->second);
}

/// Returns e.g. "OPERATION ENABLED" for "AXIS_OPERATION_ENABLED".
std::string state_name(const Value& state) {
  auto name = std::string(state.text().substr(std::min(state.text().find('_'), state.text().size() - 1) + 1));
  for (auto& c : name) {
    if (c == '_') c = ' ';
  }
  return name.empty() ? fmt::format("{}", state.whole()) : name;
}

std::string times(const Value& percentiles) {
  const auto us = [&](std::string_view name) { return percentiles.find(name)->number() * 1e-3; };
  return fmt::format("p50 {:.1f} us, p99 {:.1f} us, max {:.1f} us", us("p50_ns"), us("p99_ns"), us("max_ns"));
}

/// Present data of a line, and its page.
class LinePage {
 public:
  /// `units` must outlive the page.
  explicit LinePage(const DisplayUnits& units) : units_(units) {}

  void add(const Sample& sample) {
    Kept kept{{sample.bytes.begin(), sample.bytes.end()}, {}};
    auto value = decode(*sample.topic->structure, kept.bytes);
    if (!value) {
      other_version_ = true;
      return;
    }
    kept.value = *std::move(value);
    if (const auto* axis = kept.value.find("actual_position"); axis != nullptr) {
      const auto number = kept.value.find("axis")->whole();
      axes_.insert_or_assign(number, std::move(kept));
    } else if (kept.value.find("severity") != nullptr) {
      add_event(std::move(kept));
    } else {
      status_ = std::move(kept);
      status_at_ = Clock::now();
    }
  }

  [[nodiscard]] bool known() const { return status_.has_value(); }
  [[nodiscard]] bool complete() const { return known() && axes_.size() >= number("axes") && !events_.empty(); }
  [[nodiscard]] bool other_version() const { return other_version_ && !known(); }

  [[nodiscard]] std::vector<std::string> lines() const {
    auto page = head();
    page.emplace_back();
    page.push_back(
        fmt::format("{:<7}{:>16}{:>18}{:>15} {:<18} {}", "axis", "position", "velocity", "error", "state", "mode"));
    for (const auto& [number, axis] : axes_) page.push_back(axis_line(axis.value));
    const auto& faults = status_->value.find("faults")->parts;
    if (!faults.empty()) page.insert(page.end(), {"", "faults"});
    for (const auto& fault : faults) page.push_back("  " + visible(fault.text()));
    if (!events_.empty()) page.insert(page.end(), {"", "events"});
    for (const auto& event : events_) page.push_back(event_line(event.value));
    return page;
  }

 private:
  [[nodiscard]] const Value& field(std::string_view name) const { return *status_->value.find(name); }
  [[nodiscard]] std::uint64_t number(std::string_view name) const { return field(name).whole(); }

  void add_event(Kept event) {
    // After a restart of the bridge the last events arrive again; a new run has the same numbers at other times.
    const auto same = [&](const Kept& other) {
      const auto equal = [&](const char* field) {
        return other.value.find(field)->whole() == event.value.find(field)->whole();
      };
      return equal("number") && equal("wall_time_ns");
    };
    if (std::any_of(events_.begin(), events_.end(), same)) return;
    events_.push_back(std::move(event));
    if (events_.size() > kEvents) events_.pop_front();
  }

  [[nodiscard]] std::vector<std::string> head() const {
    const auto silent = Clock::now() - status_at_;
    const auto state = silent < kSilence
                           ? state_name(field("state"))
                           : fmt::format("no sample has arrived for {} s",
                                         std::chrono::duration_cast<std::chrono::seconds>(silent).count());
    return {
        fmt::format("{}: {}, cycle {} of {:.9g} us", visible(field("name").text()), state, number("cycle"),
                    field("cycle_period_ns").number() * 1e-3),
        fmt::format("{} cycles, {} periods missed, {} working counter errors, {} frames lost", number("cycles"),
                    number("missed_periods"), number("wkc_errors"), number("lost_frames")),
        "wake-up  " + times(field("wake_latency")),
        "cost     " + times(field("cycle_cost")),
        fmt::format("clocks   {}", number("dc_locked") != 0
                                       ? fmt::format("locked, {} ns off", field("dc_difference_ns").number())
                                       : std::string("not locked")),
        fmt::format("samples  {} published, {} dropped", number("telemetry_published"), number("telemetry_dropped"))};
  }

  /// A line of 80 columns, unless a name or a number is long.
  [[nodiscard]] std::string axis_line(const Value& axis) const {
    const auto name = std::string(axis.find("name")->text());
    const auto& unit = units_.of(name, axis.find("kind")->text() == "AXIS_LINEAR");
    const auto value = [&](std::string_view field) { return axis.find(field)->number(); };
    const auto shown = [&](std::string_view field) { return value(field) / unit.si; };
    return fmt::format("{:<7}{:>12.6f} {:<3}{:>12.6f} {:<5}{:>11.3e} {:<3} {:<18} {}", visible(name),
                       shown("actual_position"), unit.name, shown("actual_velocity"), fmt::format("{}/s", unit.name),
                       shown("following_error"), unit.name, state_name(*axis.find("state")),
                       mode_name(static_cast<std::int64_t>(value("mode"))));
  }

  static std::string event_line(const Value& event) {
    const auto at_ns = static_cast<std::int64_t>(event.find("wall_time_ns")->whole());
    const auto grave = event.find("severity")->text();
    const auto* const word = grave == "EVENT_FAULT" ? "fault: " : grave == "EVENT_FAILURE" ? "FAILURE: " : "";
    return fmt::format("  {:%H:%M:%S}.{:03}  {}{}", fmt::localtime(static_cast<std::time_t>(at_ns / 1'000'000'000)),
                       at_ns / 1'000'000 % 1000, word, visible(event.find("text")->text()));
  }

  const DisplayUnits& units_;
  std::optional<Kept> status_;
  Clock::time_point status_at_;
  std::map<std::uint64_t, Kept> axes_;
  std::deque<Kept> events_;
  bool other_version_ = false;
};

/// Prints pages one after the other, on a terminal at the same position (ECMA-48 control sequences).
class Screen {
 public:
  Outcome<void> show(const std::vector<std::string>& page) {
    std::string text = terminal_ ? "\x1B[?7l\x1B[H" : "";  // no wrapping; start at the top
    const auto rows = most_rows();
    for (std::size_t i = 0; i < page.size() && i < rows; ++i) text += page[i] + (terminal_ ? "\x1B[K\n" : "\n");
    text += terminal_ ? "\x1B[J\x1B[?7h" : "\n";  // clear the rest
    return print(text);
  }

 private:
  [[nodiscard]] std::size_t most_rows() const {
    winsize size = {};
    const bool known = terminal_ && ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1;
    return known ? size.ws_row - 1U : SIZE_MAX;
  }

  bool terminal_ = ::isatty(STDOUT_FILENO) != 0;
};

}  // namespace

Outcome<int> top(const Options& options) {
  const auto chosen = select_topics({"driveline/line_status", "driveline/axis_telemetry", "driveline/v1/event"});
  if (!chosen) return tl::unexpected(chosen.error());
  auto subscription = Subscription::create(options.place, *chosen);
  if (!subscription) return tl::unexpected(subscription.error());
  LinePage page(options.units);
  const auto patience_s = options.timeout_s.value_or(kDefaultTimeoutSeconds);
  const auto patience = after(patience_s);
  auto rest_patience = Clock::time_point::max();
  auto next = Clock::now();
  Screen screen;
  while (!rt::stop_requested()) {
    subscription->take(kWait, [&](const Sample& sample) { page.add(sample); });
    if (!page.known()) {
      if (Clock::now() < patience) continue;
      if (page.other_version()) return failed("a line of another version publishes in " + options.place.text());
      return failed(
          fmt::format("no line publishes in {}: no sample arrived for {} s", options.place.text(), patience_s));
    }
    if (rest_patience == Clock::time_point::max()) rest_patience = after(kRestPatienceSeconds);
    if (options.once) {
      if (!page.complete() && Clock::now() < rest_patience) continue;
      for (const auto& line : page.lines()) {
        if (auto told = print(line + '\n'); !told) return tl::unexpected(told.error());
      }
      return 0;
    }
    if (Clock::now() < next) continue;
    next = after(options.period_s.value_or(kPeriodSeconds));
    if (auto shown = screen.show(page.lines()); !shown) return tl::unexpected(shown.error());
  }
  return 0;
}

}  // namespace driveline::bridge::clients
