#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "axes/axis_view.hpp"
#include "axes/quantity.hpp"
#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "commands/line_control.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/runtime/toml/suggestion.hpp"
#include "driveline/trajectory/interpolation_method.hpp"
#include "groups/group_view.hpp"
#include "line/can_answers.hpp"
#include "line/run_console.hpp"
#include "line/run_drives.hpp"
#include "script/axis_script.hpp"
#include "service/cycle_witness.hpp"
#include "service/service_manager.hpp"
#include "text/cycle_trace.hpp"
#include "text/diagnosis_json.hpp"
#include "text/eoe_view.hpp"
#include "text/json_text.hpp"
#include "text/plots.hpp"
#include "text/run_report.hpp"

namespace driveline::cli {
namespace {

using motion::cia402::cyclic_mode_names;
using motion::cia402::find_cyclic_mode;

/// The options of `run`.
struct RunOptions {
  runtime::BusOptions bus;
  std::optional<std::string> duration;
  std::string output_directory;  ///< empty: as configured
  std::string capture;           ///< empty: as configured
  std::string trace;             ///< file for the phases of the cycles; empty: none
  std::string interpolation;     ///< name of a method; empty: as configured
  std::string mode;              ///< mode of all axes; empty: as configured
  std::string control;           ///< socket for other commands; empty: the default path
  std::string script;            ///< file with requests to axes; empty: none
  bool no_enable = false;
  bool no_plots = false;
  bool increments = false;
  bool telemetry = false;
  bool no_telemetry = false;
  bool json = false;
  bool force = false;
};

/// Adds a file that could not be written to the faults of the report, so that the summary is still printed.
void note_failure(runtime::RunReport& report, const runtime::Error& error) {
  ConsoleObserver().event(report.note_failure(error));
}

/// Writes the files of the run beside axes.csv. A missing or failing gnuplot is no failure of the run; a disk that does
/// not take the pictures is.
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
      draw_plots(directory, report.files.count("axes_csv") != 0 ? report.axes : std::vector<runtime::AxisRunReport>{},
                 report.increments, plot_facts(report));
  if (!pictures) {
    progress("{}", pictures.error());
    return;
  }
  report.files.merge(pictures->pictures);
  if (pictures->problem) note_failure(report, *pictures->problem);
}

/// The trace has its own option, so its file is written to that path and not beside the other files.
void write_trace(const std::string& file, runtime::RunReport& report) {
  if (file.empty()) return;
  if (auto written = write_trace_file(report, file); !written) {
    note_failure(report, written.error());
    return;
  }
  report.files["trace"] = file;
}

/// Checks the path before the run, because its error would otherwise appear only after it.
Outcome<void> check_trace(const std::string& file) {
  if (file.empty()) return {};
  const auto folder = std::filesystem::path(file).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    return misused(fmt::format("--trace {}: there is no folder {}", file, folder.string()));
  if (std::filesystem::is_directory(file, ignored))
    return misused(fmt::format("--trace {}: this is a folder; the name of a file is expected", file));
  return {};
}

/// Settings without a description: no telemetry, and a cycle that any machine can keep.
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

/// Checks the name of a choice; empty: the option was not given.
Outcome<void> check_choice(std::string_view option, const std::string& name,
                           const std::vector<std::string_view>& names) {
  if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) return {};
  const auto meant = runtime::closest(name, names);
  return misused(fmt::format("{} {}: one of {} is expected{}", option, name, fmt::join(names, ", "),
                             meant.empty() ? "" : fmt::format("; did you mean {}?", meant)));
}

Outcome<void> check(const RunOptions& options) {
  if (options.bus.config.empty() && options.bus.interface.empty()) {
    return misused(
        "no bus is selected: give --config FILE with the axes and their path, or --iface NAME to exchange process data "
        "without "
        "axes");
  }
  if (options.telemetry && options.no_telemetry) return misused("--telemetry and --no-telemetry exclude each other");
  if (options.telemetry && options.bus.config.empty()) {
    return misused("--telemetry publishes what a line description names: it needs --config FILE");
  }
  if (!options.script.empty() && options.bus.config.empty())
    return misused("--script moves the axes of a line description: it needs --config FILE");
  if (options.bus.virtual_time && !options.bus.interface.empty())
    return misused("--virtual runs the simulated line in this process; a network interface has no virtual time");
  if (auto checked = check_choice("--interpolation", options.interpolation, interpolation_names()); !checked)
    return checked;
  if (auto checked = check_choice("--mode", options.mode, cyclic_mode_names()); !checked) return checked;
  if (!options.mode.empty() && options.bus.config.empty())
    return misused("--mode is for the axes of a line description: it needs --config FILE");
  if (auto checked = check_trace(options.trace); !checked) return checked;
  return check_run_bus(options.bus);
}

