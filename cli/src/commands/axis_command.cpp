#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "axes/axis_view.hpp"
#include "axes/axis_words.hpp"
#include "axes/coupling_words.hpp"
#include "axes/quantity.hpp"
#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;
using std::chrono::steady_clock;

/// Interval at which the command requests the progress from the line, and so shows that it is alive.
constexpr std::chrono::milliseconds kAskInterval{50};
/// The same until the axis has accepted the request, which takes a few cycles.
constexpr std::chrono::milliseconds kAcceptInterval{2};
/// After this time the command starts to print its progress.
constexpr std::chrono::seconds kSilence{2};
constexpr std::chrono::seconds kTellInterval{1};

struct AxisOptions {
  std::string axis;
  std::string request;
  std::vector<std::string> operands;
  /// Options such as "--velocity": their names in requests to the line, and their values.
  struct Setting {
    std::string_view name;
    std::optional<std::string> value{};
  };
  std::vector<Setting> settings{{"velocity"},    {"acceleration"}, {"deceleration"}, {"jerk"}, {"by"}, {"add"},
                                {"superimpose"}, {"buffer"},       {"direction"},    {"from"}, {"to"}, {"at"}};
  std::optional<std::string> duration;
  std::string control;
  std::string config;
  bool take_over = false;
  bool no_wait = false;
  bool json = false;
};

/// Whether the request moves a single axis until it is stopped.
bool endless(std::string_view request) {
  return request == "jog" || request == "torque" || request == "drive-jog" || request == "drive-run" ||
         request == "gear-out" || request == "cam-out";
}

/// The command for the line: `axis x move 90deg velocity=30deg/s`.
std::string order_of(const AxisOptions& options) {
  auto order = fmt::format("axis {} {}", quoted_word(options.axis), options.request);
  for (const auto& operand : options.operands) order += fmt::format(" {}", quoted_word(operand));
  for (const auto& setting : options.settings) {
    if (setting.value) order += fmt::format(" {}", quoted_word(fmt::format("{}={}", setting.name, *setting.value)));
  }
  if (options.take_over) order += " take-over";
  return order;
}

/// A request that is over has been accepted before.
bool is_accepted(const json& row) {
  return row.at("accepted").get<bool>() || row.at("over").get<bool>();
}

/// One request to axes of a running line, followed to its end.
class AxisOrder {
 public:
  AxisOrder(const AxisOptions& options, CommandConnection connection)
      : options_(options), connection_(std::move(connection)) {}

  [[nodiscard]] Outcome<int> execute(std::optional<std::chrono::nanoseconds> duration) {
    auto answer = ask(order_of(options_));
    if (!answer) return tl::unexpected(answer.error());
    if (options_.request == "status") return print(*answer);
    if (options_.no_wait) return leave_when_accepted();
    if (duration) until_ = begin_ + *duration;
    return follow();
  }

 private:
  [[nodiscard]] bool jogs() const {
    return endless(options_.request) || options_.request == "gear-in" || options_.request == "cam-in";
  }
  [[nodiscard]] bool homes() const { return options_.request == "home" || options_.request == "home-probe"; }
  [[nodiscard]] bool probes() const { return options_.request == "probe"; }
  /// The request that ends it early. Only a stop ends homing; finish() releases that stop.
  [[nodiscard]] std::string_view ending() const { return homes() ? "stop" : probes() ? "abort-probe" : "halt"; }

  [[nodiscard]] Outcome<json> ask(const std::string& command) {
    const auto answer = connection_.ask(command);
    if (!answer) return tl::unexpected(answer.error());
    auto document = json::parse(*answer, nullptr, false);
    if (!document.is_object()) return failed(*answer);
    if (document.contains("error"))
      return tl::unexpected(Failure{document.value("status", 1), document.at("error").get<std::string>()});
    return document;
  }

  /// Waits until all axes have accepted the request, or one has refused it; the motion continues without this command.
  [[nodiscard]] Outcome<int> leave_when_accepted() {
    for (;;) {
      auto progress = ask("axis progress");
      if (!progress) return tl::unexpected(progress.error());
      const auto& axes = progress->at("axes");
      for (const auto& axis : axes) {
        if (axis.contains("failure")) return failed(axis.at("failure").get<std::string>());
      }
      if (std::all_of(axes.begin(), axes.end(), is_accepted)) {
        if (auto detached = ask("axis detach"); !detached) return tl::unexpected(detached.error());
        return print(*progress);
      }
      if (rt::stop_requested()) return failed("interrupted before the axis accepted the request");
      std::this_thread::sleep_for(kAcceptInterval);
    }
  }

  /// Waits until the request is over; where the motion is endless, until the axis is at standstill again.
  [[nodiscard]] Outcome<int> follow() {
    for (;;) {
      auto progress = ask("axis progress");
      if (!progress) return tl::unexpected(progress.error());
      const auto& axes = progress->at("axes");
      for (const auto& axis : axes) {
        if (axis.contains("failure")) return failed(axis.at("failure").get<std::string>());
      }
      const std::string_view end = jogs() && !halted_ ? "over" : "reached";
      if (std::all_of(axes.begin(), axes.end(), [&](const json& axis) { return axis.at(end).get<bool>(); })) {
        return finish(*progress);
      }
      if (auto stopped = stop_if_due(); !stopped) return tl::unexpected(stopped.error());
      tell(axes);
      std::this_thread::sleep_for(kAskInterval);
    }
  }

  [[nodiscard]] Outcome<void> stop_if_due() {
    const bool over = until_ && steady_clock::now() >= *until_;
    if (halted_ || !(over || rt::stop_requested())) return {};
    halted_ = true;
    interrupted_ = !over && !jogs();
    const auto answer = ask(fmt::format("axis {} {}", quoted_word(options_.axis), ending()));
    return answer ? Outcome<void>{} : tl::unexpected(answer.error());
  }

