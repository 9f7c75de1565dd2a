#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/runtime/toml/suggestion.hpp"
#include "driveline/trajectory/interpolation_method.hpp"
#include "signals.hpp"
#include "text/diagnosis_json.hpp"
#include "text/eoe_view.hpp"
#include "text/json_text.hpp"
#include "text/plots.hpp"
#include "text/run_report.hpp"

namespace driveline::cli {
namespace {

/// What `run` was asked for.
struct RunOptions {
  runtime::BusOptions bus;
  std::optional<std::string> duration;
  std::string output_directory;  ///< empty: as configured
  std::string capture;           ///< empty: as configured
  std::string interpolation;     ///< name of a method; empty: as configured
  std::string control;           ///< socket for `diag` and `eoe`; may be empty
  bool no_plots = false;
  bool increments = false;
  bool telemetry = false;
  bool no_telemetry = false;
  bool json = false;
  bool force = false;
};

/// A file that could not be written is a failure in the summary, not the loss of the summary.
void note_failure(runtime::RunReport& report, const runtime::Error& error) {
  ConsoleObserver().event(report.note_failure(error));
}

/// Writes the files of the run beside axes.csv. A plot that cannot be drawn is no failure of the run.
void write_files(const runtime::LineConfig& config, runtime::RunReport& report) {
  const auto& directory = config.output.directory;
  const auto jitter = directory / "jitter.csv";
  if (auto written = write_jitter_csv(report.statistics, jitter); !written) {
    note_failure(report, written.error());
    return;
  }
  report.files["jitter_csv"] = jitter;
  if (!config.output.plots) return;
  progress("drawing the plots");
  auto pictures =
      draw_plots(directory, report.files.count("axes_csv") != 0 ? report.axes : std::vector<runtime::AxisReport>{},
                 report.increments);
  if (pictures) {
    report.files.merge(*pictures);
  } else {
    progress("{}", pictures.error());
  }
}

/// Without a description nothing is published, and the cycle is one that any machine can keep.
void use_modest_cycle(runtime::LineConfig& config) {
  config.period = std::chrono::milliseconds{1};
  config.realtime.policy = rt::RealtimePolicy::kDegrade;
  config.telemetry.enabled = false;
}

std::vector<std::string_view> interpolation_names() {
  std::vector<std::string_view> names;
  for (const auto& facts : trajectory::interpolation_methods()) names.push_back(facts.name);
  return names;
}

Outcome<void> check_interpolation(const std::string& name) {
  if (name.empty() || trajectory::find_interpolation_method(name) != nullptr) return {};
  const auto names = interpolation_names();
  const auto meant = runtime::closest(name, names);
  return misused(fmt::format("--interpolation {}: one of {} is expected{}", name, fmt::join(names, ", "),
                             meant.empty() ? "" : fmt::format("; did you mean {}?", meant)));
}

Outcome<void> check(const RunOptions& options) {
  if (options.bus.config.empty() && options.bus.interface.empty()) {
    return misused(
        "which bus? Give --config FILE with the axes and their path, or --iface NAME to exchange process data without "
        "axes");
  }
  if (options.telemetry && options.no_telemetry) return misused("--telemetry and --no-telemetry: which?");
  if (options.telemetry && options.bus.config.empty()) {
    return misused("--telemetry publishes what a line description names: it needs --config FILE");
  }
  if (options.bus.virtual_time && !options.bus.interface.empty())
    return misused("--virtual runs the simulated line in this process; a network interface has no virtual time");
  if (auto checked = check_interpolation(options.interpolation); !checked) return checked;
  return check_bus_options(options.bus);
}

runtime::Result<void> adjust(const RunOptions& options, runtime::LineConfig& config) {
  if (!options.output_directory.empty()) config.output.directory = options.output_directory;
  if (!options.capture.empty()) config.output.capture = options.capture;
  if (options.no_plots) config.output.plots = false;
  config.output.increments = options.increments;
  if (options.telemetry) config.telemetry.enabled = true;
  if (options.no_telemetry) config.telemetry.enabled = false;
  if (options.bus.config.empty()) use_modest_cycle(config);
  if (options.interpolation.empty()) return {};
  if (!config.path) {
    return runtime::fail(runtime::ErrorKind::kSetting, "--interpolation is for a path, and the line has none");
  }
  config.path->interpolation = trajectory::find_interpolation_method(options.interpolation)->method;
  return {};
}

Outcome<std::unique_ptr<runtime::Line>> open_line(const RunOptions& options) {
  runtime::Line::Options to;
  to.interface = options.bus.interface;
  to.second_interface = options.bus.interface2;
  to.virtual_time = options.bus.virtual_time;
  to.adjust = [&options](runtime::LineConfig& config) { return adjust(options, config); };
  auto line = options.bus.config.empty() ? runtime::Line::from_interface(options.bus.interface, to)
                                         : runtime::Line::from_file(options.bus.config, to);
  if (!line) return tl::unexpected(line.error());
  const auto& config = (*line)->config();
  for (const auto& note : config.notes) progress("{}", note);
  if (auto claimed = (*line)->claim(options.force); !claimed) return tl::unexpected(claimed.error());
  const bool silent = config.interface && !config.telemetry.enabled && !config.telemetry.asked;
  if (silent && !options.bus.config.empty() && !options.no_telemetry) {
    progress("telemetry: off on a network interface; --telemetry, or enabled = true in [telemetry], asks for it");
  }
  return std::move(*line);
}

/// The publisher; null: telemetry is off.
Outcome<std::unique_ptr<bridge::DdsPublisher>> make_publisher(const runtime::LineConfig& config) {
  if (!config.telemetry.enabled) return nullptr;
  bridge::DdsConfig dds;
  dds.domain_id = config.telemetry.domain;
  dds.line_name = config.name;
  dds.decimation = config.telemetry.decimation;
  dds.interfaces = config.telemetry.interfaces;
  for (const auto& axis : config.axes) {
    dds.axes.push_back({axis.name, axis.linear() ? bridge::AxisKind::kLinear : bridge::AxisKind::kRotary});
  }
  auto publisher = bridge::DdsPublisher::create(std::move(dds));
  if (!publisher) return failed(fmt::format("telemetry: {}", describe(publisher.error())));
  return std::move(*publisher);
}

/// Shows what happens to the line, answers `driveline diag` and `driveline eoe`, and hands signals on.
class RunConsole final : public ConsoleObserver {
 public:
  RunConsole(runtime::Line& line, CommandInput* control)
      : ConsoleObserver(line.config().output.increments), line_(line), control_(control) {}

