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

namespace driveline::ecat_master {

/// The software limits of the axes of a group, as its moves count positions: no move leads beyond them.
class RangeCheck {
 public:
  /// One axis.
  struct Range {
    std::string axis{};                                ///< its name, for sentences
    std::optional<trajectory::PositionRange> range{};  ///< none: anywhere
  };

  explicit RangeCheck(std::vector<Range> ranges) : ranges_(std::move(ranges)) {}

  /// As they were given.
  [[nodiscard]] const std::vector<Range>& ranges() const noexcept { return ranges_; }
  /// A sentence if the place is outside.
  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> place(std::span<const double> at) const;
  /// The same of any place of a move from `from`, with its rounded corners. What the shaper refuses is not judged.
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

}  // namespace driveline::ecat_master