  [[nodiscard]] Outcome<int> finish(const json& progress) {
    if (!interrupted_) return print(progress);
    if (homes()) {
      const auto released = ask(fmt::format("axis {} release-stop", quoted_word(options_.axis)));
      if (!released) return tl::unexpected(released.error());
    }
    std::string where;
    for (const auto& axis : progress.at("axes"))
      where += fmt::format("{}{}", where.empty() ? "" : "; ", axis_line(axis));
    return failed(fmt::format("interrupted: {}", where));
  }

  void tell(const json& axes) {
    const auto now = steady_clock::now();
    if (now < next_tell_) return;
    next_tell_ = now + kTellInterval;
    for (const auto& axis : axes) progress("{}", jogs() ? motion_line(axis) : axis_line(axis));
  }

  [[nodiscard]] Outcome<int> print(const json& document) const {
    if (options_.json) {
      print_out("{}", json_text(document));
    } else if (options_.request == "status") {
      print_out("{}", axes_table(document.at("axes")));
    } else {
      for (const auto& axis : document.at("axes")) {
        print_out("{}\n", options_.no_wait ? accepted_line(axis) : probes() ? recorded_line(axis) : axis_line(axis));
      }
    }
    return 0;
  }

  const AxisOptions& options_;
  CommandConnection connection_;
  steady_clock::time_point begin_ = steady_clock::now();
  steady_clock::time_point next_tell_ = begin_ + kSilence;
  std::optional<steady_clock::time_point> until_;
  bool halted_ = false;       ///< this command has sent a halt
  bool interrupted_ = false;  ///< before the request was over
};

Outcome<int> order_axis(const AxisOptions& options) {
  rt::catch_stop_signals();
  std::optional<std::chrono::nanoseconds> duration;
  if (options.duration) {
    if (!endless(options.request))
      return misused("--for is possible with jog, drive-jog, drive-run and torque only, which do not end without it");
    const auto time = parse_time(*options.duration, "--for");
    if (!time) return tl::unexpected(time.error());
    duration = *time;
  }
  if (endless(options.request) && options.no_wait) {
    return misused(
        fmt::format("--no-wait is not possible with {}: the axis moves as long as this command runs", options.request));
  }
  const auto path = find_control(options.control, options.config);
  if (!path) return tl::unexpected(path.error());
  auto connection = CommandConnection::open(*path, "run");
  if (!connection) return tl::unexpected(connection.error());
  return AxisOrder(options, std::move(*connection)).execute(duration);
}

/// The requests that a line knows, and the additions of this command.
std::vector<std::string_view> request_names() {
  std::vector<std::string_view> names{"status"};
  for (const auto verb : axis_verbs()) names.push_back(verb);
  for (const auto verb : coupling_verbs()) names.push_back(verb);
  return names;
}

}  // namespace

Execute prepare_axis(Arguments& to) {
  auto options = std::make_shared<AxisOptions>();
  to.required(&options->axis, Value::text("NAME"), "Name of the axis, or all");
  to.required(&options->request, Value::choice("REQUEST", request_names()),
              "status, enable, disable, reset, home, move POSITION, jog VELOCITY, torque TORQUE, halt, stop, "
              "release-stop, position POSITION, override FACTOR, mode csp|csv|cst|ip, probe [1|2|zero] "
              "[rising|falling], abort-probe, home-probe DISTANCE [1|2|zero] [rising|falling], drive-move POSITION, "
              "drive-jog VELOCITY, drive-run VELOCITY, gear-in [N/M | 10mm:360deg] [at=PLACE to=PLACE "
              "[over=DISTANCE]], gear-out, "
              "cam-in [CAM] [at=PLACE "
              "[over=DISTANCE]] [master=PLACE] [slave=PLACE], cam-out, phase OFFSET");
  to.positional(&options->operands, Value::text("VALUE"),
                "Value with unit, e.g. 90deg; without unit: in the unit of the axis");
  constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kHelp{{
      {"--velocity", "Maximum velocity, e.g. 30deg/s; default: the limit of the axis"},
      {"--acceleration", "Maximum acceleration, e.g. 100deg/s^2"},
      {"--deceleration", "Maximum deceleration; default: the acceleration"},
      {"--jerk", "Highest jerk"},
      {"--by", "Distance: move, from the commanded position; drive-move, from the actual position"},
      {"--add", "move: by this distance from the end of the previous motion"},
      {"--superimpose", "move: by this distance superimposed on the motion in progress"},
      {"--buffer", "How the motion follows the previous one: aborting, buffered, blending_low, ..."},
      {"--direction", "move of a modulo axis: direction shortest, positive or negative"},
      {"--from", "probe: start of the window in which events count"},
      {"--to", "probe: end of the window in which events count"},
      {"--at", "home-probe: position assigned to the event; default: 0"},
  }};
  for (std::size_t i = 0; i < kHelp.size(); ++i) {
    to.option(kHelp[i].first, &options->settings[i].value, Value::text("VALUE"), kHelp[i].second);
  }
  to.option("--for", &options->duration, Value::text("TIME"),
            "jog, drive-jog, drive-run, torque: duration; default: until Ctrl-C");
  to.flag("--no-wait", options->no_wait,
          "Wait only until the axis has accepted the request; the motion continues without this command");
  to.flag("--take-over", options->take_over, "Take over the axis from another client");
  to.option("--config", &options->config, Value::file(), "Line description of the running line");
  to.option("--control", &options->control, Value::file("PATH"), "Socket of the running line");
  add_json_flag(to, options->json);
  return [options] { return order_axis(*options); };
}

}  // namespace driveline::cli
