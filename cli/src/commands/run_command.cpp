#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "config/axis_path.hpp"
#include "console.hpp"
#include "line/line_run.hpp"
#include "signals.hpp"
#include "text/json_text.hpp"
#include "text/plots.hpp"

namespace driveline::cli {
namespace {

/// What `run` was asked for.
struct RunOptions {
  BusOptions bus;
  std::optional<std::string> duration;
  std::string output_directory;  ///< empty: as configured
  std::string capture;           ///< empty: as configured
  std::string control;           ///< socket for `diag --control`; may be empty
  bool no_plots = false;
  bool increments = false;
  bool telemetry = false;
  bool no_telemetry = false;
  bool json = false;
  bool force = false;
};

/// What could not be written does not take the summary with it.
void note_failure(RunReport& report, const std::string& sentence) {
  progress("fault: {}", sentence);
  report.faults.push_back(sentence);
  if (report.failure.empty()) report.failure = sentence;
}

/// Files that the run leaves behind, beside axes.csv. A plot that cannot be drawn is no failure of the run.
void write_files(const LineConfig& config, RunReport& report) {
  const auto& directory = config.output.directory;
  const auto jitter = directory / "jitter.csv";
  if (auto written = write_jitter_csv(report.statistics, jitter); !written) {
    note_failure(report, written.error());
    return;
  }
  report.files["jitter_csv"] = jitter;
  if (!config.output.plots) return;
  progress("drawing the plots");
  auto pictures = draw_plots(directory, report.files.count("axes_csv") != 0 ? report.axes : std::vector<AxisReport>{},
                             report.increments);
  if (pictures) {
    report.files.merge(*pictures);
  } else {
    progress("{}", pictures.error());
  }
}

/// Without a description there is nothing to publish, and nobody has said what the machine can do.
void use_modest_cycle(LineConfig& config) {
  config.period = std::chrono::milliseconds{1};
  config.realtime.policy = rt::RealtimePolicy::kDegrade;
  config.telemetry.enabled = false;
}

Outcome<int> run_line(const RunOptions& options) {
  catch_stop_signals();
  std::optional<double> duration_s;
  if (options.duration) {
    const auto seconds = parse_seconds(*options.duration, "--duration");
    if (!seconds) return tl::unexpected(seconds.error());
    duration_s = *seconds;
  }
  if (options.bus.config.empty() && options.bus.interface.empty()) {
    return misused(
        "which bus? Give --config FILE with the axes and their path, or --iface NAME to exchange process data without "
        "axes");
  }
  if (options.telemetry && options.no_telemetry) return misused("--telemetry and --no-telemetry: which?");
  if (options.telemetry && options.bus.config.empty()) {
    return misused("--telemetry publishes what a line description names: it needs --config FILE");
  }
  std::optional<trajectory::Interpolator> path;
  auto session = Session::open(options.bus, [&](LineConfig& config) -> Outcome<void> {
    if (!options.output_directory.empty()) config.output.directory = options.output_directory;
    if (!options.capture.empty()) config.output.capture = options.capture;
    if (options.no_plots) config.output.plots = false;
    config.output.increments = options.increments;
    if (options.telemetry) config.telemetry.enabled = true;
    if (options.no_telemetry) config.telemetry.enabled = false;
    if (options.bus.config.empty()) use_modest_cycle(config);
    if (config.axes.empty()) return {};
    auto loaded = load_axis_path(config);
    if (!loaded) return misused(loaded.error());
    path = std::move(*loaded);
    return {};
  });
  if (!session) return tl::unexpected(session.error());
  if (auto claimed = (*session)->claim(options.force, "take its line away"); !claimed) {
    return tl::unexpected(claimed.error());
  }
  if (const auto& config = (*session)->config(); (*session)->has_config() && config.interface &&
                                                 !config.telemetry.enabled && !config.telemetry.asked &&
                                                 !options.no_telemetry) {
    progress("telemetry: off on a network interface; --telemetry, or enabled = true in [telemetry], asks for it");
  }
  std::unique_ptr<CommandInput> control;
  if (!options.control.empty()) {
    auto input = CommandInput::open(options.control, CommandInput::Sources::kSocket);
    if (!input) return tl::unexpected(input.error());
    control = std::move(*input);
  }
  auto report = LineRun(**session, std::move(path), duration_s, control.get(), options.force).execute();
  const auto capture = (*session)->close_capture();
  if (!report) return tl::unexpected(report.error());
  if (!capture) {
    note_failure(*report, capture.error().text);
  } else if (*capture) {
    report->files["capture"] = **capture;
  }
  write_files((*session)->config(), *report);
  print_out("{}", options.json ? json_text(to_json(*report)) : to_text(*report));
  if (!report->failure.empty()) return failed(report->failure);
  return 0;
}

}  // namespace

Execute prepare_run(Arguments& to) {
  auto options = std::make_shared<RunOptions>();
  add_bus_options(to, options->bus);
  to.option("--duration", &options->duration, Value::text("SECONDS"),
            "Seconds in operation; default: until the end of the path");
  to.flag("--virtual", options->bus.virtual_time, "Simulated line on virtual time: deterministic, as fast as possible");
  to.option("--output", &options->output_directory, Value::folder(), "Folder for CSV files and plots");
  to.option("--capture", &options->capture, Value::file(), "Write all frames to this pcapng file");
  to.option("--control", &options->control, Value::file("PATH"), "Socket to listen at for `driveline diag`");
  to.flag("--no-plots", options->no_plots, "Leave only the CSV files");
  to.flag("--increments", options->increments,
          "Drive increments beside what is in the units of the axes: summary, CSV files, plots, faults");
  to.flag("--telemetry", options->telemetry, "Publish over DDS also where the line is on a network interface");
  to.flag("--no-telemetry", options->no_telemetry, "Do not publish over DDS");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return [options] { return run_line(*options); };
}

}  // namespace driveline::cli
