#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "axes/command_sender.hpp"
#include "driveline/runtime/groups/group_requests.hpp"

namespace driveline::cli {

/// Answers the commands of clients at the control socket that start with the word "group", one line of JSON each:
///
///     plotter move 90mm 20mm feed=100mm/s  requests a motion of group plotter
///     plotter hold take-over               also if another caller commands one of its axes
///     plotter path begin MOVE MOVE ...     the first moves of a path, each a JSON object (group_view.hpp); `go-on`
///                                          instead of `begin`: further moves; `end`: the last ones. The answer
///                                          says how many were "taken": send the others again later
///     progress                             progress of the last request to each group; also a sign of life
///     plotter status                       state of the group; "all" instead of the name: of all groups
///     plotter release                      releases its axes
///     detach                               the requests continue when the connection ends
///
/// Clients own the groups that they command under the same rules as axes in AxisService. Belongs to the thread of the
/// socket.
class GroupService {
 public:
  /// Both must outlive this object.
  GroupService(runtime::GroupRequests& groups, runtime::AxisRequests& axes) : groups_(groups), axes_(axes) {}

  /// Executes a command and returns the answer; {"error": sentence, "status": 1 or 2} on failure.
  [[nodiscard]] std::string execute(const CommandSender& sender, std::string_view words);
  /// Handles the end of a connection: releases the groups of its client.
  void disconnected(const CommandSender& sender);
  /// Supervises the groups. To be called every few milliseconds.
  void watch() { groups_.watch(); }

 private:
  /// The last request of a client to a group.
  struct Request {
    std::uint64_t first = 0;  ///< number of the first request that was not over
    std::uint64_t last = 0;
    std::string failure{};  ///< why one of the requests failed; empty: none has failed
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
  void update_request(std::size_t group, const Client& client, Request& request) const;

  runtime::GroupRequests& groups_;
  runtime::AxisRequests& axes_;
  std::map<std::uint64_t, Client> clients_;  ///< by number of the connection
};

}  // namespace driveline::cli