  void look() override {
    if (stop_requested()) line_.request_stop();
    if (control_ == nullptr) return;
    control_->run(std::chrono::milliseconds{0}, [this](std::string_view command) { return answer(command); });
  }

 private:
  [[nodiscard]] std::string answer(std::string_view command) {
    if (command == "diag" || command == "diag json") return diagnosis(command == "diag json");
    if (command == "eoe" || command == "eoe json") return eoe(command == "eoe json");
    return fmt::format("error: \"{}\" is no command of a running line; diag, eoe, diag json and eoe json are", command);
  }

  [[nodiscard]] std::string eoe(bool as_json) const {
    const auto report = line_.eoe();
    if (!report) return "error: the line has no EoE: its description has no [eoe]";
    return as_json ? json_text(cli::to_json(*report)) : cli::to_text(*report);
  }

  [[nodiscard]] std::string diagnosis(bool as_json) {
    const auto diagnosis = line_.diagnose();
    if (!diagnosis) return fmt::format("error: {}", runtime::describe(diagnosis.error()));
    return as_json ? json_text(to_json(*diagnosis)) : to_text(*diagnosis);
  }

  runtime::Line& line_;
  CommandInput* control_;
};

Outcome<int> run_line(const RunOptions& options) {
  catch_stop_signals();
  runtime::Line::RunSettings settings;
  settings.force = options.force;
  if (options.duration) {
    const auto seconds = parse_seconds(*options.duration, "--duration");
    if (!seconds) return tl::unexpected(seconds.error());
    settings.duration_s = *seconds;
  }
  if (auto checked = check(options); !checked) return tl::unexpected(checked.error());
  auto line = open_line(options);
  if (!line) return tl::unexpected(line.error());
  std::unique_ptr<CommandInput> control;
  if (!options.control.empty()) {
    auto input = CommandInput::open(options.control, CommandInput::Sources::kSocket);
    if (!input) return tl::unexpected(input.error());
    control = std::move(*input);
  }
  const auto publisher = make_publisher((*line)->config());
  if (!publisher) return tl::unexpected(publisher.error());
  if (*publisher) (*line)->add(**publisher);
  RunConsole console(**line, control.get());
  (*line)->observe(console);
  auto report = (*line)->run(settings);
  if (!report) return tl::unexpected(report.error());
  write_files((*line)->config(), *report);
  const auto telemetry = *publisher ? std::optional((*publisher)->counters()) : std::nullopt;
  print_out("{}", options.json ? json_text(cli::to_json(*report, telemetry)) : cli::to_text(*report, telemetry));
  if (const auto* failure = report->failure()) return failed(runtime::describe(*failure, report->increments));
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
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket to listen at for `driveline diag` and `driveline eoe`");
  to.option("--interpolation", &options->interpolation, Value::choice("METHOD", interpolation_names()),
            "How the points of the path are joined, instead of [path] interpolation");
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