runtime::Result<void> adjust(const RunOptions& options, runtime::LineConfig& config) {
  if (!options.output_directory.empty()) config.output.directory = options.output_directory;
  if (!options.capture.empty()) config.output.capture = options.capture;
  if (options.no_plots) config.output.plots = false;
  config.output.increments = options.increments;
  if (options.telemetry) {
    config.telemetry.enabled = true;
    config.telemetry.asked = true;
  }
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
  to.mode = find_cyclic_mode(options.mode);
  to.adjust = [&options](runtime::LineConfig& config) { return adjust(options, config); };
  auto line = options.bus.config.empty() ? runtime::Line::from_interface(options.bus.interface, to)
                                         : runtime::Line::from_file(options.bus.config, to);
  if (!line) return tl::unexpected(line.error());
  const auto& config = (*line)->config();
  for (const auto& note : config.notes) progress("{}", note);
  if (auto claimed = (*line)->claim(options.force); !claimed) return tl::unexpected(claimed.error());
  return std::move(*line);
}

/// Prints the events of the line, answers `driveline diag` and `driveline eoe`, executes the script, and turns a signal
/// into a stop request.
class RunConsole final : public ConsoleObserver {
 public:
  /// `control` and `script` may be null.
  RunConsole(runtime::Line& line, LineControl* control, AxisScript* script)
      : ConsoleObserver(line.config().output.increments), line_(line), control_(control), script_(script) {
    if (manager_.has_watchdog()) line_.add(cycles_);
  }

  void event(const runtime::Event& event) override {
    ConsoleObserver::event(event);
    if (const auto* reached = event.as<runtime::events::StateReached>()) tell_manager(*reached);
    if (!event.is<runtime::events::NoPath>()) return;
    axes_wait_ = true;
    if (control_ != nullptr && script_ == nullptr) tell_how_to_move();
  }

  void poll() override {
    manager_.alive(cycles_.cycles(), ServiceManager::Clock::now());
    if (rt::stop_requested()) line_.request_stop();
    if (script_ != nullptr && axes_wait_) go_on_with_script();
    if (control_ == nullptr) return;
    control_->answer_questions([this](std::string_view question) { return answer(question); });
  }

  /// Why the script has ended early; none: it has not.
  [[nodiscard]] const std::optional<Failure>& script_failure() const noexcept { return script_failure_; }

 private:
  void tell_manager(const runtime::events::StateReached& reached) {
    if (reached.operational) {
      const auto& config = line_.config();
      manager_.ready(fmt::format("{} in {}, {} slaves, {} axes", config.name, reached.state, config.slaves.size(),
                                 config.axes.size()));
    } else {
      manager_.ending();
    }
  }

  void tell_how_to_move() const {
    const auto& axis = line_.config().axes.front();
    progress("`driveline axis {} move --by {}{}` moves an axis; driveline axis --help shows more", axis.name, 1,
             motion::position_unit(axis).name);
  }

  void go_on_with_script() {
    const auto done = script_->step(line_.axes(), line_.groups(), line_.clock().now());
    if (done && !*done) return;
    if (!done) script_failure_ = done.error();
    script_ = nullptr;
    line_.request_stop();
  }

  [[nodiscard]] std::string answer(std::string_view question) {
    if (line_.can_session() != nullptr) return answer_about_can(line_, question);
    if (question.starts_with("diag")) return diagnosis(question == "diag json");
    if (question.starts_with(kDriveQuestion)) return answer_about_drives(line_, question.substr(kDriveQuestion.size()));
    return eoe(question == "eoe json");
  }

  [[nodiscard]] std::string eoe(bool as_json) const {
    const auto report = line_.eoe();
    if (!report) return "error: the line has no EoE: its description has no [eoe]";
    return as_json ? json_text(cli::to_json(*report)) : cli::to_text(*report);
  }

  [[nodiscard]] std::string diagnosis(bool as_json) {
    const auto diagnosis = line_.diagnose();
    if (!diagnosis) return fmt::format("error: {}", runtime::describe(diagnosis.error()));
    if (!as_json) return to_text(*diagnosis) + owners_text(line_.axes()) + groups_text(line_.groups());
    auto document = to_json(*diagnosis);
    document["axes"] = owners_json(line_.axes());
    if (!line_.groups().groups().empty()) document["axis_groups"] = groups_json(line_.groups());
    return json_text(document);
  }

  runtime::Line& line_;
  LineControl* control_;
  AxisScript* script_;
  ServiceManager manager_;
  CycleWitness cycles_;
  std::optional<Failure> script_failure_;
  bool axes_wait_ = false;  ///< the axes wait for requests
};

/// Opens the default control socket of the line. Null: there is none, because its folder cannot be used or, with
/// `force`, because another run listens there (`force` takes over its line).
Outcome<std::unique_ptr<CommandInput>> open_default_control(const std::string& line, bool force) {
  if (auto made = make_control_folder(); !made) {
    progress("no control socket, so no `driveline axis`: {}; choose another one with --control PATH",
             made.error().text);
    return nullptr;
  }
  const auto path = control_path(line);
  if (const auto process = listener_at(path)) {
    if (force) {
      progress("no control socket, so no `driveline axis`: process {} listens at {}", *process, path.string());
      return nullptr;
    }
    return failed(
        fmt::format("{}: process {} runs a line called \"{}\" already and listens there; another [line] name "
                    "or --control PATH is expected",
                    path.string(), *process, line));
  }
  return CommandInput::open(path, CommandInput::Sources::kSocket);
}

