#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "axes/quantity.hpp"
#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/runtime/record/sync_margins.hpp"
#include "driveline/runtime/setup/clock_plan.hpp"
#include "driveline/runtime/setup/clock_text.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "line/mailbox_registers.hpp"
#include "text/json_text.hpp"
#include "text/plots.hpp"
#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::dc::DelayQuality;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// Interval between two readings of the clock differences.
constexpr auto kReadInterval = milliseconds{5};
constexpr double kDefaultSeconds = 3.0;
/// The other columns of the table leave this to a name.
constexpr std::size_t kNameColumns = 11;
/// Cycle of the master without a file: only the clocks depend on it, and its lock window, a hundredth of it, is wide
/// enough for the wake-ups of an ordinary machine.
constexpr auto kDefaultPeriod = milliseconds{1};

struct DcOptions {
  runtime::BusOptions bus;
  std::optional<std::string> duration;
  std::string output_directory;
  bool no_plots = false;
  bool operational = false;
  bool force = false;
  bool json = false;
};

std::string_view to_text(DelayQuality quality) {
  switch (quality) {
    case DelayQuality::kMeasured:
      return "measured";
    case DelayQuality::kEstimated:
      return "estimated";
    case DelayQuality::kAssumed:
      return "assumed";
    case DelayQuality::kNone:
      break;
  }
  return "-";
}

/// Synchronises and observes the clocks of a line for some time, in PREOP or (--op) in OP.
class ClockSession {
 public:
  ClockSession(runtime::Session& session, const DcOptions& options)
      : session_(session), options_(options), master_(session.port(), session.clock()) {}

  [[nodiscard]] Outcome<int> run(double seconds) {
    if (auto done = bring_up(); !done) return tl::unexpected(done.error());
    auto watched = watch(seconds);
    auto files = watched ? write_files() : Outcome<std::map<std::string, std::filesystem::path>>{};
    if (watched) print_out("{}", options_.json ? json_text(document(*files)) : table(*files));
    const auto down = master_.shut_down();
    if (!watched) return tl::unexpected(watched.error());
    if (!files) return tl::unexpected(files.error());
    if (!down) return bus_failure(down.error());
    if (!status_.locked)
      return failed(runtime::with_clock_remedy(ecat_master::dc::not_locked(status_, *master_.clock_follower())));
    return 0;
  }

 private:
  /// A line description sets the cycle, because its drives need it.
  [[nodiscard]] nanoseconds period() const {
    return session_.has_config() ? session_.config().period : nanoseconds{kDefaultPeriod};
  }

  [[nodiscard]] Outcome<void> bring_up() {
    if (auto free = must_not_be_driven(session_, master_, options_.force); !free) return free;
    if (auto done = master_.scan(); !done) return bus_failure(done.error());
    if (!options_.operational) {
      if (auto done = master_.enter_pre_op(); !done) return bus_failure(done.error());
    }
    ecat_master::dc::ClockPlan plan;
    plan.period = period();
    plan.frame_lead = plan.period / 2;
    if (session_.config().clocks) {
      auto configured = runtime::make_clock_plan(session_.config(), master_.slaves(), session_.virtual_time());
      if (!configured) return tl::unexpected(configured.error());
      plan = std::move(*configured);
    }
    progress("{} slaves found; measuring delays, setting offsets, determining clock rates", master_.slaves().size());
    master_.use_clocks(std::move(plan));
    if (!options_.operational) {
      if (auto done = master_.synchronise_clocks(); !done) return bus_failure(done.error());
      return start_cycle();
    }
    auto plans =
        session_.has_config() ? runtime::make_slave_plans(session_.config()) : std::vector<ecat_master::SlavePlan>{};
    if (auto done = master_.configure(std::move(plans)); !done) return bus_failure(done.error());
    if (auto done = start_cycle(); !done) return done;
    if (auto done = master_.go_operational(); !done) return failed(runtime::with_clock_remedy(done.error()));
    return {};
  }

  [[nodiscard]] Outcome<void> start_cycle() {
    ecat_master::CyclicCore::Settings settings;
    settings.period = period();
    settings.receive_window = settings.period * 3 / 4;
    auto started = master_.start_cycle(nullptr, {}, settings,
                                       [this](ecat_master::CyclicCore& core) -> std::unique_ptr<motion::CycleRunner> {
                                         if (session_.virtual_time())
                                           return std::make_unique<motion::InlineRunner>(core, session_.clock());
                                         auto realtime = session_.config().realtime;
                                         realtime.policy = rt::RealtimePolicy::kDegrade;
                                         return std::make_unique<motion::RealtimeRunner>(
                                             core, session_.clock(), realtime, session_.config().wake_ahead);
                                       });
    if (!started) return failed(started.error().message());
    return {};
  }

