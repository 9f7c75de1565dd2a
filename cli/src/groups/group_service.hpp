#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "axes/command_sender.hpp"
#include "driveline/runtime/groups/group_door.hpp"

namespace driveline::cli {

/// Answers what clients at the control socket say behind the word "group", one line of JSON each:
///
///     plotter move 90mm 20mm feed=100mm/s   asks for a motion of group plotter
///     plotter hold take-over                also if somebody else commands one of its axes
///     plotter path begin MOVE MOVE ...      the first moves of a path, each a JSON object (group_view.hpp); `go-on`
///                                          in the place of `begin`: the next ones; `end`: the last ones. The answer
///                                          says how many were "taken": the others are to be told again later
///     progress                             how far the last request to each group is; says that the client is there
///     plotter status                        what the group does; "all" in its place: all groups
///     plotter release                       gives its axes back
///     detach                               the requests go on when the connection ends
///
/// Clients have the groups that they ask something of as AxisService has it for axes. Belongs to the thread of the
/// socket.
class GroupService {
 public:
  /// Both must outlive it.
  GroupService(runtime::GroupDoor& groups, runtime::AxisDoor& axes) : groups_(groups), axes_(axes) {}

  /// The answer; {"error": sentence, "status": 1 or 2} when it cannot be done.
  [[nodiscard]] std::string execute(const CommandSender& sender, std::string_view words);
  /// The connection has ended.
  void gone(const CommandSender& sender);
  /// To be called every few milliseconds.
  void watch() { groups_.watch(); }

 private:
  /// What a client has last asked of a group.
  struct Request {
    std::uint64_t first = 0;  ///< of its numbers, the first one that was not over
    std::uint64_t last = 0;
    std::string failure{};  ///< of one of them; empty: none has failed
  };
  struct Client {
    runtime::AxisCaller caller;
    std::map<std::size_t, Request> requests;
    bool detached = false;
  };

  [[nodiscard]] nlohmann::json answer(Client& client, std::string_view line);
  [[nodiscard]] nlohmann::json order(Client& client, std::size_t group, std::vector<std::string> words);
  [[nodiscard]] nlohmann::json add_moves(Client& client, std::size_t group, std::string_view text);
  [[nodiscard]] nlohmann::json progress(Client& client) const;
  [[nodiscard]] nlohmann::json status(std::optional<std::size_t> group) const;
  [[nodiscard]] nlohmann::json row(std::size_t group) const;
  void look_at(std::size_t group, const Client& client, Request& request) const;

  runtime::GroupDoor& groups_;
  runtime::AxisDoor& axes_;
  std::map<std::uint64_t, Client> clients_;  ///< by connection
};

}  // namespace driveline::cli
