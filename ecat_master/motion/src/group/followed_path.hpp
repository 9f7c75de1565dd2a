#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/trajectory/setpoint.hpp"
#include "group_path.hpp"
#include "group_request_table.hpp"

namespace driveline::motion {

/// The path that the axes of a group follow in the cycle, and the progress of its moves in the table of requests. All
/// functions are for the cycle: \rtsafe.
class FollowedPath {
 public:
  /// `table` must outlive this object.
  explicit FollowedPath(GroupRequestTable& table) noexcept : table_(table) {}

  /// Begins a path at its start.
  void begin(GroupPath& path) noexcept;
  /// Leaves the path and returns it; null: there was none.
  [[nodiscard]] GroupPath* leave() noexcept;
  /// Whether there is a path.
  [[nodiscard]] bool there() const noexcept { return path_ != nullptr; }
  /// The path. Precondition: there().
  [[nodiscard]] GroupPath& path() noexcept { return *path_; }

  /// Computes the setpoints of the next cycle; without a path they keep their values.
  void step(std::span<trajectory::AxisSetpoint> setpoints) noexcept;
  /// Where the axes are on the path.
  [[nodiscard]] const GroupPath::Place& place() const noexcept { return place_; }
  /// Settles the moves that are done, and reports the one under way as active. Precondition: there().
  void settle_moves() noexcept;
  /// Aborts all moves that are not done.
  void abort_moves(GroupError error, std::size_t axis) noexcept;
  /// Request of the first move that is not done; 0: none.
  [[nodiscard]] std::uint64_t next_request() const noexcept { return path_ != nullptr ? path_->next_request() : 0; }
  /// Number of cycles for which the axes have been at the end of the planned path.
  [[nodiscard]] std::uint64_t cycles_at_end() const noexcept { return cycles_at_end_; }

 private:
  GroupRequestTable& table_;
  GroupPath* path_ = nullptr;
  GroupPath::Place place_{};
  std::uint64_t completed_ = 0;    ///< completed() of the path before its last step
  std::uint64_t active_move_ = 0;  ///< moves with smaller numbers have been reported as active
  std::uint64_t cycles_at_end_ = 0;
};

}  // namespace driveline::motion