  [[nodiscard]] Outcome<void> watch(double seconds) {
    auto& watch = *master_.clock_watch();
    const auto begin = session_.clock().now();
    auto elapsed = [&] { return std::chrono::duration<double>(session_.clock().now() - begin).count(); };
    double next_progress = 1.0;
    while (elapsed() < seconds && !rt::stop_requested()) {
      if (auto done = watch.poll(); !done) return bus_failure(done.error());
      poll();
      for (const auto& event : watch.take_events()) progress("{}", ecat_master::dc::describe(event));
      csv_ += fmt::format("{:.6f}", elapsed());
      for (const auto& clock : watch.clocks().slaves) csv_ += fmt::format(",{}", clock.difference.count());
      csv_ += '\n';
      if (elapsed() >= next_progress) {
        next_progress += 1.0;
        progress("{:6.1f} s  {}", elapsed(), status_.locked ? "locked" : "not locked");
      }
      master_.pass(kReadInterval);
    }
    poll();
    if (options_.operational) margins_ = runtime::read_sync_margins(master_);
    return {};
  }

  /// Reads state and frequency of the clock follower. The frequency is averaged, because its momentary value includes
  /// corrections of the phase.
  void poll() {
    status_ = master_.clock_follower()->status();
    if (!status_.locked) return;
    ppm_sum_ += status_.ppm;
    ++looks_locked_;
  }
  [[nodiscard]] double ppm() const { return ppm_sum_ / static_cast<double>(std::max<std::uint64_t>(looks_locked_, 1)); }

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> list;
    for (std::size_t i = 0; i < master_.slaves().size(); ++i) {
      const auto& configured = session_.config().slaves;
      list.push_back(i < configured.size() ? configured[i].name : fmt::format("slave {}", i));
    }
    return list;
  }

  [[nodiscard]] Outcome<std::map<std::string, std::filesystem::path>> write_files() const {
    std::map<std::string, std::filesystem::path> files;
    if (options_.output_directory.empty()) return files;
    const std::filesystem::path directory = options_.output_directory;
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) return failed(fmt::format("{}: cannot be created: {}", directory.string(), error.message()));
    std::string header = "time[s]";
    for (const auto& name : names()) header += fmt::format(",{}[ns]", name);
    const auto csv = directory / "clocks.csv";
    if (auto written = runtime::write_file(csv, header + '\n' + csv_); !written) return tl::unexpected(written.error());
    files["clocks_csv"] = csv;
    if (options_.no_plots) return files;
    auto drawing = draw_clocks(directory, names());
    if (!drawing) {
      progress("{}", drawing.error());
      return files;
    }
    if (drawing->problem) return tl::unexpected(*drawing->problem);
    files.merge(drawing->pictures);
    return files;
  }

  [[nodiscard]] nlohmann::json document(const std::map<std::string, std::filesystem::path>& files) {
    auto& watch = *master_.clock_watch();
    auto slaves = nlohmann::json::array();
    for (std::size_t i = 0; i < watch.clocks().slaves.size(); ++i) {
      const auto& clock = watch.clocks().slaves[i];
      const auto& differences = watch.differences(i);
      const auto* margin = margin_of(i);
      slaves.push_back({{"position", i},
                        {"clock_bits", clock.present ? (clock.wide ? 64 : 32) : 0},
                        {"reference", i == watch.clocks().reference},
                        {"delay_ns", static_cast<std::int32_t>(clock.delay)},
                        {"delay_quality", to_text(clock.quality)},
                        {"offset_ns", clock.offset},
                        {"difference_ns",
                         {{"last", clock.difference.count()},
                          {"p50", differences.percentile(0.5).count()},
                          {"p99", differences.percentile(0.99).count()},
                          {"max", differences.max().count()}}},
                        {"sync0_cycle_ns", clock.signals.sync0_cycle.count()},
                        {"sync0_shift_ns", clock.signals.sync0_shift.count()},
                        {"sync0_active", clock.signals.sync0()},
                        {"sync0_margin", margin == nullptr ? nlohmann::json()
                                                           : nlohmann::json{{"min_ns", margin->shortest.count()},
                                                                            {"max_ns", margin->longest.count()},
                                                                            {"missed", margin->missed}}}});
    }
    auto paths = nlohmann::json::object();
    for (const auto& [key, path] : files) paths[key] = path.string();
    return {{"locked", status_.locked},
            // Without a lock the correction is not the frequency difference of the clocks.
            {"ppm", status_.locked ? nlohmann::json(ppm()) : nlohmann::json()},
            {"phase_error_ns", status_.mean_error_ns},
            {"slaves", std::move(slaves)},
            {"files", std::move(paths)}};
  }

  /// The line below a slave: its SYNC0, and the outputs before it where the slave measures them; empty without SYNC0.
  [[nodiscard]] static std::string signal_line(const ecat_master::dc::SyncSignals& signals,
                                               const ecat_master::dc::SyncMarginReport* margin) {
    if (!signals.sync0()) return {};
    const auto us = [](nanoseconds time) { return static_cast<double>(time.count()) / 1000.0; };
    auto line = fmt::format("    SYNC0 {:.3f} us, shift {:.3f} us", us(signals.sync0_cycle), us(signals.sync0_shift));
    if (margin != nullptr) {
      line += fmt::format(", outputs {:.1f} to {:.1f} us before it, {} missed", us(margin->shortest),
                          us(margin->longest), margin->missed);
    }
    return line + "\n";
  }

  [[nodiscard]] std::string table(const std::map<std::string, std::filesystem::path>& files) {
    auto& watch = *master_.clock_watch();
    auto text = fmt::format("{:>3} {:<11} {:>6} {:>3} {:>8} {:<9} {:>20} {:>6} {:>6}\n", "pos", "name", "clock", "ref",
                            "delay ns", "", "offset ns", "now ns", "max ns");
    const auto list = names();
    for (std::size_t i = 0; i < list.size(); ++i) {
      const auto& clock = watch.clocks().slaves[i];
      if (!clock.present) {
        text += fmt::format("{:>3} {:<11} {:>6}\n", i, shortened(list[i], kNameColumns), "none");
        continue;
      }
      text += fmt::format("{:>3} {:<11} {:>6} {:>3} {:>8} {:<9} {:>20} {:>6} {:>6}\n", i,
                          shortened(list[i], kNameColumns), clock.wide ? "64 bit" : "32 bit",
                          i == watch.clocks().reference ? "*" : "", static_cast<std::int32_t>(clock.delay),
                          to_text(clock.quality), static_cast<std::int64_t>(clock.offset), clock.difference.count(),
                          watch.differences(i).max().count());
      text += signal_line(clock.signals, margin_of(i));
    }
    const double cycle_us = std::chrono::duration<double, std::micro>(period()).count();
    text += status_.locked
                ? '\n' +
                      wrapped("", fmt::format("the cycle of {} us is locked to the reference clock, which runs "
                                              "{:+.2f} ppm relative to this machine; phase {:+.0f} ns",
                                              cycle_us, ppm(), status_.mean_error_ns)) +
                      '\n'
                : fmt::format("\nthe cycle of {} us is NOT LOCKED to the reference clock, whose speed is not known\n",
                              cycle_us);
    for (const auto& [key, path] : files) text += fmt::format("  {:<14}{}\n", key, path.string());
    return text;
  }

  [[nodiscard]] const ecat_master::dc::SyncMarginReport* margin_of(std::size_t slave) const {
    const auto found = std::find_if(margins_.begin(), margins_.end(),
                                    [slave](const runtime::SlaveMargin& m) { return m.slave == slave; });
    return found == margins_.end() ? nullptr : &found->report;
  }

  runtime::Session& session_;
  const DcOptions& options_;
  ecat_master::Master master_;
  ecat_master::dc::ClockFollower::Status status_;  ///< at the last call of poll()
  double ppm_sum_ = 0.0;
  std::uint64_t looks_locked_ = 0;
  std::string csv_;
  std::vector<runtime::SlaveMargin> margins_;
};

Outcome<int> show_clocks(const DcOptions& options) {
  double seconds = kDefaultSeconds;
  if (options.duration) {
    const auto time = parse_time(*options.duration, "--duration");
    if (!time) return tl::unexpected(time.error());
    seconds = std::chrono::duration<double>(*time).count();
  }
  auto session = open_session(options.bus);
  if (!session) return tl::unexpected(session.error());
  rt::catch_stop_signals();
  return ClockSession(**session, options).run(seconds);
}

}  // namespace

Execute prepare_dc(Arguments& to) {
  auto options = std::make_shared<DcOptions>();
  add_bus_options(to, options->bus);
  to.option("--duration", &options->duration, Value::text("TIME"), "Duration of the observation; default: 3s");
  to.flag("--virtual", options->bus.virtual_time, "Simulated line on virtual time");
  to.option("--output", &options->output_directory, Value::folder(),
            "Folder for the difference of each clock over time");
  to.flag("--op", options->operational,
          "Take the line to OP with all outputs zero: the drives then report how long before SYNC0 outputs arrive");
  to.flag("--no-plots", options->no_plots, "Write only the CSV file");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return [options] { return show_clocks(*options); };
}

}  // namespace driveline::cli
