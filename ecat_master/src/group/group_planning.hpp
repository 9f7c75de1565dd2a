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
#include "driveline/ecat_master/group/group_request.hpp"
#include "group_path.hpp"
#include "group_request_table.hpp"

namespace driveline::ecat_master {

/// The moves of a group beside the cycle: waits, planning, and paths on their way to the cycle and back. One thread at
/// a time.
class GroupPlanning {
 public:
  /// Makes a path that begins where the axes stand; may throw std::invalid_argument.
  using MakePath = std::function<std::unique_ptr<GroupPath>(const AxisGroup::Standing& standing)>;
  /// Told of a move that cannot be done.
  using Refuse = std::function<void(std::uint64_t request, std::string reason)>;

  /// `grace_cycles`: how long the end of the path is kept open for a move that was announced. The others must outlive
  /// it.
  GroupPlanning(AxisGroup& group, GroupRequestTable& table, std::uint64_t grace_cycles, MakePath make_path,
                Refuse refuse);

  /// So many moves can be taken.
  [[nodiscard]] std::size_t room() const noexcept;
  /// A move behind all that were handed over, and behind `requests` requests of the group. There must be room.
  void add(std::uint64_t id, const GroupMove& move, std::uint64_t requests);
  /// As far as there is room in the path.
  void plan();

 private:
  struct Waiting {
    std::uint64_t id;
    std::uint64_t behind;  ///< so many requests to the group come first
    GroupMove move;
  };

  void leave_ended_path();
  void take_paths_back();
  void drop_aborted();
  [[nodiscard]] bool refuse_by_state();
  [[nodiscard]] bool ready_for(const Waiting& next);
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
  std::deque<Waiting> waiting_;
  std::vector<std::unique_ptr<GroupPath>> paths_;  ///< that the cycle may still have; the last one gets the moves
  GroupPath* path_ = nullptr;                      ///< null: the next move begins one
  std::uint64_t used_epoch_ = 0;                   ///< of the last path
  bool open_ = false;                              ///< the path waits for another move
  std::uint64_t at_end_when_added_ = 0;            ///< AxisGroup::cycles_at_end() when the last move was added
  bool closing_ = false;                           ///< the path has been finished, and not handed over whole
};

}  // namespace driveline::ecat_master
