#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/groups/group_door.hpp"
#include "failure.hpp"
#include "text/move_file.hpp"

namespace driveline::cli {

/// What a script has asked of groups, and how far that is. Failures are sentences without file and line of the script,
/// which are told beside them.
class ScriptGroups {
 public:
  /// A failure, and the line of the script that it belongs to.
  struct Trouble {
    std::size_t line = 0;
    Failure failure;
  };

  /// `caller`: name of the script.
  explicit ScriptGroups(std::string caller) { caller_.name = std::move(caller); }

  /// A request of that line.
  [[nodiscard]] std::optional<Trouble> ask(runtime::GroupDoor& door, std::size_t line, std::size_t group,
                                           const runtime::GroupRequest& request);
  /// A path, which is read and checked now.
  [[nodiscard]] std::optional<Trouble> begin_path(runtime::GroupDoor& door, std::size_t line, std::size_t group,
                                                  const std::filesystem::path& file);
  /// Hands on moves of paths, as there is room, and looks for failures.
  [[nodiscard]] std::optional<Trouble> look(runtime::GroupDoor& door);
  /// That group, or every one, has done what it was last asked for.
  [[nodiscard]] bool arrived(std::optional<std::size_t> group) const;

 private:
  /// A request, or a path, that has been asked for.
  struct Made {
    std::size_t line = 0;
    std::size_t group = 0;
    std::uint64_t first = 0;  ///< of its numbers, the first one that is not over
    std::uint64_t last = 0;   ///< 0: of a path none has been taken yet
    bool newest = true;       ///< nothing later moves the group
    bool over = false;
    std::vector<FileMove> moves{};  ///< of a path
    std::size_t given = 0;          ///< so many of them have been taken
    std::string file{};             ///< of the path
  };

  [[nodiscard]] std::optional<Trouble> give_moves(runtime::GroupDoor& door, Made& made);
  [[nodiscard]] std::optional<Trouble> look_at(const runtime::GroupDoor& door, Made& made) const;
  void add(Made made, bool moves);

  runtime::AxisCaller caller_;
  std::vector<Made> made_;
};

}  // namespace driveline::cli
