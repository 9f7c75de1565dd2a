#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/group_vector.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/path_piece.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::motion {

/// The software limits of the axes of a group, in move positions; no move leads beyond them.
class RangeCheck {
 public:
  /// Range of an axis.
  struct Range {
    std::string axis{};                                ///< name of the axis, for messages
    std::optional<trajectory::PositionRange> range{};  ///< none: unlimited
  };

  explicit RangeCheck(std::vector<Range> ranges) : ranges_(std::move(ranges)) {}

  /// The ranges given to the constructor.
  [[nodiscard]] const std::vector<Range>& ranges() const noexcept { return ranges_; }
  /// Returns a sentence if the position is outside the ranges.
  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> place(std::span<const double> at) const;
  /// The same for all positions of a move from `from`, with rounded corners. A move that the shaper refuses is not
  /// checked.
  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> move(const trajectory::GroupVector& from,
                                                                   const trajectory::PathMove& move,
                                                                   double tolerance_before) const;

 private:
  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> piece(const trajectory::PathPiece& piece,
                                                                    double margin) const;
  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> judge(std::size_t axis, double position,
                                                                    double margin) const;

  std::vector<Range> ranges_;
};

}  // namespace driveline::motion
