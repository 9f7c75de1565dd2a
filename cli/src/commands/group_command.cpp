#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

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

#include "axes/axis_words.hpp"
#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "groups/group_path.hpp"
#include "groups/group_view.hpp"
#include "groups/group_words.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;
using std::chrono::steady_clock;

/// Interval at which the command requests the progress from the line, and so shows that it is alive.
constexpr std::chrono::milliseconds kLookInterval{50};
/// The same while moves are being sent, and until the group has accepted a request.
constexpr std::chrono::milliseconds kGiveInterval{10};
/// After this time the command starts to print its progress.
constexpr std::chrono::seconds kQuietTime{2};
constexpr std::chrono::seconds kTellAgain{1};
/// Limit of the moves in one command, in bytes of JSON; the line accepts commands of up to 64 KiB.
constexpr std::size_t kMaxText = 48'000;
constexpr std::size_t kMaxMoves = 128;

struct GroupOptions {
  std::string group;
  std::string request;
  std::vector<std::string> operands;
  std::optional<std::string> feed;
  std::optional<std::string> tolerance;
  std::optional<std::string> buffer;
  std::string control;
  std::string config;
  bool take_over = false;
  bool no_wait = false;
  bool json = false;
};

/// Whether the request is a motion that takes time and ends on its own.
bool moves_group(std::string_view request) {
  return request.starts_with("move") || request.starts_with("arc") || request == "path";
}

/// The command for the line: `group plotter move 90 20 feed=30mm/s`.
std::string order_of(const GroupOptions& options) {
  auto order = fmt::format("group {} {}", quoted_word(options.group), options.request);
  for (const auto& operand : options.operands) order += fmt::format(" {}", quoted_word(operand));
  const auto add = [&order](std::string_view name, const std::optional<std::string>& value) {
    if (value) order += fmt::format(" {}", quoted_word(fmt::format("{}={}", name, *value)));
  };
  add("feed", options.feed);
  add("tolerance", options.tolerance);
  add("buffer", options.buffer);
  if (options.take_over) order += " take-over";
  return order;
}

/// Reads the lines that are typed during a motion, without waiting for them.
class TypedLines {
 public:
  /// The next complete line; none: there is none yet, or stdin has ended.
  [[nodiscard]] std::optional<std::string> next() {
    read();
    const auto end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    auto line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
  }

 private:
  void read() {
    // Reading from the terminal in the background would stop the program.
    if (!open_ || (isatty(STDIN_FILENO) != 0 && tcgetpgrp(STDIN_FILENO) != getpgrp())) return;
    pollfd request{STDIN_FILENO, POLLIN, 0};
    if (::poll(&request, 1, 0) <= 0) return;
    std::array<char, 512> buffer;
    const auto count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    open_ = count > 0;
    if (open_) text_.append(buffer.data(), static_cast<std::size_t>(count));
  }

  std::string text_;
  bool open_ = true;
};

/// One request to a group of a running line, followed to its end.
class GroupOrder {
 public:
  GroupOrder(const GroupOptions& options, CommandConnection connection)
      : options_(options), connection_(std::move(connection)) {}

  [[nodiscard]] Outcome<int> execute() {
    if (options_.request == "path") {
      if (auto read = read_path(); !read) return tl::unexpected(read.error());
      return follow();
    }
    auto answer = ask(order_of(options_));
    if (!answer) return tl::unexpected(answer.error());
    if (options_.request == "status") return print(*answer);
    if (options_.no_wait) return leave_when_accepted();
    return follow();
  }

 private:
  [[nodiscard]] Outcome<json> ask(const std::string& command) {
    const auto answer = connection_.ask(command);
    if (!answer) return tl::unexpected(answer.error());
    auto document = json::parse(*answer, nullptr, false);
    if (!document.is_object()) return failed(*answer);
    if (document.contains("error"))
      return tl::unexpected(Failure{document.value("status", 1), document.at("error").get<std::string>()});
    return document;
  }

  [[nodiscard]] Outcome<json> ask_group(std::string_view words) {
    return ask(fmt::format("group {} {}", quoted_word(options_.group), words));
  }