/// Without a socket on virtual time, because such a line is over before a client could connect.
Outcome<std::unique_ptr<LineControl>> open_control(const RunOptions& options, runtime::Line& line) {
  if (options.control.empty() && options.bus.virtual_time) return nullptr;
  auto input = options.control.empty() ? open_default_control(line.config().name, options.force)
                                       : CommandInput::open(options.control, CommandInput::Sources::kSocket);
  if (!input) return tl::unexpected(input.error());
  if (*input == nullptr) return nullptr;
  return std::make_unique<LineControl>(std::move(*input), line.axes(), line.groups(), line.config().couplings,
                                       make_slave_console(line));
}

/// Reads the script; none: none was given.
Outcome<std::optional<AxisScript>> read_script(const RunOptions& options, const runtime::LineConfig& config) {
  if (options.script.empty()) return std::nullopt;
  if (config.path) return misused("--script moves the axes of a line without [path]; this one has a path");
  auto script = AxisScript::read(options.script, {config.axes, config.axis_groups, &config.couplings});
  if (!script) return tl::unexpected(script.error());
  return std::move(*script);
}

Outcome<int> run_line(const RunOptions& options) {
  rt::catch_stop_signals();
  runtime::Line::RunSettings settings;
  settings.force = options.force;
  settings.enable = !options.no_enable;
  settings.telemetry = true;
  settings.trace = !options.trace.empty();
  if (options.duration) {
    const auto time = parse_time(*options.duration, "--duration");
    if (!time) return tl::unexpected(time.error());
    settings.duration_s = std::chrono::duration<double>(*time).count();
  }
  if (auto checked = check(options); !checked) return tl::unexpected(checked.error());
  auto line = open_line(options);
  if (!line) return tl::unexpected(line.error());
  auto script = read_script(options, (*line)->config());
  if (!script) return tl::unexpected(script.error());
  const auto control = open_control(options, **line);
  if (!control) return tl::unexpected(control.error());
  RunConsole console(**line, control->get(), *script ? &**script : nullptr);
  (*line)->observe(console);
  auto report = (*line)->run(settings);
  if (!report) return tl::unexpected(report.error());
  write_files((*line)->config(), *report);
  write_trace(options.trace, *report);
  print_out("{}", options.json ? json_text(cli::to_json(*report)) : cli::to_text(*report));
  if (const auto& failure = console.script_failure()) return tl::unexpected(*failure);
  if (const auto* failure = report->failure()) return failed(runtime::describe(*failure, report->increments));
  return 0;
}

}  // namespace

Execute prepare_run(Arguments& to) {
  auto options = std::make_shared<RunOptions>();
  add_bus_options(to, options->bus);
  to.option("--duration", &options->duration, Value::text("TIME"),
            "Time in operation, e.g. 10, 10s or 500ms; default: until the end of the path");
  to.flag("--virtual", options->bus.virtual_time, "Simulated line on virtual time: deterministic, as fast as possible");
  to.option("--output", &options->output_directory, Value::folder(), "Folder for CSV files and plots");
  to.option("--capture", &options->capture, Value::file(), "Write all frames to this pcapng file");
  to.option("--trace", &options->trace, Value::file(),
            "Write start and end of the phases of the last and the worst cycles, as JSON for Perfetto");
  to.option(
      "--control", &options->control, Value::file("PATH"),
      "Socket to listen at for `driveline axis`, `group`, `diag`, `drive`, `eoe`, `fault` and `input`; default: one "
      "named after the line, in $XDG_RUNTIME_DIR/driveline or /run/driveline");
  to.option("--script", &options->script, Value::file(), "Requests to the axes of a line without [path], one per line");
  to.flag("--no-enable", options->no_enable, "Without [path]: leave the axes disabled until a request enables them");
  to.option("--interpolation", &options->interpolation, Value::choice("METHOD", interpolation_names()),
            "Interpolation between the points of the path; replaces [path] interpolation");
  to.option("--mode", &options->mode, Value::choice("MODE", cyclic_mode_names()),
            "Mode of operation of all axes; replaces the modes in the description");
  to.flag("--no-plots", options->no_plots, "Write only the CSV files");
  to.flag("--increments", options->increments,
          "Show drive increments in addition to the units of the axes: summary, CSV files, plots, faults");
  to.flag("--telemetry", options->telemetry,
          "Publish over DDS even if the description disables it; fail if that is not possible");
  to.flag("--no-telemetry", options->no_telemetry, "Do not publish over DDS");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return [options] { return run_line(*options); };
}

}  // namespace driveline::cli
