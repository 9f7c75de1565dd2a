#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axes/quantity.hpp"
#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/motion/path/path_source.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/identify/load_estimate.hpp"
#include "driveline/runtime/identify/test_motion.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "text/json_text.hpp"
#include "text/load_view.hpp"

namespace driveline::cli {
namespace {

struct IdentifyOptions {
  runtime::BusOptions bus;
  std::string axis;
  std::string distance;
  std::optional<std::string> velocity;
  std::optional<std::string> acceleration;
  std::string output_directory;
  bool pendulum = false;
  bool no_plots = false;
  bool force = false;
  bool json = false;
};

using Files = std::map<std::string, std::filesystem::path>;

/// Half the limits of the axis, unless the options specify others.
Outcome<runtime::TestMotion> motion_of(const IdentifyOptions& options, const motion::AxisConfig& axis) {
  if (options.distance.empty()) return misused("the distance is missing: give --distance DISTANCE, in its unit");
  runtime::TestMotion motion{0.0, 0.5 * axis.limits.max_velocity, 0.5 * axis.limits.max_acceleration};
  const auto distance = parse_quantity(axis, Quantity::kPosition, options.distance, "--distance");
  if (!distance) return tl::unexpected(distance.error());
  motion.distance = *distance;
  if (options.velocity) {
    const auto velocity = parse_quantity(axis, Quantity::kVelocity, *options.velocity, "--velocity");
    if (!velocity) return tl::unexpected(velocity.error());
    motion.velocity = *velocity;
  }
  if (options.acceleration) {
    const auto acceleration = parse_quantity(axis, Quantity::kAcceleration, *options.acceleration, "--acceleration");
    if (!acceleration) return tl::unexpected(acceleration.error());
    motion.acceleration = *acceleration;
  }
  return motion;
}

/// Removes all other axes, so that their drives get no power.
runtime::Result<void> keep_one_axis(const IdentifyOptions& options, runtime::LineConfig& config) {
  const auto found =
      std::find_if(config.axes.begin(), config.axes.end(), [&](const auto& axis) { return axis.name == options.axis; });
  if (found == config.axes.end()) {
    std::string names;
    for (const auto& axis : config.axes) names += fmt::format("{}{}", names.empty() ? "" : ", ", axis.name);
    return runtime::fail(runtime::ErrorKind::kSetting,
                         fmt::format("there is no axis \"{}\", but {}", options.axis, names.empty() ? "none" : names));
  }
  if (found->is_virtual()) {
    return runtime::fail(runtime::ErrorKind::kSetting,
                         fmt::format("axis \"{}\" has no drive: there is nothing to identify", options.axis));
  }
  config.axes = {*found};
  config.path.reset();
  config.telemetry.enabled = false;
  config.output.plots = false;
  if (!options.output_directory.empty()) config.output.directory = options.output_directory;
  return {};
}

/// Records position and torque of the axis during the test motion.
class LoadRecorder final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      if (sample.state != snapshot::AxisState::kOperationEnabled) continue;
      samples_.push_back({static_cast<double>(sample.time_ns) * 1e-9, sample.actual_position, sample.actual_torque});
    }
  }
  /// To be called after the run.
  [[nodiscard]] const std::vector<runtime::LoadSample>& samples() const noexcept { return samples_; }

 private:
  std::vector<runtime::LoadSample> samples_;
};

/// Prints the events of the line, and turns a signal into a stop request.
class IdentifyConsole final : public ConsoleObserver {
 public:
  explicit IdentifyConsole(runtime::Line& line) : line_(line) {}
  void poll() override {
    if (rt::stop_requested()) line_.request_stop();
  }

 private:
  runtime::Line& line_;
};

Outcome<std::unique_ptr<runtime::Line>> open_axis_line(const IdentifyOptions& options) {
  if (options.bus.config.empty())
    return misused("no line is selected: give --config FILE, which describes the line and its axes");
  if (options.bus.virtual_time && !options.bus.interface.empty())
    return misused("--virtual runs the simulated line in this process; a network interface has no virtual time");
  runtime::Line::Options to;
  to.interface = options.bus.interface;
  to.virtual_time = options.bus.virtual_time;
  to.adjust = [&options](runtime::LineConfig& config) { return keep_one_axis(options, config); };
  auto line = runtime::Line::from_file(options.bus.config, to);
  if (!line) return tl::unexpected(line.error());
  for (const auto& note : (*line)->config().notes) progress("{}", note);
  return std::move(*line);
}