  /// Checks the whole path before the first move is sent to the line.
  [[nodiscard]] Outcome<void> read_path() {
    if (options_.operands.size() != 1) return misused("path needs one file of moves");
    auto answer = ask_group("status");
    if (!answer) return tl::unexpected(answer.error());
    const auto group = path_group(answer->at("groups").at(0));
    if (!group) return tl::unexpected(group.error());
    auto read = read_group_path(options_.operands[0], *group);
    if (!read) return tl::unexpected(read.error());
    path_ = std::move(*read);
    axes_ = group->place.size();
    return {};
  }

  /// Sends the next moves, as many as the line takes. The failure of a refused move names its line in the file.
  [[nodiscard]] Outcome<void> give_moves() {
    while (given_ < path_.size()) {
      auto told = json::array();
      std::size_t text = 0;
      for (std::size_t i = given_; i < path_.size() && told.size() < kMaxMoves && text < kMaxText; ++i) {
        told.push_back(to_json(path_[i].move, axes_));
        text += told.back().dump().size();
      }
      const bool begins = given_ == 0;
      const bool ends = given_ + told.size() == path_.size();
      const auto* const which = begins && ends ? "only" : begins ? "begin" : ends ? "end" : "go-on";
      const bool takes_over = begins && options_.take_over;
      auto answer = ask_group(fmt::format("path {}{} {}", which, takes_over ? " take-over" : "", told.dump()));
      if (!answer) {
        const auto& wrong = answer.error();
        return tl::unexpected(
            Failure{wrong.status, fmt::format("{}:{}: {}", options_.operands[0], path_[given_].line, wrong.text)});
      }
      const auto taken = answer->at("taken").get<std::size_t>();
      if (taken == 0) return {};
      given_ += taken;
    }
    return {};
  }

  /// Waits until the group has accepted the request or refused it; the motion continues without this command.
  [[nodiscard]] Outcome<int> leave_when_accepted() {
    for (;;) {
      auto progress = ask("group progress");
      if (!progress) return tl::unexpected(progress.error());
      const auto& group = progress->at("groups").at(0);
      if (group.contains("failure")) return failed(group.at("failure").get<std::string>());
      if (group.at("accepted").get<bool>() || group.at("over").get<bool>()) {
        if (auto detached = ask("group detach"); !detached) return tl::unexpected(detached.error());
        return print(*progress);
      }
      if (rt::stop_requested()) return failed("interrupted before the group accepted the request");
      std::this_thread::sleep_for(kGiveInterval);
    }
  }

  /// Waits until the request is over.
  [[nodiscard]] Outcome<int> follow() {
    for (;;) {
      if (!halted_) {
        if (auto given = give_moves(); !given) return tl::unexpected(given.error());
      }
      auto progress = ask("group progress");
      if (!progress) return tl::unexpected(progress.error());
      const auto& group = progress->at("groups").at(0);
      if (halted_) {
        // This command has ended the motion.
        if (group.value("state", "") != "GroupMoving") return failed(fmt::format("interrupted: {}", group_line(group)));
      } else if (group.contains("failure")) {
        return failed(group.at("failure").get<std::string>());
      } else if (group.at("over").get<bool>() && given_ == path_.size()) {
        return print(*progress);
      }
      if (auto stopped = halt_if_due(); !stopped) return tl::unexpected(stopped.error());
      if (moves_group(options_.request)) obey_typed_lines();
      tell(group);
      std::this_thread::sleep_for(given_ < path_.size() ? kGiveInterval : kLookInterval);
    }
  }

  [[nodiscard]] Outcome<void> halt_if_due() {
    if (halted_ || !rt::stop_requested()) return {};
    if (!moves_group(options_.request)) return failed("interrupted");
    halted_ = true;
    const auto answer = ask_group("halt");
    return answer ? Outcome<void>{} : tl::unexpected(answer.error());
  }

