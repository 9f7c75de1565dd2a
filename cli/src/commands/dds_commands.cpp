#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "commands/tool_options.hpp"
#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/helper/helper_program.hpp"

// Commands for a line observed over DDS. This program does not link DDS: the commands pass their arguments to the
// program driveline-dds.
namespace driveline::cli {
namespace {

/// The command line of driveline-dds.
class DdsWords {
 public:
  explicit DdsWords(std::string_view command) : words_{"driveline-dds", std::string(command)} {}

  void flag(const char* name, bool given) {
    if (given) words_.emplace_back(name);
  }
  void option(const char* name, const std::optional<std::string>& value) {
    if (value) words_.insert(words_.end(), {name, *value});
  }
  void option(const char* name, const std::vector<std::string>& values) {
    for (const auto& value : values) option(name, std::optional(value));
  }
  void argument(const std::string& value) { words_.push_back(value); }

  /// Replaces this process by driveline-dds; returns only on failure.
  [[nodiscard]] Outcome<int> become() {
    const auto program = runtime::find_helper_program("driveline-dds", "DRIVELINE_DDS");
    if (!program) {
      return failed(runtime::describe(program.error()) + "; it belongs to the Debian package driveline-bridge");
    }
    std::vector<char*> arguments;
    for (auto& word : words_) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execv(program->c_str(), arguments.data());
    return failed(fmt::format("{}: cannot be started: {}", program->string(), std::strerror(errno)));
  }

 private:
  std::vector<std::string> words_;
};

/// The options that select where lines are looked for.
struct DdsPlace {
  std::optional<std::string> domain;
  std::vector<std::string> interfaces;
  std::vector<std::string> peers;
  std::optional<std::string> partition;
  std::optional<std::string> security;

