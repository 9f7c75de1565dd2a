#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "axis_group.hpp"
#include "driveline/motion/group/group_request.hpp"
#include "group_path.hpp"
#include "group_request_table.hpp"

namespace driveline::motion {

/// A move that waits to be planned.
struct QueuedMove {
  std::uint64_t id = 0;       ///< number of its request
  AxisGroup::Count behind{};  ///< requests to the group that come first
  GroupMove move{};           ///< the move
};

/// Moves of a group outside the cycle: planning, and the exchange of paths with the cycle. For one thread at a time.
class GroupPlanning {
 public:
  /// Makes a path that starts at the given standstill; may throw std::invalid_argument.
  using MakePath = std::function<std::unique_ptr<GroupPath>(const AxisGroup::Standing& standing)>;
  /// Called with a move that is not possible, and the reason.
  using Refuse = std::function<void(std::uint64_t request, std::string reason)>;

  /// `grace_cycles`: cycles for which the end of the path stays open for an announced move. All references must outlive
  /// this object.
  GroupPlanning(AxisGroup& group, GroupRequestTable& table, std::uint64_t grace_cycles, MakePath make_path,
                Refuse refuse);

  /// Number of moves that wait to be planned.
  [[nodiscard]] std::size_t waiting() const noexcept { return waiting_.size(); }
  /// Takes moves out of a queue, after all moves taken before.
  void add(std::deque<QueuedMove>& moves);
  /// Plans moves as far as the path has space.
  void plan();

 private:
  void leave_ended_path();
  void take_paths_back();
  void drop_aborted();
  [[nodiscard]] bool refuse_by_state();
  [[nodiscard]] bool ready_for(const QueuedMove& next);
  [[nodiscard]] bool begin_path();
  [[nodiscard]] bool add_next();
  void refuse_next(std::string reason);
  void close_path();
  [[nodiscard]] bool hand_over();
  [[nodiscard]] GroupMove absolute(const GroupMove& move) const;

  AxisGroup& group_;
  GroupRequestTable& table_;
  std::uint64_t grace_cycles_;
  MakePath make_path_;
  Refuse refuse_;
  std::deque<QueuedMove> waiting_;
  std::vector<std::unique_ptr<GroupPath>> paths_;  ///< paths that the cycle may still use; the last one gets the moves
  GroupPath* path_ = nullptr;                      ///< null: the next move starts a path
  std::uint64_t used_epoch_ = 0;                   ///< epoch of the last path
  bool open_ = false;                              ///< the path waits for another move
  std::uint64_t at_end_when_added_ = 0;            ///< PathExchange::cycles_at_end() when the last move was added
  bool closing_ = false;                           ///< the path is finished, but not completely handed over
};

}  // namespace driveline::motion