/// Moves the axis and returns the recorded samples.
Outcome<std::vector<runtime::LoadSample>> record_motion(runtime::Line& line, const runtime::TestMotion& motion,
                                                        bool force) {
  const auto& axis = line.config().axes.front();
  auto path = runtime::make_test_path(motion, axis);
  if (!path) return tl::unexpected(path.error());
  const auto& unit = motion::position_unit(axis);
  progress("axis {} moves {:.6g} {} back and forth for {:.1f} s, at most {:.6g} {}/s", axis.name,
           unit.from_si(motion.distance), unit.name, path->duration_s(), unit.from_si(motion.velocity), unit.name);
  motion::PathSource source(std::move(*path), std::span(&axis.limits, 1), motion::LatePolicy::kStay);
  if (auto used = line.use(source); !used) return tl::unexpected(used.error());
  LoadRecorder records;
  line.add(records);
  IdentifyConsole console(line);
  line.observe(console);
  const auto report = line.run({.force = force});
  if (!report) return tl::unexpected(report.error());
  if (const auto* failure = report->failure()) return failed(runtime::describe(*failure, false));
  if (rt::stop_requested()) return failed("the test motion was stopped: nothing was identified");
  return records.samples();
}

Outcome<Files> write_load_files(const runtime::LoadEstimate& load, const runtime::LineConfig& config, bool plots) {
  const auto& directory = config.output.directory;
  Files files{{"load_csv", directory / "load.csv"}, {"axes_csv", directory / "axes.csv"}};
  if (auto written = write_load_csv(load, config.axes.front(), files["load_csv"]); !written)
    return tl::unexpected(written.error());
  if (!plots) return files;
  auto drawing = draw_load(directory, config.axes.front());
  if (!drawing) {
    progress("{}", drawing.error());
    return files;
  }
  if (drawing->problem) return tl::unexpected(*drawing->problem);
  files.merge(drawing->pictures);
  return files;
}

Outcome<int> identify(const IdentifyOptions& options) {
  rt::catch_stop_signals();
  auto line = open_axis_line(options);
  if (!line) return tl::unexpected(line.error());
  const auto& axis = (*line)->config().axes.front();
  const auto motion = motion_of(options, axis);
  if (!motion) return tl::unexpected(motion.error());
  const auto samples = record_motion(**line, *motion, options.force);
  if (!samples) return tl::unexpected(samples.error());
  runtime::LoadSettings settings;
  settings.standstill = axis.feed_forward.coulomb_velocity;
  settings.pendulum = options.pendulum;
  const auto load = runtime::estimate_load(*samples, settings);
  if (!load) return failed(runtime::describe(load.error()));
  const auto files = write_load_files(*load, (*line)->config(), !options.no_plots);
  if (!files) return tl::unexpected(files.error());
  print_out("{}", options.json ? json_text(to_json(*load, axis, *files)) : load_text(*load, axis));
  return 0;
}

}  // namespace

Execute prepare_identify(Arguments& to) {
  auto options = std::make_shared<IdentifyOptions>();
  add_bus_options(to, options->bus);
  to.required(&options->axis, Value::text("AXIS"), "Name of the axis; the other axes stay switched off");
  to.option(
      "--distance", &options->distance, Value::text("WAY"),
      "Maximum distance from the present position, e.g. 90deg; without unit: in the unit of the axis; negative: in "
      "negative direction");
  to.option("--velocity", &options->velocity, Value::text("V"), "At most, e.g. 30deg/s; default: half its limit");
  to.option("--acceleration", &options->acceleration, Value::text("A"),
            "At most, e.g. 100deg/s^2; default: half its limit");
  to.flag("--pendulum", options->pendulum, "Identify the torque of a pendulum, too");
  to.flag("--virtual", options->bus.virtual_time, "Simulated line on virtual time: deterministic, as fast as possible");
  to.option("--output", &options->output_directory, Value::folder(), "Folder for CSV files and the picture");
  to.flag("--no-plots", options->no_plots, "Write only the CSV files");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return [options] { return identify(*options); };
}

}  // namespace driveline::cli