  void declare(Arguments& to) {
    to.option("--domain", &domain, Value::text("N"), "DDS domain, [telemetry] domain of the line (default: 0)");
    to.option("--interface", &interfaces, Value::interface(),
              "Search on this interface, by name or IPv4 address, or on all (default: this machine only)");
    to.option("--peer", &peers, Value::text("ADDRESS"), "IPv4 address of a machine that multicast does not reach");
    to.option("--partition", &partition, Value::text("NAME"), "DDS partition (default: none)");
    to.option("--security", &security, Value::folder(), "Use DDS Security with the six files of this folder");
  }
  void add_to(DdsWords& words) const {
    words.option("--domain", domain);
    words.option("--interface", interfaces);
    words.option("--peer", peers);
    words.option("--partition", partition);
    words.option("--security", security);
  }
};

struct EchoOptions {
  DdsPlace place;
  std::string topic;
  std::optional<std::string> count;
  std::optional<std::string> timeout;
  bool json = false;
};

struct RecordOptions {
  DdsPlace place;
  std::optional<std::string> output;
  std::vector<std::string> topics;
  std::optional<std::string> duration;
  std::optional<std::string> timeout;
  bool force = false;
  bool json = false;
};

struct PlotOptions {
  std::string recording;
  std::string config;
  std::optional<std::string> output;
  std::vector<std::string> axes;
};

struct TopOptions {
  DdsPlace place;
  std::string config;
  std::optional<std::string> period;
  std::optional<std::string> timeout;
  bool once = false;
};

/// Units of axes as driveline-dds takes them: "x=deg".
using Units = std::vector<std::string>;

/// The units of a line description.
Outcome<Units> units_of_file(const std::string& config) {
  const auto read = runtime::load_line_config(config);
  if (!read) return tl::unexpected(Failure(read.error()));
  Units units;
  for (const auto& axis : read->axes)
    units.push_back(fmt::format("{}={}", axis.name, motion::position_unit(axis).name));
  return units;
}

/// The units of the only line that runs on this machine; none: it does not run, or does not tell.
Units units_of_run() {
  const auto control = running_control("");
  if (control.empty()) return {};
  auto connection = CommandConnection::open(control, "run");
  const auto answer = connection ? connection->ask("axis all status") : tl::unexpected(connection.error());
  if (!answer) return {};
  const auto document = nlohmann::json::parse(*answer, nullptr, false);
  if (!document.is_object() || !document.contains("axes")) return {};
  Units units;
  for (const auto& axis : document.at("axes"))
    units.push_back(fmt::format("{}={}", axis.at("name").get<std::string>(), axis.at("unit").get<std::string>()));
  return units;
}

}  // namespace

Execute prepare_echo(Arguments& to) {
  auto options = std::make_shared<EchoOptions>();
  to.required(&options->topic, Value::text("TOPIC"), "Name of the topic; the part up to its last / may be omitted");
  to.option("--count", &options->count, Value::text("N"), "End after this number of samples");
  to.option("--timeout", &options->timeout, Value::text("SECONDS"), "End when no sample arrives for this time");
  to.flag("--json", options->json, "One JSON document per line for each sample");
  options->place.declare(to);
  return [options] {
    DdsWords words("echo");
    words.argument(options->topic);
    words.option("--count", options->count);
    words.option("--timeout", options->timeout);
    words.flag("--json", options->json);
    options->place.add_to(words);
    return words.become();
  };
}

Execute prepare_record(Arguments& to) {
  auto options = std::make_shared<RecordOptions>();
  to.option("-o,--output", &options->output, Value::file(), "File to write: NAME.mcap, or NAME.csv for one topic");
  to.option("--topic", &options->topics, Value::text("TOPIC"),
            "Record this topic; may be given several times (default: all)");
  to.option("--duration", &options->duration, Value::text("SECONDS"),
            "End this time after the first sample (default: Ctrl-C)");
  to.option("--timeout", &options->timeout, Value::text("SECONDS"),
            "Fail if no line is found within this time (default: 10)");
  to.flag("--force", options->force, "Overwrite an existing file");
  add_json_flag(to, options->json);
  options->place.declare(to);
  return [options] {
    DdsWords words("record");
    words.option("--output", options->output);
    words.option("--topic", options->topics);
    words.option("--duration", options->duration);
    words.option("--timeout", options->timeout);
    words.flag("--force", options->force);
    words.flag("--json", options->json);
    options->place.add_to(words);
    return words.become();
  };
}

Execute prepare_plot(Arguments& to) {
  auto options = std::make_shared<PlotOptions>();
  to.required(&options->recording, Value::file("RECORDING"), "Recording (MCAP) of `driveline record`");
  to.option("-o,--output", &options->output, Value::file(), "Picture to write (default: RECORDING with .svg)");
  to.option("--axis", &options->axes, Value::text("NAME"), "Draw this axis; may be given several times (default: all)");
  to.option("--config", &options->config, Value::file(),
            "Line description with the units of the axes (default: rad and m)");
  return [options]() -> Outcome<int> {
    const auto units = options->config.empty() ? Outcome<Units>{} : units_of_file(options->config);
    if (!units) return tl::unexpected(units.error());
    DdsWords words("plot");
    words.option("--unit", *units);
    words.argument(options->recording);
    words.option("--output", options->output);
    words.option("--axis", options->axes);
    return words.become();
  };
}

Execute prepare_top(Arguments& to) {
  auto options = std::make_shared<TopOptions>();
  to.flag("--once", options->once, "Print one page and end");
  to.option("--period", &options->period, Value::text("SECONDS"), "Time between two pages (default: 0.5)");
  to.option("--timeout", &options->timeout, Value::text("SECONDS"),
            "Fail if no line is found within this time (default: 10)");
  to.option("--config", &options->config, Value::file(),
            "Line description with the units of the axes (default: those of the line that runs on this machine)");
  options->place.declare(to);
  return [options]() -> Outcome<int> {
    const auto units = options->config.empty() ? Outcome<Units>(units_of_run()) : units_of_file(options->config);
    if (!units) return tl::unexpected(units.error());
    DdsWords words("top");
    words.option("--unit", *units);
    words.flag("--once", options->once);
    words.option("--period", options->period);
    words.option("--timeout", options->timeout);
    options->place.add_to(words);
    return words.become();
  };
}

}  // namespace driveline::cli