  /// Executes typed commands for the feed: hold, resume, override 50%, reverse, forward, halt, stop.
  void obey_typed_lines() {
    while (const auto line = typed_.next()) {
      const auto words = split_words(*line);
      if (words.empty()) continue;
      constexpr std::array<std::string_view, 7> kWords{"hold",    "resume", "override", "reverse",
                                                       "forward", "halt",   "stop"};
      if (std::find(kWords.begin(), kWords.end(), words[0]) == kWords.end()) {
        progress("\"{}\": {} are possible while the group moves", *line, fmt::join(kWords, ", "));
        continue;
      }
      halted_ = halted_ || words[0] == "halt" || words[0] == "stop";
      if (const auto answer = ask_group(*line); !answer) progress("{}", answer.error().text);
    }
  }

  void tell(const json& group) {
    const auto now = steady_clock::now();
    if (now < next_tell_) return;
    next_tell_ = now + kTellAgain;
    const auto part = path_.empty() ? "" : fmt::format(", {} of {} moves sent", given_, path_.size());
    progress("{}{}", group_line(group), part);
  }

  [[nodiscard]] Outcome<int> print(const json& document) const {
    if (options_.json) {
      print_out("{}", json_text(document));
    } else if (options_.request == "status") {
      print_out("{}", groups_table(document.at("groups")));
    } else {
      for (const auto& group : document.at("groups")) {
        print_out("{}{}\n", group_line(group), options_.no_wait ? "; accepted by the group" : "");
      }
    }
    return 0;
  }

  const GroupOptions& options_;
  CommandConnection connection_;
  steady_clock::time_point next_tell_ = steady_clock::now() + kQuietTime;
  TypedLines typed_;
  std::vector<FileMove> path_;  ///< empty: the request is not a path
  std::size_t given_ = 0;       ///< number of its moves that have been sent
  std::size_t axes_ = 0;        ///< number of axes of the group; set together with path_
  bool halted_ = false;         ///< by this command
};

Outcome<int> order_group(const GroupOptions& options) {
  rt::catch_stop_signals();
  if (options.request == "path" && options.no_wait)
    return misused("--no-wait is not possible with path: the moves are sent while the group follows the path");
  const auto control = find_control(options.control, options.config);
  if (!control) return tl::unexpected(control.error());
  auto connection = CommandConnection::open(*control, "run");
  if (!connection) return tl::unexpected(connection.error());
  return GroupOrder(options, std::move(*connection)).execute();
}

std::vector<std::string_view> group_request_names() {
  std::vector<std::string_view> names{"status", "path"};
  for (const auto verb : group_verbs()) names.push_back(verb);
  return names;
}

}  // namespace

Execute prepare_group(Arguments& to) {
  auto options = std::make_shared<GroupOptions>();
  to.required(&options->group, Value::text("NAME"), "Name of the group; for status also all");
  to.required(&options->request, Value::choice("REQUEST", group_request_names()),
              "status, enable, disable, reset, move POSITION..., move-by DISTANCE..., arc POSITION... via|center "
              "POSITION..., arc-by, path FILE, hold, resume, reverse, forward, override FACTOR, halt, stop, "
              "release-stop");
  to.positional(
      &options->operands, Value::text("VALUE"),
      "One value per axis with unit, e.g. 90mm; without unit: in the unit of the axis; -: the axis does not move");
  to.option("--feed", &options->feed, Value::text("VALUE"),
            "Speed along the path, e.g. 100mm/s; default: max_feed of the group");
  to.option("--tolerance", &options->tolerance, Value::text("VALUE"),
            "Maximum distance between the path and the corner at the end of the move; default: that of the group");
  to.option("--buffer", &options->buffer, Value::text("MODE"),
            "How the motion follows the previous one: aborting, buffered, blending");
  to.flag("--no-wait", options->no_wait,
          "Wait only until the group has accepted the request; the motion continues without this command");
  to.flag("--take-over", options->take_over, "Take over the axes of the group from another client");
  to.option("--config", &options->config, Value::file(), "Line description of the running line");
  to.option("--control", &options->control, Value::file("PATH"), "Socket of the running line");
  add_json_flag(to, options->json);
  return [options] { return order_group(*options); };
}

}  // namespace driveline::cli
