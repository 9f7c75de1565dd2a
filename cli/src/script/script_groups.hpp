#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/groups/group_requests.hpp"
#include "failure.hpp"
#include "text/move_file.hpp"

namespace driveline::cli {

/// The requests of a script to groups, and their progress. Failures are sentences without file and line of the script;
/// the line comes with them.
class ScriptGroups {
 public:
  /// A failure, and the line of the script that caused it.
  struct Trouble {
    std::size_t line = 0;
    Failure failure;
  };

  /// `caller`: name of the script as a caller.
  explicit ScriptGroups(std::string caller) { caller_.name = std::move(caller); }

  /// Submits a request of that line.
  [[nodiscard]] std::optional<Trouble> ask(runtime::GroupRequests& group_requests, std::size_t line, std::size_t group,
                                           const runtime::ClientGroupRequest& request);
  /// Reads and checks a path, and starts it.
  [[nodiscard]] std::optional<Trouble> begin_path(runtime::GroupRequests& group_requests, std::size_t line,
                                                  std::size_t group, const std::filesystem::path& file);
  /// Submits further moves of paths as far as the group takes them, and checks for failures.
  [[nodiscard]] std::optional<Trouble> poll(runtime::GroupRequests& group_requests);
  /// Whether that group, or every group if none is given, has completed its last request.
  [[nodiscard]] bool arrived(std::optional<std::size_t> group) const;

 private:
  /// A request, or a path, that has been submitted.
  struct Made {
    std::size_t line = 0;
    std::size_t group = 0;
    std::uint64_t first = 0;  ///< number of the first request that is not over
    std::uint64_t last = 0;   ///< number of the last request; 0: no move of the path has been taken yet
    bool newest = true;       ///< no later request moves the group
    bool over = false;
    std::vector<FileMove> moves{};  ///< moves of the path; empty for a single request
    std::size_t given = 0;          ///< number of moves that the group has taken
    std::string file{};             ///< file of the path
  };

  [[nodiscard]] std::optional<Trouble> give_moves(runtime::GroupRequests& group_requests, Made& made);
  [[nodiscard]] std::optional<Trouble> check_made(const runtime::GroupRequests& group_requests, Made& made) const;
  void add(Made made, bool moves);

  runtime::AxisCaller caller_;
  std::vector<Made> made_;
};

}  // namespace driveline::cli
